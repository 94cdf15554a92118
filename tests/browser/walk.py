"""Walk through `breaker view` in a real browser: `make test-browser`.

Journeys: from an unknown export to a sheet; a limit that changes the verdict; a life and a fleet in
the list; two inspections. axe checks each page. Pictures of each, in a small light and a large dark
window, go into ``build/browser/``, to be looked at.
"""

import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.browser.chromium import ENTER, Browser
from tests.exports import pole, write

PICTURES = Path("build/browser")
AXE = Path("build/axe/axe_playwright_python/axe.min.js")
ODD = "$$\\frac{a}{b}$$ <b>"  # a name that tries to be a formula, and HTML
COMPLETE = "body[data-complete]"
ROW = 'a[href^="/inspection?file={}"]'


@contextmanager
def viewed(folder: Path) -> Iterator[str]:
    """Yield the address of a page of a folder, as the command prints it."""
    command = [sys.executable, "-m", "breaker", "view", str(folder), "--no-browser"]
    about = {"stdout": subprocess.PIPE, "text": True, "cwd": folder.parent}
    with subprocess.Popen(command, **about) as process:
        try:
            yield re.search(r"http://\S+", process.stdout.readline())[0]
        finally:
            process.terminate()


def exports(folder: Path) -> Path:
    """Write a life of four inspections, a fleet of two breakers, and an export without its rate."""
    folder.mkdir()
    for k in range(4):
        about = {"date": f"14/03/{2012 + k}", "serial": "HV-1", "motions": ("closing", "opening")}
        write(folder / f"life_{k}.csv", rate=5.0, seed=k, stroke=178.0 - 0.4 * k, **about)
    for k in range(2):
        for seed, phase in enumerate("RYB"):
            about = {"serial": f"HV-{20 + k}", "bay": f"Bay {k}", "date": f"1{3 + k}/05/2021"}
            pole(folder / f"bay{k}_{phase}.csv", phase, seed, stroke=178.0 - 9.0 * k, **about)
    odd = folder / "life_3.csv"
    text = odd.read_text("latin-1").replace("Coil 6 (A)", f"{ODD} (A)")
    odd.write_text(text, "latin-1")
    samples = [line.split(",")[6:8] for line in text.splitlines()[44:]]
    (folder / "unknown.txt").write_text("\n".join(["p1;p2", *map(";".join, samples), ""]))
    return folder


def to_a_sheet(browser: Browser, downloads: Path) -> None:
    """Read an export of unknown layout, and download its sheet."""
    browser.click(ROW.format("unknown.txt"))
    browser.find("#verdict.unread")
    browser.picture(PICTURES / "unknown.png")
    browser.type("#set-rate", f"5{ENTER}")
    browser.find("#verdict.none")
    browser.click("#sheet")
    browser.until((downloads / "sheet.html").exists, "the sheet")


def a_limit(browser: Browser) -> None:
    """Set and remove a limit, which changes the verdict; in the end it is failed."""
    browser.click(ROW.format("life_1.csv"))
    browser.find("#verdict.none")
    for text, verdict in (("190", "pass"), ("", "none"), ("170", "fail")):
        browser.click('#limit option[value="closing stroke"]')
        browser.type("#limit [name=high]", f"{text}{ENTER}")
        browser.find(f"#verdict.{verdict}")


def the_list(browser: Browser, name: str) -> list:
    """Look at a life and a fleet, with all verdicts; return the findings of axe."""
    browser.find(f"{COMPLETE} .verdict.fail")
    browser.picture(PICTURES / f"list-{name}.png", whole=True)
    return findings(browser)


def two_inspections(browser: Browser, name: str) -> list:
    """Compare an inspection with the first one, both motions; return the findings of axe."""
    browser.click(ROW.format("life_3.csv"))
    browser.click("#earlier option:last-child")
    browser.until(lambda: "life_0" in browser.run("return location.search"), "the first one")
    browser.find(f"{COMPLETE} .below h2")
    browser.click("#tab1")
    browser.find("#plot1:not([hidden]) svg")
    browser.picture(PICTURES / f"opening-{name}.png")
    browser.click("#tab0")
    browser.run("document.querySelectorAll('details').forEach((d) => (d.open = true))")
    browser.picture(PICTURES / f"two-{name}.png", whole=True)
    return findings(browser)


def findings(browser: Browser) -> list:
    """Return the serious findings of axe on this page, and print all."""
    browser.run(AXE.read_text(encoding="utf-8"))
    result = browser.run_until(
        "const done = arguments[0];"
        "axe.run(document, { resultTypes: ['violations'] }).then((r) => done(r.violations.map("
        "(v) => [v.impact, v.id, v.nodes.map((n) => n.target.join(' ')).slice(0, 4)])))"
    )
    print(browser.run("return document.title"), result)
    return [item for item in result if item[0] in ("serious", "critical")]


def walk() -> None:
    """Walk all journeys in a small light window, and the last two in a large dark one."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    serious = []
    with tempfile.TemporaryDirectory() as place, viewed(exports(Path(place, "curves"))) as address:
        own = address.partition("?")[0]
        for size, dark in (((1280, 800), False), ((1920, 1080), True)):
            downloads = Path(place, str(size[0]))
            downloads.mkdir()
            browser = Browser(downloads, size, dark)
            try:
                browser.open(address)
                if not dark:
                    to_a_sheet(browser, downloads)
                    browser.open(own)
                    a_limit(browser)
                    browser.open(own)
                serious += the_list(browser, str(size[0]))
                serious += two_inspections(browser, str(size[0]))
                assert not (failed := browser.errors()), failed  # of scripts, and of the policy
            finally:
                browser.end()
    assert not serious, serious
    print(f"all journeys were walked; look at {PICTURES}/")


if __name__ == "__main__":
    os.environ["OMP_NUM_THREADS"] = "1"
    walk()
