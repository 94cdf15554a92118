"""Draw the pictures of the page and of a report in Chromium.

    python docs/page.py      # needs Debian's chromium and chromium-driver

The page is `breaker view --example` with the newest inspection over the earlier one, after setting
a limit on its speed, which it fails. The report judges the same inspection.
"""

import re
import subprocess
import sys
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from tests.browser.chromium import ENTER, Browser  # noqa: E402

PAGE, REPORT = ROOT / "docs" / "page.png", ROOT / "docs" / "pictures" / "report.png"
_COLOURS, _SPEED = 256, 1.3  # m/s: the worn drive has 1.2
_LIMITS = """limits:
  - {name: slow_closing, motion: closing, of: record, lower: {closing_speed: 1.3}}
  - {name: long_closing, motion: closing, of: record, upper: {travel_time: 10.0}}
  - {name: slow_opening, motion: opening, of: record, upper: {travel_time: 13.0}}
"""


def show_page(browser: Browser, folder: Path) -> None:
    """Open the page of the example, and set a limit."""
    command = [sys.executable, "-m", "breaker", "view", "--example", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=folder) as process:
        try:
            browser.open(re.search(r"http://\S+", process.stdout.readline())[0])
            browser.click('a[href^="/inspection?file=inspection_2026-03-02.csv"]')
            browser.click('#limit option[value="closing_speed"]')
            browser.type("#limit [name=low]", f"{_SPEED}{ENTER}")
            browser.find("body[data-complete] #verdict.fail")
            browser.picture(folder / "picture.png")
        finally:
            process.terminate()


def show_report(browser: Browser, folder: Path) -> None:
    """Write a report of the example against limits, and open it."""
    (folder / "limits.yaml").write_text(_LIMITS, encoding="utf-8")
    new, old = "rack/inspection_2026-03-02.csv", "rack/inspection_2014-05-12.csv"
    judged = ["--before", old, "--config", "my.yaml", "limits.yaml", "--output", "report.html"]
    for command in (
        ["example", "rack", "--inspections"],
        ["inspect", new, "--output", "my.yaml"],
        ["report", new, *judged],
    ):
        subprocess.run([sys.executable, "-m", "breaker", *command], cwd=folder, check=True)
    browser.open((folder / "report.html").as_uri())
    browser.find("table")
    browser.picture(folder / "picture.png")


def draw(show: Callable, size: tuple[int, int], target: Path) -> None:
    """Call ``show`` in a window of ``size`` pixels, and write the picture with few colours."""
    with TemporaryDirectory() as name:
        browser = Browser(Path(name), size)
        try:
            show(browser, Path(name))
            content = Path(name, "picture.png").read_bytes()
        finally:
            browser.end()
    with Image.open(BytesIO(content)) as picture:
        picture.convert("RGB").quantize(_COLOURS).save(target, optimize=True)
    print(f"{target.name}: {target.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    draw(show_page, (1440, 900), PAGE)
    draw(show_report, (640, 1215), REPORT)
