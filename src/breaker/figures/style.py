"""The one style of all figures: sizes, colours, panels, legends.

Matplotlib's settings are changed inside :func:`styled` only. Figures are made without pyplot, so
nothing is kept open and no window system is asked for.
"""

from collections.abc import Callable, Sequence
from functools import wraps
from typing import ParamSpec

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.mechanism import MOTIONS, ONSET, PARAMETERS, Parameter

__all__ = [
    "AMORTISED",
    "COLOURS",
    "CORRECTED",
    "MEASURED",
    "MODEL",
    "PRIOR",
    "REFERENCE",
    "TIME",
    "TRAVEL",
    "WARNING",
    "colour",
    "heading",
    "legend_below",
    "new_figure",
    "panels",
    "parameter",
    "styled",
]

COLOURS = {
    "mu": "#CC79A7",
    "k_a": "#0072B2",
    "k_b": "#56B4E9",
    "gamma_a": "#D55E00",
    "gamma_b": "#E69F00",
    "f": "#009E73",
    "L": "#661141",
    "onset": "#7A35D0",
}
"""Colour of each output, the same in every figure. Six are of the palette of Okabe and Ito; its
yellow is too pale for lines and its black is kept for measurements, so that dark wine and violet
stand in. All pairs stay apart in the common colour deficiencies (a test says how far)."""

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

_SETTINGS = {
    "figure.dpi": 150,
    "savefig.dpi": "figure",
    "font.family": "DejaVu Sans",  # comes with matplotlib: the same on every machine
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

_OUTPUTS = {each.name: each for each in (*PARAMETERS, ONSET)}


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Make a figure function work in the project's style and leave the settings as they were."""

    @wraps(draw)
    def wrapper(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with mpl.rc_context():
            mpl.rcdefaults()
            mpl.rcParams.update(_SETTINGS)
            figure = draw(*args, **kwargs)
            figure.draw_without_rendering()  # ticks are made on drawing, with the settings of then
        return figure

    return wrapper


def parameter(name: str) -> Parameter:
    """Return the output of a name.

    Raises:
        ValueError: If there is none.
    """
    if name not in _OUTPUTS:
        raise ValueError(f"no output is called {name!r}; there are {', '.join(_OUTPUTS)}")
    return _OUTPUTS[name]


def colour(name: str) -> str:
    """Return the colour of an output, the same in every figure."""
    return COLOURS[parameter(name).name]


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure, size in inches, that lays itself out without overlaps."""
    return Figure(figsize=(width, height), layout="constrained")


def panels(
    count: int,
    *,
    columns: int = 4,
    width: float = 3.2,
    height: float = 2.7,
    sharex: bool = False,
    sharey: bool = False,
) -> tuple[Figure, list[Axes]]:
    """Return a figure with ``count`` panels in rows, spare places left empty.

    ``width`` and ``height`` are inches per panel.
    """
    columns = min(columns, count)
    rows = -(-count // columns)
    figure = new_figure(width * columns, height * rows + 0.9)
    grid = figure.subplots(rows, columns, sharex=sharex, sharey=sharey, squeeze=False)
    axes = list(grid.flat)
    for spare in axes[count:]:
        spare.remove()
    for above in axes[max(0, count - columns) : count]:
        above.xaxis.set_tick_params(labelbottom=True)  # the panel under it may be missing
    return figure, axes[:count]


def heading(figure: Figure, motion: str, text: str, verdict: str = "") -> None:
    """Write the title: what is shown, of which motion, and in a second line what came out.

    Raises:
        ValueError: If there is no such motion.
    """
    if motion not in MOTIONS:
        raise ValueError(f"no motion is called {motion!r}; there are {', '.join(MOTIONS)}")
    figure.suptitle(f"{motion.capitalize()}: {text}" + (f"\n{verdict}" if verdict else ""))


def legend_below(figure: Figure, handles: Sequence, *, columns: int | None = None) -> None:
    """Put one legend for all panels below them."""
    count = len(handles) if columns is None else columns
    figure.legend(handles=handles, loc="outside lower center", ncols=count)
