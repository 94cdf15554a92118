"""How sensors of other drives read: some round, and some have noise of a colour."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from breaker.model.sensor import Sensor

_ROUNDED = 0.5  # share of the sensors that round their readings,
_QUANTUM = (0.05, 0.3)  # mm, to a multiple of this, log-uniform
_COLOURED = 0.25  # share of those whose noise is correlated from sample to sample
_COLOUR = (0.3, 0.8)  # correlation of neighbouring samples, uniform


@dataclass(frozen=True)
class Reading:
    """How a drive's sensor departs from the model's.

    Attributes:
        quantum: Step to which readings are rounded, mm; 0 where they are not.
        colour: Correlation of the noise of neighbouring samples; 0 where it is white.
    """

    quantum: float
    colour: float

    @classmethod
    def draw(cls, rng: np.random.Generator) -> "Reading":
        """Draw the sensor of a drive."""
        rounds, coloured = rng.random(2) < (_ROUNDED, _COLOURED)
        quantum = np.exp(rng.uniform(*np.log(_QUANTUM)))
        colour = rng.uniform(*_COLOUR)
        return cls(float(rounds * quantum), float(coloured * colour))

    def corrupt(self, curve: np.ndarray, sensor: Sensor, rng: np.random.Generator) -> np.ndarray:
        """Add noise and zero of the model's sizes to a curve ``(t,)``, mm, and round."""
        innovations = rng.standard_normal(curve.shape)
        innovations[1:] *= np.sqrt(1.0 - self.colour**2)
        noise = lfilter([1.0], [1.0, -self.colour], innovations)
        read = curve + sensor.noise_sd * noise + sensor.zero_sd * rng.standard_normal()
        return self.quantum * np.round(read / self.quantum) if self.quantum else read
