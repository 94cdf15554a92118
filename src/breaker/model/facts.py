"""What is known beside a record: facts of the drive, and when the contact touched or parted.

A fact ``name: [value, sd]`` on a parameter or quantity, like the contact's time, is one more
Gaussian datum, so it multiplies the posterior's density exactly.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from breaker.mechanism import MOTIONS, SPEEDS, Speed, check_quantity, evaluate

_CONTRADICTED = 3.0  # sd of a fact


@dataclass(frozen=True, eq=False)
class Facts:
    """Gaussian facts.

    Attributes:
        names: Names of quantities, k of them.
        values, sds: What is known of each and how well, ``(k,)``, in the quantity's unit.
        speeds: How speeds are defined.

    Example:
        >>> facts = Facts.from_settings({"mu": [2.4, 0.1], "wipe": [3.5, 0.3]})
        >>> theta = np.array([[2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0]])
        >>> facts.residuals(theta).round(1)
        array([[-4. ,  0.1]])
    """

    names: tuple[str, ...]
    values: np.ndarray
    sds: np.ndarray
    speeds: tuple[Speed, ...] = SPEEDS

    @classmethod
    def from_settings(
        cls, settings: Mapping[str, Sequence[float]], speeds: tuple[Speed, ...] = SPEEDS
    ) -> "Facts":
        """Build from ``{name: [value, sd]}``, the section ``known`` of the configuration."""
        values, sds = np.array([*settings.values()], dtype=np.float64).reshape(-1, 2).T
        return cls(tuple(settings), values, sds, speeds)

    def residuals(self, theta: np.ndarray) -> np.ndarray:
        """Return how far parameters are from the facts, ``(n, p) -> (n, k)``, in their sds.

        NaN where a quantity does not exist.
        """
        found = np.empty((len(theta), len(self.names)))
        left = range(len(self.names))
        for motion in MOTIONS:  # each quantity by the first motion that has it
            own = [i for i in left if not check_quantity(self.names[i], motion, self.speeds)]
            left = [i for i in left if i not in own]
            if own:
                names = [self.names[i] for i in own]
                found[:, own] = evaluate(names, theta, motion, self.speeds)
        return (found - self.values) / self.sds

    def log_density(self, theta: np.ndarray) -> np.ndarray:
        """Return the log density of the facts given parameters, ``(n, p) -> (n,)``.

        It is ``-inf`` where a quantity does not exist.
        """
        constant = np.log(2 * np.pi) * len(self.names) + 2 * np.log(self.sds).sum()
        square = np.square(self.residuals(theta)).sum(axis=-1)
        return np.where(np.isnan(square), -np.inf, -0.5 * (square + constant))

    def contradicted(self, theta: np.ndarray) -> list[str]:
        """Return what facts records contradict, in words; empty if they do not.

        Args:
            theta: Posterior medians of some records, ``(n, p)``, NaN where there is none. A fact
                that they leave by more than 3 of its sds, in half of the records, is contradicted.
        """
        there = np.isfinite(theta).all(axis=-1)
        if not there.any() or not self.names:
            return []
        off = np.median(self.residuals(theta[there]), axis=0)
        return [
            f"the records contradict known.{name}, {value:g} with an sd of {sd:g}: the posterior "
            f"is {distance:+.1f} sd off; check its value and unit, or widen it"
            for name, value, sd, distance in zip(
                self.names, self.values, self.sds, off, strict=True
            )
            if not abs(distance) <= _CONTRADICTED
        ]


@dataclass(frozen=True)
class Contact:
    """Measured time of touch or parting: one more datum of a record, measured on the main contact.

    It is ``onset + switching + error``, on the record's grid, where the mechanism gives the
    switching time. Its error has nothing to do with those of the record.

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
