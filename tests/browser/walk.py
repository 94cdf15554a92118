"""Walks through `breaker view` in a real browser: `make test-browser`.

Three journeys: an unknown export to a sheet, in two clicks; a wrong setting, said and mended by
keyboard alone; two visits. Each page is checked by
axe, and pictures of each, at 1280 and 1920 pixels and in dark mode, go into ``build/browser/``, to
be looked at.
"""

import os
import re
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from pathlib import Path

from breaker.cli import main
from tests.browser.chromium import ENTER, TAB, Browser
from tests.exports import write

ALL = "\ue009a\ue000"  # Ctrl-A, and all keys up again
PICTURES = Path("build/browser")
AXE = Path("build/axe/axe_playwright_python/axe.min.js")
ODD = "$$\\frac{a}{b}$$ <b>"  # a name that tries to be a formula, and HTML


@contextmanager
def viewed(folder: Path):
    """The address of a page of a folder, as the command prints it."""
    command = [sys.executable, "-m", "breaker", "view", str(folder), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            yield re.search(r"http://\S+", process.stdout.readline())[0]
        finally:
            process.terminate()


def exports(folder: Path, count: int) -> None:
    """Exports of visits to one breaker."""
    motions = (("closing",), ("opening",), ("closing", "opening"))
    for k in range(count):
        about = {"date": f"{1 + k % 28:02d}/03/2021", "motions": motions[k % 3]}
        write(folder / f"export_{k:02d}.csv", rate=5.0, seed=k, **about)
    odd = folder / "export_02.csv"
    odd.write_text(odd.read_text("latin-1").replace("Coil 6 (A)", f"{ODD} (A)"), "latin-1")


def to_a_sheet(browser: Browser, address: str, folder: Path, downloads: Path) -> None:
    """An export of unknown layout, to a sheet that is that of the command."""
    browser.open(address)
    for each in ('a[href="/visit?file=export_02.csv"]', "#html"):  # a sheet by two clicks
        browser.click(each)
    sheet = downloads / "sheet.html"
    browser.until(sheet.exists, "the sheet")
    settings = downloads / "my.yaml"
    browser.run("document.getElementById('settings-name').value = arguments[0]", str(settings))
    browser.click("form.save button")
    browser.until(settings.exists, "the settings")
    given = [str(folder / "export_02.csv"), "--config", str(settings)]
    assert main(["report", *given, "--output", str(downloads / "same.html")]) == 0
    assert sheet.read_bytes() == (downloads / "same.html").read_bytes()
    browser.run(
        "for (const [id, at] of [['cursor1', 60], ['cursor2', 90]]) {"
        "const field = document.getElementById(id); field.value = at;"
        "field.dispatchEvent(new Event('change')); }"
    )
    browser.until(lambda: "30 ms apart" in browser.text("#readings"), "readings", 20.0)
    assert browser.run("return plot !== null")


def by_keyboard(browser: Browser, address: str) -> None:
    """A wrong rate is said, and mended, without a mouse; each change is answered at once."""
    browser.open(address.partition("?")[0])
    browser.reach('a[href="/visit?file=export_05.csv"]')
    browser.press(ENTER)
    browser.find("#set-rate")
    browser.reach("#set-rate")
    browser.press(f"{ALL}-3{TAB}")
    browser.until(lambda: "endurance.format.rate" in browser.text("#verdict"), "a message")
    browser.picture(PICTURES / "wrong.png")
    browser.run("document.activeElement.blur()")
    browser.reach("#set-rate")
    browser.press(f"{ALL}5.0{TAB}")
    browser.find("#html")
    browser.reach("#set-sign")
    for sign in ("opens", "closes") * 3:
        before = browser.run("return document.body.dataset.took")
        browser.press(sign)
        browser.until(
            lambda before=before: browser.run("return document.body.dataset.took") != before,
            "the change",
        )
        browser.until(lambda: not browser.text("#busy"), "the page")
    browser.find("#html")
    browser.reach("#html")  # the focus stays in the page, and comes to the sheet


def two_visits(browser: Browser) -> None:
    """A visit beside the one before."""
    browser.click("header a")
    browser.click('input[name="file"][value="export_05.csv"]')
    browser.click('input[name="before"][value="export_02.csv"]')
    browser.click("#list button")
    browser.until(lambda: "Changes since" in browser.text("#values"), "the changes")


def accessible(browser: Browser, what: str) -> None:
    """No finding of axe is serious; the others are said."""
    if not AXE.exists():
        print(f"{what}: axe-core is not here, so accessibility is not checked: make test-browser")
        return
    browser.run(AXE.read_text(encoding="utf-8"))
    found = browser.run_until(
        "const done = arguments[0];"
        "axe.run(document, { resultTypes: ['violations'] }).then((r) => done(r.violations.map("
        "(each) => [each.impact, each.id, each.nodes.map((n) => n.target.join(' ')).slice(0, 4)])))"
    )
    grave = [each for each in found if each[0] in ("serious", "critical")]
    print(f"{what}: {len(grave)} serious findings of axe, {len(found) - len(grave)} others {found}")
    assert not grave, grave


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
            with viewed(folder) as address:
                browser = Browser(downloads, width, dark)
                try:
                    to_a_sheet(browser, address, folder, downloads)
                    accessible(browser, "a visit")
                    browser.picture(PICTURES / f"sheet-{name}.png", 5000)
                    if width == 1280 and not dark:
                        by_keyboard(browser, address)
                    two_visits(browser)
                    accessible(browser, "two visits")
                    browser.picture(PICTURES / f"visits-{name}.png", 5000)
                    browser.click("header a")
                    browser.until(lambda: "not looked into" not in browser.text(), "all files")  # noqa: B023
                    accessible(browser, "the list")
                    browser.picture(PICTURES / f"list-{name}.png", 1500)
                    sound(browser, address)
                finally:
                    browser.end()
    print(f"all journeys were walked; look at {PICTURES}/")


if __name__ == "__main__":
    os.environ["OMP_NUM_THREADS"] = "1"
    walk()
