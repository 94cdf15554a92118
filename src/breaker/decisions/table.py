"""From trends and probabilities to decisions: is it healthy, what is wearing, how long has it left.

The state of every limit follows from its alarm and its trend; an operation is as its worst limit.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from breaker.decisions.changes import changes, latest_step
from breaker.files import ABOUT, known_about

__all__ = [
    "MAY_BE",
    "STATES",
    "decide",
    "in_doubt",
    "states",
    "until",
    "wearing",
]

_SURE = 2.69 / 1.645  # of half a 90 % interval: 5 % for seven parameters together
MAY_BE, _IS = 0.05, 0.95  # trend probabilities: a limit may be exceeded, and is exceeded

STATES = ("unknown", "healthy", "wearing", "alarm")
"""States of a limit and of the drive, the worst last."""


def states(health: xr.Dataset, trend: xr.Dataset, toward: float) -> np.ndarray:
    """Return the state of each limit after each operation, ``(o, limit)``, one of ``STATES``.

    Args:
        health: What ``health`` returns.
        trend: What ``remaining`` returns.
        toward: Probability that a trend leads to a limit from which it counts.
    """
    left = _at(trend, health.operation.values)
    beyond, early = left.beyond.values, left.remaining.values[..., 0]
    leads = (left.toward.values >= toward) & np.isfinite(early)
    return np.select(
        [
            health.alarm.values | (beyond >= _IS),
            leads & np.isfinite(beyond) | (beyond >= MAY_BE),
            np.isfinite(beyond),
        ],
        ["alarm", "wearing", "healthy"],
        default="unknown",
    )


def _at(trend: xr.Dataset, operations: np.ndarray) -> xr.Dataset:
    """Predictions at given operations, with the dims operation, limit and quantile in order."""
    return (
        trend[["remaining", "toward", "beyond"]]
        .reindex(operation=operations)
        .transpose("operation", "limit", "quantile")
    )


def decide(
    health: xr.Dataset,
    trend: xr.Dataset,
    trends: Mapping[str, xr.Dataset],
    curves: Mapping[str, xr.Dataset],
    settings: Mapping,
) -> pd.DataFrame:
    """Return one row per operation: what is known, what changed, what to do when.

    And what is known of the operation, such as its date, where anything is.

    Args:
        health: What ``health`` returns.
        trend: What ``remaining`` returns.
        trends: Whole trends by source, those that limits are read from.
        curves: Results of each motion, with ``accepted`` and ``resolved``.
        settings: The section ``wear_model`` of the configuration.
    """
    operations, names = health.operation.values, health.limit.values
    every = states(health, trend, settings["toward"])
    coming = _coming(_at(trend, operations), settings["toward"])
    reasons = {motion: _unused(data, operations) for motion, data in curves.items()}
    rows = pd.DataFrame(
        {
            "operation": operations,
            "state": [max(row, key=STATES.index) for row in every.tolist()],
            "limits_exceeded": ["; ".join(names[row == "alarm"]) for row in every],
            "next_limit": coming.limit,
            "remaining_5": coming.ends[:, 0],
            "remaining_median": coming.ends[:, 1],
            "remaining_95": coming.ends[:, 2],
            "wearing": wearing(trends, operations),
            "change": changes(trends, operations),
        }
    )
    doubts = in_doubt(health, trends, settings["notice"])
    rows["action"] = [
        _action(row, doubts[i], coming.soonest[i], coming.earliest[i], settings["notice"])
        for i, row in enumerate(rows.itertuples())
    ]
    rows["not_used"] = [
        "; ".join(f"{motion}: {each[i]}" for motion, each in reasons.items() if each[i])
        for i in range(len(operations))
    ]
    return rows.assign(**_about(curves, operations))


def _about(curves: Mapping[str, xr.Dataset], operations: np.ndarray) -> dict[str, list]:
    """What is known of each operation, ``(o,)``, by its name: of the first motion that knows it."""
    known: dict[str, dict] = {}
    for data in curves.values():
        for name in known_about(data):
            of = known.setdefault(name, {})
            for number, value in zip(data.operation.values, data[name].values, strict=True):
                if value == value and value != "":
                    of.setdefault(int(number), value)
    return {
        name: [known[name].get(int(number)) for number in operations]
        for name in ABOUT
        if name in known
    }


class _Coming(NamedTuple):
    """What comes next at each operation.

    Attributes:
        limit: Limit of the smallest median remaining life, empty without one, ``(o,)``.
        ends: Quantiles of its remaining life, nan without one, ``(o, 3)``.
        soonest: Limit that may come first, by the 5 % quantiles, ``(o,)``,
        earliest: and that quantile, inf without one, ``(o,)``.
    """

    limit: np.ndarray
    ends: np.ndarray
    soonest: np.ndarray
    earliest: np.ndarray


def _coming(left: xr.Dataset, toward: float) -> _Coming:
    quantiles, rows = left.remaining.values, np.arange(left.sizes["operation"])
    leads = left.toward.values >= toward
    early, median = (
        np.where(leads & np.isfinite(each), each, np.inf)
        for each in np.moveaxis(quantiles, -1, 0)[:2]
    )
    soonest = early.argmin(axis=1)
    nearest = np.where(np.isfinite(median.min(axis=1)), median.argmin(axis=1), soonest)
    known = np.isfinite(early[rows, nearest])
    names = left.limit.values
    return _Coming(
        np.where(known, names[nearest], ""),
        np.where(known[:, None], quantiles[rows, nearest], np.nan),
        names[soonest],
        early[rows, soonest],
    )


def _action(row, doubts: str, soonest: str, earliest: float, notice: float) -> str:
    """Say what to do after an operation, from its row of the table and what comes next."""
    if row.state == "alarm":
        return f"service now: {row.limits_exceeded.replace('; ', ', ')} exceeded"
    if row.state == "unknown":
        return "cannot tell: no usable operation yet"
    if earliest <= notice:
        return f"plan service within {max(earliest, 0):.0f} operations, before {soonest}"
    if doubts:
        return f"look closer: {doubts}"
    if row.state == "wearing" and row.next_limit:
        span = f"{row.remaining_5:.0f} to {until(row.remaining_95)}"
        return f"go on; {row.next_limit} in {until(row.remaining_median)} operations ({span})"
    return "go on"


def wearing(
    trends: Mapping[str, xr.Dataset], operations: Sequence[int], *, most: int | None = None
) -> list[str]:
    """Name the parameters that drift at each operation, with percent per 1,000 operations.

    A drift is a slope that differs from zero at 5 % for all parameters together. The steepest
    come first, at most ``most`` of each source.
    """
    words = [[] for _ in operations]
    for source, trend in trends.items():
        place = {int(number): i for i, number in enumerate(trend.operation.values)}
        names, slopes = trend.parameter.values, trend.slope.values
        half = np.diff(trend.slope_interval.values, axis=-1)[..., 0] / 2.0
        sure = np.abs(slopes) > _SURE * half
        order = np.argsort(-np.abs(slopes), axis=-1, kind="stable")
        for told, operation in zip(words, operations, strict=True):
            if (i := place.get(int(operation))) is None:
                continue
            drifts = [f"{names[j]} {_percent(slopes[i, j])}" for j in order[i] if sure[i, j]]
            if drifts:
                told.append(f"{source}: {', '.join(drifts[:most])}")
    return ["; ".join(told) for told in words]


def _percent(value: float) -> str:
    return f"{value:+.0f} %" if abs(value) >= 10 else f"{value:+.2g} %"


def _unused(data: xr.Dataset, operations: np.ndarray) -> np.ndarray:
    """Why an operation could not be used, ``(o,)``; empty where it was."""
    there = np.isin(operations, data.operation.values)
    known = data[["accepted", "resolved"]].reindex(operation=operations, fill_value=False)
    return np.select(
        [~there, ~known.accepted.values, ~known.resolved.values],
        ["no record", "rejected", "not resolved"],
        default="",
    )


def in_doubt(health: xr.Dataset, trends: Mapping[str, xr.Dataset], notice: int) -> list[str]:
    """Say what asks for a closer look after each operation, ``(o,)``; empty if nothing does.

    Limits that may be exceeded by the trend, though it is not certain, and the last step, for
    ``notice`` operations.
    """
    beyond = health.trend_probability.transpose("operation", "limit").values
    names, told = health.limit.values, []
    steps = latest_step(trends, health.operation.values, within=notice)
    for row, step in zip(beyond, steps, strict=True):
        doubtful = ", ".join(names[(row >= MAY_BE) & (row < _IS)])
        beyond_words = f"{doubtful} may be exceeded" if doubtful else ""
        told.append("; ".join(filter(None, [beyond_words, step])))
    return told


def until(value: float) -> str:
    """Write a number of operations that may be beyond the horizon."""
    return f"{value:.0f}" if np.isfinite(value) else "beyond the horizon"
