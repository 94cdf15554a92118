"""What is known of a drive beside its records: Gaussian facts on parameters and quantities.

A fact ``name: [value, sd]`` is one more Gaussian datum about the drive, so it multiplies the
posterior's density exactly.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from breaker.mechanism import MOTIONS, QUANTITIES, evaluate

__all__ = ["Facts"]


@dataclass(frozen=True, eq=False)
class Facts:
    """Gaussian facts.

    Attributes:
        names: Names of quantities, k of them.
        values, sds: What is known of each and how well, ``(k,)``, in the quantity's unit.

    Example:
        >>> facts = Facts.from_settings({"mu": [2.4, 0.1], "wipe": [3.5, 0.3]})
        >>> theta = np.array([[2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0]])
        >>> facts.residuals(theta).round(1)
        array([[-4. ,  0.1]])
    """

    names: tuple[str, ...]
    values: np.ndarray
    sds: np.ndarray

    @classmethod
    def from_settings(cls, settings: Mapping[str, Sequence[float]]) -> "Facts":
        """Build from ``{name: [value, sd]}``, the section ``known`` of the configuration."""
        values, sds = np.array([*settings.values()], dtype=np.float64).reshape(-1, 2).T
        return cls(tuple(settings), values, sds)

    def residuals(self, theta: np.ndarray) -> np.ndarray:
        """Return how far parameters are from the facts, ``(n, p) -> (n, k)``, in their sds.

        NaN where a quantity does not exist.
        """
        found = np.empty((len(theta), len(self.names)))
        for motion in MOTIONS:  # each quantity by the first motion that has it
            columns = [
                column
                for column, name in enumerate(self.names)
                if QUANTITIES[name].motions[0] == motion
            ]
            if columns:
                found[:, columns] = evaluate([self.names[i] for i in columns], theta, motion)
        return (found - self.values) / self.sds

    def log_density(self, theta: np.ndarray) -> np.ndarray:
        """Return the log density of the facts given parameters, ``(n, p) -> (n,)``.

        It is ``-inf`` where a quantity does not exist.
        """
        constant = np.log(2 * np.pi) * len(self.names) + 2 * np.log(self.sds).sum()
        square = np.square(self.residuals(theta)).sum(axis=-1)
        return np.where(np.isnan(square), -np.inf, -0.5 * (square + constant))
