r"""When the contact touched or parted: one more datum of a record, measured on the main contact.

With ``y`` the measured time on the record's grid, ms after the nominal first motion,

``y = onset + switching + lag + error``,

where the mechanism gives the switching time and the lag is that of a real drive behind the model
(``Discrepancy``). The lag and the error of the curve belong together, so the datum is judged given
the record: ``log p(record, y) = log p(record) + log p(y | record)``, both normal and exact.
"""

from dataclasses import dataclass

import numpy as np

from breaker.model.sensor import Sensor

__all__ = ["Contact"]


@dataclass(frozen=True)
class Contact:
    """Measured time of touch or parting.

    Attributes:
        time: On the record's grid, ms after the nominal first motion.
        sd: Standard deviation of its error, ms.

    Example:
        >>> sensor = Sensor(-2.0, 58.0, 151, noise_sd=0.1, onset_sd=0.3, zero_sd=0.1)
        >>> expected = np.array([10.0, 9.8])
        >>> Contact(10.0, 0.1).residuals(sensor, np.zeros(151), np.zeros((2, 151)), expected)
        array([0., 2.])
    """

    time: float
    sd: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.time) and 0 < self.sd < np.inf):
            raise ValueError(
                f"a time of touch or parting must be finite and its sd positive, not {self.time} "
                f"and {self.sd} ms"
            )

    def residuals(
        self, sensor: Sensor, record: np.ndarray, curves: np.ndarray, expected: np.ndarray
    ) -> np.ndarray:
        """Return how far the time is from what is expected given the record, in sds, ``(n,)``.

        Args:
            sensor: Errors of the record, and what the model leaves out.
            record: ``(t,)``, mm; nan where a sample is missing.
            curves: Expected of each of n draws, ``(n, t)``, mm.
            expected: Times expected without the record, the lag's mean included, ``(n,)``, ms;
                inf where the contact does not switch.
        """
        mean, sd = self._given_record(sensor, record, curves)
        return (self.time - expected - mean) / sd

    def log_density(
        self, sensor: Sensor, record: np.ndarray, curves: np.ndarray, expected: np.ndarray
    ) -> np.ndarray:
        """Return the log density of the time given the record, ``(n,)``; as for ``residuals``."""
        mean, sd = self._given_record(sensor, record, curves)
        square = np.square((self.time - expected - mean) / sd)
        return -0.5 * (square + np.log(2 * np.pi)) - np.log(sd)

    def _given_record(
        self, sensor: Sensor, record: np.ndarray, curves: np.ndarray
    ) -> tuple[np.ndarray | float, float]:
        """What the record adds to the expected times, and the sd about them, ms."""
        if sensor.discrepancy is None:
            return 0.0, self.sd
        mean, variance = sensor.lag_given(record, curves)
        return mean, float(np.sqrt(self.sd**2 + variance))
