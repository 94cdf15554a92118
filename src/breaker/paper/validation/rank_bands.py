"""Simultaneous bands for the empirical distribution function of ranks.

Paper, Sec. 6, Fig. 4; Talts et al. 2020; Säilynoja, Bürkner & Vehtari 2022, "Graphical test for
discrete uniformity".

The rank of a truth among ``d`` draws takes one of ``d + 1`` values. Bands for continuous values
are left far too often by such ranks, so everything here lives on their own grid ``i / (d + 1)``,
``i = 1 ... d``, where the number of ranks below ``i`` is exactly binomial. Nothing is randomised,
and the false-alarm probability is computed by a recursion instead of simulated, so a judgement is
the same every time, and small probabilities have no error of a simulation.

Shapes: ``n`` simulations, ``d`` draws, ``q`` outputs, ``k = d`` grid points.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import bdtr, gammaln


def ecdf_difference(ranks: ArrayLike, draws: int) -> np.ndarray:
    """Return the share of ranks below grid point ``i`` minus ``i / (d + 1)``, ``(k, q)``.

    Args:
        ranks: Ranks ``(n, q)`` or ``(n,)`` among ``draws`` draws.
        draws: Number of draws ``d`` behind each rank; the grid has ``k = d`` points.

    Raises:
        ValueError: If there is no rank or one is outside ``0 ... d``.
    """
    counts, n = _counts_below(ranks, draws)
    return counts / n - _grid(draws)[:, None]


@dataclass(frozen=True)
class Band:
    """Simultaneous band for the ECDF difference of ``n`` uniform ranks.

    Attributes:
        grid: Grid of the ranks, ``(k,)``, fractions ``i / (d + 1)``.
        lower: Lowest ECDF difference inside the band, ``(k,)``.
        upper: Highest ECDF difference inside the band, ``(k,)``.
        false_alarm: Probability that calibrated ranks of one panel leave the band. At most
            ``alpha / panels``, and below it by no more than what one count is worth.
    """

    grid: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    false_alarm: float


def simultaneous_band(n: int, draws: int, *, alpha: float, panels: int) -> Band:
    """Return the band that all grid points of all panels stay in with ``1 - alpha`` or more.

    A point's bounds are binomial quantiles; one level, common to all points, is the largest that
    keeps the false-alarm probability at ``alpha / panels`` or less. The division
    (Bonferroni) holds for dependent panels: outputs that share curves are dependent.

    Args:
        draws: Number of draws behind each rank.
        alpha: Probability that calibrated ranks leave the band in any of the panels.
        panels: Number of panels that are read together.
    """
    low, false_alarm = _lower_counts(int(n), int(draws), alpha / panels)
    grid = _grid(draws)
    return Band(grid, low / n - grid, (n - low[::-1]) / n - grid, false_alarm)


def calibration_p_values(ranks: ArrayLike, draws: int) -> np.ndarray:
    """Return the p-value of the ranks of each output, ``(q,)``.

    It is the probability that calibrated ranks reach, at their worst grid point, a two-sided
    binomial tail as small as the one seen. An output leaves :func:`simultaneous_band` exactly
    when its p-value is at most ``alpha / panels``.

    Raises:
        ValueError: If there is no rank or one is outside ``0 ... d``.
    """
    counts, n = _counts_below(ranks, draws)
    grid = _grid(draws)[:, None]
    below = bdtr(counts, n, grid)
    above = bdtr(n - counts, n, grid[::-1])  # P(X >= counts) by symmetry of the grid
    tails = np.minimum(below, above).min(axis=0)
    return np.array([_leaving_probability(_bounds(n, draws, tail), n, draws) for tail in tails])


def checked_ranks(ranks: ArrayLike, draws: int) -> np.ndarray:
    """Return ranks as an array ``(n, q)``, or say that they are none.

    Raises:
        ValueError: If there is no rank or one is outside ``0 ... d``.
    """
    ranks = np.asarray(ranks)
    ranks = ranks[:, None] if ranks.ndim == 1 else ranks
    whole = np.issubdtype(ranks.dtype, np.integer)
    if ranks.ndim != 2 or not ranks.size or not whole or ranks.min() < 0 or ranks.max() > draws:
        raise ValueError(f"ranks must be an array (n, q) of integers from 0 to {draws}")
    return ranks


def _grid(draws: int) -> np.ndarray:
    return np.arange(1, draws + 1) / (draws + 1)


def _counts_below(ranks: ArrayLike, draws: int) -> tuple[np.ndarray, int]:
    """Return how many ranks lie below each grid point, ``(k, q)``, and their number."""
    ranks = checked_ranks(ranks, draws)
    columns = [np.bincount(column, minlength=draws + 1) for column in ranks.T]
    return np.cumsum(np.stack(columns, axis=1), axis=0)[:-1], len(ranks)


def _bounds(n: int, draws: int, tail: float) -> np.ndarray:
    """Return the least count ``(k,)`` at each grid point whose lower binomial tail exceeds tail.

    The greatest count allowed is ``n`` minus the mirrored least one. Found by bisection, with the
    same tails that make the p-values: a library's quantile may round across a count.
    """
    grid = _grid(draws)
    below, reached = np.full(draws, -1), np.full(draws, n)
    while np.any(reached - below > 1):
        middle = (below + reached) // 2
        exceeds = bdtr(middle, n, grid) > tail
        reached = np.where(exceeds, middle, reached)
        below = np.where(exceeds, below, middle)
    return reached


def _leaving_probability(low: np.ndarray, n: int, draws: int) -> float:
    """Return the probability that counts of ``n`` uniform ranks leave their bounds anywhere.

    Uniform ranks are independent Poisson numbers per rank value, given that they sum to ``n``;
    their running sum is a Markov chain, followed here inside the bounds. What leaves is summed
    where it leaves, so that small probabilities keep their relative precision.
    """
    rate, high = n / (draws + 1), n - low[::-1]
    step = _poisson(np.arange(int(rate + 14.0 * np.sqrt(rate) + 60)), rate)
    start, inside, leaving = 0, np.ones(1), 0.0
    for i, (first, last) in enumerate(zip(low, high, strict=True), start=1):
        reached = np.convolve(inside, step)[: n - start + 1]
        counts = np.arange(start, start + len(reached))
        out = (counts < first) | (counts > last)
        leaving += reached[out] @ _poisson(n - counts[out], rate * (draws + 1 - i))
        start, inside = counts[~out][0] if np.any(~out) else n, reached[~out]
        if not inside.size:
            break
    return float(min(1.0, leaving / _poisson(np.array(n), float(n))))


def _poisson(counts: np.ndarray, rate: float) -> np.ndarray:
    return np.exp(counts * np.log(rate) - rate - gammaln(counts + 1.0))


@lru_cache(maxsize=32)
def _lower_counts(n: int, draws: int, level: float) -> tuple[np.ndarray, float]:
    """Return the least counts of the band at ``level``, and its false-alarm probability."""
    safe, unsafe = np.log(level / (2 * draws)), 0.0  # logs of tails: the union bound is safe
    for _ in range(40):
        middle = (safe + unsafe) / 2
        leaving = _leaving_probability(_bounds(n, draws, np.exp(middle)), n, draws)
        safe, unsafe = (middle, unsafe) if leaving <= level else (safe, middle)
    low = _bounds(n, draws, np.exp(safe))
    low.flags.writeable = False
    return low, _leaving_probability(low, n, draws)
