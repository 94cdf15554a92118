"""The travel sensor: errors of a record relative to an exact curve.

Paper, Sec. 3: normal noise on the position of the drive. Real records have two more unknowns: the
motion starts at an *onset* near the nominal time, and the reading has an additive offset, the
*zero*. Both are normal with mean zero; a standard deviation of zero removes the unknown. The zero
is integrated in closed form: the covariance of a record is ``noise_sd^2 I + zero_sd^2 1 1^T``. A
missing sample is NaN and does not count.
"""

from dataclasses import dataclass, replace

import numpy as np

from breaker.model.parameters import Size


def grid(start: float, stop: float, samples: int) -> np.ndarray:
    """Return the times of a record's samples, ``(t,)``, ms around the nominal start of motion."""
    return np.linspace(start, stop, samples)


@dataclass(frozen=True)
class Sensor:
    """Time grid and errors of a travel sensor, the section ``sensor`` of the configuration.

    Attributes:
        start, stop: First and last time of the grid, ms around the nominal start of motion.
        samples: Number of samples of the grid, both ends included.
        noise_sd: Standard deviation of the noise of a sample, mm.
        onset_sd: Standard deviation of the onset, ms; 0 if the motion starts at the nominal time.
        zero_sd: Standard deviation of the zero, mm; 0 if readings have no offset.

    Example:
        >>> sensor = Sensor(-2.0, 58.0, 151, noise_sd=0.1, onset_sd=0.3, zero_sd=0.1)
        >>> sensor.times[:3]
        array([-2. , -1.6, -1.2])
        >>> record = sensor.corrupt(np.zeros(151), np.random.default_rng(1))
        >>> bool(abs(sensor.whiten(record).std() - 1) < 0.2)  # with the zero
        True
    """

    start: float
    stop: float
    samples: int
    noise_sd: float
    onset_sd: float
    zero_sd: float

    def __post_init__(self) -> None:
        if not (self.start < 0 < self.stop and self.samples >= 2):
            raise ValueError("the sensor's grid must begin before 0 and end after it")
        if not (self.noise_sd > 0 and self.onset_sd >= 0 and self.zero_sd >= 0):
            raise ValueError("noise_sd must be positive, onset_sd and zero_sd not negative")

    def sized(self, size: Size) -> "Sensor":
        """Return the sensor with grid and errors scaled to drives of another size."""
        return replace(
            self,
            start=self.start * size.times,
            stop=self.stop * size.times,
            noise_sd=self.noise_sd * size.lengths,
            onset_sd=self.onset_sd * size.times,
            zero_sd=self.zero_sd * size.lengths,
        )

    @property
    def times(self) -> np.ndarray:
        """Times of the samples, ``(t,)``, ms."""
        return grid(self.start, self.stop, self.samples)

    @property
    def infers_onset(self) -> bool:
        """Whether the onset is one of the unknowns."""
        return self.onset_sd > 0

    def corrupt(self, travel: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Add noise and a zero to exact curves ``(..., t)``, mm."""
        noise = self.noise_sd * rng.standard_normal(travel.shape)
        return travel + noise + self.zero_sd * rng.standard_normal((*travel.shape[:-1], 1))

    def sample_shared(
        self, measured: np.ndarray, travel: np.ndarray, rng: np.random.Generator
    ) -> np.ndarray:
        """Draw the zero of records given their exact curves, ``(..., t) -> (..., 1)``, mm.

        Its posterior is normal, with precision ``t / noise_sd^2 + 1 / zero_sd^2``.
        """
        residual, t = _present(measured - travel)
        variance = self.noise_sd**2 * self.zero_sd**2 / (self.noise_sd**2 + t * self.zero_sd**2)
        mean = variance / self.noise_sd**2 * residual.sum(axis=-1, keepdims=True)
        return mean + np.sqrt(variance) * rng.standard_normal(mean.shape)

    def whiten(self, residual: np.ndarray) -> np.ndarray:
        """Multiply ``(..., t)`` by the inverse square root of a record's covariance."""
        t = residual.shape[-1]
        kept = self.noise_sd / np.sqrt(self.noise_sd**2 + t * self.zero_sd**2)
        mean = residual.sum(axis=-1, keepdims=True) / t
        return (residual - (1.0 - kept) * mean) / self.noise_sd

    def chi_square(self, measured: np.ndarray, travel: np.ndarray) -> np.ndarray:
        """Return the squared Mahalanobis distance of records from curves, ``(..., t) -> (...)``."""
        residual, t = _present(measured - travel)
        total = residual.sum(axis=-1)
        # Squared distance under noise alone, minus the part of the mean that the zero explains.
        explained = self.zero_sd**2 / (self.noise_sd**2 + t[..., 0] * self.zero_sd**2)
        square = np.einsum("...t,...t->...", residual, residual)
        return (square - explained * total**2) / self.noise_sd**2

    def log_likelihood(self, measured: np.ndarray, travel: np.ndarray) -> np.ndarray:
        """Return the log density of records given exact curves, ``(..., t) -> (...)``."""
        t = _present(measured)[1][..., 0]
        log_determinant = (t - 1) * np.log(self.noise_sd**2) + np.log(
            self.noise_sd**2 + t * self.zero_sd**2
        )
        return -0.5 * (self.chi_square(measured, travel) + log_determinant + t * np.log(2 * np.pi))


def _present(residual: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return residuals ``(..., t)`` with 0 for NaN, and the number of finite ones, ``(..., 1)``."""
    missing = np.isnan(residual)
    if not missing.any():
        return residual, np.array([residual.shape[-1]])
    return np.where(missing, 0.0, residual), (~missing).sum(axis=-1, keepdims=True)
