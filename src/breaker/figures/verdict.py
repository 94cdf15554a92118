"""Picture of the first page: recommended action, and distance and state of each limit."""

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
    """Draw one row per limit after the last operation: its progress, its state, and the action.

    ``sentences`` are printed above: first the action, then others. Data are as in ``life``.
    """
    now, (progresses, parts) = standing.isel(operation=-1), _progress_of(life.isel(asked=-1))
    # A non-breaking space keeps a number and its percent sign on one line.
    action, *others = (p.spoken(sentence).replace(" %", "\u00a0%") for sentence in sentences)
    action, others = fill(action, 115), "\n".join(fill(other, 175) for other in others)
    head = 0.22 * (action.count("\n") + 1) + 0.17 * (others.count("\n") + 1) + 0.4  # inches
    body = 0.82 * len(progresses) + 0.55
    figure = style.new_figure(13.6, head + body)
    above, below = figure.subfigures(2, 1, height_ratios=[head, body])
    states = list(p.STATES)
    look = {"weight": "bold", "color": p.STATES[states[now["drive_state"].item()]]}
    above.text(0.01, 1.0 - 0.1 / head, action, va="top", fontsize=13, **look)
    above.text(0.01, 0.12 / head, others, va="bottom", fontsize=10)
    axis = below.subplots()
    high = progresses[np.isfinite(progresses)].max(initial=0.0) + 5.0
    axis.set_xlim(-20.0, float(np.clip(high, 130.0, 220.0)))
    labels, words = [], []
    for row, (progress, part) in enumerate(zip(progresses, parts, strict=True)):
        one, state = now.isel(limit=row), states[now["state"].values[row]]
        _draw_progress(axis, row, progress, p.STATES[state])
        _values(axis, row, progress, life.isel(asked=-1, part=part))
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


def _progress_of(life: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return the progress to each limit, ``(limit, quantile)``: 0 when new, 100 at the limit, inf
    if exceeded when new; and the decisive part of each limit, the farthest from its bound.
    """
    new, whole = life["new"].values, life["part_bound"].values - life["new"].values
    ahead = np.where(life["part_upper"], whole, -whole) > 0.0
    gone = life["value"].transpose("part", "quantile").values - new[:, None]
    progresses = np.sort(100.0 * gone / np.where(ahead, whole, np.nan)[:, None], axis=1)
    progresses[~ahead] = np.inf
    every = [np.flatnonzero(life["part_limit"].values == name) for name in life["limit"].values]
    parts = np.array([rows[progresses[rows, 1].argmin()] for rows in every], dtype=int)
    return progresses[parts], parts


def _known(progress: np.ndarray) -> bool:
    """Return whether an interval of progress is narrower than 100, or surely past the limit."""
    past = progress[1] >= 100.0 and progress[0] > 0.0
    return bool(np.isfinite(progress).all() and (progress[2] - progress[0] <= 100.0 or past))


def _draw_progress(axis: Axes, row: int, progress: np.ndarray, colour: str) -> None:
    """Draw a progress with its interval, clipped to the axis, if it is known well enough."""
    axis.barh(row, 100.0, 0.26, color=style.PRIOR, alpha=0.28, lw=0)
    if not _known(progress):
        words = "beyond the limit when new" if np.isinf(progress[0]) else "not known well enough"
        axis.text(50.0, row, words, ha="center", va="center", color=style.REFERENCE)
        return
    low, middle, high = np.clip(progress, *axis.get_xlim())
    axis.barh(row, middle, 0.26, color=colour, alpha=0.35, lw=0)
    axis.hlines(row, low, high, color=colour, lw=4)
    for shown, value, marker in zip((low, middle, high), progress, "<o>", strict=True):
        if (marker == "o") == (shown == value):
            look = {"mec": "white", "ms": 11, "clip_on": False, "zorder": 3}
            axis.plot(shown, row, marker, color=colour, **look)


def _values(axis: Axes, row: int, progress: np.ndarray, part: xr.Dataset) -> None:
    """Write the values when new, now and at the limit, with their unit."""
    values, unit = (part["new"].item(), part["part_bound"].item()), part["part_unit"].item()
    new, bound, low, middle, high = (
        p.signed(in_digits(number, 3, sign=bool(number)) if unit == "%" else in_digits(number, 4))
        for number in (*values, *part["value"].values)
    )
    unit = "" if unit == "1" else f" {unit}"
    place = {"textcoords": "offset points", "ha": "center"}
    for x, text in ((0.0, f"new {new}{unit}"), (100.0, f"limit {bound}{unit}")):
        axis.annotate(text, (x, row), xytext=(0, -11), va="top", fontsize=9, **place)
    if _known(progress):
        least, most = axis.get_xlim()
        room = 0.17 * (most - least)  # half the width of the text
        x = float(np.clip(progress[1], least + room, most - room))
        axis.annotate(f"now {middle}{unit} ({low} to {high})", (x, row), xytext=(0, 10), **place)


def _words(state: str, one: xr.Dataset) -> str:
    """Return the action for a limit, with its reason, its probability, and its start."""
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
