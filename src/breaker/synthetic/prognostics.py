"""Scores of predicted remaining lives and of alarms, over many lives. Arrays in, arrays out.

Saxena et al. 2010, "Metrics for offline evaluation of prognostic performance"; CRPS: Gneiting &
Raftery 2007; exact intervals: Clopper & Pearson 1934 of a share, Garwood 1936 of a rate.

Shapes: ``...`` predictions, ``d`` draws, ``k`` operations of a life, ``n`` lives.
Remaining lives are operations. Arguments of another kind raise ValueError.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import binomtest, chi2

__all__ = ["Detections", "crps", "detections", "false_alarms_per", "prognostic_horizon", "share"]


def crps(lives: ArrayLike, truth: ArrayLike, horizon: float) -> np.ndarray:
    """Return the continuous ranked probability score within the horizon, ``(...)``, operations.

    The integral of ``(F(x) - 1[x >= truth])^2`` over x from 0 to the horizon, exact for the
    distribution F of draws. 0 is best. What lies beyond the horizon is not judged, and *no
    crossing*, all inf, scores the horizon less the truth.

    Args:
        lives: Draws of the remaining life, from 0, inf beyond the horizon, ``(..., d)``.
        truth: True remaining lives, ``(...)``, from 0 to the horizon.

    Example:
        >>> float(crps([100.0, 200.0], 150.0, 1000.0))  # half of the mass at either side
        25.0
    """
    lives, truth = np.asarray(lives, float), np.asarray(truth, float)
    if lives.shape[:-1] != truth.shape or lives.shape[-1] == 0:
        raise ValueError("there must be draws for each truth")
    if not np.all((truth >= 0) & (truth <= horizon)):
        raise ValueError(f"truth must be from 0 to the horizon, {horizon:g}")
    if not np.all(lives >= 0):
        raise ValueError("a draw is below 0 or nan")
    # E|X - truth| - E|X - X'| / 2, the latter from sorted draws (Gneiting & Raftery 2007).
    drawn, d = np.sort(np.minimum(lives, horizon), axis=-1), lives.shape[-1]
    spread = drawn @ (2.0 * np.arange(1, d + 1) - d - 1) / d**2
    return np.abs(drawn - truth[..., None]).mean(axis=-1) - spread


def prognostic_horizon(operations: np.ndarray, inside: np.ndarray, failure: float) -> float:
    """Return how long before its failure a life is predicted well to the end, operations.

    The remaining life at the first operation from which on all predictions are inside their
    target; 0 if the last one is not, or if there is none.

    Args:
        operations: Operations that were predicted after, ``(k,)``, increasing, up to the failure.
        inside: Whether each prediction met its target, ``(k,)`` of bool.
        failure: Operation of the failure.

    Example:
        >>> prognostic_horizon(np.array([10, 30, 50, 70]), np.array([True, False, True, True]), 100)
        50.0
    """
    misses = np.flatnonzero(~inside)
    first = misses[-1] + 1 if misses.size else 0
    return float(failure - operations[first]) if first < operations.size else 0.0


class Detections(NamedTuple):
    """How alarms met the changes of lives.

    Attributes:
        delay: Operations from the change of each life to the first alarm at or after it, ``(n,)``;
            NaN if there is none before the failure.
        false_alarms: Alarms before the changes, in all lives together.
    """

    delay: np.ndarray
    false_alarms: int


def detections(alarms: Sequence[ArrayLike], change: ArrayLike, failure: ArrayLike) -> Detections:
    """Compare the alarms of lives with their changes.

    An alarm at the failure or later is neither true nor false: it comes too late to count.

    Args:
        alarms: Operations of the alarms of each life, ``n`` times ``(k,)``, in any order.
        change, failure: Operation of the change, and of the failure after it, ``(n,)``.

    Example:
        >>> detections([[30, 120, 110], [200]], [100, 100], [200, 200])
        Detections(delay=array([10., nan]), false_alarms=1)
    """
    delays, false = [], 0
    for alarm, begin, end in zip(alarms, change, failure, strict=True):
        each = np.asarray(alarm, float)
        delays.append(np.min(each[(each >= begin) & (each < end)] - begin, initial=np.inf))
        false += int(np.sum(each < begin))
    return Detections(np.where(np.isinf(delays), np.nan, delays), false)


def false_alarms_per(
    count: int, operations: float, per: float = 10_000, *, level: float = 0.95
) -> tuple[float, float, float]:
    """Return false alarms per so many operations, and the exact interval of a Poisson count.

    Args:
        count: False alarms.
        operations: Operations without a change that were watched.
        per: Operations that the rate refers to.
        level: Probability of the interval, which holds at least that (Garwood 1936).

    Example:
        >>> rate, lower, upper = false_alarms_per(0, 10_000)
        >>> round(upper, 3)
        3.689
    """
    tail = (1 - level) / 2
    lower = chi2.ppf(tail, 2 * count) / 2 if count else 0.0
    upper = chi2.isf(tail, 2 * count + 2) / 2
    rate, lower, upper = (float(each * per / operations) for each in (count, lower, upper))
    return rate, lower, upper


def share(hits: ArrayLike, *, level: float = 0.95) -> tuple[float, float, float]:
    """Return the share of hits ``(n,)``, and its interval of Clopper & Pearson; NaN where n is 0.

    The interval holds at least ``level``, whatever the share.

    Example:
        >>> share([True, True, True, False])[0]
        0.75
    """
    hits = np.asarray(hits, bool)
    if hits.size == 0:
        return np.nan, np.nan, np.nan
    lower, upper = binomtest(int(hits.sum()), hits.size).proportion_ci(level, method="exact")
    return float(hits.mean()), float(lower), float(upper)
