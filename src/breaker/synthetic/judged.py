"""Rigs on which posteriors and trends are judged: which rigs, how they are measured, one record.

Two families: *held back*, that of the configuration, but of other draws than those from which the
model's error is learned; and *foreign*, with elements on top that the learning family lacks. The
sensors of some rigs round, those of others have noise that is correlated from sample to sample.
"""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.signal import lfilter
from tqdm import tqdm

from breaker.mechanism import NAMES, UNIT, Size, evaluate
from breaker.model import Discrepancy, Model, Prior, Sensor, generator, information, pool
from breaker.posterior import correct, predictive_p_value
from breaker.synthetic.drive import Drive
from breaker.synthetic.family import Family

__all__ = ["READ", "Reading", "family_of", "judge_records", "mode_of", "record_of", "records_of"]

READ = {"closing": ("touch_time", "closing_speed"), "opening": ("part_time", "opening_speed")}
"""Quantities of each motion that are judged beside the seven parameters."""

_DRAWS = 500  # of each posterior
_WIDER = 1.5  # factor on the covariance of the draws that a correction starts from
_ENDS = (0.05, 0.5, 0.95)


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


def judge_records(
    name: str,
    family: Family,
    models: Mapping[str, Model],
    left_out: Mapping[str, Discrepancy],
    numbers: Sequence[int],
    judged: Mapping,
    correction: Mapping,
) -> pd.DataFrame:
    """Infer one record per motion of rigs exactly, and keep intervals beside the truth.

    Args:
        models: Model of each motion, without an error of its own.
        left_out: What each leaves out, at scale 1.
        numbers: Numbers of the rigs; each has a generator of its own.
        judged, correction: Sections of the configuration.

    Returns:
        A row per rig, motion, scale and quantity: ``truth``, 90 % interval (``lower``, ``upper``),
        ``median``, whether the posterior is ``resolved``, and the record's ``p_value``.
    """
    rows = []
    for number in tqdm(numbers, desc=f"rigs {name}", mininterval=5, unit="rig"):
        rng = generator(judged["seed"], "judged record", name, int(number))
        drive, reading = family.new(rng), Reading.draw(judged, rng)
        for motion, model in models.items():
            record = record_of(drive, model.sensor, motion, reading, rng)
            for scale in judged["scales"]:
                known = model.leaving_out(left_out[motion].scaled(scale))
                found = _infer(known, record, np.array(drive.theta), correction, rng)
                begins = {"set": name, "rig": number, "motion": motion, "scale": scale}
                rows += [begins | each for each in found]
    return pd.DataFrame(rows)


def _infer(
    model: Model,
    record: np.ndarray,
    theta: np.ndarray,
    correction: Mapping,
    rng: np.random.Generator,
) -> list[dict]:
    """Intervals of one record's exact posterior beside the true parameters ``(p,)``."""
    found, p, motion = None, len(NAMES), model.motion
    try:
        found = correct(model, record, _normal_draws(model, record, rng), correction, rng)
    except ValueError as error:  # so unlike the model that it leads to what cannot be simulated
        logging.getLogger("breaker").warning("%s: unresolved: %s", motion, error)
    resolved = found is not None and found.resolved
    p_value, ends = np.nan, np.full((3, p + len(READ[motion])), np.nan)
    if resolved:
        draws = found.draws[:, :p]
        p_value = predictive_p_value(model, record, found.draws)
        values = np.column_stack([draws, evaluate(READ[motion], draws, motion)])
        ends = np.nanquantile(values, _ENDS, axis=0)
    truth = np.append(theta, evaluate(READ[motion], theta[None], motion))
    names, common = (*NAMES, *READ[motion]), {"resolved": resolved, "p_value": p_value}
    return [
        {"quantity": name, "truth": true, "lower": low, "median": middle, "upper": high} | common
        for name, true, low, middle, high in zip(names, truth, *ends, strict=True)
    ]


def _normal_draws(model: Model, record: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Draws of the normal approximation of a posterior, widened, ``(d, q)``, physical units."""
    mode = mode_of(model, record)
    there = information(model, record[None], mode[None], np.zeros(1))
    cov = _WIDER * np.linalg.inv(np.eye(len(mode)) + there.matrix[0])
    draws = rng.multivariate_normal(mode, cov, _DRAWS)
    onsets = there.onset + 0.7 * rng.standard_normal(_DRAWS)
    return model.destandardise(np.column_stack([draws, onsets])[:, : len(model.names)])
