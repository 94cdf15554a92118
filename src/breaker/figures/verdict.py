"""The picture of the first page: what to do, how far each limit is, and what it leads to."""

from collections.abc import Sequence
from textwrap import fill

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.common.numerals import in_digits
from breaker.drive.life.first_page import about, in_percent, span
from breaker.drive.life.limit_states import STATES
from breaker.figures import marks, style

_LEAST, _MOST = -20.0, (130.0, 220.0)  # percent of the way where the axis begins, and may end
_HALF = 0.13  # half the height of a bar, in rows
_ROW, _AXIS, _GAP = 0.82, 0.55, 0.4  # inches: of a limit, of the axis below, around lines above
_LINES, _LETTERS = (0.22, 0.17), (115, 175)  # inches and letters of a line above, bold and plain
_SMALL = 9
_DIGITS, _SIGNED = 4, 3  # of a value, and of a change in percent
_WHITE = {"fc": "white", "ec": "none", "alpha": 0.75, "pad": 0.5}
_ROOM = 0.17  # of the axis, that half a value above a bar takes


@style.styled
def verdict(life: xr.Dataset, standing: xr.Dataset, sentences: Sequence[str]) -> Figure:
    """Draw one row per limit, after the last operation: way to the limit, state, and what to do.

    Args:
        life: What ``life_results.follow_life`` returns.
        standing: What ``decisions.standing`` returns.
        sentences: What stands above: first what to do, of ``first_page.headline``, then others.
    """
    now, (ways, parts) = standing.isel(operation=-1), _ways(life.isel(asked=-1))
    # A number is in one line with its sign of percent.
    action, *others = (style.spoken(each).replace(" %", "\u00a0%") for each in sentences)
    action, others = fill(action, _LETTERS[0]), "\n".join(fill(e, _LETTERS[1]) for e in others)
    counts = (action.count("\n") + 1, others.count("\n") + 1)
    head, body = float(np.dot(_LINES, counts)) + _GAP, _ROW * len(ways) + _AXIS
    figure = style.new_figure(13.6, head + body)
    above, below = figure.subfigures(2, 1, height_ratios=[head, body])
    state = STATES[now["drive_state"].item()]
    look = {"fontsize": 13, "weight": "bold", "color": marks.COLOURS[state]}
    above.text(0.01, 1.0 - 0.1 / head, action, va="top", **look)
    above.text(0.01, 0.12 / head, others, va="bottom", fontsize=10)
    left, right = below.subplots(1, 2, sharey=True, width_ratios=[1.75, 1.0])
    high = ways[np.isfinite(ways)].max(initial=0.0) + 5.0
    left.set_xlim(_LEAST, float(np.clip(high, *_MOST)))
    for row, (way, part) in enumerate(zip(ways, parts, strict=True)):
        one = now.isel(limit=row)
        _way(left, row, way, marks.COLOURS[_state(one)])
        _values(left, row, way, life.isel(asked=-1, part=part))
        _tell(right, row, one)
    _frame(left, right, life)
    return figure


def _state(one: xr.Dataset) -> str:
    return STATES[one["state"].item()]


def _ways(life: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return how far each limit is gone ``(limit, quantile)``: 0 when new, 100 at the limit.

    Of several parts, all of which a limit needs, by the one that is farthest from its bound, which
    is returned, too, ``(limit,)``; inf where the bound was passed when new.
    """
    new, whole = life["new"].values, life["part_bound"].values - life["new"].values
    ahead = np.where(life["part_upper"], whole, -whole) > 0.0
    gone = life["value"].transpose("part", "quantile").values - new[:, None]
    ways = np.sort(100.0 * gone / np.where(ahead, whole, np.nan)[:, None], axis=1)
    ways[~ahead] = np.inf
    every = [np.flatnonzero(life["part_limit"].values == name) for name in life["limit"].values]
    parts = np.array([each[ways[each, 1].argmin()] for each in every], dtype=int)
    return ways[parts], parts


def _known(way: np.ndarray) -> bool:
    """Whether a way is known well enough to draw: less wide than all of it; or begun for sure, and
    past the limit by its median.
    """
    past = way[1] >= 100.0 and way[0] > 0.0
    return bool(np.isfinite(way).all() and (way[2] - way[0] <= 100.0 or past))


def _way(axis: Axes, row: int, way: np.ndarray, mark: str) -> None:
    """Draw how far the way is gone with the interval of that, if it is known well enough."""
    axis.barh(row, 100.0, 2 * _HALF, color=style.PRIOR, alpha=0.28, lw=0)
    if _known(way):
        shown = float(np.clip(way[1], *axis.get_xlim()))
        axis.barh(row, shown, 2 * _HALF, color=mark, alpha=0.35, lw=0)
        _interval(axis, row, way, mark)
        return
    words = "beyond the limit when new" if np.isinf(way[0]) else "not known well enough"
    axis.text(50.0, row, words, ha="center", va="center", color=style.REFERENCE)


def _interval(axis: Axes, row: int, values: np.ndarray, mark: str) -> None:
    """Draw an interval with its median as far as the axis reaches, and arrows where it goes on."""
    (low, middle, high), (least, most) = values, axis.get_xlim()
    axis.hlines(row, *np.clip([low, high], least, most), color=mark, lw=4)
    if least <= middle <= most:
        axis.plot(middle, row, "o", color=mark, mec="white", ms=11, zorder=3, clip_on=False)
    for end, marker, outside in ((least, "<", low < least), (most, ">", high > most)):
        if outside:
            axis.plot(end, row, marker, color=mark, ms=9, clip_on=False, zorder=3)


def _values(axis: Axes, row: int, way: np.ndarray, part: xr.Dataset) -> None:
    """Write the values when new, now, and at the limit, in their unit."""
    unit = part["part_unit"].item()
    new, bound, low, middle, high = (
        _said(each, unit)
        for each in (part["new"].item(), part["part_bound"].item(), *part["value"].values)
    )
    unit = "" if unit == "1" else f" {unit}"
    place = {"textcoords": "offset points", "ha": "center", "bbox": _WHITE}
    for x, said in ((0.0, f"new {new}{unit}"), (100.0, f"limit {bound}{unit}")):
        look = {"xytext": (0, -11), "va": "top", "fontsize": _SMALL, "color": style.REFERENCE}
        axis.annotate(said, (x, row), **place, **look)
    if _known(way):
        at = float(np.clip(way[1], *_inside(axis)))
        axis.annotate(f"now {middle}{unit} ({low} to {high})", (at, row), xytext=(0, 10), **place)


def _said(value: float, unit: str) -> str:
    """Write a value, of a change with its sign."""
    change = unit == "%"
    text = in_digits(value, _SIGNED if change else _DIGITS, sign=bool(change and value))
    return text.replace("-", "−")


def _inside(axis: Axes) -> tuple[float, float]:
    """Return between which places a value above a bar does not leave the axis."""
    least, most = axis.get_xlim()
    return least + _ROOM * (most - least), most - _ROOM * (most - least)


def _tell(axis: Axes, row: int, one: xr.Dataset) -> None:
    """Write what to do about a limit, how long it has left, and how sure that is."""
    state = _state(one)
    action, *others = _words(state, one)
    place = {"xytext": (0, 14), "textcoords": "offset points", "va": "center"}
    look = {"color": marks.COLOURS[state], "weight": "bold", "annotation_clip": False}
    axis.annotate(action, (0.0, row), **place, **look)
    place |= {"xytext": (0, 5), "va": "top", "fontsize": _SMALL, "annotation_clip": False}
    axis.annotate("\n".join(others), (0.0, row), **place)


def _words(state: str, one: xr.Dataset) -> list[str]:
    """Return what to do about a limit, then why, how sure, and since when."""
    low, middle, high = one["left"].values
    by, since, certain = (one[name].item() for name in ("service_by", "since", "certain"))
    probable = f"P {in_percent(one['beyond'].item())} that it is exceeded"
    left = f"operations left: {about(middle)} ({span(low, high)})"
    if np.isinf(low):
        left = "operations left: beyond the horizon"
    if np.isfinite(certain):
        crossed = one["crossed"].item()
        told = f"service was told since {since:,.0f}, at last by {by:,.0f}"
        told = told if since < certain else "no service was told before"
        over = f"certain at {certain:,.0f}, crossed about {crossed:,.0f}"
        return ["now: exceeded", over, told]
    if state == "unknown":
        return ["unknown: cannot be told", *[probable] * bool(np.isfinite(one["beyond"]))]
    if state == "healthy":
        return ["healthy: no service is planned", left, probable]
    due = "now: service is due" if state == "now" else f"plan: service by operation {by:,.0f}"
    told = f"told since {since:,.0f}" + (f", by {by:,.0f}" if state == "now" else "")
    return [due, left, f"{probable}; {told}"]


def _frame(left: Axes, right: Axes, life: xr.Dataset) -> None:
    """Name rows and axes."""
    labels = [
        f"{style.spoken(limit)}\n{fill(style.spoken(words), 38)}"
        for limit, words in zip(life["limit"].values, life["words"].values, strict=True)
    ]
    left.set_yticks(np.arange(len(labels)), labels)
    left.tick_params(axis="y", labelsize=10, length=0, pad=9)
    left.axvspan(100.0, left.get_xlim()[1], color=style.WARNING, alpha=0.08, lw=0)
    left.axvline(100.0, color=style.WARNING, lw=1.4)
    left.axvline(0.0, color=style.MEASURED, lw=1.0)
    left.set_ylim(len(labels) - 0.5, -0.5)
    left.set_xticks([0, 25, 50, 75, 100], ["new", "25 %", "50 %", "75 %", "limit"])
    left.set_xlabel("way from new to the limit: median and 90 % interval (arrow: goes on)")
    left.grid(axis="y", visible=False)
    right.set_axis_off()
    right.set(xlim=(0.0, 1.0))
