"""What the travel sensor adds to the exact curve: onset, zero and noise.

Paper, Sec. 3: normally distributed noise on the position of mass a. Real records have two more
unknowns: the motion starts at an *onset* around the nominal time, not at it, and the reading has an
additive offset, the *zero*. Both are normal with mean zero; a standard deviation of zero turns one
off. The onset shifts the exact curve, so the mechanism simulates it; the zero is linear and is
integrated in closed form: the covariance of a record is ``noise_sd^2 I + zero_sd^2 1 1^T``. A
missing sample is NaN; results are then those of the samples that are present.

What the model leaves out of a motion, the ``Discrepancy``, is one more term of the covariance,
``factor^T factor``. Whitened by noise and zero it is diagonal in few orthonormal directions, its
*modes*, so whitening, distances and densities cost one small product more, at any scale.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from breaker.mechanism import Size
from breaker.model.discrepancy import Discrepancy, Modes, modes

__all__ = ["Sensor", "grid"]


def grid(start: float, stop: float, samples: int) -> np.ndarray:
    """Return the times of a record's samples, ``(t,)``, ms around the nominal first motion."""
    return np.linspace(start, stop, samples)


@dataclass(frozen=True)
class Sensor:
    """Time grid and errors of a travel sensor.

    Attributes:
        start, stop: First and last time of the grid, ms around the nominal first motion.
        samples: Number of samples of the grid, both ends included.
        noise_sd: Standard deviation of the noise of one sample, mm.
        onset_sd: Standard deviation of the onset, ms; 0 if the motion starts at the nominal time.
        zero_sd: Standard deviation of the zero, mm; 0 if the reading is true.
        discrepancy: What the model leaves out of the motion; None if it is right. Here its
            deviations from its mean count; ``Model.curves`` has the mean.

    Example:
        >>> sensor = Sensor(-2.0, 58.0, 151, noise_sd=0.1, onset_sd=0.3, zero_sd=0.1)
        >>> sensor.times[:3]
        array([-2. , -1.6, -1.2])
        >>> record = sensor.corrupt(np.zeros(151), np.random.default_rng(1))
        >>> bool(abs(sensor.whiten(record).std() - 1) < 0.2)  # the zero included
        True
    """

    start: float
    stop: float
    samples: int
    noise_sd: float
    onset_sd: float
    zero_sd: float
    discrepancy: Discrepancy | None = None

    def __post_init__(self) -> None:
        if not (self.start < 0 < self.stop and self.samples >= 2):
            raise ValueError("the sensor's grid must begin before 0 and end after it")
        if not (self.noise_sd > 0 and self.onset_sd >= 0 and self.zero_sd >= 0):
            raise ValueError("noise_sd must be positive, onset_sd and zero_sd not negative")
        if self.discrepancy is not None and len(self.discrepancy.mean) != self.samples:
            raise ValueError(
                f"what the model leaves out is of {len(self.discrepancy.mean)} samples, and the "
                f"sensor has {self.samples}"
            )

    @classmethod
    def from_settings(cls, settings: Mapping[str, float]) -> "Sensor":
        """Build the sensor from the section ``sensor`` of the configuration."""
        return cls(**settings)

    def settings(self) -> dict[str, float]:
        """Return what ``from_settings`` takes."""
        names = [each.name for each in fields(self) if each.name != "discrepancy"]
        return {name: getattr(self, name) for name in names}

    def sized(self, size: Size) -> "Sensor":
        """Return the sensor as it is for drives of another size: grid, errors, discrepancy."""
        return replace(
            self,
            start=self.start * size.times,
            stop=self.stop * size.times,
            noise_sd=self.noise_sd * size.lengths,
            onset_sd=self.onset_sd * size.times,
            zero_sd=self.zero_sd * size.lengths,
            discrepancy=self.discrepancy and self.discrepancy.sized(size),
        )

    @cached_property
    def noise_and_zero(self) -> "Sensor":
        """The sensor where the model is right."""
        return replace(self, discrepancy=None)

    @property
    def times(self) -> np.ndarray:
        """Times of the samples, ``(t,)``, ms."""
        return grid(self.start, self.stop, self.samples)

    @property
    def step(self) -> float:
        """Time between two samples, ms."""
        return (self.stop - self.start) / (self.samples - 1)

    @property
    def infers_onset(self) -> bool:
        """Whether the onset is one of the unknowns."""
        return self.onset_sd > 0

    def corrupt(self, travel: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Add what records ``(..., t)`` have beside their expected curves, mm: zero and noise.

        And what the model leaves out, about its mean.
        """
        noise = self.noise_sd * rng.standard_normal(travel.shape)
        records = travel + noise + self.zero_sd * rng.standard_normal((*travel.shape[:-1], 1))
        if self.discrepancy is None:
            return records
        return records + self.discrepancy.sample(travel.shape[:-1], rng)

    def sample_shared(
        self, measured: np.ndarray, travel: np.ndarray, rng: np.random.Generator
    ) -> np.ndarray:
        """Draw what a repetition shares with its record, ``(..., t) -> (..., t or 1)``, mm.

        All samples of a record share one zero, so its posterior is normal, with precision
        ``t / noise_sd^2 + 1 / zero_sd^2``. With a discrepancy it is drawn along by Matheron's rule:
        a draw of all errors, moved by the regression on what it leaves of the record.
        """
        if self.discrepancy is not None:
            shape = np.broadcast_shapes(np.shape(measured), travel.shape)
            shared = self.zero_sd * rng.standard_normal((*shape[:-1], 1))
            shared = shared + self.discrepancy.sample(shape[:-1], rng)
            noise = self.noise_sd * rng.standard_normal(shape)
            left = self._precision(measured - travel - shared - noise)
            factor = self.discrepancy.factor
            shared += self.zero_sd**2 * left.sum(axis=-1, keepdims=True)
            return shared + (left @ factor.T) @ factor
        residual, t = _there(measured - travel)
        variance = self.noise_sd**2 * self.zero_sd**2 / (self.noise_sd**2 + t * self.zero_sd**2)
        mean = variance / self.noise_sd**2 * residual.sum(axis=-1, keepdims=True)
        return mean + np.sqrt(variance) * rng.standard_normal(mean.shape)

    def lag_given(self, measured: np.ndarray, travel: np.ndarray) -> tuple[np.ndarray, float]:
        """Return mean, ``(n,)``, and variance of the lag's deviation from its own mean, ms.

        What the components bring along is known as far as the record knows the components:
        ``Cov(lag, record) Cov(record)^-1 (record - travel)``.

        Args:
            measured: Record, ``(t,)``, mm; nan where a sample is missing.
            travel: Its expected curves, ``(n, t)``, mm.
        """
        there, lag = ~np.isnan(measured), self.discrepancy.lag
        along = lag.loading @ self.discrepancy.factor
        gain = self._precision(np.where(there, along, np.nan))
        left = np.where(there, measured, 0.0) @ gain - travel @ gain
        return left, float(lag.loading @ lag.loading + lag.sd**2 - along @ gain)

    def _modes(self, residual: np.ndarray) -> Iterator[tuple[Any, Modes]]:
        """Yield which residuals ``(..., t)`` miss the same samples, and the modes of these."""
        there = ~np.isnan(residual)
        rows = there.reshape(-1, self.samples)
        if len(rows) and (rows == rows[0]).all():
            yield ..., modes(self, rows[0].tobytes())
            return
        # Every record may miss samples of its own, so rows are compared with no other row.
        alike: dict[bytes, list[int]] = {}
        for i, row in enumerate(rows):
            alike.setdefault(row.tobytes(), []).append(i)
        for present, numbers in alike.items():
            yield np.unravel_index(numbers, there.shape[:-1]), modes(self, present)

    def _precision(self, residual: np.ndarray) -> np.ndarray:
        """Multiply ``(..., t)`` by the inverse of a record's covariance; missing samples give 0."""
        plain = self.noise_and_zero
        whitened = plain.whiten(residual)
        for rows, (directions, _, variances) in self._modes(residual):
            along = whitened[rows] @ directions.T
            whitened[rows] -= (along * (variances / (1.0 + variances))) @ directions
        # The root by noise and zero is symmetric.
        return plain.whiten(np.where(np.isnan(residual), np.nan, whitened))

    def whiten(self, residual: np.ndarray) -> np.ndarray:
        """Multiply ``(..., t)`` by the inverse square root of a record's covariance.

        Of the mean, the only direction in which the covariance differs from ``noise_sd^2 I``,
        the share ``noise_sd / sqrt(noise_sd^2 + t zero_sd^2)`` is left; of a mode of the
        discrepancy with the variance v over the noise's, ``1 / sqrt(1 + v)``. A missing sample
        becomes 0, so that it adds to no sum.
        """
        values, t = _there(residual)
        kept = self.noise_sd / np.sqrt(self.noise_sd**2 + t * self.zero_sd**2)
        mean = values.sum(axis=-1, keepdims=True) / t
        whitened = (values - (1.0 - kept) * mean) / self.noise_sd
        if values is not residual:
            whitened = np.where(np.isnan(residual), 0.0, whitened)
        if self.discrepancy is not None:
            for rows, (directions, _, variances) in self._modes(residual):
                lost = 1.0 - 1.0 / np.sqrt(1.0 + variances)
                whitened[rows] -= (whitened[rows] @ directions.T * lost) @ directions
        return whitened

    def chi_square(self, measured: np.ndarray, travel: np.ndarray) -> np.ndarray:
        """Return the squared Mahalanobis distance of records from curves, ``(..., t) -> (...)``."""
        difference = measured - travel
        residual, t = _there(difference)
        total = residual.sum(axis=-1)
        # That of the noise alone, less what the zero explains of the mean.
        explained = self.zero_sd**2 / (self.noise_sd**2 + t[..., 0] * self.zero_sd**2)
        square = np.einsum("...t,...t->...", residual, residual)
        square = (square - explained * total**2) / self.noise_sd**2
        if self.discrepancy is not None:
            square = np.asarray(square)
            for rows, (_, weights, variances) in self._modes(difference):
                along = residual[rows] @ weights.T
                square[rows] -= np.square(along) @ (variances / (1.0 + variances))
        return square

    def log_likelihood(self, measured: np.ndarray, travel: np.ndarray) -> np.ndarray:
        """Return the log density of records given exact curves, ``(..., t) -> (...)``.

        Zero and discrepancy are integrated out; the onset is in ``travel``.
        """
        t = _there(measured)[1][..., 0]
        log_determinant = (t - 1) * np.log(self.noise_sd**2) + np.log(
            self.noise_sd**2 + t * self.zero_sd**2
        )
        if self.discrepancy is not None:
            log_determinant = np.broadcast_to(log_determinant, measured.shape[:-1]).copy()
            for rows, each in self._modes(measured):
                log_determinant[rows] += np.log1p(each.variances).sum()
        return -0.5 * (self.chi_square(measured, travel) + log_determinant + t * np.log(2 * np.pi))


def _there(residual: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Residuals ``(..., t)`` with 0 for NaN, and how many are there, ``(..., 1)`` or ``(1,)``."""
    missing = np.isnan(residual)
    if not missing.any():
        return residual, np.array([residual.shape[-1]])
    return np.where(missing, 0.0, residual), (~missing).sum(axis=-1, keepdims=True)
