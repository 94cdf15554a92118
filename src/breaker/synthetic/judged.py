"""Rigs on which trends are judged: which rigs, and how they are measured.

Two families: *held back*, that of the configuration, but of other draws than those from which the
model's error is learned; and *foreign*, with elements on top that the learning family lacks. The
sensors of some rigs round, those of others have noise that is correlated from sample to sample.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from breaker.mechanism import NAMES, UNIT, Size
from breaker.model import Model, Prior, Sensor, pool
from breaker.synthetic.drive import Drive
from breaker.synthetic.family import Family

__all__ = ["READ", "Reading", "family_of", "mode_of", "record_of", "records_of"]

READ = {"closing": ("touch_time", "closing_speed"), "opening": ("part_time", "opening_speed")}
"""Quantities of each motion that are judged beside the seven parameters."""


def family_of(name: str, prior: Prior, rigs: Mapping, judged: Mapping, size: Size = UNIT) -> Family:
    """Return the family of a set.

    Args:
        name: Of the set; "foreign" has the elements of ``judged.foreign`` on top.
        rigs, judged: Sections of the configuration.
    """
    foreign = judged["foreign"] if name == "foreign" else {}
    elements = {**rigs["elements"], **foreign}
    return Family(prior, {**rigs, "elements": elements}, size)


@dataclass(frozen=True)
class Reading:
    """How a rig's sensor departs from the model's.

    Attributes:
        quantum: Step to which readings are rounded, mm; 0 where they are not.
        colour: Correlation of the noise of neighbouring samples; 0 where it is white.

    Example:
        >>> sensor = Sensor(-2.0, 58.0, 151, noise_sd=0.1, onset_sd=0.3, zero_sd=0.1)
        >>> rounded = Reading(0.5, 0.0).corrupt(np.zeros(151), sensor, np.random.default_rng(1))
        >>> np.unique(np.abs(rounded)).tolist()
        [0.0, 0.5]
    """

    quantum: float
    colour: float

    @classmethod
    def draw(cls, judged: Mapping, rng: np.random.Generator) -> "Reading":
        """Draw the sensor of a rig."""
        rounds, coloured = rng.random(2) < (judged["rounded"], judged["coloured"])
        quantum = np.exp(rng.uniform(*np.log(judged["quantum"])))
        colour = rng.uniform(*judged["colour"])
        return cls(float(rounds * quantum), float(coloured * colour))

    def corrupt(self, curve: np.ndarray, sensor: Sensor, rng: np.random.Generator) -> np.ndarray:
        """Add noise and zero of the model's sizes to a curve ``(t,)``, mm, and round."""
        innovations = rng.standard_normal(curve.shape)
        innovations[1:] *= np.sqrt(1.0 - self.colour**2)
        noise = lfilter([1.0], [1.0, -self.colour], innovations)
        read = curve + sensor.noise_sd * noise + sensor.zero_sd * rng.standard_normal()
        return self.quantum * np.round(read / self.quantum) if self.quantum else read


def record_of(
    drive: Drive, sensor: Sensor, motion: str, reading: Reading, rng: np.random.Generator
) -> np.ndarray:
    """Return the record of one operation, ``(t,)``, mm; nan if the drive does not hold closed."""
    onset = sensor.onset_sd * rng.standard_normal()
    if not drive.holds:
        return np.full(sensor.samples, np.nan)
    return reading.corrupt(drive.travel(motion, sensor.times - onset), sensor, rng)


def mode_of(model: Model, record: np.ndarray) -> np.ndarray:
    """Return the standardised parameters at a record's posterior mode, roughly, ``(p,)``."""
    motion, start = model.motion, np.zeros(len(NAMES))
    return pool({motion: model}, {motion: record[None]}, start, {motion: np.zeros(1)})


def records_of(
    drives: Sequence[Drive], models: Mapping[str, Model], reading: Reading, rng: np.random.Generator
) -> dict[str, np.ndarray]:
    """Return a record of each drive, in every motion, ``(o, t)``."""
    return {
        motion: np.stack([record_of(drive, model.sensor, motion, reading, rng) for drive in drives])
        for motion, model in models.items()
    }
