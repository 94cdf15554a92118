"""Drives of a family as rows of normal scores: all that is unknown of a drive, in one space.

A family draws a drive by some hundred random numbers. Given as standard normal scores these are
coordinates of its drives, whose prior is a standard normal, whatever each stands for.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import gammaln, ndtr, ndtri

from breaker.drive.exact.gates import Gates
from breaker.drive.exact.recorded_program import Program
from breaker.drive.exact.simulated_motions import closed_travels
from breaker.drive.simulation.drive_family import Family
from breaker.drive.simulation.rich_drive import CONTACTS, ELEMENTS
from breaker.quantities.parameters import NAMES

_ENOUGH = 10_000  # scores, more than a drive has
_ENDS = 8.0  # of a score that is drawn anew
_SMALL = -2.0  # middle of the scores of mechanisms that come small
_DRAWN = 4000  # drives of each kind, of which the share that works is seen


class ScoreColumns:
    """A generator whose numbers are columns of given scores, in the order in which they are asked.

    It answers each question for n drives at once: ``(n,)`` for one number, ``(k, n)`` for k.

    Args:
        scores: ``(n, m)``.
    """

    def __init__(self, scores: np.ndarray) -> None:
        self.scores, self.shares, self.used, self.presence = scores, ndtr(scores), 0, None

    def standard_normal(self, size=()) -> np.ndarray:
        return self._next(self.scores, size)

    def random(self, size=()) -> np.ndarray:
        if self.presence is None and np.prod(size) > 1:  # whether each mechanism is there
            self.presence = self.used, int(size)
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
        family: The family, of the package's own simulator.
        unknowns: Number of scores.
        presence: First score and number of those that say whether each mechanism is there; before
            them is the one of the share of all that are, behind them are those of the sizes. None
            of a family without.
        working: Share of the draws that make a drive, of each of ``kinds``. A family draws again
            within a kind, so that the density of a drive is that of its scores over this share.
        gates: Which numbers of its drives act as far as others do.
    """

    family: Family
    unknowns: int
    working: np.ndarray
    gates: Gates
    presence: tuple[int, int] | None = None

    @classmethod
    def of(cls, family: Family, rng: np.random.Generator) -> "FamilyScores":
        """Look how many scores a drive has, and how many make a drive."""
        columns = ScoreColumns(np.ones((2, _ENOUGH)))
        family.drawn(CONTACTS[0], columns)
        presence = columns.presence and (columns.presence[0] + 1, columns.presence[1])
        new = cls(family, columns.used + 1, np.ones(0), None, presence)
        scores = rng.standard_normal((len(new.kinds), _DRAWN, columns.used))
        drawn = [each.run(own)[0] for each, own in zip(new._programs, scores, strict=True)]
        works = np.isfinite([closed_travels(numbers, new.touch) for numbers in drawn])
        gates = Gates.of(np.concatenate(drawn)[works.ravel()])
        return replace(new, working=works.mean(axis=1), gates=gates)

    @property
    def touch(self) -> np.ndarray:
        """Way to the touch of contacts that slide, least and most, share of the stroke."""
        return np.array(self.family.settings["touch"], dtype=np.float64)

    @property
    def kinds(self) -> list[str]:
        """Kinds of contact that the family has, in the order in which it chooses one."""
        return [kind for kind in CONTACTS if self.family.settings["contacts"][kind]]

    @property
    def shares(self) -> np.ndarray:
        """Share of each of ``kinds``, ``(k,)``."""
        shares = np.array([self.family.settings["contacts"][kind] for kind in self.kinds])
        return shares / shares.sum()

    def contact(self, scores: np.ndarray) -> np.ndarray:
        """Number of the kind of contact of drives ``(n, m)``, among ``kinds``, ``(n,)``."""
        return (ndtr(scores[:, :1]) > self.shares.cumsum()[:-1]).sum(axis=1)

    def numbers(self, scores: np.ndarray) -> np.ndarray:
        """Drives of scores ``(n, m)`` as ``Drive.numbers`` has them, ``(n, p + e)``."""
        return self.traced(scores)[0]

    def traced(self, scores: np.ndarray) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
        """What ``numbers`` returns, and what takes slopes by these, ``(n, p + e)``, to slopes by
        the scores, ``(n, m)``. By scores that decide they are 0.
        """
        contact, parts = self.contact(scores), []
        numbers = np.empty((len(scores), len(NAMES) + len(ELEMENTS)))
        for i in np.unique(contact):
            own = np.flatnonzero(contact == i)
            numbers[own], back = self._programs[i].run(scores[own, 1:])
            parts.append((own, back))

        def taken_back(slopes: np.ndarray) -> np.ndarray:
            found = np.zeros(scores.shape)
            for own, back in parts:
                found[own, 1:] = back(slopes[own])
            return found

        return numbers, taken_back

    @cached_property
    def _programs(self) -> list[Program]:
        """How the family makes a drive of each of ``kinds``."""

        def program(kind: str) -> Program:
            def numbers(scores: np.ndarray) -> list:
                theta, elements = self.family.drawn(kind, ScoreColumns(scores))
                return [*theta.reshape(len(NAMES), -1), *elements.numbers]

            return Program.of(numbers, self.unknowns - 1)

        return [program(kind) for kind in self.kinds]

    def sample(self, tries: int, rng: np.random.Generator) -> np.ndarray:
        """Draw drives of the family as often as is said, ``(n, p + e)``: as many as work, and fewer
        of a kind that works more often, as the family draws again within a kind.
        """
        scores = rng.standard_normal((tries, self.unknowns))
        found, working = self.numbers(scores), self.working[self.contact(scores)]
        works = np.isfinite(closed_travels(found, self.touch))
        return found[works & (rng.random(tries) < self.working.min() / working)]

    def redrawn(self, scores: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Draw anew, for drives ``(n, m)``, what decides which mechanisms are there: given these,
        the share of those that are there, and how far each is from it. The drives stay.
        """
        if self.presence is None:
            return scores
        new = scores.copy()
        self._decide(new, self._there(scores), rng)
        return new

    def switched(
        self, scores: np.ndarray, exchanged: bool, rng: np.random.Generator
    ) -> tuple[np.ndarray, np.ndarray]:
        """Let a mechanism of each drive come or go; or one come and another one go.

        As often as not one that comes is small, as it is more often there in a posterior.

        Args:
            scores: Of drives of a family in which mechanisms may be absent, ``(n, m)``.

        Returns:
            Other scores, and the logarithm of their density in the prior over that of ``scores``,
            and over that of the move over that of the way back, ``(n,)``.
        """
        begin, count = self.presence
        there, sizes = self._there(scores), slice(begin + count, begin + 2 * count)
        order = rng.random(there.shape)
        chosen = order == order.max(axis=1, keepdims=True)
        if exchanged:
            chosen = np.zeros_like(there)
            for some in (there, ~there):
                first = np.where(some, order, -1.0)
                chosen |= some & (first == first.max(axis=1, keepdims=True))
            chosen &= (there.any(axis=1) & ~there.all(axis=1))[:, None]
        come, go = chosen & ~there, chosen & there
        new, drawn = scores.copy(), rng.standard_normal(there.shape)
        drawn += _SMALL * (come & (rng.random(there.shape) < 0.5))
        new[:, sizes] = np.where(chosen, drawn, scores[:, sizes])
        self._decide(new, there ^ chosen, rng)
        over = np.where(come, _over_move(drawn), 0.0) - np.where(
            go, _over_move(scores[:, sizes]), 0
        )
        before, after = (
            gammaln(has + 1.0) + gammaln(count - has + 1.0)
            for has in (there.sum(axis=1), (there ^ chosen).sum(axis=1))
        )
        return new, over.sum(axis=1) + after - before

    def _there(self, scores: np.ndarray) -> np.ndarray:
        """Which mechanisms are there, ``(n, k)``."""
        begin, count = self.presence
        return ndtr(scores[:, [begin - 1]]) > ndtr(scores[:, begin : begin + count])

    def _decide(self, scores: np.ndarray, there: np.ndarray, rng: np.random.Generator) -> None:
        """Draw the scores that decide which mechanisms are there, given these, ``(n, k)``."""
        begin, count = self.presence
        has = there.sum(axis=1, keepdims=True)
        share = rng.beta(has + 1.0, count - has + 1.0)
        at = rng.random(there.shape)
        shares = np.where(there, share * at, share + (1.0 - share) * at)
        decided = np.clip(ndtri(np.column_stack([share, shares])), -_ENDS, _ENDS)
        scores[:, begin - 1 : begin + count] = decided

    def shares_of(self, contact: np.ndarray) -> dict[str, float]:
        """Share of each kind of contact, by numbers of ``CONTACTS``, ``(n,)``."""
        return {kind: float((contact == CONTACTS.index(kind)).mean()) for kind in self.kinds}

    def log_prior(self, scores: np.ndarray) -> np.ndarray:
        """Log densities of scores ``(n, m)`` that make a drive, but for a constant, ``(n,)``."""
        working = self.working[self.contact(scores)]
        return -0.5 * np.square(scores).sum(axis=1) - np.log(working)


def _over_move(sizes: np.ndarray) -> np.ndarray:
    """Log densities of the scores of sizes in the prior over those with which mechanisms come."""
    return np.log(2.0) - np.logaddexp(0.0, _SMALL * sizes - 0.5 * _SMALL**2)
