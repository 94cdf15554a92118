"""The size of a drive: factors on lengths and times, to which the mechanism is indifferent.

A drive whose lengths are ``s`` times and whose times are ``t`` times those of another moves on the
same curve, stretched: Eqs. (3) and (4) of the paper hold for it with ``f s / t^2``, ``L s``,
``k / t^2``, ``gamma / t`` and the same ``mu``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from breaker.common.lazy_numpy import np
from breaker.quantities.parameters import PARAMETERS

# Powers of length and time in a unit.
_POWERS = {
    "1": (0, 0),
    "mm": (1, 0),
    "ms": (0, 1),
    "s": (0, 1),
    "A": (0, 0),
    "m/s": (1, -1),  # which is mm/ms
    "mm/ms²": (1, -2),
    "1/ms": (0, -1),
    "1/ms²": (0, -2),
}


def powers() -> np.ndarray:
    """Return the powers of length and of time in the unit of each parameter, ``(2, p)``."""
    return np.array([_POWERS[parameter.unit] for parameter in PARAMETERS], dtype=float).T


@dataclass(frozen=True)
class Size:
    """Size of a drive beside that of another.

    Attributes:
        lengths, times: Factors on the other's lengths and times.

    Example:
        >>> size = Size(lengths=10.0, times=4.0)
        >>> size.factor("m/s"), size.factor("1/ms²")
        (2.5, 0.0625)
    """

    lengths: float = 1.0
    times: float = 1.0

    def __post_init__(self) -> None:
        if not (0 < self.lengths < math.inf and 0 < self.times < math.inf):
            raise ValueError(
                f"the factors of a size must be positive, not {self.lengths} and {self.times}"
            )

    def factor(self, unit: str) -> float:
        """Return the factor on a quantity of a unit, one of those of parameters and quantities."""
        length, time = _POWERS[unit]
        return self.lengths**length * self.times**time

    @property
    def factors(self) -> np.ndarray:
        """Factors on the parameters, ``(p,)``."""
        return np.array([self.factor(parameter.unit) for parameter in PARAMETERS])


UNIT = Size()
"""The size of the reference drive."""
