"""Names, symbols, units, words, colours and order of what is inferred.

Four modules know the seven parameters by name and position: this one, their formulas
(``drive_conditions``), the equations (``kernels``), and those of richer drives (``integrator``).
Sources: paper, Sec. 3, Eqs. (3) to (5). The paper's k_1, k_2, gamma_1, gamma_2 are k_a, k_b,
gamma_a, gamma_b here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from breaker.common.lazy_numpy import np


@dataclass(frozen=True)
class Parameter:
    """A quantity that is inferred.

    Attributes:
        name: Name in code, configuration and stores.
        symbol: Symbol for figures, in matplotlib's mathtext.
        unit: Unit, "1" if it has none.
        meaning: What it is, in a few words.
        worse: 1 where more of it is the worse, -1 where less of it is, 0 where neither is.
        word: What it is called in a sentence.
        colour: Its colour in every figure.
    """

    name: str
    symbol: str
    unit: str
    meaning: str
    worse: int = 0
    word: str = ""
    colour: str = ""

    @property
    def label(self) -> str:
        """Symbol and unit, for an axis."""
        return self.symbol if self.unit == "1" else f"{self.symbol} ({self.unit})"


# Six colours are of the palette of Okabe and Ito. Its yellow is too pale for lines and its black is
# kept for measurements, so that dark wine and violet stand in. All pairs stay apart in the common
# colour deficiencies (a test says how far).
FORCE = Parameter(
    "f", r"$f$", "mm/ms²", "closing force per drive mass", -1, "closing force", "#009E73"
)
"""The force that closes the drive, in which forces of other kinds are told."""

GAP = Parameter("L", r"$L$", "mm", "contact gap", 1, "contact gap", "#661141")
"""The way at which the contact touches: known only where the touch is."""

OPENING_SPRING = Parameter(
    "k_a", r"$k_a$", "1/ms²", "opening spring on the main shaft", -1, "opening spring", "#0072B2"
)
"""The spring that closing strains, and that opens the drive."""

PARAMETERS = (
    Parameter("mu", r"$\mu$", "1", "mass ratio of drive to contact", 0, "mass ratio", "#CC79A7"),
    OPENING_SPRING,
    Parameter(
        "k_b", r"$k_b$", "1/ms²", "contact spring in the pushrod", -1, "contact spring", "#56B4E9"
    ),
    Parameter(
        "gamma_a", r"$\gamma_a$", "1/ms", "friction of the drive", 1, "drive friction", "#D55E00"
    ),
    Parameter(
        "gamma_b",
        r"$\gamma_b$",
        "1/ms",
        "friction of the contact spring",
        1,
        "contact friction",
        "#E69F00",
    ),
    FORCE,
    GAP,
)
"""The seven parameters of the mechanism, in the order of every array."""

ONSET = Parameter(
    "onset", r"$t_0$", "ms", "start of the motion after the nominal one", colour="#7A35D0"
)
"""The eighth output, a nuisance of the measurement, inferred where the sensor has one."""

NAMES = tuple(parameter.name for parameter in PARAMETERS)
MOTIONS = ("closing", "opening")


def outputs(onset: bool) -> tuple[Parameter, ...]:
    """Return what a network infers: the seven, and the onset last where it is on."""
    return (*PARAMETERS, ONSET) if onset else PARAMETERS


def split(theta: np.ndarray) -> tuple[np.ndarray, ...]:
    """Split parameters ``(..., p)`` into seven arrays ``(...)``, in the order of ``NAMES``."""
    return tuple(np.moveaxis(theta, -1, 0))


def is_logarithmic(names: Sequence[str]) -> np.ndarray:
    """Say which outputs are judged by their logarithm, ``(q,)``: all but the onset."""
    return np.array([name != ONSET.name for name in names])


def prior_sds(
    names: Sequence[str], prior: Mapping[str, Mapping[str, float]], onset_sd: float
) -> np.ndarray:
    """Return the prior sd of each output in the scale in which it is judged, ``(q,)``; of the
    onset, ms.
    """
    return np.array([onset_sd if name == ONSET.name else prior[name]["log_sd"] for name in names])


# ---- size ----


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
