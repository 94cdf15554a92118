"""Names, symbols, units and order of what is inferred.

The only module that knows the seven parameters by name and position. Sources: paper, Sec. 3,
Eqs. (3) to (5). The paper's k_1, k_2, gamma_1, gamma_2 are k_a, k_b, gamma_a, gamma_b here.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Parameter:
    """A quantity that is inferred.

    Attributes:
        name: Name in code, configuration and stores.
        symbol: Symbol for figures, in matplotlib's mathtext.
        unit: Unit, "1" if it has none.
        meaning: What it is, in a few words.
    """

    name: str
    symbol: str
    unit: str
    meaning: str

    @property
    def label(self) -> str:
        """Symbol and unit, for an axis."""
        return self.symbol if self.unit == "1" else f"{self.symbol} ({self.unit})"


PARAMETERS = (
    Parameter("mu", r"$\mu$", "1", "mass ratio of drive to contact"),
    Parameter("k_a", r"$k_a$", "1/ms²", "opening spring on the main shaft"),
    Parameter("k_b", r"$k_b$", "1/ms²", "contact spring in the pushrod"),
    Parameter("gamma_a", r"$\gamma_a$", "1/ms", "friction of the drive"),
    Parameter("gamma_b", r"$\gamma_b$", "1/ms", "friction of the contact spring"),
    Parameter("f", r"$f$", "mm/ms²", "closing force per drive mass"),
    Parameter("L", r"$L$", "mm", "contact gap"),
)
"""The seven parameters of the mechanism, in the order of every array."""

ONSET = Parameter("onset", r"$t_0$", "ms", "start of the motion after the nominal one")
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
    """Return the prior sd of each output in the scale in which it is judged, ``(q,)``.

    Args:
        prior: The section ``prior`` of the configuration.
        onset_sd: Standard deviation of the onset, ms.
    """
    return np.array([onset_sd if name == ONSET.name else prior[name]["log_sd"] for name in names])
