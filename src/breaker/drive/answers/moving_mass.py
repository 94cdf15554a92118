"""Quantities in newtons and joules, which need the moving mass of the drive."""

from dataclasses import dataclass

import numpy as np

from breaker.model.parameters import NAMES


@dataclass(frozen=True)
class MassQuantity:
    """A quantity that needs the moving mass: factor * parameter * mass * stroke^power.

    Attributes:
        of: Name of the parameter.
        factor: From the units of parameter, kg and mm to ``unit``.
        power: Power of the stroke.
    """

    name: str
    unit: str
    meaning: str
    of: str
    factor: float
    power: int = 0


MASS_QUANTITIES = (
    MassQuantity("closing_force", "N", "closing force", "f", 1e3),
    MassQuantity("opening_spring", "N/m", "opening spring", "k_a", 1e6),
    MassQuantity("contact_spring", "N/m", "contact spring", "k_b", 1e6),
    MassQuantity("drive_friction", "N s/m", "drive damping", "gamma_a", 1e3),
    MassQuantity("contact_friction", "N s/m", "contact damping", "gamma_b", 1e3),
    MassQuantity("closing_work", "J", "work of the closing force over the stroke", "f", 1.0, 1),
    MassQuantity("opening_energy", "J", "energy of the opening spring, closed", "k_a", 0.5, 2),
)
"""All quantities that need the moving mass."""


def mass_draws(mass: float, sd: float, n: int, rng: np.random.Generator) -> np.ndarray:
    """Return normal draws of a mass, ``(n,)``, kg, positive."""
    return np.abs(mass + sd * rng.standard_normal(n))


def with_mass(theta: np.ndarray, stroke: float, mass: np.ndarray) -> dict[str, np.ndarray]:
    """Return ``MASS_QUANTITIES`` by name, ``(d,)``, of draws of parameters ``(d, p)`` and of a
    mass ``(d,)``, kg, with a stroke in mm.
    """
    return {
        each.name: each.factor * theta[:, NAMES.index(each.of)] * mass * stroke**each.power
        for each in MASS_QUANTITIES
    }
