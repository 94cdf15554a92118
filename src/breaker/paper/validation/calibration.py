"""Calibration: are the ranks of the truth among posterior draws uniform? Arrays in, arrays out.

It is judged here and nowhere else, by :func:`judge_ranks`: tables, figures and words go by it. All
outputs of a calibrated posterior pass together with probability 1 - ``LEVEL``.

Shapes: ``n`` simulations, ``d`` draws, ``q`` outputs, ``k = d`` grid points.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from breaker.common.numerals import in_digits, in_p
from breaker.paper.validation.rank_bands import (
    Band,
    calibration_p_values,
    checked_ranks,
    ecdf_difference,
    simultaneous_band,
)

LEVEL = 0.05
"""Probability that a posterior which is calibrated fails, all of its outputs together."""


def ranks(draws: ArrayLike, truth: ArrayLike) -> np.ndarray:
    """Return how many draws lie below the truth, ``(n, q)``, integers from 0 to ``d``.

    Under an exact posterior each column is uniform on ``0 ... d``.

    Args:
        draws: Posterior draws, ``(n, d, q)``.
        truth: Values that made the data, ``(n, q)``, same units.

    Raises:
        ValueError: If shapes do not fit or a value is not finite.

    Example:
        One curve, three draws of two outputs:

        >>> draws = [[[1.0, 5.0], [2.0, 4.0], [3.0, 6.0]]]
        >>> ranks(draws, [[2.5, 7.0]])
        array([[2, 3]])
    """
    draws, truth = checked_draws(draws, truth)
    return np.sum(draws < truth[:, None, :], axis=1)


def family_p_value(p_values: ArrayLike) -> float:
    """Return the smallest p-value times their number, at most 1: Bonferroni, of any panels."""
    p_values = np.asarray(p_values, dtype=np.float64)
    return float(min(1.0, p_values.size * p_values.min()))


@dataclass(frozen=True)
class Calibration:
    """Which outputs leave the simultaneous band, and by how much.

    Attributes:
        difference: ECDF difference, ``(k, q)``.
        band: The band, common to all outputs.
        p_values: p-value of each output, ``(q,)``.
        outside: Which outputs leave the band, ``(q,)`` of bool.
        excess: Largest distance of the ECDF difference beyond the band, ``(q,)``; zero or negative
            (distance left to the band) where it stays inside.
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

    def words(self, symbols: Sequence[str]) -> str:
        """Return the result in one line; ``symbols`` name the ``q`` outputs."""
        least = int(np.argmin(self.p_values))
        p = f"smallest {in_p(self.p_values[least])} of {symbols[least]}, times {len(symbols)}: "
        p += f"{in_p(self.p_value)}, level {in_digits(self.alpha, 4)}"
        if not self.outside.any():
            return f"calibrated: all {len(symbols)} outputs inside the band ({p})"
        names = [name for name, out in zip(symbols, self.outside, strict=True) if out]
        return f"NOT calibrated: {', '.join(names)} outside the band ({p})"


def judge_ranks(ranks: ArrayLike, draws: int, *, alpha: float = LEVEL) -> Calibration:
    """Judge the ranks ``(n, q)`` of all outputs among ``draws`` draws.

    Args:
        ranks: From :func:`ranks`.
        draws: Number of draws behind each rank.
        alpha: Probability that calibrated outputs leave the band in any panel.

    Raises:
        ValueError: If there is no rank, or one is outside ``0 ... d``.
    """
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
    """Return the share of truths inside central intervals, ``(l, q)``.

    Args:
        ranks: Ranks ``(n, q)`` among ``draws`` draws.
        draws: Number of draws behind each rank.
        levels: Nominal probability of the ``l`` intervals; on the grid of the ranks, the share to
            be expected is within 1/(d + 1) of it.

    Raises:
        ValueError: If there is no rank, or one is outside ``0 ... d``.
    """
    off_centre = np.abs((checked_ranks(ranks, draws) + 0.5) / (draws + 1) - 0.5)
    return np.array([np.mean(off_centre <= level / 2, axis=0) for level in levels])


def checked_draws(draws: ArrayLike, truth: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Return draws ``(n, d, q)`` and truth ``(n, q)`` in double precision, or say what is wrong.

    Raises:
        ValueError: If shapes do not fit or a value is not finite.
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
