"""The path of coordinates: a regression whose records come one after the other."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

_LEADING = 12  # coordinates of a block that count for changes, and for how its path bends


class Block(NamedTuple):
    """Coordinates that are seen together, independent, in units of their scatter.

    Attributes:
        values: ``(o, k)``; rows of nan where there is no record.
        variance: Of the changes that drives of the family make, ``(k,)``, the largest first.
        sought: Whether changes are looked for in them, and records weighed by them.
    """

    values: np.ndarray
    variance: np.ndarray
    sought: bool = True


class Change(NamedTuple):
    """A change of the path.

    Attributes:
        noticed: Index of the operation at which it was.
        start: Index of the first operation after it,
        earliest, latest: and within which indices it lies by 90 %.
        kind: ``"rate"`` of the wear, or its direction, ``"step"``, or ``"event"``, known work.
        evidence: Log Bayes factor against none, nats; below 0 it was taken back.
        transducer: Whether what it moved is no change of the drive.
    """

    noticed: int
    start: int
    earliest: int
    latest: int
    kind: str
    evidence: float
    transducer: bool = False


@dataclass(frozen=True)
class Path:
    """What is known after each operation, of all blocks' coordinates side by side, ``(o, k)``.

    Attributes:
        change, variance: Change since new, mean and variance; nan before the reference is full.
        since, since_variance: The same since the last known event; nan before one.
        rate, rate_variance: Of the change, per operation.
        covariance: Of change and rate.
        bend, bend_variance: Of the rate, per operation.
        evidence: For a change that is not noticed yet, nats, ``(o,)``; nan where none is sought.
        weight: Of the record beside one that follows the path, ``(o,)``; nan without one.
    """

    change: np.ndarray
    variance: np.ndarray
    since: np.ndarray
    since_variance: np.ndarray
    rate: np.ndarray
    rate_variance: np.ndarray
    covariance: np.ndarray
    bend: np.ndarray
    bend_variance: np.ndarray
    evidence: np.ndarray
    weight: np.ndarray
    changes: tuple[Change, ...]


class Explained(NamedTuple):
    """What one more column of the design would explain, by candidate.

    Attributes:
        precision, product: Of its coefficient in every coordinate, ``(c, k)`` each: what the
            records say of it where nothing is known before.
    """

    precision: np.ndarray
    product: np.ndarray

    def evidence(self, variance: np.ndarray) -> np.ndarray:
        """Return the log Bayes factors ``(c,)`` of coefficients with prior variances ``(c, k)``."""
        grown = 1.0 + self.precision * variance
        return 0.5 * (np.square(self.product) * variance / grown - np.log(grown)).sum(axis=1)


class PathFit:
    """A regression of coordinates on the columns of a design, with a prior of its own each.

    Args:
        blocks: What is followed, side by side.

    Attributes:
        there: Whether there is a record, ``(o, k)``.
        weight: Of each record, ``(o,)``.
        mean: Coefficients, ``(k, p)``.
        cov: Their covariance, ``(k, p, p)``.
        change: Change so far, ``(k,)``.
        noise: Variance of a record, ``(k,)``: 1 as in the reference, and followed from there,
        memory: times this, where neighbouring records err alike.
        last: How far the last record was from the path, in sds, ``(k,)``.
        sought: Coordinates in which changes are sought, indices ``(l,)``.
    """

    def __init__(self, blocks: Sequence[Block]) -> None:
        sizes = [block.variance.size for block in blocks]
        self.block = np.repeat(np.arange(len(blocks)), sizes)
        seen = np.stack([np.isfinite(block.values).all(axis=1) for block in blocks], axis=1)
        # Coordinates that are seen together share their sums of squares.
        self.seen, alike = np.unique(seen, axis=1, return_inverse=True)
        self.alike, self.there = alike.ravel()[self.block], seen[:, self.block]
        values = np.concatenate([block.values for block in blocks], axis=1)
        self.values = np.where(self.there, values, 0.0)
        self.variance = np.concatenate([block.variance for block in blocks])
        self.leading = np.concatenate([np.arange(size) < _LEADING for size in sizes])
        sought = np.repeat([block.sought for block in blocks], sizes)
        self.sought = np.flatnonzero(self.leading & sought)
        self.weight = np.ones(len(self.values))
        self.noise, self.memory = np.ones_like(self.variance), 1.0
        self.change, self.last = np.zeros((2, self.variance.size))
        # Sums over the records before each; 0 in columns that the design did not have then.
        n, (k, s) = len(self.values) + 1, (self.variance.size, self.seen.shape[1])
        self.gram, self.moment = np.zeros((n, s, 0, 0)), np.zeros((n, 0, k))

    def sum_up(self, rows: np.ndarray, first: int) -> None:
        """Add up records from index ``first`` on, by their rows of a design, ``(r, p)``.

        Columns that are new are 0 before; what had been added from there on is forgotten.
        """
        r, p = rows.shape
        if more := max(p - self.moment.shape[1], 0):
            self.gram = np.pad(self.gram, ((0, 0), (0, 0), (0, more), (0, more)))
            self.moment = np.pad(self.moment, ((0, 0), (0, more), (0, 0)))
        gram, moment = (each[first : first + r + 1] for each in (self.gram, self.moment))
        gram[:, :, p:], gram[:, :, :, p:], moment[:, p:] = 0.0, 0.0, 0.0
        some = slice(first, first + r)
        weighted = self.weight[some, None, None] * rows[:, :, None]
        gram[1:, :, :p, :p] = self.seen[some, :, None, None] * (weighted * rows[:, None])[:, None]
        moment[1:, :p] = weighted * self.values[some, None]
        for each in (gram, moment):
            np.cumsum(each, axis=0, out=each)

    def solve(self, i: int, precision: np.ndarray) -> None:
        """Fit the records up to ``i``, with prior precisions of the coefficients, ``(k, p)``."""
        noise = self.memory * self.noise
        p = precision.shape[1]
        matrix = self.gram[i + 1, self.alike, :p, :p] / noise[:, None, None]
        self.cov = np.linalg.inv(matrix + precision[:, :, None] * np.eye(p))
        self.mean = (self.cov @ (self.moment[i + 1, :p] / noise).T[:, :, None])[:, :, 0]

    def bends(self) -> tuple[np.ndarray, np.ndarray]:
        """Return squares of the change: along it, and as much as its block may bend aside."""
        square, roots = np.square(self.change), np.sqrt(self.variance)
        aside, root = (
            np.bincount(self.block, e)[self.block] for e in (square * self.leading, roots)
        )
        return square, aside * roots / root

    def about(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return linear functions ``(r, p)`` of the coefficients: ``(k, r)``, and covariances."""
        return self.mean @ rows.T, rows @ self.cov @ rows.T

    def off(self, rows: np.ndarray, first: int, some: np.ndarray | slice) -> np.ndarray:
        """Return how far records are from the path in some coordinates, in sds, ``(r, k)``."""
        left = self.values[first : first + len(rows), some] - rows @ self.mean[some].T
        spread = ((rows @ self.cov[some]) * rows).sum(axis=-1).T
        return left / np.sqrt(self.noise[some] + spread)

    def explained(self, starts: np.ndarray, i: int, columns: np.ndarray) -> list[Explained]:
        """Say what columns would explain that are 0 before a start, in coordinates that count.

        Args:
            starts: Index of the first record of each, ``(c,)``.
            i: Index of the last record.
            columns: Kinds of column from there on, as sums of those of the design, ``(v, c, p)``.
        """
        some, p = self.sought, columns.shape[-1]
        gram = self.gram[i + 1, :, :p, :p] - self.gram[starts, :, :p, :p]
        moment = (self.moment[i + 1, :p] - self.moment[starts, :p])[:, :, some]
        noise, alike = self.memory * self.noise[some], self.alike[some]
        cross = (columns[:, :, None, None] @ gram)[:, :, :, 0]
        square = (cross * columns[:, :, None]).sum(axis=-1)[..., alike]
        cross = cross[:, :, alike].swapaxes(1, 2)
        known = ((cross @ self.cov[some]) * cross).sum(axis=-1).swapaxes(1, 2)
        foreseen = (cross @ self.mean[some][:, :, None])[..., 0].swapaxes(1, 2)
        product = (columns[:, :, None] @ moment)[:, :, 0] - foreseen
        precision = square / noise - known / np.square(noise)
        return [Explained(*each) for each in zip(precision, product / noise, strict=True)]
