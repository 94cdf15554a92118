"""Style of all figures: sizes, colours, fonts and titles; and functions that write a figure.

Figures are made without pyplot, so no figure stays open and no window system is needed.
"""

import logging
import re
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from io import BytesIO
from pathlib import Path
from textwrap import wrap
from typing import ParamSpec

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.font_manager import fontManager
from matplotlib.text import Annotation
from PIL import Image

from breaker.common.clean_text import visible_text

MEASURED = "#000000"  # measurements, and the truth of a simulation
MODEL = "#33486B"  # predictions of the model
PRIOR = "#9A9A9A"
REFERENCE = "#404040"  # diagonals, zero lines, limits
WARNING = "#B2182B"  # worse or wrong; never a change without a judgement
AMORTISED = "#D98C21"  # posterior of the network, and the opening
CORRECTED = "#2166AC"  # posterior after exact correction, and the closing
SERVICE = "#8A4B00"
CHANGED = "#7A35D0"

TIME = "time (ms)"
TRAVEL = "travel (mm)"

OWN_FONT = "DejaVu Sans"
"""Font of matplotlib, the same on all machines, with Latin, Greek, Cyrillic and Arabic letters."""

OTHER_FONTS = (
    *("Noto Sans", "Noto Sans CJK SC", "Noto Sans CJK JP", "Noto Sans CJK KR", "Noto Sans SC"),
    *("Source Han Sans SC", "WenQuanYi Micro Hei", "Droid Sans Fallback", "Microsoft YaHei"),
    *("PingFang SC", "Hiragino Sans", "Arial Unicode MS", "IPAGothic", "Yu Gothic", "MS Gothic"),
    *("Malgun Gothic", "NanumGothic", "Noto Sans Hebrew", "Noto Sans Thai", "Noto Sans Symbols"),
)
"""Fonts for letters that ``OWN_FONT`` lacks, if a machine has them."""

_LACKS = r"(?s)Glyph .* missing from"
_BOXES = (
    "no font of this machine has some signs of a picture, so boxes stand there; install one that "
    "has, such as Noto Sans CJK of Chinese, Japanese and Korean"
)

_SETTINGS = {
    "figure.dpi": 150,
    "savefig.dpi": "figure",
    "mathtext.fontset": "dejavusans",
    "font.size": 10,
    "axes.titlesize": 11,
    "figure.titlesize": 14,
    "figure.titleweight": "bold",
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "legend.frameon": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E6E6E6",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.4,
    "axes.formatter.useoffset": False,
    "figure.constrained_layout.h_pad": 0.06,
    "figure.constrained_layout.w_pad": 0.06,
}
# The mean width of a letter of DejaVu Sans is 0.58 of its size, so an inch takes 125 letters of
# 1 pt; bold letters are a tenth wider.
_LETTERS = 125.0

P = ParamSpec("P")


@contextmanager
def _settings() -> Iterator[None]:
    """Draw in the project's style; log an error if no font has a character."""
    there = {font.name for font in fontManager.ttflist}
    fonts = [OWN_FONT, *(font for font in OTHER_FONTS if font in there)]
    with mpl.rc_context(), warnings.catch_warnings(record=True) as caught:
        warnings.filterwarnings("always", _LACKS)
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS | {"font.family": fonts, "svg.hashsalt": "breaker"})
        yield
    if any(re.match(_LACKS, str(warning.message)) for warning in caught):
        logging.getLogger("breaker").error(_BOXES)


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Make a figure function use the project's style, and then restore matplotlib's settings."""

    @wraps(draw)
    def wrapper(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with _settings():
            warnings.filterwarnings("ignore", _LACKS)  # repeated when the file is written
            figure = draw(*args, **kwargs)
            if figure.axes:
                figure.get_layout_engine().execute(figure)
            figure.set_layout_engine(None)  # computed once: it takes a third of each drawing
        return figure

    return wrapper


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure with a size in inches and a layout without overlaps."""
    return Figure(figsize=(width, height), layout="constrained")


def title(figure: Figure, finding: str, about: str = "", *, failed: bool = False) -> None:
    """Write the finding above a figure, red for a failure, and below it what the figure shows."""
    width = figure.get_figwidth()
    others = within(about, width, 10.0)
    room = int(np.ceil(1.2 * 10.0 / 14.0 * len(others.splitlines())))  # lines of the larger letters
    text = "\n".join([within(finding, 0.9 * width, 14.0), *[" "] * room])
    above = figure.suptitle(text, color=WARNING if failed else "black")
    look = {"ha": "center", "va": "bottom", "fontsize": 10.0, "linespacing": 1.3}
    figure.add_artist(Annotation(others, (0.5, 0.0), xycoords=above, **look))


def within(text: str, width: float, size: float = 11.0) -> str:
    """Return a text in lines of at most ``width`` inches, in letters of ``size`` pt."""
    letters = max(10, int(_LETTERS * width / size))
    return "\n".join(line for part in text.splitlines() for line in wrap(part, letters))


def literal(text: object) -> str:
    """Return a text on one line, without mathematics and invisible characters."""
    return visible_text(" ".join(str(text).splitlines())).replace("$", r"\$")


def shortened(text: str, most: int) -> str:
    """Return the first and last letters of a text with more than ``most`` letters."""
    half = most // 2
    return text if len(text) <= most else f"{text[: half - 1]}…{text[-half:]}"


def encoded(figure: Figure, form: str) -> bytes:
    """Return the bytes of a figure in a format, such as "png", without a date."""
    date = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(form)
    file = BytesIO()
    with _settings():
        figure.savefig(file, format=form, **({"metadata": date} if date else {}))
    return file.getvalue()


def save(figure: Figure, path: str | Path) -> None:
    """Write a figure as PNG of 256 colours, which takes a third of the bytes."""
    with Image.open(BytesIO(encoded(figure, "png"))) as picture:
        picture.convert("RGB").quantize(256, dither=Image.Dither.NONE).save(path, optimize=True)
