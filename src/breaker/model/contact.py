r"""When the contact touched or parted: one more datum of a record, measured on the main contact.

With ``y`` the measured time on the record's grid, ms after the nominal first motion,

``y = onset + switching + error``,

where the mechanism gives the switching time. Its error has nothing to do with those of the record,
so it multiplies the posterior's density exactly.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Contact:
    """Measured time of touch or parting.

    Attributes:
        time: On the record's grid, ms after the nominal first motion.
        sd: Standard deviation of its error, ms.

    Example:
        >>> Contact(10.0, 0.1).residuals(np.array([10.0, 9.8])).round(6)
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

    def residuals(self, expected: np.ndarray) -> np.ndarray:
        """Return how far the time is from expected ones ``(n,)``, in sds.

        Args:
            expected: ms; inf where the contact does not switch.
        """
        return (self.time - expected) / self.sd

    def log_density(self, expected: np.ndarray) -> np.ndarray:
        """Return the log density of the time given expected ones, ``(n,)``."""
        square = np.square(self.residuals(expected))
        return -0.5 * (square + np.log(2 * np.pi)) - np.log(self.sd)
