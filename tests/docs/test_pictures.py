"""The pictures of the pages are made from the present data, by the present modules."""

import re
from pathlib import Path

from tests.scripts import ROOT, script

DOCS = ROOT / "docs"
pictures = script("docs/pictures.py")


def test_pictures_are_made_from_the_present_data():
    assert pictures.CHECKSUMS.read_text("utf-8") == pictures.checksums(), "run: make pictures"


def test_no_picture_is_left_over():
    there = {path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.png")}
    assert there == {*pictures.MODULES, "page.png", "pictures/report.png"}  # by docs/page.py
    texts = [DOCS.parent / "README.md", *DOCS.rglob("*.md")]
    words = "".join(path.read_text(encoding="utf-8") for path in texts)
    shown = re.findall(r"\]\((?:[\w.]+/)*(\w+\.png)\)", words)
    assert {Path(item).name for item in there} <= {*shown}
