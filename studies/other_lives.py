"""Lives of drives of other code, by other laws of wear than trackers assume: for ``studies.lives``.

A drive of ``studies.other_code`` wears in one or two parameters and, in half of the lives, in one
of its own elements. How far it is worn, from 0 to 1, follows one of ``LAWS`` of the share of its
life. Lives last from 700 to 4,000 operations, with 400 records each. Temperature moves the friction
in one life of five, by the season, and nobody writes it down. Parameters scatter from operation to
operation by other amounts than in lives of the family.

A curve at any wear is interpolated between curves at ``LEVELS``, and what scatters is added by
differences; the truth is that of the drive without scatter, sensor and season.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.interpolate import CubicSpline

from breaker.model.parameters import MOTIONS, NAMES
from breaker.model.prior import Prior
from studies.other_code import WEAR, Other

LEVELS = np.linspace(0.0, 1.3, 14)
LENGTHS, RECORDS = (700.0, 4000.0), 400
SCATTER = {"f": 0.004, "gamma_a": 0.006, "k_a": 0.003}
OWN = {"preload": -0.3, "fall": 0.8, "dry": 1.0, "oil": -0.4}  # share by which an element wears
SEASON, YEAR = 0.02, 300.0  # share of the friction, operations
FINE = np.arange(-1.0, 66.0, 0.1)  # ms after the release


def _two_knees(u: np.ndarray) -> np.ndarray:
    return np.interp(u, [0.0, 0.4, 0.7, 1.0, 2.0], [0.0, 0.15, 0.45, 1.0, 3.0])


LAWS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "straight": lambda u: u,
    "saturating": lambda u: -np.expm1(-1.6 * u) / -np.expm1(-1.6),
    "running-in": lambda u: 0.25 * -np.expm1(-u / 0.05) + 0.75 * u,
    "steps": lambda u: 0.5 * u + 0.5 * np.floor(8.0 * u + 1e-9) / 8.0,
    "late": lambda u: np.interp(u, [0.0, 0.65, 1.0, 2.0], [0.0, 0.3, 1.0, 3.0]),
    "two knees": _two_knees,
    "accelerating": lambda u: 0.3 * u + 0.7 * u**3,
}
"""Wear by the share of the life."""


@dataclass
class OtherLife:
    """A life: the drive as new, factors on parameters and elements when worn, a law, a length."""

    drive: Other
    factors: dict[str, float]
    law: str
    length: float
    season: float

    @classmethod
    def drawn(cls, prior: Prior, rng: np.random.Generator) -> "OtherLife":
        """Draw one."""
        names = rng.choice(list(WEAR), rng.integers(1, 3), replace=False)
        factors = {str(name): WEAR[name] * rng.uniform(0.5, 1.2) for name in names}
        if rng.random() < 0.5:
            own = str(rng.choice(list(OWN)))
            factors[own] = OWN[own] * rng.uniform(0.5, 1.0)
        length = float(np.exp(rng.uniform(*np.log(LENGTHS))))
        season = SEASON * float(rng.random() < 0.2)
        law = str(rng.choice(list(LAWS)))
        return cls(Other.drawn(prior, rng), factors, law, length, season)

    @property
    def every(self) -> float:
        """Operations from one record to the next, on average."""
        return self.length / RECORDS

    @property
    def operations(self) -> np.ndarray:
        """Operations with a record: to the end of the life, so that all failures are seen."""
        return np.round(self.every * np.arange(1, RECORDS + 1)).astype(int)

    def wear(self, operation: np.ndarray) -> np.ndarray:
        """How far it is worn."""
        return LAWS[self.law](np.asarray(operation, dtype=float) / self.length)

    def reached(self, share: float) -> float:
        """Operation at which a share of the wear is reached."""
        over = np.arange(0.0, 1.3 * self.length)
        return float(over[np.argmax(self.wear(over) >= share)])

    def at(self, level: float, scale: dict[str, float] | None = None) -> Other:
        """The drive at a wear, its parameters times one and a ``scale``."""
        theta, more = self.drive.theta.copy(), dict(self.drive.more)
        for name, factor in self.factors.items():
            if name in NAMES:
                theta[NAMES.index(name)] *= 1.0 + level * factor
            else:
                more[name] *= 1.0 + level * factor
        for name, item in (scale or {}).items():
            theta[NAMES.index(name)] *= 1.0 + item
        return Other(theta, more)


class Curves:
    """Curves of a life by wear, and what a relative change of a parameter adds to them."""

    def __init__(self, life: OtherLife) -> None:
        self.way: dict[str, CubicSpline] = {}
        self.more: dict[str, dict[str, CubicSpline]] = {}
        for motion in MOTIONS:
            curves = np.array([life.at(w).travel(motion, FINE)[0] for w in LEVELS])
            self.way[motion] = CubicSpline(LEVELS, curves)
            some, self.more[motion] = LEVELS[::6], {}
            for name, sd in SCATTER.items():
                moved = [life.at(w, {name: sd}).travel(motion, FINE)[0] for w in some]
                item = (np.array(moved) - curves[::6]) / sd
                self.more[motion][name] = CubicSpline(some, item)

    def travel(
        self, motion: str, level: float, times: np.ndarray, scale: dict[str, float] | None = None
    ) -> np.ndarray:
        """Travel at times after the release, mm."""
        way = self.way[motion](level)
        for name, item in (scale or {}).items():
            way = way + item * self.more[motion][name](level)
        return np.interp(times, FINE, way)


def truth_of(
    life: OtherLife, curves: Curves, times: np.ndarray, measured: Callable
) -> pd.DataFrame:
    """Parameters, and what records show but for scatter and sensor, by operation."""
    rows = []
    over = np.linspace(0.0, 1.3 * life.length, 105)
    for operation in over[life.wear(over) <= LEVELS[-1]]:
        level = float(life.wear(operation))
        row = dict(zip(NAMES, life.at(level).theta, strict=True)) | {"operation": operation}
        for motion in MOTIONS:
            truth = measured(curves.travel(motion, level, times), motion)
            row |= {f"{motion} {name}": item.value for name, item in truth.items()}
        rows.append(row)
    return pd.DataFrame(rows).set_index("operation")


def records_of(life: OtherLife, curves: Curves, operations: np.ndarray, rng) -> dict:
    """Functions of times that give the travel of each operation, by motion."""
    records: dict[str, list] = {motion: [] for motion in MOTIONS}
    for operation in operations:
        level = float(life.wear(operation))
        scale = {name: sd * rng.standard_normal() for name, sd in SCATTER.items()}
        scale["gamma_a"] += life.season * np.sin(2.0 * np.pi * operation / YEAR)
        for motion, item in records.items():
            item.append(lambda times, m=motion, w=level, s=scale: curves.travel(m, w, times, s))
    return records
