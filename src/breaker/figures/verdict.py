"""The picture of the first page: what to do, how near each limit is, and what follows."""

from collections.abc import Sequence
from textwrap import fill

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.common.numerals import about, in_digits, in_percent, span
from breaker.figures import panels as p
from breaker.figures import style


@style.styled
def verdict(life: xr.Dataset, standing: xr.Dataset, sentences: Sequence[str]) -> Figure:
    """Draw one row per limit, after the last operation: its nearness, its state, and what to do.

    Above stand ``sentences``: first what to do, then others. The data are those of ``life``.
    """
    now, (ways, parts) = standing.isel(operation=-1), _ways(life.isel(asked=-1))
    # A number is in one line with its sign of percent.
    action, *others = (p.spoken(sentence).replace(" %", "\u00a0%") for sentence in sentences)
    action, others = fill(action, 115), "\n".join(fill(other, 175) for other in others)
    head = 0.22 * (action.count("\n") + 1) + 0.17 * (others.count("\n") + 1) + 0.4  # inches
    body = 0.82 * len(ways) + 0.55
    figure = style.new_figure(13.6, head + body)
    above, below = figure.subfigures(2, 1, height_ratios=[head, body])
    states = list(p.STATES)
    look = {"weight": "bold", "color": p.STATES[states[now["drive_state"].item()]]}
    above.text(0.01, 1.0 - 0.1 / head, action, va="top", fontsize=13, **look)
    above.text(0.01, 0.12 / head, others, va="bottom", fontsize=10)
    axis = below.subplots()
    high = ways[np.isfinite(ways)].max(initial=0.0) + 5.0
    axis.set_xlim(-20.0, float(np.clip(high, 130.0, 220.0)))
    labels, words = [], []
    for row, (way, part) in enumerate(zip(ways, parts, strict=True)):
        one, state = now.isel(limit=row), states[now["state"].values[row]]
        _way(axis, row, way, p.STATES[state])
        _values(axis, row, way, life.isel(asked=-1, part=part))
        limit = fill(p.spoken(life["words"].values[row]), 38)
        labels.append(f"{p.spoken(life['limit'].values[row])}\n{limit}")
        words.append((_words(state, one), p.STATES[state]))
    axis.axvspan(100.0, axis.get_xlim()[1], color=style.WARNING, alpha=0.08, lw=0)
    axis.axvline(100.0, color=style.WARNING, lw=1.4)
    axis.axvline(0.0, color=style.MEASURED, lw=1.0)
    axis.set_xticks([0, 25, 50, 75, 100], ["new", "25 %", "50 %", "75 %", "limit"])
    axis.set_xlabel("from new to the limit: median and 90 % interval (arrow: goes on)")
    actions = p.rows_of_words(axis, labels, [text for text, _ in words])
    for text, (_, color) in zip(actions.get_yticklabels(), words, strict=True):
        text.set_color(color)
    return figure


def _ways(life: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return how near each limit is ``(limit, quantile)``: 0 when new, 100 at the limit, inf where
    it was passed when new; and the part of each that counts, the one farthest from its bound.
    """
    new, whole = life["new"].values, life["part_bound"].values - life["new"].values
    ahead = np.where(life["part_upper"], whole, -whole) > 0.0
    gone = life["value"].transpose("part", "quantile").values - new[:, None]
    ways = np.sort(100.0 * gone / np.where(ahead, whole, np.nan)[:, None], axis=1)
    ways[~ahead] = np.inf
    every = [np.flatnonzero(life["part_limit"].values == name) for name in life["limit"].values]
    parts = np.array([rows[ways[rows, 1].argmin()] for rows in every], dtype=int)
    return ways[parts], parts


def _known(way: np.ndarray) -> bool:
    """Whether a way is less wide than all of it, or begun for sure and past the limit."""
    past = way[1] >= 100.0 and way[0] > 0.0
    return bool(np.isfinite(way).all() and (way[2] - way[0] <= 100.0 or past))


def _way(axis: Axes, row: int, way: np.ndarray, colour: str) -> None:
    """Draw a way with its interval, as far as the axis reaches, if it is known well enough."""
    axis.barh(row, 100.0, 0.26, color=style.PRIOR, alpha=0.28, lw=0)
    if not _known(way):
        words = "beyond the limit when new" if np.isinf(way[0]) else "not known well enough"
        axis.text(50.0, row, words, ha="center", va="center", color=style.REFERENCE)
        return
    low, middle, high = np.clip(way, *axis.get_xlim())
    axis.barh(row, middle, 0.26, color=colour, alpha=0.35, lw=0)
    axis.hlines(row, low, high, color=colour, lw=4)
    for shown, value, marker in zip((low, middle, high), way, "<o>", strict=True):
        if (marker == "o") == (shown == value):
            look = {"mec": "white", "ms": 11, "clip_on": False, "zorder": 3}
            axis.plot(shown, row, marker, color=colour, **look)


def _values(axis: Axes, row: int, way: np.ndarray, part: xr.Dataset) -> None:
    """Write the values when new, now, and at the limit, in their unit."""
    values, unit = (part["new"].item(), part["part_bound"].item()), part["part_unit"].item()
    new, bound, low, middle, high = (
        p.signed(in_digits(number, 3, sign=bool(number)) if unit == "%" else in_digits(number, 4))
        for number in (*values, *part["value"].values)
    )
    unit = "" if unit == "1" else f" {unit}"
    place = {"textcoords": "offset points", "ha": "center"}
    for x, text in ((0.0, f"new {new}{unit}"), (100.0, f"limit {bound}{unit}")):
        axis.annotate(text, (x, row), xytext=(0, -11), va="top", fontsize=9, **place)
    if _known(way):
        least, most = axis.get_xlim()
        room = 0.17 * (most - least)  # that half of the text takes
        at = float(np.clip(way[1], least + room, most - room))
        axis.annotate(f"now {middle}{unit} ({low} to {high})", (at, row), xytext=(0, 10), **place)


def _words(state: str, one: xr.Dataset) -> str:
    """Return what to do about a limit, then why, how sure, and since when."""
    low, middle, high = one["remaining"].values
    names = ("service_by", "recommended_since", "certain")
    by, since, certain = (one[name].item() for name in names)
    if np.isfinite(certain):
        crossed = one["crossed"].item()
        advice = f"recommended since {since:,.0f}, at last by {by:,.0f}"
        advice = advice if since < certain else "no service was recommended before"
        return f"due: exceeded\ncertain at {certain:,.0f}, crossed about {crossed:,.0f}\n{advice}"
    chance = one["p_exceeded"].item()
    probable = f"P {in_percent(chance)} that it is exceeded" if np.isfinite(chance) else ""
    if state == "unknown":
        return f"unknown\n{probable}"
    left = "beyond the horizon" if np.isinf(low) else f"{about(middle)} ({span(low, high)})"
    left = f"operations left: {left}"
    if state == "ok":
        return f"ok: no service is planned\n{left}\n{probable}"
    due = "due: service now" if state == "due" else f"planned: service by operation {by:,.0f}"
    return f"{due}\n{left}\n{probable}; recommended since {since:,.0f}"
