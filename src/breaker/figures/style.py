"""The one style of all figures: sizes, colours, panels, legends, and marks that several draw.

Matplotlib's settings are changed inside :func:`styled` only. Figures are made without pyplot, so
nothing is kept open and no window system is asked for.
"""

import logging
import re
from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, ParamSpec

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text
from numpy.typing import ArrayLike
from PIL import Image

from breaker.figures.encoding import families, quiet, without_font
from breaker.model.parameters import ONSET, PARAMETERS
from breaker.reading.files.guards import printable

if TYPE_CHECKING:  # figures of single records do without
    import xarray as xr

OUTPUTS = {each.name: each for each in (*PARAMETERS, ONSET)}
"""What is inferred, by name: symbols, units, meanings and colours."""

MEASURED = "#000000"  # what was measured, and the truth of a simulation
MODEL = "#33486B"  # what the model predicts
PRIOR = "#9A9A9A"
REFERENCE = "#404040"  # diagonals, zero lines, limits
WARNING = "#B2182B"
AMORTISED = "#D98C21"  # posterior by the network alone
CORRECTED = "#2166AC"  # posterior brought to the exact one

P = ParamSpec("P")

TIME = "time (ms)"
TRAVEL = "travel (mm)"
MODELLED = "two-spring model"  # of which drives simulated records are, if of no family

_SOURCES = {"closing": "Closing", "opening": "Opening", "both": "Both motions"}
_NAMES = re.compile(rf"\b({'|'.join(OUTPUTS)})\b")
_LETTERS = 8.2  # of a title, per inch of its figure
_PANEL_LETTERS = 125.0  # of 1 pt, per inch
_LONGEST = 46  # letters of a file's name in a title
BAND = {"color": PRIOR, "alpha": 0.25, "lw": 0}  # of tolerances

_SETTINGS = {
    "figure.dpi": 150,
    "savefig.dpi": "figure",
    "mathtext.fontset": "dejavusans",
    "font.size": 10,
    "axes.titlesize": 11,
    "axes.labelsize": 10,
    "figure.titlesize": 14,
    "figure.titleweight": "bold",
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "legend.fontsize": 10,
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


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Make a figure function work in the project's style and leave the settings as they were."""

    @wraps(draw)
    def wrapper(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with mpl.rc_context(), quiet():
            mpl.rcdefaults()
            mpl.rcParams.update(_SETTINGS | {"font.family": families()})
            figure = draw(*args, **kwargs)
            figure.draw_without_rendering()  # ticks are made on drawing, with the settings of then
            # Places are found: each time that they are looked for takes a third of all drawing.
            figure.set_layout_engine(None)
        return figure

    return wrapper


def save(figure: Figure, path: str | Path) -> None:
    """Write a figure as PNG of 256 colours, a third of the size: a report holds all figures.

    Signs that no font has are said in a warning of the log.
    """
    canvas = FigureCanvasAgg(figure)
    with quiet():
        canvas.draw()
    if lacking := without_font([figure]):
        logging.getLogger("breaker").warning("%s: %s", path, lacking)
    colours = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    colours.quantize(256, dither=Image.Dither.NONE).save(path, optimize=True)


def symbols(names: Sequence[str]) -> list[str]:
    """Return the symbols of outputs."""
    return [OUTPUTS[name].symbol for name in names]


def literal(text: object) -> str:
    """Return a text, with names that a user gave, without signs of mathematics or none at all.

    >>> literal("5 $ or more")
    '5 \\\\$ or more'
    """
    return printable(str(text)).replace("$", r"\$")


def spoken(text: object) -> str:
    """Return a literal text for somebody who knows no names of code: words, and no underscores.

    >>> spoken("slow_opening: measured travel_time above 9.5 ms, change of f below -5 %")
    'slow opening: measured travel time above 9.5 ms, change of closing force $f$ below -5 %'
    """
    parts = _NAMES.split(literal(text))
    named = [f"{OUTPUTS[name].word} {OUTPUTS[name].symbol}".strip() for name in parts[1::2]]
    plain = [part.replace("_", " ") for part in parts[::2]]
    return "".join(a + b for a, b in zip(plain, [*named, ""], strict=True))


def file_name(path: object) -> str:
    """Return the name of a file without its folder, of a long one the first and last letters.

    >>> file_name("visits/North_400_kV_Bay_4_circuit_breaker_Q0_closing_after_overhaul.csv")
    'North_400_kV_Bay_4_cir…sing_after_overhaul.csv'
    """
    return shortened(re.split(r"[/\\]", str(path))[-1], _LONGEST)


def shortened(text: str, most: int) -> str:
    """Return the first and last letters of a text that has more than so many."""
    half = most // 2
    return text if len(text) <= most else f"{text[: half - 1]}…{text[-half:]}"


def within(text: str, width: float, size: float = 11.0) -> str:
    """Return a literal text in lines that are not wider than inches, its letters of so many pt."""
    return fill(literal(text), max(10, int(_PANEL_LETTERS * width / size)))


def title(figure: Figure, text: str, **look: object) -> Text:
    """Write and return a title above a figure, in lines that are not wider than it."""
    width = int(_LETTERS * figure.get_figwidth())
    lines = [fill(line, width) for line in text.splitlines()]
    return figure.suptitle("\n".join(lines), **look)


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure, size in inches, that lays itself out without overlaps."""
    return Figure(figsize=(width, height), layout="constrained")


def panels(
    count: int, *, columns: int = 4, width: float = 3.2, height: float = 2.7, **shared: bool
) -> tuple[Figure, list[Axes]]:
    """Return a figure with ``count`` panels in rows, spare places left empty.

    ``width`` and ``height`` are inches per panel; ``shared`` is ``sharex`` and ``sharey``.
    """
    columns = min(columns, count)
    rows = -(-count // columns)
    figure = new_figure(width * columns, height * rows + 0.9)
    grid = figure.subplots(rows, columns, squeeze=False, **shared)
    axes = list(grid.flat)
    for spare in axes[count:]:
        spare.remove()
    for above in axes[max(0, count - columns) : count]:
        above.xaxis.set_tick_params(labelbottom=True)  # the panel under it may be missing
    return figure, axes[:count]


def heading(figure: Figure, source: str, text: str, outcome: str = "", *, of: str = "") -> Text:
    """Write and return the title: what is shown, of which motion or both, and what came out.

    ``of`` says of which drives.
    """
    first = ", ".join(filter(None, [_SOURCES[source], of]))
    return title(figure, "\n".join([f"{first}: {text}", outcome]).strip())


def legend_below(figure: Figure, handles: Sequence, *, columns: int | None = None) -> None:
    """Put one legend for all panels below them, of those handles that are there."""
    there = [handle for handle in handles if handle]
    figure.legend(handles=there, loc="outside lower center", ncols=columns or len(there))


def line_key(label: str, color: str = REFERENCE, ls: str = "-", **look: object) -> Line2D:
    """Return a line, or a line with markers, for a legend."""
    return Line2D([], [], color=color, ls=ls, label=label, **look)


def dot_key(label: str, color: str = REFERENCE, marker: str = "o", **look: object) -> Line2D:
    """Return a marker for a legend."""
    return Line2D([], [], color=color, ls="", marker=marker, label=label, **look)


def band_key(label: str, color: str, alpha: float) -> Patch:
    """Return a filled area for a legend."""
    return Patch(color=color, alpha=alpha, lw=0, label=label)


def draw_intervals(
    axis: Axes, rows: ArrayLike, ends: Sequence, *, color: str, marker: str = "o", **look: float
) -> None:
    """Draw low ends, middles and high ends in rows; ``look`` is that of the lines."""
    low, middle, high = ends
    axis.hlines(rows, low, high, color=color, **look)
    axis.plot(middle, rows, marker, color=color, mec="white", mew=0.8, ms=7)


def label_outer(axes: Sequence[Axes], xlabel: str, ylabel: str | None = None) -> None:
    """Label shared axes: x where the ticks have numbers, y in the first column."""
    for axis in axes:
        if axis.xaxis.get_tick_params()["labelbottom"]:
            axis.set_xlabel(xlabel)
        if ylabel is not None and axis.get_subplotspec().is_first_col():
            axis.set_ylabel(ylabel)


def limit_panels(
    data: "xr.Dataset",
    titles: Sequence[str],
    *,
    height: float,
    above: int = 0,
    sharex: bool = True,
    sharey: bool = True,
) -> tuple[Figure, list[Axes]]:
    """Return a figure with one panel per limit of ``data``, over the operations.

    ``titles`` stand beside the names of the limits, ``above`` lines are kept free below them, and
    ``height`` is inches per panel.
    """
    count = len(titles)
    columns, width = (2, 6.4) if count > 1 else (1, 10.0)
    figure, axes = panels(
        count, columns=columns, width=width, height=height, sharex=sharex, sharey=sharey
    )
    for axis, limit, words in zip(axes, data["limit"].values, titles, strict=True):
        lines = f"{limit}: {words}".splitlines()
        said = "\n".join(fill(spoken(line), int(width * 10.5)) for line in lines)
        axis.set_title(said, loc="left", pad=6.0 + 14.0 * above)
        axis.margins(x=0.01)
    label_outer(axes, "operation")
    return figure, axes


def spans(operation: np.ndarray, inside: np.ndarray) -> list[tuple[float, float]]:
    """Return where runs of the operations ``(o,)`` inside begin and end, halfway to neighbours."""
    ends = edges(operation)
    turns = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
    return [(ends[i], ends[j]) for i, j in turns.reshape(-1, 2)]


def edges(operation: np.ndarray) -> np.ndarray:
    """Return the edges ``(o + 1,)`` of cells around operations ``(o,)``."""
    operation = np.asarray(operation, dtype=float)
    if operation.size < 2:
        return np.concatenate([operation - 0.5, operation[-1:] + 0.5])
    half = np.diff(operation) / 2
    first, last = operation[:1] - half[:1], operation[-1:] + half[-1:]
    return np.concatenate([first, operation[:-1] + half, last])
