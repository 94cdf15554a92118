"""What is known of each limit after each operation: exceeded or not, since when, how long left.

The one definition that alarms, table, first page and figures read. "Exceeded" is about the level of
the drive, without the scatter of single operations. What is known stays known while operations
bring no record of a motion; operations that are left then count down.

Shapes: ``o`` operations, ``l`` limits.
"""

import math
from collections.abc import Mapping

import numpy as np
import xarray as xr

from breaker.decisions.alarms import latched, latest
from breaker.decisions.wearing import drifts

__all__ = ["MAY_BE", "STATES", "evidence", "health", "judge", "leaving"]

MAY_BE = 0.05  # probability from which a limit may be exceeded

STATES = ("unknown", "healthy", "drifting", "plan", "now")
"""States of a limit and of the drive, the worst last."""


def evidence(
    single: np.ndarray,
    trend: np.ndarray,
    *,
    after: int,
    sure: float,
    clear: float,
    anew: np.ndarray | None = None,
) -> np.ndarray:
    """Return how probably the level is beyond each limit, ``(o, l)``, nan if nothing is known.

    The larger of two probabilities: the trend's, and the smallest of the last ``after`` usable
    operations, each judged by its own posterior. These tell a sudden fault before the trend
    follows, and a drive without a trend. Beside a trend, which knows more than single operations,
    they count only once they are ``sure`` that the limit is exceeded, until they are ``clear``.

    Args:
        single: Probabilities of single operations, nan where one is not usable, ``(o, l)``.
        trend: Probabilities by the trend, nan where there is none, ``(o, l)``.
        after: Operations in a row.
        sure, clear: Probabilities.
        anew: Whether a known event started something anew before an operation, ``(o,)``; the
            operations in a row then begin anew, too.

    >>> single = np.array([[0.9], [0.8], [np.nan], [0.7]])
    >>> evidence(single, np.full((4, 1), np.nan), after=2, sure=0.95, clear=0.5).ravel()
    array([nan, 0.8, 0.8, 0.7])
    """
    begins = [] if anew is None else np.flatnonzero(anew)
    rows = np.concatenate([_in_row(each, after) for each in np.split(single, begins)])
    trend = _carried(trend)
    counts = np.isnan(trend) | latched(rows >= sure, ~(rows > clear))
    return np.fmax(np.where(counts, rows, np.nan), trend)


def _in_row(single: np.ndarray, after: int) -> np.ndarray:
    """The smallest of the last so many usable probabilities, ``(o, l)``, nan before there are."""
    rows = np.full(single.shape, np.nan)
    for j, own in enumerate(single.T):
        usable = np.flatnonzero(np.isfinite(own))
        if usable.size >= after:
            windows = np.lib.stride_tricks.sliding_window_view(own[usable], after)
            rows[usable[after - 1 :], j] = windows.min(axis=-1)
    return _carried(rows)


def _carried(values: np.ndarray) -> np.ndarray:
    """The last values that are known, ``(o, l)``."""
    last = latest(np.isfinite(values))
    return np.take_along_axis(values, np.maximum(last, 0), axis=0)


def leaving(toward: float) -> float:
    """Probability ``toward`` below which a trend leads to its limit no more: of twice the doubt.

    >>> round(leaving(0.95), 3)
    0.9
    """
    return max(0.0, 2.0 * toward - 1.0)


def judge(
    condition: xr.Dataset,
    left: xr.Dataset,
    trends: Mapping[str, xr.Dataset],
    *,
    alarm: Mapping,
    toward: float,
) -> xr.Dataset:
    """Judge every limit after every operation.

    Args:
        condition: What ``condition`` returns, all operations.
        left: What ``remaining`` returns, for the same operations.
        trends: As of ``drifts``.
        alarm: The section ``alarm`` of the configuration.
        toward: Probability that a trend leads to a limit from which it counts.

    Returns:
        Dataset over ``operation``, ``limit`` and ``quantile``. ``probability`` and ``marginal`` of
        single operations, ``trend_probability``; ``level_probability``, what ``evidence`` returns;
        ``exceeded``; ``since``, the operation at which the present spell of it began, nan without
        one; ``told``, operations left: 0 where exceeded, inf beyond the horizon, nan where no trend
        leads to the limit; ``state``, one of ``STATES``. ``drive_state (operation)``. ``words``,
        ``source`` and ``of`` of each limit.

    Raises:
        ValueError: If levels of the alarm cannot be used, or operations differ.
    """
    each = ("operation", "limit")
    data = condition[["probability", "marginal"]].transpose(*each)
    operations = data.operation.values
    if not np.array_equal(operations, left.operation.values):
        raise ValueError("single operations and trends must be of the same operations")
    beyond, leads, remaining = _by_trends(left, toward)
    anew = _anew(trends, operations)
    probability, exceeded = _exceeded(data.probability.values, beyond, anew, alarm)
    wears = [rows.any(axis=1) for rows in drifts(trends, operations).values()]
    told = np.select([exceeded[..., None], leads[..., None]], [0.0, remaining], default=np.nan)
    state = np.select(
        [exceeded, leads & np.isfinite(told[..., 0]), leads, probability < MAY_BE],
        ["now", "plan", "drifting", "healthy"],
        default="unknown",
    )
    return data.assign(
        trend_probability=(each, left.beyond.transpose(*each).values),
        level_probability=(each, probability),
        exceeded=(each, exceeded),
        since=(each, _since(exceeded, operations)),
        told=((*each, "quantile"), told),
        state=(each, state),
        drive_state=("operation", _drive(state, np.any(wears, axis=0))),
        words=("limit", condition.words.values),
        source=("limit", left.source.values),
        of=("limit", left.of.values),
    ).assign_coords(quantile=left["quantile"].values)


def _exceeded(
    single: np.ndarray, trend: np.ndarray, anew: np.ndarray, alarm: Mapping
) -> tuple[np.ndarray, np.ndarray]:
    """Probability to be beyond each limit, and whether it is exceeded, ``(o, l)``.

    A known event ends a spell, unless the limit is surely exceeded right after it, too.
    """
    up, down, after = (alarm[name] for name in ("raise", "clear", "after"))
    if not (0 <= down <= up <= 1 and after >= 1):
        raise ValueError("an alarm needs 0 <= clear <= raise <= 1 and after >= 1")
    probability = evidence(single, trend, after=after, sure=up, clear=down, anew=anew)
    return probability, latched(probability >= up, (probability <= down) | anew[:, None])


def _anew(trends: Mapping[str, xr.Dataset], operations: np.ndarray) -> np.ndarray:
    """Whether a known event started something anew before each operation, ``(o,)``."""
    found = [each.operation.values[each.event.values != ""] for each in trends.values()]
    return np.isin(operations, np.concatenate(found) if found else [])


def _by_trends(left: xr.Dataset, toward: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Probability to be beyond, whether a trend leads there, and operations left, as last known."""
    each = ("operation", "limit")
    beyond, way = left.beyond.transpose(*each).values, left.toward.transpose(*each).values
    last = np.maximum(latest(np.isfinite(beyond)), 0)
    passed = left.operation.values[:, None] - left.operation.values[last]
    remaining = left.remaining.transpose(*each, "quantile").values
    remaining = np.take_along_axis(remaining, last[..., None], axis=0) - passed[..., None]
    leads = latched(way >= toward, way < leaving(toward)) & ~np.isnan(remaining[..., 1])
    return beyond, leads, np.maximum(remaining, 0.0)


def _since(exceeded: np.ndarray, operations: np.ndarray) -> np.ndarray:
    """Operation at which the present spell began, nan where there is none, ``(o, l)``."""
    before = np.vstack([np.zeros((1, exceeded.shape[1]), dtype=bool), exceeded[:-1]])
    began = latest(exceeded & ~before)
    return np.where(exceeded, operations[np.maximum(began, 0)], math.nan)


def _drive(state: np.ndarray, wears: np.ndarray) -> np.ndarray:
    """State of the drive after each operation: of its worst limit, unknown if none is known."""
    worst = np.vectorize(STATES.index, otypes=[int])(state).max(axis=1)
    drifting = STATES.index("drifting")
    worst = np.where(wears & (worst > 0) & (worst < drifting), drifting, worst)
    return np.array(STATES)[worst]


def health(judged: xr.Dataset, alarm: Mapping) -> xr.Dataset:
    """Return what is stored of the judgement beside remaining lives; ``since`` is of the end.

    Args:
        judged: What ``judge`` returns.
        alarm: The section ``alarm`` of the configuration.
    """
    last = judged.since.isel(operation=-1, drop=True)
    return judged.drop_vars(["told", "since", "quantile"]).assign(since=last).assign_attrs(alarm)
