"""The first page: is this breaker healthy, what is wearing, how long has it left; in what trust."""

from textwrap import fill, wrap

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import blended_transform_factory

from breaker.decisions import STATES, about, span
from breaker.figures import style
from breaker.figures.words import literal, symbolic

__all__ = ["COLOURS", "verdict"]

_EACH = ("#5A5A5A", "#1B9E77", "#3F6FD1", "#E08A00", style.WARNING)
COLOURS = dict(zip(STATES, _EACH, strict=True))
"""Colour of each state; the word always stands beside it."""

_MEANING = {
    "healthy": "no trend leads to the limit",
    "drifting": "a trend leads there, not within the horizon",
    "plan": "a trend leads there within the horizon",
    "now": "exceeded",
    "unknown": "cannot be told",
}
_WAY = (-18.0, 130.0)  # percent of the way that is shown; what lies outside is an arrow
_SOON = 1.0  # operations at which the axis of remaining life begins
_HEADLINE, _LINE, _LINES = 115, 160, 5  # letters in a line of the headline, of the others; lines
_EDGE = 0.012  # left edge of the text, share of the page
_HALF = 0.17  # half the height of a bar, in rows


@style.styled
def verdict(data: xr.Dataset) -> Figure:
    """Draw the headline and one row per limit: how far on the way, how many operations left.

    Args:
        data: ``way (limit, quantile)``: percent of the way from the value in new condition, 0, to
            the limit, 100, nan where not known; ``remaining (limit, quantile)``: operations as
            decided, 0 where exceeded, inf beyond the horizon, nan without a trend, both at 0.05,
            0.5 and 0.95; ``state``, one of ``STATES``, ``since``, the operation at which the limit
            was exceeded, nan where it is not, and ``words`` ``(limit)``; coordinate ``limit``;
            attributes ``headline``, ``wearing`` and ``trust``, sentences.

    Raises:
        ValueError: If a state is not one of them.
    """
    states = [str(state) for state in data["state"].values]
    if strange := sorted(set(states) - set(STATES)):
        raise ValueError(f"no state is called {strange[0]!r}; there are {', '.join(STATES)}")
    headline, sentences = _text(data.attrs)
    text_height, rows_height = 0.27 * len(sentences) + 0.1, 0.66 * len(states) + 0.6
    height = text_height + rows_height + 0.33 * len(headline) + 1.15
    figure = style.new_figure(13.6, height)
    grid = figure.add_gridspec(2, 2, height_ratios=(text_height, rows_height))
    figure.suptitle("\n".join(headline), x=_EDGE, ha="left", fontsize=13.5)
    _sentences(figure.add_subplot(grid[0, :]), sentences)
    left = figure.add_subplot(grid[1, 0])
    right = figure.add_subplot(grid[1, 1], sharey=left)
    known = data["remaining"].values[np.isfinite(data["remaining"].values)]
    last = 10.0 ** np.ceil(np.log10(max(1000.0, 1.5 * known.max(initial=0.0))))
    right.set(xscale="log", xlim=(_SOON, last))
    for row, state in enumerate(states):
        one = data.isel(limit=row)
        _way(left, row, one["way"].values, COLOURS[state])
        look = {"color": COLOURS[state], "weight": "bold", **_beside(left)}
        left.annotate(state, (1.045, row), **look)
        _remaining(right, row, one, last)
    _frame(left, right, data)
    style.legend_below(figure, _handles(states), columns=min(3, 1 + len(set(states))))
    return figure


def _text(sentences: dict[str, str]) -> tuple[list[str], list[str]]:
    """Break the sentences into few lines: of the headline, and of what stands below it."""
    short = {"placeholder": " …"}
    headline = wrap(literal(sentences["headline"]), _HEADLINE, max_lines=2, **short)
    lines = wrap(symbolic(sentences["wearing"]), _LINE, max_lines=2, **short)
    room = _LINES - len(headline) - len(lines)
    return headline, [*lines, *wrap(symbolic(sentences["trust"]), _LINE, max_lines=room, **short)]


def _sentences(axis: Axes, lines: list[str]) -> None:
    """Write lines from the left edge of the page, left of where the panels begin."""
    axis.set_axis_off()
    at = blended_transform_factory(axis.figure.transFigure, axis.transAxes)
    text = axis.text(_EDGE, 1.0, "\n".join(lines), transform=at, va="top", fontsize=11)
    text.set(linespacing=1.35, in_layout=False)  # or the panels would make room for it


def _way(axis: Axes, row: int, way: np.ndarray, mark: str) -> None:
    """Draw the whole way, how far it is gone, and the interval of that."""
    axis.barh(row, 100.0, 2 * _HALF, color=style.PRIOR, alpha=0.28, lw=0)
    low, middle, high = way
    if not np.isfinite(middle):
        axis.text(50.0, row, "not known", ha="center", va="center", color=style.REFERENCE)
        return
    shown = float(np.clip(middle, *_WAY))
    axis.barh(row, shown, 2 * _HALF, color=mark, alpha=0.35, lw=0)
    _interval(axis, row, (low, middle, high), _WAY, mark)
    words = f"{middle:.0f} %".replace("-", "−")
    look = {"fontsize": 9, "bbox": {"fc": "white", "ec": "none", "alpha": 0.7, "pad": 0.5}}
    above = {"xytext": (0, 12), "textcoords": "offset points", "ha": "center"}
    axis.annotate(words, (shown, row), **above, **look)


def _interval(
    axis: Axes, row: int, values: tuple[float, float, float], ends: tuple[float, float], mark: str
) -> None:
    """Draw an interval with its median as far as the axis reaches, and arrows where it goes on."""
    (low, middle, high), (least, most) = values, ends
    axis.hlines(row, *np.clip([low, high], least, most), color=mark, lw=4)
    if least <= middle <= most:
        axis.plot(middle, row, "o", color=mark, mec="white", ms=11, zorder=3, clip_on=False)
    for end, marker, outside in ((least, "<", low < least), (most, ">", high > most)):
        if outside:
            axis.plot(end, row, marker, color=mark, ms=9, clip_on=False, zorder=3)


def _remaining(axis: Axes, row: int, one: xr.Dataset, last: float) -> None:
    """Draw the remaining operations of a limit and write them beside; or since when it is over."""
    low, middle, high = one["remaining"].values
    state, since = one["state"].item(), one["since"].item()
    if state == "now" or np.isnan(middle):
        without = "cannot be told" if state == "unknown" else "no trend"
        when = f"exceeded since {since:,.0f}" if np.isfinite(since) else "exceeded"
        words = when if state == "now" else without
        look = {"color": COLOURS[state], "weight": "bold"} if state == "now" else {}
        axis.annotate(words, (1.03, row), **_beside(axis), **look)
        return
    _interval(axis, row, (low, middle, high), (_SOON, last), COLOURS[state])
    words = about(low) if low == high else f"{about(middle)}  ({span(low, high)})"
    axis.annotate(words.replace(" the horizon", ""), (1.03, row), **_beside(axis))


def _beside(axis: Axes) -> dict:
    """How to write beside a panel, at a row of it."""
    return {"xycoords": axis.get_yaxis_transform(), "va": "center", "annotation_clip": False}


def _frame(left: Axes, right: Axes, data: xr.Dataset) -> None:
    labels = [
        f"{literal(limit)}\n{symbolic(fill(str(words), 38))}"
        for limit, words in zip(data["limit"].values, data["words"].values, strict=True)
    ]
    left.set_yticks(np.arange(len(labels)), labels)
    left.tick_params(axis="y", labelsize=10, length=0, pad=9)
    right.tick_params(axis="y", labelleft=False, length=0)
    left.axvspan(100.0, _WAY[1], color=style.WARNING, alpha=0.08, lw=0)
    left.axvline(100.0, color=style.WARNING, lw=1.4)
    left.axvline(0.0, color=style.MEASURED, lw=1.0)
    left.set(xlim=_WAY, ylim=(len(labels) - 0.5, -0.5))
    left.set_xticks([0, 25, 50, 75, 100], ["new", "25 %", "50 %", "75 %", "limit"])
    left.set_title("way from new to the limit", loc="left")
    right.set_title("operations left", loc="left")
    right.xaxis.set_major_formatter("{x:,.0f}")
    for axis in (left, right):
        axis.grid(axis="y", visible=False)


def _handles(states: list[str]) -> list:
    """Return the states that are there, the worst first, and how intervals are drawn."""
    there = [state for state in reversed(STATES) if state in states]
    words = [f"{state}: {_MEANING[state]}" for state in there]
    handles = [style.band_key(w, COLOURS[s], 1.0) for s, w in zip(there, words, strict=True)]
    label = "median, 90 % interval (arrow: goes on)"
    return [*handles, style.line_key(label, marker="o", mec="white", ms=9, lw=4)]
