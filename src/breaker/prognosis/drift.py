"""How the rate of wear drifts: what has run in wears ever slower, other wear ever faster.

The rate is ``(1 + h / a)^k`` times that of now, h operations ahead of an age a: a drift k of 0 is a
steady rate, 1 one that grows in proportion to the age. The bend of the path now tells k, as its
rate changes by ``k / a`` of itself an operation; the rest comes from a prior about a steady rate.
Draws are Student's, as some wear drifts much more.

Shapes: ``n`` operations at which it is asked, ``d`` draws, ``k`` coordinates.
"""

from typing import NamedTuple, Self

import numpy as np
from scipy.special import stdtrit

from breaker.common.randomness import generator
from breaker.prognosis.path_fit import Path

_TAILS = 3.0  # degrees of freedom
_STEADY = 1e-6  # a power this close to 0 is none


class Drift(NamedTuple):
    """What is known of the drift.

    Attributes:
        mean, sd: Of the drift, ``(n,)``.
        age: Operations since new, or since the last work on the drive, ``(n,)``.
        seed: Of the draws.
    """

    mean: np.ndarray
    sd: np.ndarray
    age: np.ndarray
    seed: int

    @classmethod
    def of(
        cls,
        path: Path,
        where: np.ndarray,
        age: np.ndarray,
        prior: float,
        goes_on: float,
        seed: int,
    ) -> Self:
        """Return the drift after some operations.

        Args:
            where: Their indices, ``(n,)``.
            prior: Standard deviation of the drift of drives,
            goes_on: and of that to come, about that so far.
        """
        rate, bend, variance = (each[where] for each in (path.rate, path.bend, path.bend_variance))
        shown = (np.square(rate) / variance).sum(axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            seen = age * (rate * bend / variance).sum(axis=1) / shown
            known = 1.0 / (np.square(age) / shown + goes_on**2)
        precision = known + prior**-2.0
        mean = np.where(shown > 0.0, known * np.nan_to_num(seen) / precision, 0.0)
        return cls(mean, precision**-0.5, age, seed)

    def draws(self, count: int) -> np.ndarray:
        """Return draws of the drift, ``(n, d)``: alike at each operation, as a draw is a drive."""
        shares = generator(self.seed, "drift of wear").permutation(count)
        students = stdtrit(_TAILS, (shares + 0.5) / count)
        return self.mean[:, None] + self.sd[:, None] * students

    def operations(self, steady: np.ndarray) -> np.ndarray:
        """Return in how many operations as much wears as in ``steady`` ones at the rate of now,
        ``(n, d)``.

        >>> age, steady = np.full(1, 100.0), np.full((1, 1), 150.0)
        >>> Drift(np.ones(1), np.zeros(1), age, 1).operations(steady).round(6)
        array([[100.]])
        """
        power = 1.0 + self.draws(steady.shape[1])
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            share = steady / self.age[:, None]
            logs = np.log1p(np.maximum(power * share, -1.0)) / power
            logs = np.where(np.abs(power) < _STEADY, share, logs)
            return self.age[:, None] * np.expm1(logs)
