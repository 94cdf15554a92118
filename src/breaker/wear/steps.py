r"""Steps: a drive that is another one from one operation to the next.

A damper that fails, a bounce that begins, a spring that breaks change the record at once, whether
the model has words for it or not. What an operation says of parameters *and* difference is compared
with what the last operations say: a line through them predicts it, and the residuals that came
before give the covariance, scatter of the drive and colour of the noise included. Under no change
the squared distance follows Hotelling's distribution (Hotelling, 1931; Montgomery, "Introduction to
statistical quality control", ch. 11). Real distances have longer tails, so one operation beyond a
level is an outlier. Three in a row are a step if they agree with each other: a drive that changed
stays where it is, outliers do not. Twelve in a row are one in any case.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import fdtrc

__all__ = ["IN_ROW", "VARIANCE", "Watch"]

IN_ROW = 3
"""Operations beyond the level that make a step, where they agree."""

_ALIKE = 1e-3  # p-value of the farthest of them from their mean, above which they agree
_WINDOW = 60  # operations of the line
_MEMORY = 400.0  # operations of the covariance
_FEWEST = 12  # operations from which the next is judged, after a step

VARIANCE = 1.0 / IN_ROW + 1.0 / _FEWEST
"""Variance of the change at a step, over that of what one operation says."""


@dataclass(frozen=True)
class Watch:
    """What is known of the last operations.

    Attributes:
        operations: Numbers of the operations of the line, ``(w,)``.
        seen: What they say, ``(w, k)``.
        square: Sum of squared residuals, ``(k, k)``, forgetting with age.
        freedom: Operations that it counts for.
        suspects: Operations in a row that were beyond the level, ``(s,)``,
        suspected: and what they say, ``(s, k)``.
    """

    operations: np.ndarray
    seen: np.ndarray
    square: np.ndarray
    freedom: float
    suspects: np.ndarray
    suspected: np.ndarray

    @classmethod
    def begin(cls, size: int) -> "Watch":
        """Return the watch before the first operation, which expects the noise alone.

        Args:
            size: Number k of what an operation says, with the noise of unit covariance.
        """
        freedom = 2.0 * size
        empty, none = np.zeros(0), np.zeros((0, size))
        return cls(empty, none, freedom * np.eye(size), freedom, empty, none)

    def anew(self) -> "Watch":
        """Return the watch before an operation that need not be as the last ones were.

        How much operations scatter goes on.
        """
        empty, none = self.operations[:0], self.seen[:0]
        return replace(self, operations=empty, seen=none, suspects=empty, suspected=none)

    def p_value(self, operation: float, said: np.ndarray) -> tuple[float, np.ndarray]:
        """Return how probable something farther from the line is, and the residual, ``(k,)``.

        The residual is scaled to the covariance of those before. nan with too few operations.
        """
        w, k = self.seen.shape
        if w < _FEWEST:
            return np.nan, np.zeros(k)
        design = np.column_stack([np.ones(w), self.operations - operation])
        row = np.linalg.solve(design.T @ design, design.T)[0]  # weights of the line at 0
        residual = (said - row @ self.seen) / np.sqrt(1.0 + row @ row)
        return self._beyond(residual), residual

    def _beyond(self, residual: np.ndarray) -> float:
        """p-value of a residual ``(k,)`` under the covariance of those before."""
        k, free = len(residual), self.freedom - len(residual) + 1.0
        square = residual @ np.linalg.solve(self.square / self.freedom, residual)
        return float(fdtrc(k, free, square * free / (self.freedom * k)))

    def _alike(self, said: np.ndarray) -> bool:
        """Say whether what a few operations say, ``(s, k)``, differs by no more than scatter."""
        apart = (said - said.mean(axis=0)) / np.sqrt(1.0 - 1.0 / len(said))
        return min(map(self._beyond, apart)) > _ALIKE / len(said)

    def learn(
        self, operation: float, said: np.ndarray, level: float
    ) -> tuple["Watch", float, np.ndarray | None]:
        """Learn from an operation.

        Args:
            said: What it says, ``(k,)``.
            level: p-value below which it counts towards a step.

        Returns:
            The watch after it, its p-value, and where it completes a step the change ``(k,)``.
        """
        p_value, residual = self.p_value(operation, said)
        if p_value < level:
            suspects = np.append(self.suspects, operation)
            suspected = np.vstack([self.suspected, said])
            agree = len(suspects) >= IN_ROW and self._alike(suspected[-IN_ROW:])
            if not agree and len(suspects) < _FEWEST:
                return replace(self, suspects=suspects, suspected=suspected), p_value, None
            suspects, suspected = suspects[-IN_ROW:], suspected[-IN_ROW:]
            change = suspected.mean(axis=0) - self.seen[-_FEWEST:].mean(axis=0)
            empty, none = self.suspects[:0], self.suspected[:0]
            new = replace(self, operations=suspects, seen=suspected, suspects=empty, suspected=none)
            return new, p_value, change
        square, freedom = self.square, self.freedom
        if np.isfinite(p_value):
            keeps = 1.0 - 1.0 / _MEMORY
            square, freedom = keeps * square + np.outer(residual, residual), keeps * freedom + 1.0
        new = Watch(
            np.append(self.operations, operation)[-_WINDOW:],
            np.vstack([self.seen, said])[-_WINDOW:],
            *(square, freedom, self.suspects[:0], self.suspected[:0]),
        )
        return new, p_value, None
