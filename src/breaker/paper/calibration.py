"""Simulation-based calibration: are ranks of the truth among posterior draws uniform?

Paper, Sec. 6, Fig. 4 (Talts et al., 2020). A calibrated posterior passes with all its outputs with
probability 1 - ``LEVEL``. Shapes: ``n`` simulations, ``d`` draws, ``q`` outputs, ``k = d`` points.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import bdtr, gammaln


def ecdf_difference(ranks: ArrayLike, draws: int) -> np.ndarray:
    """Return the share of ranks ``(n, q)`` among ``draws`` draws that lie below grid point ``i``,
    minus ``i / (d + 1)``, ``(k, q)``.
    """
    counts, n = _counts_below(ranks, draws)
    return counts / n - _grid(draws)[:, None]


@dataclass(frozen=True)
class Band:
    """Simultaneous band for the ECDF difference of ``n`` uniform ranks.

    Attributes:
        grid: Grid of the ranks, ``(k,)``, fractions ``i / (d + 1)``.
        lower, upper: Lowest and highest ECDF difference inside the band, ``(k,)``.
        false_alarm: Probability that calibrated ranks of one panel leave the band: at most
            ``alpha / panels``, and smaller only because counts are integers.
    """

    grid: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    false_alarm: float


def simultaneous_band(n: int, draws: int, *, alpha: float, panels: int) -> Band:
    """Return the band that contains calibrated ranks of all panels with probability ``1 - alpha``.

    The bounds of a point are binomial quantiles. All points share the largest level that keeps the
    false-alarm probability at or below ``alpha / panels``. The division (Bonferroni) is valid for
    dependent panels, such as outputs of the same curves.
    """
    low, false_alarm = _lower_counts(int(n), int(draws), alpha / panels)
    grid = _grid(draws)
    return Band(grid, low / n - grid, (n - low[::-1]) / n - grid, false_alarm)


def calibration_p_values(ranks: ArrayLike, draws: int) -> np.ndarray:
    """Return the p-value of the ranks of each output, ``(q,)``.

    It is the probability that calibrated ranks reach, at their worst grid point, a binomial tail as
    small as the observed one. An output leaves the band if and only if its p-value is at most
    ``alpha / panels``.
    """
    counts, n = _counts_below(ranks, draws)
    grid = _grid(draws)[:, None]
    below = bdtr(counts, n, grid)
    above = bdtr(n - counts, n, grid[::-1])  # P(X >= counts) by symmetry of the grid
    tails = np.minimum(below, above).min(axis=0)
    return np.array([_leaving_probability(_bounds(n, draws, tail), n, draws) for tail in tails])


def _grid(draws: int) -> np.ndarray:
    return np.arange(1, draws + 1) / (draws + 1)


def _counts_below(ranks: ArrayLike, draws: int) -> tuple[np.ndarray, int]:
    """Return how many ranks lie below each grid point, ``(k, q)``, and how many there are, n."""
    columns = [np.bincount(column, minlength=draws + 1) for column in np.transpose(ranks)]
    return np.cumsum(np.stack(columns, axis=1), axis=0)[:-1], len(ranks)


def _bounds(n: int, draws: int, tail: float) -> np.ndarray:
    """Return the least count ``(k,)`` at each grid point whose lower binomial tail exceeds tail.

    By symmetry the greatest allowed count is ``n`` minus the mirrored least count. The bisection
    uses the tails of the p-values, because a library's quantile may round to another count.
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

    Counts of uniform ranks are independent Poisson numbers, conditioned on their sum ``n``. Their
    running sum is a Markov chain, computed here inside the bounds. The probability of leaving is
    summed step by step, so that small probabilities keep their relative precision.
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
    safe, unsafe = np.log(level / (2 * draws)), 0.0  # logs of tails, from the union bound
    for _ in range(40):
        middle = (safe + unsafe) / 2
        leaving = _leaving_probability(_bounds(n, draws, np.exp(middle)), n, draws)
        safe, unsafe = (middle, unsafe) if leaving <= level else (safe, middle)
    low = _bounds(n, draws, np.exp(safe))
    low.flags.writeable = False
    return low, _leaving_probability(low, n, draws)


# ---- judgement ---------------------------------------------------------------------------------

LEVEL = 0.05
"""Probability that a calibrated posterior fails, for all outputs together."""


def ranks(draws: ArrayLike, truth: ArrayLike) -> np.ndarray:
    """Return how many draws ``(n, d, q)`` lie below the truth ``(n, q)``, integers ``(n, q)``,
    uniform on ``0 ... d`` under an exact posterior.

    Example:
        >>> draws = [[[1.0, 5.0], [2.0, 4.0], [3.0, 6.0]]]
        >>> ranks(draws, [[2.5, 7.0]])
        array([[2, 3]])
    """
    draws, truth = checked_draws(draws, truth)
    return np.sum(draws < truth[:, None, :], axis=1)


def family_p_value(p_values: ArrayLike) -> float:
    """Return the smallest p-value times the number of p-values, at most 1 (Bonferroni)."""
    p_values = np.asarray(p_values, dtype=np.float64)
    return float(min(1.0, p_values.size * p_values.min()))


@dataclass(frozen=True)
class Calibration:
    """Judgement of ranks: outputs that leave the simultaneous band, and by how much.

    Attributes:
        difference: ECDF difference, ``(k, q)``.
        band: Band, the same for all outputs.
        p_values: p-value of each output, ``(q,)``.
        outside: Which outputs leave the band, ``(q,)`` of bool.
        excess: Largest distance of the ECDF difference beyond the band, ``(q,)``; zero or negative
            inside the band.
        p_value: Smallest p-value of the outputs times their number, at most 1.
        alpha: Probability that calibrated outputs leave the band in any panel.
    """

    difference: np.ndarray
    band: Band
    p_values: np.ndarray
    outside: np.ndarray
    excess: np.ndarray
    p_value: float
    alpha: float


def judge_ranks(ranks: ArrayLike, draws: int, *, alpha: float = LEVEL) -> Calibration:
    """Judge the ranks ``(n, q)`` of all outputs among ``draws`` draws (see ``ranks``)."""
    difference = ecdf_difference(ranks, draws)
    panels = difference.shape[1]
    band = simultaneous_band(len(np.asarray(ranks)), draws, alpha=alpha, panels=panels)
    beyond = np.maximum(difference - band.upper[:, None], band.lower[:, None] - difference)
    p_values = calibration_p_values(ranks, draws)
    return Calibration(
        difference=difference,
        band=band,
        p_values=p_values,
        outside=p_values <= alpha / panels,
        excess=beyond.max(axis=0),
        p_value=family_p_value(p_values),
        alpha=alpha,
    )


def judge_draws(draws: ArrayLike, truth: ArrayLike) -> Calibration:
    """Judge the ranks of truths ``(n, q)`` among posterior draws ``(n, d, q)``."""
    return judge_ranks(ranks(draws, truth), np.shape(draws)[1])


def coverage(ranks: ArrayLike, draws: int, *, levels: Sequence[float]) -> np.ndarray:
    """Return the share of true values inside central intervals of ``l`` nominal levels, ``(l, q)``.

    The expected share of a calibrated posterior is within 1/(d + 1) of the level.
    """
    off_centre = np.abs((np.asarray(ranks) + 0.5) / (draws + 1) - 0.5)
    return np.array([np.mean(off_centre <= level / 2, axis=0) for level in levels])


def checked_draws(draws: ArrayLike, truth: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Return draws ``(n, d, q)`` and truth ``(n, q)`` in double precision; raise a ValueError if
    shapes do not fit or a value is not finite.
    """
    draws = np.asarray(draws, dtype=np.float64)
    truth = np.asarray(truth, dtype=np.float64)
    if draws.ndim != 3 or (len(draws), draws.shape[2]) != truth.shape or not draws.size:
        raise ValueError(
            f"draws (n, d, q) and truth (n, q) do not fit: {draws.shape}, {truth.shape}"
        )
    for name, values in (("draws", draws), ("truth", truth)):
        if faults := np.count_nonzero(~np.isfinite(values)):
            raise ValueError(f"{faults} of {values.size} values of {name} are not finite")
    return draws, truth
