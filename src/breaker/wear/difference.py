r"""How far a drive is from the model, and what that leaves of what its trend says.

A record of a drive is ``curve(z) + shift(z) + d basis + errors``: d, the *difference*, is what the
model leaves out of this very drive. All records share it, so it does not average out, and it
changes as the drive wears. The records alone cannot tell it from the parameters: where ``G`` is the
gain with which a difference passes for a change of parameters, they determine

``a = z + G (d - d0)``,   ``G = (J J')^-1 J B'``,

the *apparent* parameters, with ``d0`` a fixed guess, and, in what no parameters explain, a part of
the difference itself. Under the linearised likelihood the two are independent. So the trend follows
a, whatever the difference, with the noise alone; the sums of this module hold what the rest says of
d; and only where results are read off are they joined with what was learned of d beforehand (prior
and wear of ``results/discrepancy.zarr``). That is the exact posterior of one linear-Gaussian model
of all records, at the cost of a few small products an operation.

The size of a difference's change grows with the wear. What was learned is the second moment of both
together, in a life of usual wear; the unknown factor follows from how fast a drifts.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag

from breaker.mechanism import NAMES
from breaker.wear.changepoint import PER
from breaker.wear.learned import Learned

__all__ = ["Apparent", "Difference", "Readout", "split_off"]

_RIDGE = 1e-6  # of the information about parameters, for directions that no record determines
_LEAST = 1e-3  # square of the least drift, in lives of usual wear per thousand operations


class Apparent(NamedTuple):
    """Information about parameters and difference, split into two that are independent.

    Attributes:
        held: Information about the apparent parameters, ``(p, p)``.
        mean: Where they are most probable, about the centre, ``(p,)``.
        gain: With which a difference passes for a change of parameters, ``G``, ``(p, n)``.
        rest, left: Information about the difference that no parameters explain, ``(n, n)`` and
            ``(n,)``.
    """

    held: np.ndarray
    mean: np.ndarray
    gain: np.ndarray
    rest: np.ndarray
    left: np.ndarray


def split_off(matrix: np.ndarray, slope: np.ndarray) -> Apparent:
    """Split information ``(p + n, p + n)`` and ``(p + n,)`` about parameters and difference."""
    p = len(NAMES)
    held = matrix[:p, :p] + _RIDGE * np.trace(matrix[:p, :p]) / p * np.eye(p)
    solved = np.linalg.solve(held, np.column_stack([slope[:p], matrix[:p, p:]]))
    mean, gain = solved[:, 0], solved[:, 1:]
    share = matrix[p:, :p]
    return Apparent(held, mean, gain, matrix[p:, p:] - share @ gain, slope[p:] - share @ mean)


@dataclass(frozen=True)
class Readout:
    """From apparent parameters, level and slope, to true ones: ``z = A a + b + noise``.

    Attributes:
        matrix: ``A``, ``(2 p, 2 p)``.
        offset: ``b``, ``(2 p,)``.
        cov: Covariance of the noise, ``(2 p, 2 p)``.
    """

    matrix: np.ndarray
    offset: np.ndarray
    cov: np.ndarray

    def apply(self, mean: np.ndarray, cov: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return means ``(h, 2 p)`` and covariances ``(h, 2 p, 2 p)`` of true parameters."""
        return mean @ self.matrix.T + self.offset, self.matrix @ cov @ self.matrix.T + self.cov


@dataclass(frozen=True)
class Difference:
    """What records have said of the difference of a drive, about the known one.

    Attributes:
        gain: ``G``, ``(p, n)``.
        single: Covariance of the apparent parameters by the noise of one operation, ``(p, p)``.
        prior, known: Information about the difference at the epoch before its records, ``(n, n)``,
            and its slope, ``(n,)``.
        matrix, slope: That of the records since then about the difference at the epoch and its
            change in a thousand operations, ``(2 n, 2 n)`` and ``(2 n,)``.
        moments: Sums of 1, time and time squared over these records, ``(2, 2)``.
        epoch: Operation of the epoch: the first, or the last reported change.
    """

    gain: np.ndarray
    single: np.ndarray
    prior: np.ndarray
    known: np.ndarray
    matrix: np.ndarray
    slope: np.ndarray
    moments: np.ndarray
    epoch: int

    @classmethod
    def begin(
        cls, learned: Learned, known: np.ndarray, matrix: np.ndarray, epoch: int
    ) -> "Difference":
        """Return what is known before the first operation.

        Args:
            learned: What was learned of drives.
            known: The difference that the models know, ``(n,)``.
            matrix: Information of one record of the reference about parameters and difference,
                ``(p + n, p + n)``, from which the gain follows.
            epoch: Number of the first operation.
        """
        prior = np.linalg.inv(learned.new)
        found = split_off(matrix, np.zeros(len(matrix)))
        start = prior, -prior @ known
        return cls(found.gain, np.linalg.inv(found.held), *start, *_nothing(len(known)), epoch)

    def learn(self, operation: int, matrix: np.ndarray, slope: np.ndarray) -> "Difference":
        """Add what an operation says of the difference, whatever its parameters.

        Args:
            matrix, slope: Its information about parameters and difference, ``(p + n, p + n)`` and
                ``(p + n,)``.
        """
        found = split_off(matrix, slope)
        design = np.array([1.0, (operation - self.epoch) / PER])
        square = np.outer(design, design)
        return replace(
            self,
            matrix=self.matrix + np.kron(square, found.rest),
            slope=self.slope + np.kron(design, found.left),
            moments=self.moments + square,
        )

    def now(
        self, learned: Learned, operation: int, drift: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the difference at an operation and its change in a thousand.

        Args:
            learned: What was learned of drives.
            drift: Apparent slope, standardised, per thousand operations, ``(p,)``: sets the scale
                of the change.

        Returns:
            Mean of both, ``(2 n,)``, and their covariance ``(2 n, 2 n)``.
        """
        p, n = len(NAMES), self.gain.shape[1]
        wear, size = learned.wear, self.wear(learned, drift)
        response = np.linalg.solve(wear[:p, :p], wear[:p, p:]).T
        change = np.linalg.inv(size * (wear[p:, p:] - response @ wear[:p, p:]))
        expected = response @ np.linalg.solve(np.eye(p) + self.gain @ response, drift)
        # What the components leave out is the same in all records, so their sums saturate.
        half, share = (
            np.kron(each, np.eye(n)) for each in _saturating(self.moments, learned.rough, size)
        )
        matrix = block_diag(self.prior, change) + half @ self.matrix @ half.T
        slope = np.append(self.known, change @ expected) + share @ self.slope
        cov = np.linalg.inv(0.5 * (matrix + matrix.T))
        move = np.eye(2 * n)
        move[:n, n:] = (operation - self.epoch) / PER * np.eye(n)
        return move @ cov @ slope, move @ cov @ move.T

    def wear(self, learned: Learned, drift: np.ndarray) -> float:
        """Square of the wear in a thousand operations over that in a life of usual wear."""
        through = np.hstack([np.eye(len(drift)), self.gain])
        usual = through @ learned.wear @ through.T
        return max(drift @ np.linalg.solve(usual, drift) / len(drift), _LEAST)

    def readout(
        self, learned: Learned, operation: int, drift: np.ndarray, slope_sd: float
    ) -> Readout:
        """Return how true parameters follow from apparent ones at an operation.

        Args:
            learned, operation, drift: As of ``now``.
            slope_sd: Prior sd of a slope, in prior sds per thousand operations.
        """
        p = len(NAMES)
        mean, cov = self.now(learned, operation, drift)
        both = np.kron(np.eye(2), self.gain)
        passes = both @ cov @ both.T  # what the difference adds to apparent level and slope
        fine = np.diag([1.0, self.wear(learned, drift)])
        passes += learned.rough * np.kron(fine, self.single)
        prior = np.diag(np.append(np.ones(p), np.full(p, np.square(slope_sd))))
        matrix = np.linalg.solve(prior + passes, prior).T
        return Readout(matrix, -matrix @ both @ mean, prior - matrix @ prior)

    def renewed(
        self, learned: Learned, operation: int, drift: np.ndarray, *, stepped: bool
    ) -> "Difference":
        """Return the same from a reported change on: what is known of its level stays.

        Args:
            learned, operation, drift: As of ``now``.
            stepped: Whether the level may be another one, by as much as drives differ.
        """
        n = self.gain.shape[1]
        mean, cov = self.now(learned, operation, drift)
        prior = np.linalg.inv(cov[:n, :n] + (learned.new if stepped else 0.0))
        start = prior, prior @ mean[:n]
        return Difference(self.gain, self.single, *start, *_nothing(n), operation)


def _saturating(moments: np.ndarray, rough: float, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Return what sums over records are worth where each has the same error beside its noise.

    Of information ``S x R`` about a level and a slope, with ``S`` the moments, ``(S^-1 + r D)^-1 x
    R`` is left, ``D = diag(1, size)``.

    Args:
        moments: ``S``, ``(2, 2)``.
        rough: ``r``, variance of that error over the variance by the noise of one record.
        size: As of ``Difference.wear``.

    Returns:
        ``T`` with ``T S T' = (S^-1 + r D)^-1``, on both sides of a matrix so that it stays positive
        definite where not every record says the same, and ``(1 + r S D)^-1`` for a slope.
    """
    scale = np.sqrt(np.array([1.0, size]))
    values, vectors = np.linalg.eigh(scale[:, None] * moments * scale)
    half = (vectors / np.sqrt(1.0 + rough * np.maximum(values, 0.0))) @ vectors.T
    return half / scale[:, None] * scale, np.linalg.inv(np.eye(2) + rough * moments * scale**2)


def _nothing(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sums over no record."""
    return np.zeros((2 * n, 2 * n)), np.zeros(2 * n), np.zeros((2, 2))
