"""Forces, springs, friction and energies of a drive whose moving mass is known.

Parameters are per mass of the drive, without that of the contact. With this mass ``m`` in kg the
closing force is ``f m``, a spring ``k m``, friction ``gamma m``; to close, the force works ``f m
s`` over the stroke ``s``, and the opening spring then holds ``k_a m s^2 / 2``.
"""

from __future__ import annotations

from dataclasses import dataclass

from breaker.common.lazy_numpy import np
from breaker.quantities.parameters import FORCE, NAMES, OPENING_SPRING, PARAMETERS

_LARGEST = 1e5  # kg
_WIDEST = 1.0 / 3.0  # of the mass, that its standard deviation may be


@dataclass(frozen=True)
class MassQuantity:
    """A quantity that needs the moving mass: a parameter, of name ``of``, times mass and factor.

    Attributes:
        factor: From the parameter's unit times kg and mm to the power ``ways`` to the unit.
        ways: Power of the stroke.
    """

    name: str
    unit: str
    meaning: str
    of: str
    factor: float
    ways: int = 0


# By unit of a parameter: the unit with the mass, and the factor to it. mm/ms^2 are 1e3 m/s^2,
# 1/ms^2 are 1e6 1/s^2, 1/ms are 1e3 1/s, and mm are 1e-3 m.
_UNITS = {"mm/ms²": ("N", 1e3), "1/ms²": ("N/m", 1e6), "1/ms": ("N s/m", 1e3)}
_OTHERS = tuple(each for each in PARAMETERS if each.unit in _UNITS and each is not FORCE)
_WORK, _ENERGY = "work of the closing force over the stroke", "energy of the opening spring, closed"

MASS_QUANTITIES = (
    *(
        MassQuantity(
            each.word.replace(" ", "_"),
            _UNITS[each.unit][0],
            each.word,
            each.name,
            _UNITS[each.unit][1],
        )
        for each in (FORCE, *_OTHERS)
    ),
    MassQuantity("closing_work", "J", _WORK, FORCE.name, 1.0, 1),
    MassQuantity("opening_energy", "J", _ENERGY, OPENING_SPRING.name, 0.5e6 * 1e-6, 2),
)
"""All of them, in the order in which they are told."""


def check_mass(mass: float, sd: float) -> str | None:
    """Return why nothing moves with such a mass, kg, with a remedy; None if it may.

    Example:
        >>> check_mass(0.0, 0.5)
        'has the value 0, but a moving mass is above 0 and at most 100000 kg.'
    """
    if not 0.0 < mass <= _LARGEST:
        return f"has the value {mass:g}, but a moving mass is above 0 and at most {_LARGEST:g} kg."
    if not 0.0 <= sd <= _WIDEST * mass:
        return (
            f"has the standard deviation {sd:g}, but must have one from 0 to a third of the mass: "
            "weigh the moving parts, or leave it out."
        )
    return None


def mass_draws(mass: float, sd: float, n: int, rng: np.random.Generator) -> np.ndarray:
    """Return draws of a mass, ``(n,)``, kg: normal, and above 0."""
    return np.abs(mass + sd * rng.standard_normal(n))


def with_mass(theta: np.ndarray, stroke: float, mass: np.ndarray) -> dict[str, np.ndarray]:
    """Return draws of all quantities by name, ``(d,)``.

    Args:
        theta: Draws of the parameters, ``(d, p)``.
        stroke: Of the drive, mm.
        mass: Of the drive, kg, ``(d,)``.
    """
    return {
        each.name: each.factor * theta[:, NAMES.index(each.of)] * mass * stroke**each.ways
        for each in MASS_QUANTITIES
    }
