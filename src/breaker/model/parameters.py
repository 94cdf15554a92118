"""The seven parameters of the model: names, units, order, and the scale factors of a drive.

The paper (Eq. 5) divides masses, springs, damping and force by the mass of the drive. It numbers
the springs and dampings; here they have the letters of their masses:

========== ========================= ======= ======================================================
name here  paper                     unit    meaning
========== ========================= ======= ======================================================
mu         mu = M_a / M_b (inverted) 1       mass of the drive (a) over mass of the contact (b)
k_a        k_1 = K_1 / M_a           1/ms²   spring of the drive, which opens the breaker
k_b        k_2 = K_2 / M_a           1/ms²   contact spring between both masses, in the pushrod
gamma_a    gamma_1 = Gamma_1 / M_a   1/ms    damping of the drive
gamma_b    gamma_2 = Gamma_2 / M_a   1/ms    damping of the contact spring
f          f = F / M_a               mm/ms²  force that closes the breaker
L          L                         mm      contact gap: travel of the contact until it touches
========== ========================= ======= ======================================================

Eq. (5) prints the inverse of mu by mistake, because Eq. (3) then does not follow from Eq. (1); see
``equations``.

Only this module, ``equations``, ``kernels`` and, outside the folder, the drives with additional
effects (``breaker.family.integrator``) use parameters by name or position. Others use ``NAMES``.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Parameter:
    """An inferred quantity.

    Attributes:
        name: Name in code, configuration and files.
        unit: Unit, "1" for a number without one.
        meaning: Definition in a few words.
        worse: 1 if a larger value is worse, -1 if a smaller value is worse, 0 otherwise.
        word: Name in a sentence.
        symbol: Symbol in figures, in matplotlib's mathtext.
        colour: Colour in every figure.
    """

    name: str
    unit: str
    meaning: str
    worse: int = 0
    word: str = ""
    symbol: str = ""
    colour: str = ""

    @property
    def label(self) -> str:
        """Symbol and unit, for an axis."""
        return self.symbol if self.unit == "1" else f"{self.symbol} ({self.unit})"


# Six colours are from the palette of Okabe and Ito. Dark wine and violet replace its yellow, which
# is too pale for lines, and its black, which marks measurements.
_ROWS = (
    ("mu", "1", "mass ratio of drive to contact", 0, "mass ratio", r"$\mu$", "#CC79A7"),
    ("k_a", "1/ms²", "opening spring on main shaft", -1, "opening spring", r"$k_a$", "#0072B2"),
    ("k_b", "1/ms²", "contact spring in the pushrod", -1, "contact spring", r"$k_b$", "#56B4E9"),
    ("gamma_a", "1/ms", "damping of the drive", 1, "drive damping", r"$\gamma_a$", "#D55E00"),
    ("gamma_b", "1/ms", "contact-spring damping", 1, "contact damping", r"$\gamma_b$", "#E69F00"),
    ("f", "mm/ms²", "closing force per drive mass", -1, "closing force", r"$f$", "#009E73"),
    ("L", "mm", "contact gap", 1, "contact gap", r"$L$", "#661141"),
)
PARAMETERS = tuple(Parameter(*row) for row in _ROWS)
"""Parameters in the order of every array ``(..., p)``."""

FORCE, GAP = PARAMETERS[-2:]
ONSET = Parameter(
    "onset", "ms", "start of motion after the nominal one", 0, "", r"$t_0$", "#7A35D0"
)
"""Eighth output of a network: a nuisance parameter of the sensor (see ``sensor``)."""

NAMES = tuple(parameter.name for parameter in PARAMETERS)
MOTIONS = ("closing", "opening")


def split(theta: np.ndarray) -> tuple[np.ndarray, ...]:
    """Split parameters ``(..., p)`` into seven arrays ``(...)``, in the order of ``NAMES``."""
    return tuple(np.moveaxis(theta, -1, 0))


def is_logarithmic(names: Sequence[str]) -> np.ndarray:
    """Return which outputs are judged by their logarithm, ``(q,)`` of bool: all but the onset."""
    return np.array([name != ONSET.name for name in names])


# ---- scale factors ---------------------------------------------------------------------------

# Powers of length and of time in a unit.
_POWERS = {
    "1": (0, 0),
    "mm": (1, 0),
    "ms": (0, 1),
    "s": (0, 1),
    "A": (0, 0),
    "µΩ": (0, 0),
    "m/s": (1, -1),  # the same number as mm/ms
    "mm/ms²": (1, -2),
    "1/ms": (0, -1),
    "1/ms²": (0, -2),
}


def powers() -> np.ndarray:
    """Return the powers of length and of time in the unit of each parameter, ``(2, p)``."""
    return np.array([_POWERS[parameter.unit] for parameter in PARAMETERS], dtype=float).T


@dataclass(frozen=True)
class Size:
    """Scale factors of a drive relative to another: the model is the same at any size.

    Attributes:
        lengths, times: Factors that multiply lengths and times of the other drive.

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
                f"the factors of a size are {self.lengths} and {self.times}. Give positive ones"
            )

    def factor(self, unit: str) -> float:
        """Return the factor on a quantity of a unit."""
        length, time = _POWERS[unit]
        return self.lengths**length * self.times**time

    @property
    def factors(self) -> np.ndarray:
        """Factors on the parameters, ``(p,)``."""
        return np.array([self.factor(parameter.unit) for parameter in PARAMETERS])


UNIT = Size()
"""Size of the reference drive, which the default prior describes."""
