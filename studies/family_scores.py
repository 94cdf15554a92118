"""Drives of a family as rows of normal scores, and their curves, many at once.

A family draws a drive by some hundred random numbers. Given as standard normal scores these are
coordinates of its drives, whose prior is a standard normal, whatever each stands for.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtr

from breaker.common.compiling import compiled, numba_or_plain
from breaker.drive.simulation.drive_family import Family
from breaker.drive.simulation.integrator import closed_rest, follow
from breaker.drive.simulation.paths import curve, sampled
from breaker.drive.simulation.rich_drive import CONTACTS, ELEMENTS
from breaker.quantities.parameters import NAMES

_, prange = numba_or_plain()
_TOLERANCE = 1e-5  # mm and mm/ms, error of a step
_ENOUGH = 10_000  # scores, more than a drive has
_DRAWN = 4000  # drives of each kind, of which the share that works is seen
_LINKAGE = len(NAMES) + ELEMENTS.index("linkage")


class ScoreColumns:
    """A generator whose numbers are columns of given scores, in the order in which they are asked.

    It answers each question for n drives at once: ``(n,)`` for one number, ``(k, n)`` for k.

    Args:
        scores: ``(n, m)``.
    """

    def __init__(self, scores: np.ndarray) -> None:
        self.scores, self.shares, self.used = scores, ndtr(scores), 0

    def standard_normal(self, size=()) -> np.ndarray:
        return self._next(self.scores, size)

    def random(self, size=()) -> np.ndarray:
        return self._next(self.shares, size)

    def uniform(self, low, high) -> np.ndarray:
        return low + (high - low) * self.random()

    def triangular(self, low, mode, high, size) -> np.ndarray:
        assert low == mode
        return high - (high - low) * np.sqrt(1.0 - self.random(size))

    def _next(self, numbers: np.ndarray, size) -> np.ndarray:
        begin, self.used = self.used, self.used + math.prod(np.atleast_1d(size).tolist())
        if self.used > numbers.shape[1]:
            raise ValueError(f"a drive has more than {numbers.shape[1]} scores")
        found = numbers[:, begin : self.used]
        if size in ((), 1):
            return found[:, 0]
        return found if isinstance(size, tuple) else found.T


@dataclass(frozen=True, eq=False)
class FamilyScores:
    """What makes drives of scores: the first is the kind of contact, others as the family asks.

    Attributes:
        family: Without sliding contacts.
        unknowns: Number of scores.
        working: Share of the draws that make a drive, of each of ``kinds``. A family draws again
            within a kind, so that the density of a drive is that of its scores over this share.
    """

    family: Family
    unknowns: int
    working: np.ndarray

    @classmethod
    def of(cls, family: Family, rng: np.random.Generator) -> "FamilyScores":
        """Look how many scores a drive has, and how many make a drive."""
        columns = ScoreColumns(np.ones((2, _ENOUGH)))
        family.drawn(CONTACTS[0], columns)
        new = cls(family, columns.used + 1, np.ones(0))
        drawn = [new._numbers(k, rng.standard_normal((_DRAWN, columns.used))) for k in new.kinds]
        rests = [[closed_rest(each) for each in numbers] for numbers in drawn]
        return replace(new, working=np.isfinite(rests).mean(axis=1))

    @property
    def kinds(self) -> list[str]:
        """Kinds of contact that the family has, in the order in which it chooses one."""
        return [kind for kind in CONTACTS if self.family.settings["contacts"][kind]]

    def contact(self, scores: np.ndarray) -> np.ndarray:
        """Number of the kind of contact of drives ``(n, m)``, among ``kinds``, ``(n,)``."""
        shares = np.array([self.family.settings["contacts"][kind] for kind in self.kinds])
        return (ndtr(scores[:, :1]) * shares.sum() > shares.cumsum()).sum(axis=1)

    def numbers(self, scores: np.ndarray) -> np.ndarray:
        """Drives of scores ``(n, m)`` as ``Drive.numbers`` has them, ``(n, p + e)``."""
        found, contact = np.empty((len(scores), len(NAMES) + len(ELEMENTS))), self.contact(scores)
        for i, kind in enumerate(self.kinds):
            found[contact == i] = self._numbers(kind, scores[contact == i, 1:])
        return found

    def _numbers(self, kind: str, scores: np.ndarray) -> np.ndarray:
        theta, elements = self.family.drawn(kind, ScoreColumns(scores))
        columns = [*theta.reshape(len(NAMES), -1), *elements.numbers]
        return np.column_stack([np.broadcast_to(each, len(scores)) for each in columns])

    def log_prior(self, scores: np.ndarray) -> np.ndarray:
        """Log densities of scores ``(n, m)`` that make a drive, but for a constant, ``(n,)``."""
        working = self.working[self.contact(scores)]
        return -0.5 * np.square(scores).sum(axis=1) - np.log(working)


@compiled(parallel=True)
def curves(numbers, closing, times, begins):
    """Travel of drives of size 1 ``(n, p + e)`` at times, released at begins ``(n,)``, ``(n, t)``.

    It is nan of a drive that does not work, or whose curve is not finite.
    """
    found = np.full((len(numbers), times.size), np.nan)
    for i in prange(len(numbers)):
        rest, at = closed_rest(numbers[i]), times - begins[i]
        if np.isfinite(rest):
            steps = follow(numbers[i], rest, closing, max(at[-1], 1e-9), np.inf, _TOLERANCE)[0]
            if len(steps):
                found[i] = sampled(curve(steps, numbers[i, _LINKAGE]), at)
    return found
