"""Hypotheses about the present segment of a drive's wear: since when, what changed, which line."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

__all__ = ["FIRST", "Hypotheses", "confirmed", "merged"]

FIRST = -1
"""Kind of a segment that no change began: the first, or the first after a known event."""


@dataclass(frozen=True)
class Hypotheses:
    """Hypotheses ``(h,)`` about the current segment, after an operation.

    Attributes:
        operation: Number of the operation.
        log_weight: Log probability of each, ``(h,)``.
        mean: Of the level now and the slope per thousand operations, standardised, ``(h, 2 p)``;
            behind these may be constants that all segments share, see ``temperature``.
        cov: Their covariance, ``(h, 2 p, 2 p)``.
        start: Operation after which the segment began, on average, ``(h,)``.
        kind: Kind of the change that began it: number of the parameter whose slope changed, p for
            a change of every slope, p + 1 of everything, -1 for the first, ``(h,)``.
        scatter: Index of the scatter, ``(h,)``.
        start_variance: Variance of the start, of all that became one, operations², ``(h,)``.
    """

    operation: int
    log_weight: np.ndarray
    mean: np.ndarray
    cov: np.ndarray
    start: np.ndarray
    kind: np.ndarray
    scatter: np.ndarray
    start_variance: np.ndarray

    @property
    def weight(self) -> np.ndarray:
        """Probability of each hypothesis, ``(h,)``."""
        return np.exp(self.log_weight)

    def level(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean ``(2 p,)`` and covariance ``(2 p, 2 p)`` of the mixture of all hypotheses."""
        return merged(self.weight, self.mean, self.cov)

    def of(self, which: np.ndarray) -> "Hypotheses":
        """Return chosen hypotheses, in a given order, by a mask or indices."""
        return Hypotheses(self.operation, *(each[which] for each in self._fields()))

    def with_others(self, others: Sequence["Hypotheses"]) -> "Hypotheses":
        """Return these and others in one, sorted by scatter, kind and start."""
        every = zip(*(each._fields() for each in (self, *others)), strict=True)
        joined = Hypotheses(self.operation, *map(np.concatenate, every))
        return joined.of(np.lexsort((joined.start, joined.kind, joined.scatter)))

    def likeliest(self) -> int:
        """Kind of the likeliest change that began the segment."""
        return int(np.argmax(np.bincount(self.kind - FIRST, self.weight))) + FIRST

    def _fields(self) -> tuple[np.ndarray, ...]:
        return tuple(getattr(self, each.name) for each in fields(self)[1:])

    def began_after(self, operation: float) -> float:
        """Return the probability that the segment began after an operation."""
        return float(self.weight[self.start > operation].sum())

    def began_within(self, first: float, last: float) -> np.ndarray:
        """Return the weight of each whose segment began after ``first``, by ``last``, ``(h,)``."""
        return self.weight * ((self.start > first) & (self.start <= last))


def confirmed(before: Hypotheses, after: Hypotheses, since: float) -> float:
    """Probability that the segment began after ``since``: what the last two operations agree on.

    The smaller of the probabilities before and after an operation, so that no single one is enough.
    """
    return min(before.began_after(since), after.began_after(since))


def merged(weight: np.ndarray, mean: np.ndarray, cov: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean ``(n,)`` and covariance ``(n, n)`` of a mixture of normals.

    >>> mean, cov = merged(np.array([1.0, 1.0]), np.array([[0.0], [2.0]]), np.ones((2, 1, 1)))
    >>> mean.tolist(), cov.tolist()
    ([1.0], [[2.0]])
    """
    share = weight / weight.sum()
    centre = share @ mean
    apart = mean - centre
    return centre, np.tensordot(share, cov, 1) + (share[:, None] * apart).T @ apart
