"""Parts of several figures: words for outputs, panels in rows, legends, intervals and states."""

import re
from collections.abc import Sequence
from itertools import pairwise
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from breaker.common.numerals import in_digits
from breaker.figures import style
from breaker.model.parameters import ONSET, PARAMETERS, Parameter

if TYPE_CHECKING:  # `breaker infer` draws pictures without xarray
    import xarray as xr


class _Outputs(dict):
    """Parameters by name; a parameter of your own model only has a name."""

    def __missing__(self, name: str) -> Parameter:
        return Parameter(name, "1", name, symbol=spoken(name), colour=style.MODEL)


OUTPUTS = _Outputs({output.name: output for output in (*PARAMETERS, ONSET)})
"""Inferred outputs by name: symbols, units, meanings and colours."""

SOURCES = {"closing": "Closing", "opening": "Opening", "both": "Both motions"}
STATES = {"unknown": "#5A5A5A", "ok": "#1B9E77", "planned": "#E08A00", "due": style.WARNING}
"""States of a limit, in the order of their numbers, with colours. Figures also print the word."""

_NAMES = re.compile(rf"\b({'|'.join(OUTPUTS)})\b")


def word(name: str) -> str:
    """Return the name of an output in a sentence."""
    return "start of motion" if name == ONSET.name else OUTPUTS[name].word or spoken(name)


def named(name: str) -> str:
    """Return the name of an output in a sentence, with its symbol."""
    return f"{word(name)} {OUTPUTS[name].symbol}" if name in OUTPUTS else word(name)


def spoken(text: object) -> str:
    """Return a text with words instead of names of code, and no underscores.

    >>> spoken("slow_opening: measured travel_time above 9.5 ms, change of f below -5 %")
    'slow opening: measured travel time above 9.5 ms, change of closing force $f$ below -5 %'
    """
    parts = _NAMES.split(style.literal(text))
    parts[::2] = [word.replace("_", " ") for word in parts[::2]]
    parts[1::2] = map(named, parts[1::2])
    return "".join(parts)


def signed(text: str) -> str:
    """Return a number with a minus sign instead of a hyphen."""
    return text.replace("-", "−")


def percent(share: float) -> str:
    """Return a share as a percentage; below 10 % with two digits."""
    if not np.isfinite(share):
        return "not known"
    return f"{100 * share:.0f} %" if share >= 0.1 else f"{in_digits(100 * share, 2)} %"


def from_to(texts: Sequence[str]) -> str:
    """Return "first to last" of texts, or the text if both are equal."""
    return " to ".join(dict.fromkeys([texts[0], texts[-1]]))


def panels(
    count: int, *, columns: int = 4, width: float = 3.2, height: float = 2.7, **shared: bool
) -> tuple[Figure, list[Axes]]:
    """Return a figure with panels of ``width`` by ``height`` inches in rows, and the panels."""
    columns = min(columns, count)
    rows = -(-count // columns)
    figure = style.new_figure(width * columns, height * rows + 1.0)
    axes = list(figure.subplots(rows, columns, squeeze=False, **shared).flat)
    for spare in axes[count:]:
        spare.remove()
    for above in axes[max(0, count - columns) : count]:
        above.xaxis.set_tick_params(labelbottom=True)  # the panel below may be missing
    return figure, axes[:count]


def label_outer(axes: Sequence[Axes], xlabel: str, ylabel: str | None = None) -> None:
    """Label shared axes: x where the ticks have numbers, y in the first column."""
    for axis in axes:
        if axis.xaxis.get_tick_params()["labelbottom"]:
            axis.set_xlabel(xlabel)
        if ylabel is not None and axis.get_subplotspec().is_first_col():
            axis.set_ylabel(ylabel)


def limit_panels(
    data: "xr.Dataset", titles: Sequence[str], *, height: float, **shared: bool
) -> tuple[Figure, list[Axes]]:
    """Return a figure with one panel per limit, over the operations; titles follow limit names."""
    count = len(titles)
    columns, width = (2, 6.4) if count > 1 else (1, 10.0)
    figure, axes = panels(count, columns=columns, width=width, height=height, **shared)
    for axis, limit, words in zip(axes, data["limit"].values, titles, strict=True):
        lines = spoken(limit) + ": " + "\n".join(spoken(row) for row in words.splitlines())
        axis.set_title(style.within(lines, width - 0.8), loc="left")
        axis.margins(x=0.01)
        axis.xaxis.set_major_formatter("{x:,.0f}")
    label_outer(axes, "operation")
    return figure, axes


def read_title(axis: Axes, text: str, width: float, *, failed: bool = False) -> None:
    """Write a literal title over a panel ``width`` inches wide, at the left; red if it failed."""
    look = {"loc": "left", "fontsize": 10, "color": style.WARNING if failed else "black"}
    axis.set_title(style.within(style.literal(text), width, 10.0), **look)


def empty(finding: str, why: str) -> Figure:
    """Return a figure that states in one sentence why nothing is drawn."""
    figure = style.new_figure(10.0, 1.6)
    figure.suptitle(finding)
    figure.text(0.5, 0.35, fill(why, 110), ha="center", fontsize=12)
    return figure


def legend_below(figure: Figure, *, columns: int | None = None, **look: float) -> None:
    """Put one legend with all labels of all panels, without repetition, below the panels."""
    below = {}
    for axis in figure.axes:
        if axis.get_legend() is None:
            below |= dict(zip(*axis.get_legend_handles_labels()[::-1], strict=True))
    count = min(columns or len(below), len(below))
    place = {"loc": "outside lower center", "ncols": count, "markerscale": 1.5}
    legend = figure.legend([*below.values()], [*below], **place, **look)
    for handle in legend.legend_handles:
        if alpha := handle.get_alpha():
            handle.set_alpha(max(alpha, 0.4))  # lines of many curves are too pale for a legend


def draw_intervals(
    axis: Axes, rows: ArrayLike, ends: Sequence, *, label: str, color: str, marker: str = "o"
) -> None:
    """Draw intervals in rows; ``ends`` are low ends, middles and high ends."""
    low, middle, high = ends
    axis.hlines(rows, low, high, color=color, lw=1.4)
    look = {"mec": "white", "mew": 0.8, "ms": 7, "label": label}
    axis.plot(middle, rows, marker, color=color, **look)


def rows_of_words(axis: Axes, left: Sequence[str], right: Sequence[str]) -> Axes:
    """Name the rows of a panel on both sides, from the top down; return the right-hand axes."""
    other = axis.twinx()
    for panel, words in ((axis, left), (other, right)):
        panel.set(yticks=range(len(words)), yticklabels=words, ylim=(len(words) - 0.45, -0.6))
        panel.tick_params(axis="y", labelsize=10, length=0, pad=9)
        panel.grid(axis="y", visible=False)
    return other


def change_lines(axis: Axes, life: "xr.Dataset") -> None:
    """Draw the changes of a life with their 90 % intervals."""
    for change in (life.isel(change=k) for k in range(life.sizes["change"])):
        look = {"color": style.CHANGED, "label": "change, 90 % interval"}
        if change["kind"].item() == "event":
            look = {"color": style.MEASURED, "ls": "--", "label": "known work"}
        axis.axvspan(change["earliest"], change["latest"], color=look["color"], alpha=0.15, lw=0)
        axis.axvline(change["start"].item(), lw=1.1, zorder=1.6, **look)


def state_strip(axis: Axes, operation: np.ndarray, state: np.ndarray) -> None:
    """Colour the foot of a panel by the numbers of the states ``(o,)`` of operations."""
    ends = np.append(operation, operation[-1] + 1)
    turns = [0, *np.flatnonzero(np.diff(state)) + 1, len(state)]
    for first, last in pairwise(turns):
        name, color = [*STATES.items()][state[first]]
        look = {"color": color, "label": f"state: {name}", "lw": 0, "zorder": 3}
        axis.axvspan(ends[first], ends[last], ymax=0.05, **look)
