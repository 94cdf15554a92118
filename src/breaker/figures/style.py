"""The one style of all figures: sizes, colours, fonts, titles, and figures on their way to a file.

Figures are made without pyplot, so nothing is kept open and no window system is asked for.
"""

import logging
import re
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cache, wraps
from io import BytesIO
from pathlib import Path
from textwrap import wrap
from typing import ParamSpec

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, fontManager, get_font
from matplotlib.text import Annotation, Text
from PIL import Image

from breaker.common.numerals import first_of
from breaker.common.text import visible_text

MEASURED = "#000000"  # what was measured, and the truth of a simulation
MODEL = "#33486B"  # what the model predicts
PRIOR = "#9A9A9A"
REFERENCE = "#404040"  # diagonals, zero lines, limits
WARNING = "#B2182B"  # what is worse, or wrong; never what merely changed
AMORTISED = "#D98C21"  # posterior by the network alone, and the opening
CORRECTED = "#2166AC"  # posterior corrected to the exact one, and the closing
SERVICE = "#8A4B00"
CHANGED = "#7A35D0"

TIME = "time (ms)"
TRAVEL = "travel (mm)"

OWN_FONT = "DejaVu Sans"
"""Comes with matplotlib: the same on every machine. Has Latin, Greek, Cyrillic, Arabic letters."""

OTHER_FONTS = (
    *("Noto Sans", "Noto Sans CJK SC", "Noto Sans CJK JP", "Noto Sans CJK KR", "Noto Sans SC"),
    *("Source Han Sans SC", "WenQuanYi Micro Hei", "Droid Sans Fallback", "Microsoft YaHei"),
    *("PingFang SC", "Hiragino Sans", "Arial Unicode MS", "IPAGothic", "Yu Gothic", "MS Gothic"),
    *("Malgun Gothic", "NanumGothic", "Noto Sans Hebrew", "Noto Sans Thai", "Noto Sans Symbols"),
)
"""Families that have what ``OWN_FONT`` lacks, where a machine has them."""

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
# Mean width of a letter of DejaVu Sans is 0.58 of its size, so 125 letters of 1 pt take an inch;
# bold ones are a tenth wider.
_LETTERS = 125.0

P = ParamSpec("P")


@contextmanager
def _settings() -> Iterator[None]:
    """Draw in the project's style, without matplotlib's warnings of signs that no font has."""
    logger = logging.getLogger("matplotlib")
    level = logger.level
    with mpl.rc_context(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"(?s)Glyph .* missing from")
        logger.setLevel(logging.ERROR)
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS | {"font.family": families(), "svg.hashsalt": "breaker"})
        try:
            yield
        finally:
            logger.setLevel(level)


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Make a figure function work in the project's style and leave the settings as they were."""

    @wraps(draw)
    def wrapper(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with _settings():
            figure = draw(*args, **kwargs)
            if figure.axes:
                figure.get_layout_engine().execute(figure)
            figure.set_layout_engine(None)  # to find it at each drawing takes a third of the time
        return figure

    return wrapper


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure, size in inches, that lays itself out without overlaps."""
    return Figure(figsize=(width, height), layout="constrained")


def title(figure: Figure, finding: str, about: str = "", *, failed: bool = False) -> None:
    """Write what was found above a figure, red if that is a failure, and below what is shown."""
    width = figure.get_figwidth()
    others = within(about, width, 10.0)
    room = int(np.ceil(1.2 * 10.0 / 14.0 * len(others.splitlines())))  # lines of the larger letters
    text = "\n".join([within(finding, 0.9 * width, 14.0), *[" "] * room])
    above = figure.suptitle(text, color=WARNING if failed else "black")
    look = {"ha": "center", "va": "bottom", "fontsize": 10.0, "linespacing": 1.3}
    figure.add_artist(Annotation(others, (0.5, 0.0), xycoords=above, **look))


def within(text: str, width: float, size: float = 11.0) -> str:
    """Return a text in lines that are not wider than inches, its letters of so many pt."""
    letters = max(10, int(_LETTERS * width / size))
    return "\n".join(line for part in text.splitlines() for line in wrap(part, letters))


def literal(text: object) -> str:
    """Return a text on one line, without mathematics and signs that are not seen."""
    return visible_text(" ".join(str(text).splitlines())).replace("$", r"\$")


def file_name(path: object) -> str:
    """Return the name of a file without its folder, shortened if it is long."""
    return shortened(re.split(r"[/\\]", str(path))[-1], 46)


def shortened(text: str, most: int) -> str:
    """Return the first and last letters of a text that has more than so many."""
    half = most // 2
    return text if len(text) <= most else f"{text[: half - 1]}…{text[-half:]}"


def save(figure: Figure, path: str | Path) -> None:
    """Write a figure as PNG of 256 colours, a third of the size; log signs that no font has."""
    canvas = FigureCanvasAgg(figure)
    with _settings():
        canvas.draw()
    if lacking := without_font([figure]):
        logging.getLogger("breaker").warning("%s: %s", path, lacking)
    colours = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    colours.quantize(256, dither=Image.Dither.NONE).save(path, optimize=True)


def encoded(figure: Figure, form: str) -> bytes:
    """Return a file of a format, such as "png", without its date; signs not shown are escaped."""
    date = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(form)
    for text in figure.findobj(Text):
        text.set_text(visible_text(text.get_text()))
    file = BytesIO()
    with _settings():
        figure.savefig(file, format=form, **({"metadata": date} if date else {}))
    return file.getvalue()


def families() -> list[str]:
    """Return the families of letters: that of matplotlib, and others that this machine has."""
    there = {font.name for font in fontManager.ttflist}
    return [OWN_FONT, *(font for font in OTHER_FONTS if font in there)]


def without_font(figures: Iterable[Figure]) -> str:
    """Say which signs in figures no font of this machine has; empty if there is none."""
    lacking = {}
    for text in (text_box.get_text() for figure in figures for text_box in figure.findobj(Text)):
        # Text with mathematics in it is set in matplotlib's own font alone.
        others = [] if text.replace(r"\$", "").count("$") > 1 else families()[1:]
        for sign in (character for character in text if not character.isspace()):
            if not any(ord(sign) in _signs(font) for font in (OWN_FONT, *others)):
                lacking[sign] = ""
    if not lacking:
        return ""
    return (
        f"no font of this machine has {first_of([*lacking], 20)}, so boxes stand there; install "
        "one that has, such as Noto Sans CJK of Chinese, Japanese and Korean"
    )


@cache
def _signs(family: str) -> frozenset[int]:
    """Numbers of the signs that a family has."""
    return frozenset(get_font(findfont(FontProperties(family=family))).get_charmap())
