"""The picture of the first page: how far to each limit, its state, and how long it has left."""

from textwrap import fill

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.drive.life.first_page import about, exceeded, in_percent, span
from breaker.drive.life.limit_states import STATES
from breaker.figures import marks, style

_MEANING = {
    "healthy": "healthy: no service within the planning horizon",
    "plan": "plan: service within the planning horizon",
    "now": "now: exceeded, or service is due",
    "unknown": "unknown: cannot be told",
}
_LEAST, _MOST = -20.0, (130.0, 220.0)  # percent of the way where the axis begins, and may end
_SOON = 1.0  # operations at which the axis of those left begins
_HALF = 0.17  # half the height of a bar, in rows


@style.styled
def verdict(life: xr.Dataset, standing: xr.Dataset) -> Figure:
    """Draw one row per limit, after the last operation: way to the limit, and operations left.

    Args:
        life: What ``life_results.follow_life`` returns.
        standing: What ``decisions.standing`` returns.
    """
    now, ways = standing.isel(operation=-1), _ways(life.isel(asked=-1))
    figure = style.new_figure(13.6, 0.66 * len(ways) + 1.75)
    left, right = figure.subplots(1, 2, sharey=True)
    known = now["left"].values[np.isfinite(now["left"].values)]
    last = 10.0 ** np.ceil(np.log10(max(1000.0, 1.5 * known.max(initial=0.0))))
    high = ways[np.isfinite(ways)].max(initial=0.0) + 5.0
    left.set_xlim(_LEAST, float(np.clip(high, *_MOST)))
    right.set(xscale="log", xlim=(_SOON, last))
    for row, way in enumerate(ways):
        one = now.isel(limit=row)
        _way(left, row, way, marks.COLOURS[_state(one)])
        _say_state(left, row, one)
        _left(right, row, one)
    _frame(left, right, now)
    interval = "median, 90 % interval (arrow: goes on)"
    keys = [style.line_key(interval, marker="o", mec="white", ms=9, lw=4)]
    there = [name for k, name in enumerate(STATES) if (now["state"] == k).any()]
    keys += [style.band_key(_MEANING[name], marks.COLOURS[name], 1.0) for name in there]
    style.legend_below(figure, keys, columns=3)
    return figure


def _state(one: xr.Dataset) -> str:
    return STATES[one["state"].item()]


def _ways(life: xr.Dataset) -> np.ndarray:
    """Return how far each limit is gone ``(limit, quantile)``: 0 when new, 100 at the limit.

    Of several parts, all of which a limit needs, by the one that is farthest from its bound; inf
    where the bound was passed when new.
    """
    new, whole = life["new"].values, life["part_bound"].values - life["new"].values
    ahead = np.where(life["part_upper"], whole, -whole) > 0.0
    gone = life["value"].transpose("part", "quantile").values - new[:, None]
    ways = np.sort(100.0 * gone / np.where(ahead, whole, np.nan)[:, None], axis=1)
    ways[~ahead] = np.inf
    parts = [ways[life["part_limit"].values == name] for name in life["limit"].values]
    return np.array([each[each[:, 1].argmin()] for each in parts]).reshape(-1, 3)


def _way(axis: Axes, row: int, way: np.ndarray, mark: str) -> None:
    """Draw how far the way is gone with the interval of that, if it is known well enough."""
    axis.barh(row, 100.0, 2 * _HALF, color=style.PRIOR, alpha=0.28, lw=0)
    low, middle, high = way
    known = np.isfinite(way).all() and (high - low <= 100.0 or low >= 100.0)
    if not known:
        words = "beyond the limit when new" if np.isinf(low) else "not known well enough"
        axis.text(50.0, row, words, ha="center", va="center", color=style.REFERENCE)
        return
    shown = float(np.clip(middle, *axis.get_xlim()))
    axis.barh(row, shown, 2 * _HALF, color=mark, alpha=0.35, lw=0)
    _interval(axis, row, way, mark)
    look = {"fontsize": 9, "bbox": {"fc": "white", "ec": "none", "alpha": 0.7, "pad": 0.5}}
    above = {"xytext": (0, 12), "textcoords": "offset points", "ha": "center"}
    axis.annotate(f"{middle:.0f} %".replace("-", "−"), (shown, row), **above, **look)


def _interval(axis: Axes, row: int, values: np.ndarray, mark: str) -> None:
    """Draw an interval with its median as far as the axis reaches, and arrows where it goes on."""
    (low, middle, high), (least, most) = values, axis.get_xlim()
    axis.hlines(row, *np.clip([low, high], least, most), color=mark, lw=4)
    if least <= middle <= most:
        axis.plot(middle, row, "o", color=mark, mec="white", ms=11, zorder=3, clip_on=False)
    for end, marker, outside in ((least, "<", low < least), (most, ">", high > most)):
        if outside:
            axis.plot(end, row, marker, color=mark, ms=9, clip_on=False, zorder=3)


def _say_state(axis: Axes, row: int, one: xr.Dataset) -> None:
    """Write the state and the probability to be beyond the limit beside a row."""
    state, beyond = _state(one), one["beyond"].item()
    place = {"xycoords": axis.get_yaxis_transform(), "annotation_clip": False}
    place |= {"textcoords": "offset points"}
    look = {"color": marks.COLOURS[state], "weight": "bold", "va": "bottom"}
    axis.annotate(state, (1.03, row), xytext=(0, -1), **look, **place)
    if np.isfinite(beyond):
        words = f"{in_percent(beyond)} beyond"
        axis.annotate(words, (1.03, row), xytext=(0, -3), va="top", fontsize=9, **place)


def _left(axis: Axes, row: int, one: xr.Dataset) -> None:
    """Draw and write the operations left, by when to service; or since when it is exceeded."""
    state, (low, middle, high) = _state(one), one["left"].values
    if np.isfinite(one["certain"].item()) or state == "unknown":
        words, look = "cannot be told", {"color": style.REFERENCE}
        if state != "unknown":
            words = exceeded(one["certain"].item(), one["crossed"].item())
            look = {"color": marks.COLOURS[state], "weight": "bold"}
        axis.text(0.02, row, words, transform=axis.get_yaxis_transform(), va="center", **look)
        return
    _interval(axis, row, np.array([low, middle, high]), marks.COLOURS[state])
    words = f"{about(middle)}  ({span(low, high)})".replace(" the horizon", "")
    words = "beyond the horizon" if np.isinf(low) else words
    if state in ("plan", "now"):
        words += f"\nservice by operation {one['service_by'].item():,.0f}"
    place = {"xycoords": axis.get_yaxis_transform(), "va": "center", "annotation_clip": False}
    axis.annotate(words, (1.03, row), **place)


def _frame(left: Axes, right: Axes, now: xr.Dataset) -> None:
    """Name rows and axes."""
    labels = [
        f"{style.literal(limit)}\n{style.symbolic(fill(str(words), 38))}"
        for limit, words in zip(now["limit"].values, now["words"].values, strict=True)
    ]
    left.set_yticks(np.arange(len(labels)), labels)
    left.tick_params(axis="y", labelsize=10, length=0, pad=9)
    right.tick_params(axis="y", labelleft=False, length=0)
    left.axvspan(100.0, left.get_xlim()[1], color=style.WARNING, alpha=0.08, lw=0)
    left.axvline(100.0, color=style.WARNING, lw=1.4)
    left.axvline(0.0, color=style.MEASURED, lw=1.0)
    left.set_ylim(len(labels) - 0.5, -0.5)
    left.set_xticks([0, 25, 50, 75, 100], ["new", "25 %", "50 %", "75 %", "limit"])
    left.set_title("way from new to the limit", loc="left")
    right.set_title("operations left", loc="left")
    right.xaxis.set_major_formatter("{x:,.0f}")
    for axis in (left, right):
        axis.grid(axis="y", visible=False)
