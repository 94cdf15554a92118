"""Probability that limits of the drive's state are exceeded, operation by operation."""

from textwrap import fill

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from breaker.figures.style import (
    MODEL,
    REFERENCE,
    WARNING,
    legend_below,
    panels,
    styled,
)

__all__ = ["edges", "health", "limit_title", "spans"]

_MARGINAL = "#EBC48A"
_FOOT = -0.05  # where unusable operations are ticked, on the axis of probability


@styled
def health(health: xr.Dataset) -> Figure:
    """Draw a panel a limit: probability that it is exceeded, alarm levels and the alarm.

    The product of the marginals is shown only where it is not the same, that is, for a limit of
    several parts. Operations that are not usable are ticked at the foot.

    Args:
        health: ``probability``, ``marginal`` and ``trend_probability`` ``(operation, limit)``, nan
            where there is none, ``alarm (operation, limit)``, ``first_alarm (limit)``, an operation
            or nan, ``words`` and ``source`` ``(limit)``; coordinates ``operation`` and ``limit``;
            attributes ``raise``, ``clear`` and ``after``.
    """
    count = health.sizes["limit"]
    size = {"columns": 2, "width": 6.4} if count > 1 else {"columns": 1, "width": 10.0}
    figure, axes = panels(count, height=2.7, sharex=True, sharey=True, **size)
    for axis, limit in zip(axes, health["limit"].values, strict=True):
        one = health.sel(limit=limit)
        _probabilities(axis, one)
        _alarm(axis, one, health.attrs)
        limit_title(axis, str(limit), one["words"].item(), room=int(size["width"] * 11.5), above=1)
        axis.set_ylabel("probability")
        if axis.xaxis.get_tick_params()["labelbottom"]:
            axis.set_xlabel("operation")
    axes[0].margins(x=0.01)
    axes[0].set(ylim=(-0.1, 1.05), yticks=np.linspace(0.0, 1.0, 6))
    alarms = int(health["first_alarm"].notnull().sum())
    words = f"limits with an alarm: {alarms} of {count}" if alarms else "no alarm at any limit"
    figure.suptitle(f"Health: probability that a limit is exceeded\n{words}")
    legend_below(figure, _handles(health), columns=4 if count == 1 else 3)
    return figure


def limit_title(axis: Axes, name: str, words: str, *, room: int, above: int = 0) -> None:
    """Write name and words of a limit over its panel.

    Args:
        axis: The panel.
        name, words: Of the limit.
        room: Characters that a line holds.
        above: Lines kept free between title and panel.
    """
    title = fill(f"{name.replace('_', ' ')}: {words}", room)
    axis.set_title(title, loc="left", pad=6.0 + 14.0 * above)


def spans(operation: np.ndarray, inside: np.ndarray) -> list[tuple[float, float]]:
    """Return where runs of operations begin and end, halfway to the neighbours.

    Args:
        operation: Numbers of the operations, rising, ``(o,)``.
        inside: Which of them are in a run, ``(o,)``.
    """
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


def _probabilities(axis: Axes, one: xr.Dataset) -> None:
    """Draw single operations and trend of a limit, and what is not usable."""
    operation = one["operation"].values
    size = np.interp(operation.size, [50, 500, 5000], [5.0, 2.8, 1.6])
    if _differs(one):
        axis.plot(operation, one["marginal"], "D", color=_MARGINAL, ms=size, mew=0, zorder=1.9)
    axis.plot(operation, one["probability"], "o", color=MODEL, alpha=0.45, ms=size, mew=0)
    # The marker is as wide as the line: it keeps values in sight that have no neighbour.
    axis.plot(operation, one["trend_probability"], ".-", color=MODEL, lw=1.8, ms=3.6, mew=0)
    missing = operation[one["probability"].isnull().values]
    axis.plot(missing, np.full(missing.shape, _FOOT), "|", color=REFERENCE, ms=6, mew=0.8)


def _alarm(axis: Axes, one: xr.Dataset, levels: dict) -> None:
    """Draw levels, stretches of alarm, and the first alarm with its words."""
    axis.axhline(levels["raise"], color=WARNING, lw=1.0, ls="--")
    axis.axhline(levels["clear"], color=REFERENCE, lw=1.0, ls="--")
    for start, stop in spans(one["operation"].values, one["alarm"].values.astype(bool)):
        axis.axvspan(start, stop, color=WARNING, alpha=0.13, lw=0)
    first = one["first_alarm"].item()
    known = np.isfinite(first)
    if known:
        axis.axvline(first, color=WARNING, lw=1.4)
    axis.annotate(
        f"first alarm: operation {first:.0f}" if known else "no alarm",
        (0.0, 1.0),
        xycoords="axes fraction",
        xytext=(0, 5),
        textcoords="offset points",
        color=WARNING if known else REFERENCE,
        weight="bold" if known else "normal",
    )
    source = one["source"].item()
    axis.annotate(
        "from both motions" if source == "both" else f"from {source}",
        (1.0, 1.0),
        xycoords="axes fraction",
        xytext=(0, 5),
        textcoords="offset points",
        ha="right",
        color=REFERENCE,
    )


def _differs(one: xr.Dataset) -> bool:
    """Say whether a limit's marginal probability is another than that of the full posterior."""
    same = np.isclose(one["probability"], one["marginal"], rtol=0, atol=1e-12, equal_nan=True)
    return not bool(same.all())


def _handles(health: xr.Dataset) -> list:
    levels = health.attrs
    limits = [health.sel(limit=limit) for limit in health["limit"].values]
    handles = [
        Line2D([], [], color=MODEL, ls="", marker="o", ms=5, alpha=0.6, label="single operations"),
        Line2D([], [], color=MODEL, lw=1.8, label="by the trend"),
    ]
    if any(_differs(one) for one in limits):
        label = "single operations, as if parts were independent"
        handles.append(Line2D([], [], color=_MARGINAL, ls="", marker="D", ms=5, label=label))
    up = f"alarm raised at {levels['raise']:g}, {levels['after']:g} in a row"
    down = f"alarm cleared at {levels['clear']:g}"
    handles += [
        Line2D([], [], color=WARNING, lw=1.0, ls="--", label=up),
        Line2D([], [], color=REFERENCE, lw=1.0, ls="--", label=down),
    ]
    if bool(health["alarm"].any()):
        handles.append(Patch(color=WARNING, alpha=0.13, lw=0, label="alarm on"))
    if bool(health["first_alarm"].notnull().any()):
        handles.append(Line2D([], [], color=WARNING, lw=1.4, label="first alarm"))
    if bool(health["probability"].isnull().any()):
        label = "operation not usable"
        handles.append(Line2D([], [], color=REFERENCE, ls="", marker="|", ms=8, label=label))
    return handles
