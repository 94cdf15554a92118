"""Scores of predicted remaining lives and of alarms, over many lives. Arrays in, arrays out.

Saxena et al. 2010, "Metrics for offline evaluation of prognostic performance"; CRPS: Gneiting &
Raftery 2007; exact intervals: Clopper & Pearson 1934 of a share, Garwood 1936 of a rate.

A *prediction* is a distribution function of the remaining life on a grid that begins at 0 or later
and ends at the horizon, one grid for all. It is linear between nodes and 0 at 0, so between 0 and
a first node above 0 it rises linearly; at a first node of 0 it may jump, which is the probability
that the limit is exceeded already. It may end below 1: what is missing lies beyond the horizon,
*no crossing*. A row of NaN is *no prediction*: it has no quantiles and no CRPS, and it misses every
target. All zeros, no crossing for certain, is a prediction.

Shapes: ``...`` predictions, ``g`` nodes of the grid, ``k`` operations. Everywhere ``grid`` is
``(g,)``, remaining operations, increasing; ``cdf`` is ``(..., g)``; ``truth``, the true remaining
lives, is ``(...)``, operations. Arguments of another kind raise ValueError.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import beta as beta_law
from scipy.stats import chi2

__all__ = [
    "Detection",
    "Rate",
    "alpha_lambda",
    "alpha_lambda_median",
    "coverage_interval",
    "covered",
    "crps",
    "detection",
    "false_alarms_per",
    "prognostic_horizon",
    "quantile",
    "relative_accuracy",
]

_ROUND_OFF = 1e-9  # by which a distribution function may fall or leave 0 to 1: sums of weights do


# ---- predictions -----------------------------------------------------------------------------


def quantile(grid: ArrayLike, cdf: ArrayLike, q: ArrayLike) -> np.ndarray:
    """Return the least remaining life that has a probability of ``q``, ``(...)`` or ``(..., q)``.

    ``q`` is above 0 and at most 1, a number or ``(q,)``. The result is ``inf`` where the mass
    within the horizon does not reach it, NaN where there is no prediction.
    """
    nodes, cdf = _checked(grid, cdf)
    q = np.asarray(q, float)
    if q.ndim > 1 or not np.all((q > 0) & (q <= 1)):
        raise ValueError("q must be probabilities above 0 and at most 1")
    found = [_quantile(nodes, cdf, each) for each in q.ravel()]
    return found[0] if q.ndim == 0 else np.stack(found, axis=-1)


def crps(grid: ArrayLike, cdf: ArrayLike, truth: ArrayLike) -> np.ndarray:
    """Return the continuous ranked probability score within the horizon, ``(...)``, operations.

    The integral of ``(cdf(x) - 1[x >= truth])^2`` over x from 0 to the last node, exact for a
    function that is linear between nodes. 0 is best; *no crossing* scores the horizon less the
    truth; what lies beyond the horizon is not judged. NaN where there is no prediction.

    Raises:
        ValueError: Also if a truth is beyond the last node.
    """
    nodes, cdf = _checked(grid, cdf)
    truth = _checked_truth(truth, cdf.shape[:-1], nodes[-1])
    # Each interval between nodes is parted at the truth; one of the parts may be empty.
    left, right = cdf[..., :-1], cdf[..., 1:]
    middle = np.clip(truth[..., None], nodes[:-1], nodes[1:])
    share = (middle - nodes[:-1]) / np.diff(nodes)
    at_middle = left + share * (right - left)
    before = share * _mean_square(left, at_middle)
    after = (1 - share) * _mean_square(at_middle - 1, right - 1)
    return np.sum((before + after) * np.diff(nodes), axis=-1)


def _mean_square(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Mean square of a line from ``a`` to ``b``."""
    return (a * a + a * b + b * b) / 3


def alpha_lambda(
    grid: ArrayLike, cdf: ArrayLike, truth: ArrayLike, alpha: float, beta: float = 0.5
) -> np.ndarray:
    """Say whether enough of the probability lies in the α-λ cone, ``(...)`` of bool.

    The cone of a prediction is the interval from ``(1 - alpha) truth`` to ``(1 + alpha) truth``.
    What lies beyond the horizon is not in it, and no prediction is a miss.

    Args:
        grid, cdf, truth: The truth above 0, up to the last node.
        alpha: Half width of the cone, a share of the truth between 0 and 1.
        beta: Least probability that has to be inside, above 0, at most 1.
    """
    nodes, cdf = _checked(grid, cdf)
    truth = _positive(_checked_truth(truth, cdf.shape[:-1], nodes[-1]))
    _check_share("alpha", alpha)
    if not 0 < beta <= 1:
        raise ValueError("beta must be above 0 and at most 1")
    inside = _at(nodes, cdf, (1 + alpha) * truth) - _at(nodes, cdf, (1 - alpha) * truth)
    return inside >= beta  # not of NaN


def alpha_lambda_median(median: ArrayLike, truth: ArrayLike, alpha: float) -> np.ndarray:
    """Say whether medians lie in the α-λ cone, ``(...)`` of bool.

    Args:
        median: Medians, ``(...)``; ``inf`` beyond the horizon, NaN if there is no trend or no
            prediction. Both are misses.
        truth: Above 0.
        alpha: Half width of the cone, a share of the truth between 0 and 1.
    """
    _check_share("alpha", alpha)
    median, truth = np.asarray(median, float), _positive(truth)
    return (median >= (1 - alpha) * truth) & (median <= (1 + alpha) * truth)


def covered(lower: ArrayLike, upper: ArrayLike, truth: ArrayLike) -> np.ndarray:
    """Say whether truths lie in their intervals, bounds included, ``(...)`` of bool.

    Bounds may be ``inf``, beyond the horizon. An interval with a NaN for a bound covers nothing.
    """
    lower, upper, truth = (np.asarray(each, float) for each in (lower, upper, truth))
    if np.isnan(truth).any():
        raise ValueError("truth must not be NaN")
    if np.any(lower > upper):
        raise ValueError("a lower bound is above its upper one")
    return (lower <= truth) & (truth <= upper)


def relative_accuracy(median: ArrayLike, truth: ArrayLike) -> np.ndarray:
    """Return ``1 - |median - truth| / truth``, ``(...)``: 1 is best, and there is no least value.

    ``-inf`` where the median is beyond the horizon, NaN where it is NaN. The truth is above 0.
    """
    truth = _positive(truth)
    return 1 - np.abs(np.asarray(median, float) - truth) / truth


def prognostic_horizon(operations: ArrayLike, inside: ArrayLike, failure: float) -> float:
    """Return how long before its failure a life is predicted well to the end, operations.

    The remaining life at the first operation from which on all predictions are inside their
    target; 0 if the last one is not, or if there is none.

    Args:
        operations: Operations that were predicted after, ``(k,)``, increasing, up to the failure.
        inside: Whether each prediction met its target, ``(k,)`` of bool.
        failure: Operation of the failure.
    """
    operations, inside = np.asarray(operations, float), np.asarray(inside)
    if operations.ndim != 1 or inside.shape != operations.shape or inside.dtype != bool:
        raise ValueError("operations and inside must be (k,), inside of bool")
    if not (np.all(np.diff(operations) > 0) and np.all(operations <= failure)):
        raise ValueError("operations must increase and not pass the failure")
    misses = np.flatnonzero(~inside)
    first = misses[-1] + 1 if misses.size else 0
    return float(failure - operations[first]) if first < operations.size else 0.0


# ---- detection -------------------------------------------------------------------------------


class Detection(NamedTuple):
    """How alarms met the change of one life.

    Attributes:
        delay: Operations from the change to the first alarm at or after it; NaN if there is none
            before the failure.
        false_alarms: Alarms before the change.
    """

    delay: float
    false_alarms: int


def detection(alarms: ArrayLike, change: float, failure: float) -> Detection:
    """Compare alarms with the change of a life.

    An alarm at the failure or later is neither: it comes too late to count.

    Args:
        alarms: Operations of the alarms, ``(k,)``, in any order.
        change: Operation of the change, before the failure; ``inf`` in a life without one, where
            all alarms are false.
        failure: Operation of the failure; ``inf`` if there is none.
    """
    alarms = np.asarray(alarms, float)
    if alarms.ndim != 1 or not np.isfinite(alarms).all():
        raise ValueError("alarms must be finite operation numbers, (k,)")
    if not (change < failure or np.isposinf(change)):
        raise ValueError("the change must come before the failure, or be inf")
    in_time = alarms[alarms < failure]
    true = in_time[in_time >= change]
    delay = float(true.min() - change) if true.size else np.nan
    return Detection(delay, int(np.sum(in_time < change)))


class Rate(NamedTuple):
    """A rate with its interval."""

    rate: float
    lower: float
    upper: float


def false_alarms_per(
    count: int, operations: float, per: float = 10_000, *, level: float = 0.95
) -> Rate:
    """Return false alarms per so many operations, with the exact interval of a Poisson count.

    Args:
        count: False alarms, whole, from 0.
        operations: Operations without a change that were watched.
        per: Operations that the rate refers to.
        level: Probability of the interval, which holds at least that (Garwood 1936).
    """
    if not (count >= 0 and count % 1 == 0 and operations > 0 and per > 0):
        raise ValueError("count must be a whole number from 0, operations and per positive")
    _check_share("level", level)
    tail = (1 - level) / 2
    lower = chi2.ppf(tail, 2 * count) / 2 if count else 0.0
    upper = chi2.isf(tail, 2 * count + 2) / 2
    return Rate(*(float(each * per / operations) for each in (count, lower, upper)))


def coverage_interval(
    hits: ArrayLike, n: ArrayLike, level: float = 0.95
) -> tuple[np.ndarray, np.ndarray]:
    """Return the exact interval of a share, lower and upper ``(...)``, from ``hits`` of ``n``.

    Clopper & Pearson: it holds at least ``level`` whatever the share.
    """
    hits, n = np.broadcast_arrays(np.asarray(hits, float), np.asarray(n, float))
    if not np.all((n >= 1) & (hits >= 0) & (hits <= n) & (hits % 1 == 0) & (n % 1 == 0)):
        raise ValueError("hits must be whole numbers from 0 to n, and n from 1")
    _check_share("level", level)
    tail = (1 - level) / 2
    # The laws at the edges have a parameter of 0; their quantiles there are 0 and 1.
    lower = np.where(hits == 0, 0.0, beta_law.ppf(tail, np.maximum(hits, 1), n - hits + 1))
    upper = np.where(hits == n, 1.0, beta_law.isf(tail, hits + 1, np.maximum(n - hits, 1)))
    return lower, upper


# ---- distribution functions ------------------------------------------------------------------


def _quantile(nodes: np.ndarray, cdf: np.ndarray, q: float) -> np.ndarray:
    reached = cdf >= q
    after = np.maximum(reached.argmax(axis=-1), 1)
    low, high = (_pick(cdf, at) for at in (after - 1, after))
    with np.errstate(divide="ignore", invalid="ignore"):  # where q is not reached, or at once
        share = (q - low) / (high - low)
    value = nodes[after - 1] + share * (nodes[after] - nodes[after - 1])
    value = np.where(reached[..., 0], nodes[0], np.where(reached.any(axis=-1), value, np.inf))
    return np.where(np.isnan(cdf[..., 0]), np.nan, value)


def _at(nodes: np.ndarray, cdf: np.ndarray, lives: np.ndarray) -> np.ndarray:
    """Value of each distribution function ``(..., g)`` at a life of its own ``(...)``."""
    after = np.clip(np.searchsorted(nodes, lives), 1, nodes.size - 1)
    share = (np.minimum(lives, nodes[-1]) - nodes[after - 1]) / (nodes[after] - nodes[after - 1])
    low, high = (_pick(cdf, at) for at in (after - 1, after))
    return low + share * (high - low)


def _pick(cdf: np.ndarray, at: np.ndarray) -> np.ndarray:
    return np.take_along_axis(cdf, np.asarray(at)[..., None], axis=-1)[..., 0]


def _checked(grid: ArrayLike, cdf: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Check a grid and its predictions; add the node (0, 0) where the grid begins later."""
    grid, cdf = np.asarray(grid, float), np.asarray(cdf, float)
    if grid.ndim != 1 or cdf.ndim < 1 or cdf.shape[-1] != grid.size:
        raise ValueError(f"cdf must be (..., {grid.size}) like the grid, not {cdf.shape}")
    rises = grid.size and np.isfinite(grid).all() and np.all(np.diff(grid) > 0)
    if not (rises and grid[0] >= 0 and grid[-1] > 0):
        raise ValueError("the grid must be finite, increase, and not begin below 0")
    missing = np.isnan(cdf)
    if np.any(missing.any(axis=-1) & ~missing.all(axis=-1)):
        raise ValueError("a distribution function is NaN in part: all of it, or nothing")
    falls = np.any(np.diff(cdf, axis=-1) < -_ROUND_OFF)
    if falls or np.any((cdf < -_ROUND_OFF) | (cdf > 1 + _ROUND_OFF)):
        raise ValueError("a distribution function falls, or leaves 0 to 1")
    cdf = np.maximum.accumulate(np.clip(cdf, 0, 1), axis=-1)  # round-off
    if grid[0] > 0:
        zero = np.where(missing[..., :1], np.nan, 0.0)
        grid, cdf = np.append(0.0, grid), np.concatenate([zero, cdf], axis=-1)
    return grid, cdf


def _checked_truth(truth: ArrayLike, shape: tuple[int, ...], horizon: float) -> np.ndarray:
    truth = np.asarray(truth, float)
    if truth.shape != shape:
        raise ValueError(f"truth must be {shape}, one a prediction, not {truth.shape}")
    if not np.all((truth >= 0) & (truth <= horizon)):
        raise ValueError(f"truth must be from 0 to the last node of the grid, {horizon:g}")
    return truth


def _positive(truth: ArrayLike) -> np.ndarray:
    truth = np.asarray(truth, float)
    if not np.all((truth > 0) & np.isfinite(truth)):
        raise ValueError("truth must be positive and finite")
    return truth


def _check_share(name: str, value: float) -> None:
    if not 0 < value < 1:
        raise ValueError(f"{name} must be between 0 and 1, not {value:g}")
