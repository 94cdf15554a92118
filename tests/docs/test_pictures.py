"""The pictures of the pages are what the functions of figures draw: none is stale or left over."""

import importlib.util
import io
import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from breaker.figures.style import save

DOCS = Path(__file__).parents[2] / "docs"
spec = importlib.util.spec_from_file_location("pictures", DOCS / "pictures.py")
pictures = importlib.util.module_from_spec(spec)
spec.loader.exec_module(pictures)
DATA = json.loads(pictures.DATA.read_text(encoding="utf-8"))
BLOCK, LEVELS = 16, 8.0  # pixels; levels of 255, in the mean over a block: a digit has 20


def apart(figure, file):
    """Largest difference of a block between a figure and a picture; inf of another size."""
    stream = io.BytesIO()
    stream.name = "a.png"
    save(figure, stream)
    first, second = (np.asarray(Image.open(each).convert("RGB"), float) for each in (stream, file))
    if first.shape != second.shape:
        return np.inf
    rows, columns = (size // BLOCK for size in first.shape[:2])
    off = abs(first - second).mean(axis=2)[: rows * BLOCK, : columns * BLOCK]
    return off.reshape(rows, BLOCK, columns, BLOCK).mean(axis=(1, 3)).max()


@pytest.mark.parametrize("name", ["verdict.png", "visits.png"])
def test_a_picture_is_what_is_drawn(name):
    assert apart(pictures.drawn(DATA)[name], DOCS / name) < LEVELS, "run: make pictures"


def test_another_number_is_seen():
    text = json.dumps(DATA)
    number = re.search(r"certain at ([\d,]*\d)", text)[1]
    changed = json.loads(text.replace(number, number[:-1] + ("7" if number[-1] == "1" else "1")))
    changed["visits"]["changes"][0]["today"] += 1.0
    for name, figure in pictures.drawn(changed).items():
        assert apart(figure, DOCS / name) > 2 * LEVELS


def test_no_picture_is_left_over():
    there = {path.name for path in DOCS.glob("*.png")}
    assert there == {*pictures.drawn(DATA), "page.png"}  # which docs/page.py takes in a browser
    texts = [DOCS.parent / "README.md", *DOCS.rglob("*.md")]
    words = "".join(path.read_text(encoding="utf-8") for path in texts)
    assert there <= {*re.findall(r"\]\((?:docs/|\.\./)?(\w+\.png)\)", words)}
