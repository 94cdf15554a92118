"""The path of a block of coordinates: a regression whose records come one after the other."""

from typing import NamedTuple

import numpy as np

from breaker.wear.path import Block

__all__ = ["Explained", "Fit"]


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


class Fit:
    """A regression of coordinates on the columns of a design, with a prior of its own each.

    Args:
        block: What is followed.

    Attributes:
        weight: Of each record, ``(o,)``; 0 where there is none.
        mean: Coefficients, ``(k, p)``.
        cov: Their covariance, ``(k, p, p)``.
        change: Change so far, ``(k,)``.
        noise: Variance of a record, ``(k,)``: 1 as in the reference, and followed from there,
        memory: times this, where neighbouring records err alike.
        last: How far the last record was from the path, in sds, ``(k,)``.
    """

    def __init__(self, block: Block) -> None:
        self.there = np.isfinite(block.values).all(axis=1)
        self.values = np.where(self.there[:, None], block.values, 0.0)
        self.variance, self.sought = block.variance, block.sought
        self.weight = self.there.astype(float)
        self.change = np.zeros_like(block.variance)
        self.noise, self.memory = np.ones_like(block.variance), 1.0
        self.last = np.zeros_like(block.variance)

    def sum_up(self, design: np.ndarray, last: int) -> None:
        """Add up the records before ``last`` anew, with a design ``(o, p)``."""
        (n, p), k = design.shape, self.variance.size
        self.gram, self.moment = np.zeros((n + 1, p, p)), np.zeros((n + 1, p, k))
        rows = design[:last]
        weighted = (self.weight[:last, None] * rows)[:, :, None]
        self.gram[1 : last + 1] = np.cumsum(weighted * rows[:, None], axis=0)
        self.moment[1 : last + 1] = np.cumsum(weighted * self.values[:last, None], axis=0)

    def add(self, row: np.ndarray, i: int) -> None:
        """Add record ``i`` with its row of the design."""
        weighted = self.weight[i] * row
        self.gram[i + 1] = self.gram[i] + np.outer(weighted, row)
        self.moment[i + 1] = self.moment[i] + np.outer(weighted, self.values[i])

    def solve(self, i: int, precision: np.ndarray) -> None:
        """Fit the records up to ``i``, with prior precisions of the coefficients, ``(k, p)``."""
        noise = self.memory * self.noise
        matrix = self.gram[i + 1] / noise[:, None, None]
        self.cov = np.linalg.inv(matrix + precision[:, :, None] * np.eye(precision.shape[1]))
        self.mean = np.einsum("kpq,qk->kp", self.cov, self.moment[i + 1] / noise)

    def about(self, row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and variance of a linear function of the coefficients, ``(k,)`` each."""
        return self.mean @ row, np.einsum("p,kpq,q->k", row, self.cov, row)

    def off(self, design: np.ndarray, rows: slice, leading: int) -> np.ndarray:
        """Return how far records are from the path in leading coordinates, in sds, ``(r, k)``."""
        left = self.values[rows, :leading] - design[rows] @ self.mean[:leading].T
        spread = np.einsum("rp,kpq,rq->rk", design[rows], self.cov[:leading], design[rows])
        return left / np.sqrt(self.noise[:leading] + spread)

    def explained(self, starts: np.ndarray, i: int, columns: np.ndarray, leading: int) -> Explained:
        """Say what columns would explain that are 0 before a start.

        Args:
            starts: Index of the first record of each, ``(c,)``.
            i: Index of the last record.
            columns: The column from there on as a sum of those of the design, ``(c, p)``.
            leading: Coordinates k that count.
        """
        gram = self.gram[i + 1] - self.gram[starts]
        moment = (self.moment[i + 1] - self.moment[starts])[:, :, :leading]
        noise = self.memory * self.noise[:leading]
        mean, cov = self.mean[:leading], self.cov[:leading]
        cross = np.einsum("cp,cpq->cq", columns, gram)
        square = np.einsum("cq,cq->c", cross, columns)[:, None]
        known = np.einsum("cp,kpq,cq->ck", cross, cov, cross, optimize=True)
        product = np.einsum("cp,cpk->ck", columns, moment) - cross @ mean.T
        return Explained(square / noise - known / np.square(noise), product / noise)
