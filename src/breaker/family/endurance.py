"""Simulate an endurance test: a drive that the model does not fit wears out while a sensor records.

The endurance test of the paper is not public (paper, Sec. 7). This test has the seven parameters of
the model, with known true values, and additional effects. Its rates of wear are assumptions.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from breaker.common.randomness import generator
from breaker.family.rich_drive import Drive, Elements
from breaker.model.parameters import NAMES


@dataclass(frozen=True)
class EnduranceTest:
    """The drive of a test before its first operation; settings of its wear and sensor, from
    ``data_files.simulated_test``; and the seed of the configuration.
    """

    new: Drive
    settings: Mapping
    seed: int

    @classmethod
    def from_settings(cls, settings: Mapping, seed: int) -> "EnduranceTest":
        """Build the test from its settings.

        Raises:
            ValueError: If the drive has no closed position, new or at the end of its life.
        """
        theta = tuple(float(settings["parameters"][name]) for name in NAMES)
        test = cls(Drive(theta, Elements.from_settings(settings["effects"])), settings, seed)
        for operation in (1, test.operations):
            if not test.worn(operation, scatter=False).holds:
                raise ValueError(
                    f"at operation {operation} of the simulated test, the closing force does not "
                    "press the contact, or presses it past the dead centre; change f, k_a or L"
                )
        return test

    @property
    def operations(self) -> int:
        """Number of operations of the life."""
        return self.settings["operations"]

    def worn(self, operation: int, *, scatter: bool = True) -> Drive:
        """Return the drive at an operation, counted from 1.

        Values change linearly up to the knee, and ``faster`` times as fast after it, to the change
        at the end of life. Operations scatter around these values.
        """
        wear, life = self.settings["wear"], operation / self.operations
        knee, faster = wear["knee"], wear["faster"]
        way = min(life, knee) + faster * max(0.0, life - knee)
        share = way / (knee + faster * (1.0 - knee))
        rng = generator(self.seed, "rig wear", operation)  # these words seed the stated results
        changed = {}
        for name, change in sorted(wear["change"].items()):
            if change:
                noise = wear["scatter"] * rng.standard_normal() if scatter else 0.0
                changed[name] = self.new.value(name) * ((1.0 + change * share) * (1.0 + noise))
        return self.new.changed(**changed)

    def record(self, motion: str, operation: int) -> tuple[np.ndarray, np.ndarray]:
        """Return an operation as the sensor records it: times, ms, and travel, mm, ``(t,)``."""
        sensor = self.settings["sensor"]
        rng = generator(self.seed, "rig sensor", motion, operation)
        samples = round((sensor["lead"] + sensor["length"]) * sensor["rate"])
        times = np.arange(samples) / sensor["rate"]
        moves = sensor["lead"] + sensor["trigger_sd"] * rng.standard_normal()
        curve = self.worn(operation).travel(motion, times - moves)
        zero = sensor["zero_sd"] * rng.standard_normal()
        return times, curve + zero + sensor["noise_sd"] * rng.standard_normal(samples)


def write_curve(
    file: str | Path, time: np.ndarray, travel: np.ndarray, *, motion: str, operation: int
) -> None:
    """Write times, ms, and travel, mm, ``(t,)``, as a text file that the default format reads, with
    motion and operation in its header; the travel is zero at the open position.
    """
    above = ["travel record", f"motion: {motion}", f"operation: {operation}", "zero: open position"]
    columns = {"time": ["s", *texts(time / 1e3, 7)], "travel": ["mm", *texts(travel, 3)]}
    text = "\n".join([*above, *rows(columns, ","), ""])
    Path(file).write_text(text, encoding="utf-8")


def texts(values: np.ndarray, digits: int) -> list[str]:
    """Return numbers as text; missing numbers are blank."""
    return [f"{x:.{digits}f}" if x == x else "" for x in values.tolist()]


def rows(columns: Mapping[str, Sequence[str]], delimiter: str) -> list[str]:
    """Return the line of names and the lines of cells."""
    cells = zip(*columns.values(), strict=True)
    return [delimiter.join(columns), *(delimiter.join(row) for row in cells)]
