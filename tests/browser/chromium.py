"""Drives Debian's Chromium by its ChromeDriver: the few words of WebDriver that a walk needs."""

import base64
import json
import shutil
import socket
import subprocess
import time
import urllib.request
from pathlib import Path

TAB, ENTER = "\ue004", "\ue007"
_ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  # the key of an element, as the standard has it
_FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
)


class Browser:
    """A browser with an empty profile; what it downloads goes into a folder.

    Args:
        folder: Of its profile and downloads.
        size: Width and height of what it shows of a page, pixels.
        dark: Whether it prefers dark pages.
    """

    def __init__(self, folder: Path, size: tuple[int, int] = (1280, 800), dark: bool = False):
        driver = shutil.which("chromedriver")
        if driver is None:
            raise SystemExit("no ChromeDriver is here: apt install chromium chromium-driver")
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        self.process = subprocess.Popen([driver, f"--port={port}"], stdout=subprocess.DEVNULL)
        self.base = f"http://127.0.0.1:{port}"
        self.until(self._ready, "ChromeDriver")
        options = {
            "args": [*_FLAGS, f"--user-data-dir={folder / 'profile'}"],
            "prefs": {"download.default_directory": str(folder)},
        }
        logs = {"browser": "ALL", "performance": "ALL"}
        wanted = {"goog:chromeOptions": options, "goog:loggingPrefs": logs}
        session = self._ask("/session", {"capabilities": {"alwaysMatch": wanted}})
        self.base += f"/session/{session['sessionId']}"
        scheme = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
        self._order("Emulation.setEmulatedMedia", features=scheme)
        about = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
        self._order("Emulation.setDeviceMetricsOverride", **about)

    def _ready(self) -> bool:
        try:
            return self._ask("/status")["ready"]
        except OSError:
            return False

    def _ask(self, path: str, body: dict | None = None):
        content = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.base + path, content)
        with urllib.request.urlopen(request, timeout=120) as answer:
            return json.load(answer)["value"]

    def _order(self, command: str, **parameters):
        return self._ask("/goog/cdp/execute", {"cmd": command, "params": parameters})

    def open(self, address: str) -> None:
        """Open an address, and wait for its page."""
        self._ask("/url", {"url": address})

    def find(self, selector: str) -> str:
        """An element by its CSS selector, once it is there."""

        def result():
            try:
                return self._ask("/element", {"using": "css selector", "value": selector})
            except OSError:
                return None

        return self.until(result, selector)[_ELEMENT]

    def click(self, selector: str) -> None:
        """Click on an element."""
        self._act(selector, "click", {})

    def type(self, selector: str, text: str) -> None:
        """Type into a field what replaces its text, or name files to a field of files."""
        self._act(selector, "value", {"text": text})

    def _act(self, selector: str, action: str, body: dict) -> None:
        """Act on an element; again if a script has replaced it meanwhile."""

        def acted():
            try:
                self._ask(f"/element/{self.find(selector)}/{action}", body)
            except OSError:
                return False
            return True

        self.until(acted, selector)

    def run(self, script: str, *arguments):
        """What a script returns in the page."""
        return self._ask("/execute/sync", {"script": script, "args": list(arguments)})

    def run_until(self, script: str, *arguments):
        """What a script hands to the function that is its last argument."""
        return self._ask("/execute/async", {"script": script, "args": list(arguments)})

    def picture(self, file: Path, whole: bool = False) -> None:
        """Take a picture of what is shown of the page, or of the whole page."""
        time.sleep(0.5)  # until curves are painted
        more = {}
        if whole:
            size = self._order("Page.getLayoutMetrics")["cssContentSize"]
            more = {"captureBeyondViewport": True, "clip": {**size, "scale": 1}}
        picture = self._order("Page.captureScreenshot", **more)["data"]
        file.write_bytes(base64.b64decode(picture))

    def log(self, kind: str) -> list[dict]:
        """What was logged since it was last asked for: "browser" or "performance"."""
        return self._ask("/se/log", {"type": kind})

    def requests(self) -> list[str]:
        """Addresses that pages asked for since this was last asked."""
        result = (json.loads(item["message"])["message"] for item in self.log("performance"))
        sent = (item for item in result if item["method"] == "Network.requestWillBeSent")
        return [item["params"]["request"]["url"] for item in sent]

    @staticmethod
    def until(result, what: str, most: float = 120.0):
        """What is found, once it is."""
        end = time.monotonic() + most
        while not (value := result()):
            if time.monotonic() > end:
                raise AssertionError(f"{what} did not come in {most:.0f} s")
            time.sleep(0.05)
        return value

    def end(self) -> None:
        """End the browser and its driver."""
        try:
            urllib.request.urlopen(urllib.request.Request(self.base, method="DELETE"), timeout=20)
        finally:
            self.process.terminate()
            self.process.wait()
