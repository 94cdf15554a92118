"""Walks through `breaker view` in a real browser: `make test-browser`.

The journeys: an unknown export to a sheet; a limit that changes the verdict; two inspections; a
life and a fleet in the list. Each page is checked by axe, and pictures of each, at three widths,
light and dark, go into ``build/browser/``, to be looked at.
"""

import os
import re
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from pathlib import Path

from tests.browser.chromium import ENTER, Browser
from tests.exports import pole, write

PICTURES = Path("build/browser")
AXE = Path("build/axe/axe_playwright_python/axe.min.js")
GRAVE: list = []
ODD = "$$\\frac{a}{b}$$ <b>"  # a name that tries to be a formula, and HTML
SIZES = ((1280, 800), (1440, 900), (1920, 1080))
COMPLETE = "body[data-complete]"
ROW = 'a[href^="/inspection?file={}"]'


@contextmanager
def viewed(folder: Path):
    """The address of a page of a folder, as the command prints it; types are kept beside it."""
    command = [sys.executable, "-m", "breaker", "view", str(folder), "--no-browser"]
    about = {"stdout": subprocess.PIPE, "text": True, "cwd": folder.parent}
    with subprocess.Popen(command, **about) as process:
        try:
            yield re.search(r"http://\S+", process.stdout.readline())[0]
        finally:
            process.terminate()


def exports(folder: Path) -> Path:
    """A life of ten inspections, a fleet of four breakers, and an export that lacks its rate."""
    folder.mkdir()
    for k in range(10):
        about = {"date": f"14/03/{2012 + k}", "serial": "HV-1", "motions": ("closing", "opening")}
        write(folder / f"life_{k:02d}.csv", rate=5.0, seed=k, stroke=178.0 - 0.4 * k, **about)
    for k in range(4):
        for seed, phase in enumerate("RYB"):
            about = {"serial": f"HV-{20 + k}", "bay": f"Bay {k}", "date": f"1{3 + k}/05/2021"}
            pole(folder / f"bay{k}_{phase}.csv", phase, seed, stroke=178.0 - 3.0 * k, **about)
    odd = folder / "life_09.csv"
    text = odd.read_text("latin-1").replace("Coil 6 (A)", f"{ODD} (A)")
    odd.write_text(text, "latin-1")
    samples = [line.split(",")[6:8] for line in text.splitlines()[44:]]
    (folder / "unknown.txt").write_text("\n".join(["p1;p2", *map(";".join, samples), ""]))
    return folder


def to_a_sheet(browser: Browser, downloads: Path) -> None:
    """An export of unknown layout, to a sheet."""
    browser.click(ROW.format("unknown.txt"))
    browser.find("#verdict.unread")
    browser.picture(PICTURES / "unknown.png")
    browser.type("#set-rate", f"5{ENTER}")
    browser.find("#verdict.none")
    browser.picture(PICTURES / "unknown-read.png")
    browser.click("#sheet")
    browser.until((downloads / "sheet.html").exists, "the sheet")


def a_limit(browser: Browser) -> None:
    """A limit that is set or removed changes the verdict; in the end it is failed."""
    browser.find("#verdict.none")
    for text, verdict in (("190", "pass"), ("", "none"), ("170", "fail")):
        browser.click('#limit option[value="closing stroke"]')
        browser.type("#limit [name=high]", f"{text}{ENTER}")
        browser.find(f"#verdict.{verdict}")


def two_inspections(browser: Browser, address: str, name: str) -> None:
    """An inspection over the first one, both motions, and a value shown on the curve."""
    browser.open(address.partition("?")[0])
    browser.click(ROW.format("life_09.csv"))
    browser.find("#earlier")
    browser.run(
        "const field = document.getElementById('earlier');"
        "field.selectedIndex = field.options.length - 1;"
        "field.dispatchEvent(new Event('change'))"
    )
    browser.until(lambda: "life_00" in browser.run("return location.search"), "the first one")
    browser.find(f"{COMPLETE} .below h2")
    browser.click("#tab1")
    browser.find("#plot1:not([hidden]) svg")
    browser.picture(PICTURES / f"opening-{name}.png")
    browser.click("#tab0")
    accessible(browser, f"two inspections, {name}")
    browser.picture(PICTURES / f"two-{name}.png")


def the_list(browser: Browser, address: str, name: str) -> None:
    """A life and a fleet, with all verdicts."""
    browser.open(address.partition("?")[0])
    browser.find(f"{COMPLETE} #list tr[data-query]:nth-of-type(11)")
    accessible(browser, f"the list, {name}")
    browser.picture(PICTURES / f"list-{name}.png", whole=True)


def accessible(browser: Browser, what: str) -> None:
    """Collect serious findings of axe, and print the others."""
    browser.run(AXE.read_text(encoding="utf-8"))
    result = browser.run_until(
        "const done = arguments[0];"
        "axe.run(document, { resultTypes: ['violations'] }).then((r) => done(r.violations.map("
        "(each) => [each.impact, each.id, each.nodes.map((n) => n.target.join(' ')).slice(0, 4)])))"
    )
    grave = [item for item in result if item[0] in ("serious", "critical")]
    print(
        f"{what}: {len(grave)} serious findings of axe, {len(result) - len(grave)} others {result}"
    )
    GRAVE.extend(grave)


def sound(browser: Browser, address: str) -> None:
    """No script failed, nothing was asked of elsewhere, and each field has a label."""
    own = address.partition("/?")[0]
    here = (own, "data:", "blob:", "chrome")
    elsewhere = [request for request in browser.requests() if not request.startswith(here)]
    assert not elsewhere, elsewhere
    failed = [e["message"] for e in browser.log("browser") if e["level"] == "SEVERE"]
    assert not failed, failed
    assert browser.run(
        "return [...document.querySelectorAll('main input, main select')].every("
        "(field) => field.type === 'hidden' || field.labels.length || field.ariaLabel)"
    )


def walk() -> None:
    """All journeys, and the pages with a failed inspection at each size."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as place, viewed(exports(Path(place, "curves"))) as address:
        for size, dark in [(size, dark) for dark in (False, True) for size in SIZES]:
            name = f"{size[0]}{'-dark' * dark}"
            downloads = Path(place, name)
            downloads.mkdir()
            browser = Browser(downloads, size, dark)
            try:
                browser.open(address)
                if name == "1280":
                    to_a_sheet(browser, downloads)
                    browser.open(address.partition("?")[0])
                    browser.click(ROW.format("life_01.csv"))
                    a_limit(browser)
                the_list(browser, address, name)
                two_inspections(browser, address, name)
                if name == "1280":
                    browser.run(
                        "document.querySelectorAll('details').forEach((d) => (d.open = true))"
                    )
                    accessible(browser, "all parts")
                    browser.picture(PICTURES / "whole.png", whole=True)
                sound(browser, address)
            finally:
                browser.end()
    assert not GRAVE, GRAVE
    print(f"all journeys were walked; look at {PICTURES}/")


if __name__ == "__main__":
    os.environ["OMP_NUM_THREADS"] = "1"
    walk()
