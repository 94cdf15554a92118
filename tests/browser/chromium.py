"""Drive Debian's Chromium by its ChromeDriver, with the few commands of WebDriver that are used."""

import base64
import json
import shutil
import socket
import subprocess
import time
import urllib.request
from collections.abc import Callable
from pathlib import Path

ENTER = "\ue007"
_ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  # key of an element, by the standard
_FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
)


class Browser:
    """A browser with an empty profile; downloads go into a folder.

    Args:
        folder: Folder of profile and downloads.
        size: Width and height of the window, pixels.
        dark: Whether it prefers dark pages.
    """

    def __init__(self, folder: Path, size: tuple[int, int], dark: bool = False):
        driver = shutil.which("chromedriver")
        if driver is None:
            raise SystemExit("there is no ChromeDriver. Run: apt install chromium chromium-driver")
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        self.process = subprocess.Popen([driver, f"--port={port}"], stdout=subprocess.DEVNULL)
        self.base = f"http://127.0.0.1:{port}"
        self.until(lambda: self._ask("/status")["ready"], "ChromeDriver")
        options = {
            "args": [*_FLAGS, f"--user-data-dir={folder / 'profile'}"],
            "prefs": {"download.default_directory": str(folder)},
        }
        wanted = {"goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}
        session = self._ask("/session", {"capabilities": {"alwaysMatch": wanted}})
        self.base += f"/session/{session['sessionId']}"
        scheme = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
        self._order("Emulation.setEmulatedMedia", features=scheme)
        about = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
        self._order("Emulation.setDeviceMetricsOverride", **about)

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
        """Wait for an element, and return its identifier."""
        by = {"using": "css selector", "value": selector}
        return self.until(lambda: self._ask("/element", by), selector)[_ELEMENT]

    def click(self, selector: str) -> None:
        """Click on an element."""
        self._act(selector, "click", {})

    def type(self, selector: str, text: str) -> None:
        """Type into a field."""
        self._act(selector, "value", {"text": text})

    def _act(self, selector: str, action: str, body: dict) -> None:
        """Act on an element; again if a new page has replaced it meanwhile."""

        def acted() -> bool:
            self._ask(f"/element/{self.find(selector)}/{action}", body)
            return True

        self.until(acted, selector)

    def run(self, script: str):
        """Return the result of a script in the page."""
        return self._ask("/execute/sync", {"script": script, "args": []})

    def run_until(self, script: str):
        """Return the result that a script hands to the function that is its last argument."""
        return self._ask("/execute/async", {"script": script, "args": []})

    def picture(self, file: Path, whole: bool = False) -> None:
        """Take a picture of the window, or of the entire page."""
        time.sleep(0.5)  # until curves are painted
        more = {}
        if whole:
            size = self._order("Page.getLayoutMetrics")["cssContentSize"]
            more = {"captureBeyondViewport": True, "clip": {**size, "scale": 1}}
        picture = self._order("Page.captureScreenshot", **more)["data"]
        file.write_bytes(base64.b64decode(picture))

    def errors(self) -> list[str]:
        """Return the new errors of pages."""
        entries = self._ask("/se/log", {"type": "browser"})
        return [entry["message"] for entry in entries if entry["level"] == "SEVERE"]

    @staticmethod
    def until(find: Callable, what: str, most: float = 120.0):
        """Return a result once there is one; a function that raises an OSError has none."""
        end = time.monotonic() + most
        while time.monotonic() < end:
            try:
                if value := find():
                    return value
            except OSError:
                pass
            time.sleep(0.05)
        raise AssertionError(f"{what} did not come in {most:.0f} s")

    def end(self) -> None:
        """End the browser and its driver."""
        try:
            urllib.request.urlopen(urllib.request.Request(self.base, method="DELETE"), timeout=20)
        finally:
            self.process.terminate()
            self.process.wait()
