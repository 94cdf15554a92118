"""Walks through `breaker view` in a real browser: `make test-browser`.

Three journeys: an unknown export to a sheet, in at most five clicks; a wrong setting, said and
mended by keyboard alone; two visits. Pictures of each, at 1280 and 1920 pixels and in dark mode, go
into ``build/browser/``, to be looked at.
"""

import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

from breaker.cli import main
from tests.browser.chromium import Browser
from tests.exports import write

PICTURES = Path("build/browser")
TAB, ENTER = "\ue004", "\ue007"


@contextmanager
def viewed(folder: Path):
    """The address of a page of a folder, as the command prints it."""
    command = [sys.executable, "-m", "breaker", "view", str(folder), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            yield re.search(r"http://\S+", process.stdout.readline())[0], process.pid
        finally:
            process.terminate()


def exports(folder: Path, count: int) -> None:
    """Exports of visits to one breaker."""
    motions = (("closing",), ("opening",), ("closing", "opening"))
    for k in range(count):
        about = {"date": f"{1 + k % 28:02d}/03/2021", "motions": motions[k % 3]}
        write(folder / f"export_{k:02d}.csv", rate=5.0, seed=k, **about)


def to_a_sheet(browser: Browser, address: str, folder: Path, downloads: Path) -> None:
    """An export of unknown layout, to a sheet that is that of the command."""
    start = time.monotonic()
    browser.open(address)
    browser.find('a[href="/visit?file=export_02.csv"]')
    said("list of 40 files", start)
    clicks = 0
    for each in ('a[href="/visit?file=export_02.csv"]', "#pdf"):
        browser.click(each)
        clicks += 1
    sheet = downloads / "sheet.pdf"
    browser.until(sheet.exists, "the sheet")
    said(f"a sheet, after {clicks} clicks", start)
    settings = downloads / "my.yaml"
    browser.run("document.getElementById('settings-name').value = arguments[0]", str(settings))
    browser.click('form.save:has([value="settings"]) button')
    browser.until(settings.exists, "the settings")
    given = [str(folder / "export_02.csv"), "--config", str(settings)]
    assert main(["report", *given, "--output", str(downloads / "same.pdf")]) == 0
    assert sheet.read_bytes() == (downloads / "same.pdf").read_bytes()
    assert clicks <= 5
    browser.run(
        "for (const [id, at] of [['cursor1', 60], ['cursor2', 90]]) {"
        "const field = document.getElementById(id); field.value = at;"
        "field.dispatchEvent(new Event('change')); }"
    )
    browser.until(lambda: "30 ms apart" in browser.text("#readings"), "readings", 20.0)
    assert browser.run("return plot !== null")


def by_keyboard(browser: Browser) -> None:
    """A wrong rate is said, and mended, without a mouse; each change is answered at once."""
    browser.run("document.getElementById('set-rate').select()")
    browser.keys("-3" + TAB, "#set-rate")
    browser.until(lambda: "endurance.format.rate" in browser.text("#verdict"), "a message")
    browser.picture(PICTURES / "wrong.png")
    browser.run("document.getElementById('set-rate').select()")
    browser.keys("5.0" + TAB, "#set-rate")
    browser.find("#pdf")
    took = []
    for sign in ("opens", "closes") * 3:
        before = browser.run("return document.body.dataset.took")
        browser.keys(sign, "#set-sign")
        browser.until(
            lambda before=before: browser.run("return document.body.dataset.took") != before,
            "the change",
        )
        took.append(int(browser.run("return document.body.dataset.took")))
        browser.until(lambda: not browser.text("#busy"), "the page")
    print(f"a change: median {statistics.median(took):.0f} ms, with the curves drawn ({took})")
    browser.find("#pdf")


def two_visits(browser: Browser) -> None:
    """A visit beside the one before."""
    browser.click("header a")
    browser.click('input[name="file"][value="export_05.csv"]')
    browser.click('input[name="before"][value="export_02.csv"]')
    browser.click("#list button")
    browser.until(lambda: "since the visit before" in browser.text("#values"), "the changes")


def sound(browser: Browser, address: str) -> None:
    """No script failed, nothing was asked of elsewhere, and each field has a label."""
    own = address.partition("/?")[0]
    elsewhere = [
        each
        for each in browser.requests()
        if not each.startswith((own, "data:", "blob:", "chrome"))
    ]
    assert not elsewhere, elsewhere
    failed = [e["message"] for e in browser.log("browser") if e["level"] == "SEVERE"]
    assert not [e for e in failed if "/visit?" not in e], failed  # of a setting that was wrong
    assert browser.run(
        "return [...document.querySelectorAll('main input, main select')].every("
        "(field) => field.type === 'hidden' || field.labels.length || field.ariaLabel)"
    )


def said(what: str, start: float) -> None:
    print(f"{what}: {time.monotonic() - start:.1f} s")


def walk() -> None:
    """All journeys, at each size."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place, "curves")
        folder.mkdir()
        exports(folder, 40)
        for width, dark in ((1280, False), (1920, False), (1280, True)):
            downloads = Path(place, f"{width}-{dark}")
            downloads.mkdir()
            name = f"{width}{'-dark' * dark}"
            with viewed(folder) as (address, process):
                browser = Browser(downloads, width, dark)
                try:
                    to_a_sheet(browser, address, folder, downloads)
                    browser.picture(PICTURES / f"sheet-{name}.png", 5000)
                    if width == 1280 and not dark:
                        by_keyboard(browser)
                    two_visits(browser)
                    browser.picture(PICTURES / f"visits-{name}.png", 5000)
                    browser.click("header a")
                    browser.until(lambda: "not looked into" not in browser.text(), "all files")  # noqa: B023
                    browser.picture(PICTURES / f"list-{name}.png", 1500)
                    sound(browser, address)
                    memory(process)
                finally:
                    browser.end()
    print(f"all journeys were walked; look at {PICTURES}/")


def memory(process: int) -> None:
    """Say what the command held at most."""
    status = Path(f"/proc/{process}/status")
    if status.exists():
        held = re.search(r"VmHWM:\s+(\d+)", status.read_text())
        print(f"the command held {int(held[1]) / 1e3:.0f} MB at most")


if __name__ == "__main__":
    os.environ["OMP_NUM_THREADS"] = "1"
    walk()
