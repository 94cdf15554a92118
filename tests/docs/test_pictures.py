"""The pictures of the pages are made from the present data, by the present modules."""

import importlib.util
import re
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"
spec = importlib.util.spec_from_file_location("pictures", DOCS / "pictures.py")
pictures = importlib.util.module_from_spec(spec)
spec.loader.exec_module(pictures)


def test_pictures_are_made_from_the_present_data():
    assert pictures.CHECKSUMS.read_text("utf-8") == pictures.checksums(), "run: make pictures"


def test_no_picture_is_left_over():
    there = {path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.png")}
    assert there == {*pictures.MODULES, "page.png"}  # which docs/page.py takes in a browser
    texts = [DOCS.parent / "README.md", *DOCS.rglob("*.md")]
    words = "".join(path.read_text(encoding="utf-8") for path in texts)
    shown = re.findall(r"\]\((?:[\w.]+/)*(\w+\.png)\)", words)
    assert {Path(each).name for each in there} <= {*shown}
