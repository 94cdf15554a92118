"""Lives of drives of the networks' family, with few records: for ``studies.lives``.

Drives wear along a straight line, half of them faster from 30 to 90 % of the life on. All that
wears scatters by 0.4 % from operation to operation. One or two records are taken at each of ten
inspections.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd

from breaker.configuration.data_files import family_of
from breaker.family.drive_family import Family
from breaker.family.rich_drive import Drive
from breaker.model.parameters import NAMES
from breaker.model.prior import Prior
from studies.sensors import MEASURED, TIMES, measured

NAME = "medium_voltage"
LIFE, INSPECTIONS, LONGER = 2000, 10, 1.3  # operations; inspections; share at which truth ends
CHANGES, FASTER = (0.3, 0.9), (3.0, 8.0)  # share of the life at which the rate changes; its factor
SCATTER = 0.004
TRIES = 100
STAGES = 53  # of a life, at which the truth is known


@dataclass
class FamilyLife:
    """A drive that wears: new, worn, and how fast.

    Attributes:
        change: Operation from which on it wears ``faster`` times as fast.
        pace: Of the wear, relative to that for which limits are set; 0 without wear.
        at_inspection: Number of records.
    """

    new: Drive
    worn: Drive
    change: float
    faster: float
    pace: float
    at_inspection: int
    length = LIFE

    @classmethod
    def drawn(cls, prior: Prior, rng: np.random.Generator, wears: bool) -> "FamilyLife":
        """Draw a life."""
        family, worn = Family(prior, family_of(NAME)), None
        while worn is None:
            new = family.new(rng)
            with suppress(RuntimeError):  # hardly any worn condition of this drive is possible
                worn = family.worn(new, rng, "sparse")
        change = LIFE * rng.uniform(*CHANGES)
        faster = float(np.exp(rng.uniform(*np.log(FASTER))))
        if rng.random() < 0.5 or not wears:
            change, faster = LIFE, 1.0
        return cls(new, worn, change, faster, float(wears), int(rng.integers(1, 3)))

    @property
    def operations(self) -> np.ndarray:
        """Operations with a record: the last ones before the end of each inspection."""
        first = LIFE // INSPECTIONS * np.arange(1, INSPECTIONS + 1) - self.at_inspection + 1
        return (first[:, None] + np.arange(self.at_inspection)).ravel()

    def reached(self, share: float) -> float:
        """Return the operation at which a share of the wear is reached."""
        way = share * (self.change + self.faster * (LIFE - self.change))
        return way if way <= self.change else self.change + (way - self.change) / self.faster

    def at(self, operation: float, noise: Mapping[str, float], pace: float) -> Drive:
        """Return the drive at an operation; its numbers times ``1 + noise``."""
        way = min(pace * operation, self.change)
        way += self.faster * max(pace * operation - self.change, 0.0)
        share = way / (self.change + self.faster * (LIFE - self.change))
        changed = {}
        for name in (*NAMES, *noise):
            new, worn = self.new.value(name), self.worn.value(name)
            changed[name] = (new + share * (worn - new)) * (1.0 + noise.get(name, 0.0))
        return self.new.changed(**changed)

    def travels(self, rng: np.random.Generator) -> dict[str, list[Callable]]:
        """Return functions of times that give the travel of each operation, by motion."""
        ranges = family_of(NAME)["wear"]["change"]
        worn = [name for name in ranges if self.new.value(name) != self.worn.value(name)]
        names, drives = sorted({*NAMES, *worn}), []
        for operation in self.operations:
            for _ in range(TRIES):
                noise = dict(zip(names, SCATTER * rng.standard_normal(len(names)), strict=True))
                drive = self.at(operation, noise, self.pace)
                if drive.holds:
                    break
            drives.append(drive)
        return {motion: [partial(drive.travel, motion) for drive in drives] for motion in MEASURED}

    def truth(self) -> pd.DataFrame:
        """Return parameters and measured quantities without noise by operation, at a pace of 1."""
        stages, rows = np.linspace(0.0, LONGER * LIFE, STAGES).round(), []
        for stage in np.unique(np.append(stages, round(self.change))):
            drive = self.at(stage, {}, 1.0)
            if not drive.holds:
                break
            row = dict(zip(NAMES, drive.theta, strict=True)) | {"operation": stage}
            for motion, quantities in MEASURED.items():
                values = measured(drive.travel(motion, TIMES), motion)
                row |= {f"{motion} {q}": values[q].value if values else np.nan for q in quantities}
            rows.append(row)
        return pd.DataFrame(rows).set_index("operation")
