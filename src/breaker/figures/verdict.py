"""The first page: is this breaker healthy, what is wearing, how long has it left; in what trust."""

from textwrap import wrap

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import blended_transform_factory

from breaker.decisions import STATES
from breaker.figures import style
from breaker.figures.words import literal

__all__ = ["COLOURS", "verdict"]

_EACH = ("#5A5A5A", "#1B9E77", "#C8A400", "#E08A00", style.WARNING)
COLOURS = dict(zip(STATES, _EACH, strict=True))
"""Colour of each state; the word always stands beside it."""

_WAY = (-18.0, 130.0)  # percent of the way that is shown; what lies outside is an arrow
_SOON = 1.0  # operations at which the axis of remaining life begins
_HEADLINE, _LINE = 80, 120  # characters of a line of the first sentence, and of the others
_EDGE = 0.012  # left edge of the text, share of the page
_HALF = 0.17  # half the height of a bar, in rows


@style.styled
def verdict(data: xr.Dataset) -> Figure:
    """Draw four sentences and one row per limit: how far on the way, how many operations left.

    Args:
        data: ``way (limit, quantile)``: percent of the way from the value in new condition, 0, to
            the limit, 100, nan where not known; ``remaining (limit, quantile)``: operations, inf
            beyond the horizon, nan without a trend, both at 0.05, 0.5 and 0.95; ``state``, one of
            ``STATES``, ``since``, an operation or nan, and ``words`` ``(limit)``; coordinate
            ``limit``; attributes ``headline``, ``wearing``, ``left`` and ``trust``, the sentences.

    Raises:
        ValueError: If a state is not one of them.
    """
    states = [str(state) for state in data["state"].values]
    if strange := sorted(set(states) - set(STATES)):
        raise ValueError(f"no state is called {strange[0]!r}; there are {', '.join(STATES)}")
    count = data.sizes["limit"]
    headline = wrap(literal(data.attrs["headline"]), _HEADLINE)
    names = "wearing", "left", "trust"
    sentences = [line for name in names for line in wrap(literal(data.attrs[name]), _LINE)]
    text_height, rows_height = 0.31 * len(sentences) + 0.15, 0.78 * count + 0.6
    figure = style.new_figure(13.6, text_height + rows_height + 1.5)
    grid = figure.add_gridspec(2, 2, height_ratios=(text_height, rows_height))
    figure.suptitle("\n".join(headline), x=_EDGE, ha="left", fontsize=19)
    _sentences(figure.add_subplot(grid[0, :]), sentences)
    left = figure.add_subplot(grid[1, 0])
    right = figure.add_subplot(grid[1, 1], sharey=left)
    last = _last(data["remaining"].values)
    right.set(xscale="log", xlim=(_SOON, last))
    for row, state in enumerate(states):
        one = data.isel(limit=row)
        _way(left, row, one, COLOURS[state])
        beside = {"xycoords": left.get_yaxis_transform(), "va": "center", "annotation_clip": False}
        left.annotate(state, (1.03, row), color=COLOURS[state], weight="bold", **beside)
        _remaining(right, row, one, COLOURS[state], last)
    _frame(left, right, data)
    style.legend_below(figure, _handles())
    return figure


def _sentences(axis: Axes, lines: list[str]) -> None:
    """Write lines from the left edge of the page, left of where the panels begin."""
    axis.set_axis_off()
    at = blended_transform_factory(axis.figure.transFigure, axis.transAxes)
    text = axis.text(_EDGE, 1.0, "\n".join(lines), transform=at, va="top", fontsize=15)
    text.set(linespacing=1.35, in_layout=False)  # or the panels would make room for it


def _way(axis: Axes, row: int, one: xr.Dataset, mark: str) -> None:
    """Draw the whole way, how far it is gone, and the interval of that."""
    axis.barh(row, 100.0, 2 * _HALF, color=style.PRIOR, alpha=0.28, lw=0)
    low, middle, high = one["way"].values
    if not np.isfinite(middle):
        axis.text(50.0, row, "not known", ha="center", va="center", color=style.REFERENCE)
        return
    shown = float(np.clip(middle, *_WAY))
    axis.barh(row, shown, 2 * _HALF, color=mark, alpha=0.35, lw=0)
    _interval(axis, row, (low, middle, high), _WAY, mark)
    axis.annotate(
        f"{middle:.0f} %".replace("-", "−"),
        (shown, row),
        xytext=(0, 13),
        textcoords="offset points",
        ha="center",
        fontsize=9,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.5},
    )


def _interval(
    axis: Axes, row: int, values: tuple[float, float, float], ends: tuple[float, float], mark: str
) -> None:
    """Draw an interval with its median as far as the axis reaches, and arrows where it goes on."""
    (low, middle, high), (least, most) = values, ends
    axis.hlines(row, *np.clip([low, high], least, most), color=mark, lw=4)
    if least <= middle <= most:
        axis.plot(middle, row, "o", color=mark, mec="white", ms=11, zorder=3)
    for end, marker, outside in ((least, "<", low < least), (most, ">", high > most)):
        if outside:
            axis.plot(end, row, marker, color=mark, ms=9, clip_on=False, zorder=3)


def _remaining(axis: Axes, row: int, one: xr.Dataset, mark: str, last: float) -> None:
    """Draw the remaining operations of a limit, and write them beside."""
    low, middle, high = one["remaining"].values
    if np.isnan(middle):
        words = "not known" if one["state"].item() == "unknown" else "no trend"
        middle_of_axis = np.sqrt(_SOON * last)
        axis.text(middle_of_axis, row, words, ha="center", va="center", color=style.REFERENCE)
        return
    _interval(axis, row, (low, middle, high), (_SOON, last), mark)
    beside = {"xycoords": axis.get_yaxis_transform(), "va": "center", "annotation_clip": False}
    text = f"{_operations(middle)}  ({_operations(low)} to {_operations(high)})"
    since = one["since"].item()
    now = np.isfinite(since)
    weight = "bold" if now else "normal"
    told = f"exceeded since {since:,.0f}" if now else text
    axis.annotate(told, (1.03, row), weight=weight, **beside)


def _operations(value: float) -> str:
    if not np.isfinite(value):
        return "beyond"
    digits = max(0, int(np.floor(np.log10(max(value, 1.0)))) - 2)  # three that count
    return f"{round(value, -digits):,.0f}"


def _last(remaining: np.ndarray) -> float:
    """Return the power of ten at which the axis of remaining life ends."""
    known = remaining[np.isfinite(remaining)]
    return 10.0 ** np.ceil(np.log10(max(1000.0, 1.5 * known.max(initial=0.0))))


def _frame(left: Axes, right: Axes, data: xr.Dataset) -> None:
    labels = []
    for limit, words in zip(data["limit"].values, data["words"].values, strict=True):
        labels.append("\n".join([literal(limit), *wrap(str(words), 38)]))
    rows = np.arange(len(labels))
    left.set_yticks(rows, labels)
    left.tick_params(axis="y", labelsize=10, length=0)
    right.tick_params(axis="y", labelleft=False, length=0)
    left.axvspan(100.0, _WAY[1], color=style.WARNING, alpha=0.08, lw=0)
    left.axvline(100.0, color=style.WARNING, lw=1.4)
    left.axvline(0.0, color=style.MEASURED, lw=1.0)
    left.set(xlim=_WAY, ylim=(len(labels) - 0.5, -0.5))
    left.set_xticks([0, 25, 50, 75, 100], ["new", "25 %", "50 %", "75 %", "limit"])
    left.set_title("way from new to the limit", loc="left")
    right.set_title("remaining operations", loc="left")
    right.xaxis.set_major_formatter("{x:,.0f}")
    for axis in (left, right):
        axis.grid(axis="y", visible=False)


def _handles() -> list:
    every = *STATES[1:], STATES[0]
    handles = [style.band_key(state, COLOURS[state], 1.0) for state in every]
    label = "median and 90 % interval (arrow: goes on)"
    return [*handles, style.line_key(label, marker="o", mec="white", ms=9, lw=4)]
