"""Lives of drives of the independent simulator, by other laws of wear than trends assume.

A drive of ``studies.other_code`` wears in one or two parameters and, in half of the lives, in one
of its own effects. Its wear, from 0 to 1, is one of ``LAWS`` of the share of its life. Lives last
from 700 to 4,000 operations, with 400 records each. In one life of five the friction follows the
season, and the temperature is not recorded. Parameters scatter from operation to operation by other
amounts than in lives of the family.

A curve at any wear is interpolated between curves at ``LEVELS``, and scatter is added by
derivatives. True values are those of the drive without scatter, sensor and season.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
import pandas as pd
from scipy.interpolate import CubicSpline

from breaker.model.parameters import MOTIONS, NAMES
from breaker.model.prior import Prior
from studies.other_code import WEAR, Other
from studies.sensors import MEASURED, TIMES, measured

LEVELS = np.linspace(0.0, 1.3, 14)
LENGTHS, RECORDS = (700.0, 4000.0), 400
SCATTER = {"f": 0.004, "gamma_a": 0.006, "k_a": 0.003}
OWN = {"preload": -0.3, "fall": 0.8, "dry": 1.0, "oil": -0.4}  # largest wear of effects, shares
SEASON, YEAR = 0.02, 300.0  # amplitude as a share of the friction; period in operations
FINE = np.arange(-1.0, 66.0, 0.1)  # ms after the start of motion
STAGES = 105  # of a life, at which true values are computed
LAWS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "straight": lambda u: u,
    "saturating": lambda u: -np.expm1(-1.6 * u) / -np.expm1(-1.6),
    "running-in": lambda u: 0.25 * -np.expm1(-u / 0.05) + 0.75 * u,
    "steps": lambda u: 0.5 * u + 0.5 * np.floor(8.0 * u + 1e-9) / 8.0,
    "late": lambda u: np.interp(u, [0.0, 0.65, 1.0, 2.0], [0.0, 0.3, 1.0, 3.0]),
    "two changes": lambda u: np.interp(u, [0, 0.4, 0.7, 1, 2], [0, 0.15, 0.45, 1, 3]),
    "accelerating": lambda u: 0.3 * u + 0.7 * u**3,
}
"""Wear by the share of the life."""


@dataclass
class OtherLife:
    """A life: the drive as new, relative changes at full wear, law, length and season."""

    drive: Other
    factors: dict[str, float]
    law: str
    length: float
    season: float

    @classmethod
    def drawn(cls, prior: Prior, rng: np.random.Generator) -> "OtherLife":
        """Draw a life."""
        names = rng.choice(list(WEAR), rng.integers(1, 3), replace=False)
        factors = {str(name): WEAR[name] * rng.uniform(0.5, 1.2) for name in names}
        if rng.random() < 0.5:
            effect = str(rng.choice(list(OWN)))
            factors[effect] = OWN[effect] * rng.uniform(0.5, 1.0)
        length = float(np.exp(rng.uniform(*np.log(LENGTHS))))
        season = SEASON * float(rng.random() < 0.2)
        law = str(rng.choice(list(LAWS)))
        return cls(Other.drawn(prior, rng), factors, law, length, season)

    @property
    def operations(self) -> np.ndarray:
        """Operations with a record: to the end of the life, so that all failures are included."""
        return np.round(self.length / RECORDS * np.arange(1, RECORDS + 1)).astype(int)

    def wear(self, operation: np.ndarray) -> np.ndarray:
        """Return the wear of the drive."""
        return LAWS[self.law](np.asarray(operation, dtype=float) / self.length)

    def reached(self, share: float) -> float:
        """Return the operation at which a share of the wear is reached."""
        over = np.arange(0.0, LEVELS[-1] * self.length)
        return float(over[np.argmax(self.wear(over) >= share)])

    def at(self, level: float, scatter: Mapping[str, float] | None = None) -> Other:
        """Return the drive at a wear, with parameters changed by the shares in ``scatter``."""
        theta, more = self.drive.theta.copy(), dict(self.drive.more)
        for name, factor in self.factors.items():
            if name in NAMES:
                theta[NAMES.index(name)] *= 1.0 + level * factor
            else:
                more[name] *= 1.0 + level * factor
        for name, share in (scatter or {}).items():
            theta[NAMES.index(name)] *= 1.0 + share
        return Other(theta, more)

    @cached_property
    def curves(self) -> dict[str, "Curves"]:
        """Curves by motion."""
        return {motion: Curves(self, motion) for motion in MOTIONS}

    def travels(self, rng: np.random.Generator) -> dict[str, list[Callable]]:
        """Return functions of times that give the travel of each operation, by motion."""
        travels: dict[str, list] = {motion: [] for motion in MOTIONS}
        for operation in self.operations:
            level = float(self.wear(operation))
            scatter = {name: sd * rng.standard_normal() for name, sd in SCATTER.items()}
            scatter["gamma_a"] += self.season * np.sin(2.0 * np.pi * operation / YEAR)
            for motion, own in travels.items():
                own.append(partial(self.curves[motion].travel, level, scatter))
        return travels

    def truth(self) -> pd.DataFrame:
        """Return true parameters and measured quantities, without scatter, by operation."""
        over, rows = np.linspace(0.0, LEVELS[-1] * self.length, STAGES), []
        for operation in over[self.wear(over) <= LEVELS[-1]]:
            level = float(self.wear(operation))
            row = dict(zip(NAMES, self.at(level).theta, strict=True)) | {"operation": operation}
            for motion, names in MEASURED.items():
                values = measured(self.curves[motion].travel(level, {}, TIMES), motion)
                row |= {f"{motion} {q}": values[q].value if values else np.nan for q in names}
            rows.append(row)
        return pd.DataFrame(rows).set_index("operation")


class Curves:
    """Curves of a motion by wear, and their derivatives by relative changes of parameters."""

    def __init__(self, life: OtherLife, motion: str) -> None:
        curves = np.array([life.at(level).travel(motion, FINE)[0] for level in LEVELS])
        self._way, coarse, self._slopes = CubicSpline(LEVELS, curves), LEVELS[::6], {}
        for name, sd in SCATTER.items():
            moved = [life.at(level, {name: sd}).travel(motion, FINE)[0] for level in coarse]
            self._slopes[name] = CubicSpline(coarse, (np.array(moved) - curves[::6]) / sd)

    def travel(self, level: float, scatter: Mapping[str, float], times: np.ndarray) -> np.ndarray:
        """Return the travel at times after the start of motion, mm."""
        way = self._way(level)
        for name, share in scatter.items():
            way = way + share * self._slopes[name](level)
        return np.interp(times, FINE, way)
