"""A synthetic endurance test: a drive that the model does not fit, wearing out.

Stands in for the paper's endurance test, which is not public (paper, Sec. 7). It has the seven
parameters of the model, which are the truth, and what the model lacks on top. It wears out, has a
sensor of its own and writes CSV files. Its rates of wear are assumptions.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tqdm import tqdm

from breaker.common.randomness import generator
from breaker.family.export import write_curve
from breaker.family.rich_drive import Drive, Elements
from breaker.model.parameters import NAMES


@dataclass(frozen=True)
class Rig:
    """The rig, its wear and its sensor; ``settings`` is what
    ``definitions.simulated_test`` returns, ``seed`` that of the configuration.
    """

    new: Drive
    settings: Mapping
    seed: int

    @classmethod
    def from_settings(cls, settings: Mapping, seed: int) -> "Rig":
        """Build the rig from what ``definitions.simulated_test`` returns.

        Raises:
            ValueError: If the drive has no closed position, new or at the end of its life.
        """
        theta = tuple(float(settings["parameters"][name]) for name in NAMES)
        rig = cls(Drive(theta, Elements.from_settings(settings["effects"])), settings, seed)
        for operation in (1, settings["operations"]):
            if not rig.worn(operation, scatter=False).holds:
                raise ValueError(
                    f"at operation {operation} of the simulated test, the closing force does not "
                    "press the contact, or presses it past the dead centre; change f, k_a or L"
                )
        return rig

    def worn(self, operation: int, *, scatter: bool = True) -> Drive:
        """Return the drive at an operation, counted from 1.

        Each parameter and element that wears changes linearly up to the knee, and ``faster`` times
        as fast after it, to its change at the end of life. Operations scatter around that.
        """
        wear = self.settings["wear"]
        life = operation / self.settings["operations"]
        knee, faster = wear["knee"], wear["faster"]
        way = min(life, knee) + faster * max(0.0, life - knee)
        share = way / (knee + faster * (1.0 - knee))
        rng = generator(self.seed, "rig wear", operation)
        changed = {}
        for name, change in sorted(wear["change"].items()):
            if change:
                noise = wear["scatter"] * rng.standard_normal() if scatter else 0.0
                changed[name] = self.new.value(name) * ((1.0 + change * share) * (1.0 + noise))
        return self.new.changed(**changed)

    def record(self, motion: str, operation: int) -> tuple[np.ndarray, np.ndarray]:
        """Return an operation as the rig's sensor records it: times, ms, and travel, mm."""
        sensor = self.settings["sensor"]
        rng = generator(self.seed, "rig sensor", motion, operation)
        samples = round((sensor["lead"] + sensor["length"]) * sensor["rate"])
        times = np.arange(samples) / sensor["rate"]
        moves = sensor["lead"] + sensor["trigger_sd"] * rng.standard_normal()
        curve = self.worn(operation).travel(motion, times - moves)
        zero = sensor["zero_sd"] * rng.standard_normal()
        return times, curve + zero + sensor["noise_sd"] * rng.standard_normal(samples)

    def run(self, motion: str, folder: str | Path) -> None:
        """Write the curve files of all operations of one motion."""
        Path(folder).mkdir(parents=True, exist_ok=True)
        operations = range(1, self.settings["operations"] + 1)
        for operation in tqdm(operations, desc=f"rig {motion}", mininterval=5, unit="operation"):
            times, curve = self.record(motion, operation)
            file = Path(folder, f"{motion}_{operation:05d}.csv")
            write_curve(file, times, curve, motion=motion, operation=operation)
