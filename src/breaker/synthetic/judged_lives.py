"""Lives of rigs that the model does not fit, followed: drifts, changes, and remaining lives.

A life goes from a rig in new condition to the worn one of the family, linearly in every parameter
and element that wears, up to a change from which on all of them wear faster. Whatever wears
scatters from operation to operation.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import xarray as xr
from tqdm import tqdm

from breaker.mechanism import NAMES, Limit, evaluate
from breaker.model import Discrepancy, Model, generator
from breaker.synthetic.drive import Drive
from breaker.synthetic.family import Family
from breaker.synthetic.judged import READ, Reading, mode_of, records_of
from breaker.synthetic.lives import slope_error
from breaker.wear import Follower, Learned, Series, State

__all__ = ["FRACTIONS", "RigLife", "followers", "judge_lives"]

FRACTIONS = (0.25, 0.5, 0.75)
"""Shares of the way from the change to the end of life at which predictions are judged."""

_LONGER = 1.25  # operations that are simulated, over those of a life
_CLEAR = 5.0  # way of a quantity after the change, over its scatter, that makes a limit on it
_BEFORE = 0.9  # share of the way to the change at which drifts are judged


@dataclass(frozen=True, eq=False)
class RigLife:
    """A rig that wears.

    Attributes:
        new, worn: The rig in new condition and at the end of life.
        reading: Its sensor.
        operations: Operations of a life.
        change: Operation after which it wears faster; that of the end where it does not.
        faster: How many times.
        noise: Scatter of whatever wears, share of the value, ``(n, names)``.
    """

    new: Drive
    worn: Drive
    reading: Reading
    operations: int
    change: int
    faster: float
    noise: np.ndarray

    @classmethod
    def draw(cls, family: Family, judged: Mapping, rng: np.random.Generator) -> "RigLife":
        """Draw a life; half of them have a change."""
        new = family.new(rng)
        worn = family.worn(new, rng)
        reading, n = Reading.draw(judged, rng), judged["operations"]
        at = round(n * rng.uniform(*judged["change"]))
        faster = float(np.exp(rng.uniform(*np.log(judged["faster"]))))
        change, faster = (at, faster) if rng.random() < 0.5 else (n, 1.0)
        count = len(family.settings["wear"]["change"])
        noise = judged["scatter"] * rng.standard_normal((round(_LONGER * n), count))
        return cls(new, worn, reading, n, change, faster, noise)

    @property
    def changes(self) -> bool:
        """Whether the wear becomes faster."""
        return self.change < self.operations

    def share(self, operation: np.ndarray | float) -> np.ndarray:
        """Return the share of the wear that is over at operations, 1 at the end of life."""
        life, knee = np.asarray(operation) / self.operations, self.change / self.operations
        way = np.minimum(life, knee) + self.faster * np.maximum(life - knee, 0.0)
        return way / (knee + self.faster * (1.0 - knee))

    def condition(self, operation: int, names: Sequence[str]) -> Drive:
        """Return the rig at an operation, scatter included, if ``names`` are what may wear."""
        share, changed = float(self.share(operation)), {}
        for name, noise in zip(sorted(names), self.noise[operation - 1], strict=True):
            new, worn = self.new.value(name), self.worn.value(name)
            if new != worn:
                changed[name] = (new + share * (worn - new)) * (1.0 + noise)
        return self.new.changed(**changed)

    def theta(self, operations: np.ndarray) -> np.ndarray:
        """Return the true parameters at operations, without scatter, ``(o, p)``."""
        new, worn = np.array(self.new.theta), np.array(self.worn.theta)
        return new + self.share(operations)[:, None] * (worn - new)

    def limit(self, scatter: float, rng: np.random.Generator) -> tuple[Limit, int] | None:
        """Choose a limit that the rig reaches at the end of its life, and when its level does.

        On a parameter or quantity whose way after the change is well beyond its scatter, at its
        true value at the end of life. None where there is no such one, or where it is beyond before
        it has come a tenth of the way.
        """
        candidates = []
        ends = self.theta(np.array([self.change, self.operations]))
        around = np.vstack([ends, ends[0] * (1.0 + scatter * np.eye(len(NAMES)))])
        for motion, quantities in READ.items():
            every = (*NAMES, *quantities) if motion == "closing" else quantities
            values = evaluate(every, around, motion)
            spread = np.sqrt(np.square(values[2:] - values[0]).sum(axis=0))
            clear = np.abs(values[1] - values[0]) > _CLEAR * spread
            candidates += [(motion, every[k], *values[:2, k]) for k in np.flatnonzero(clear)]
        if not candidates or not self.changes:
            return None
        motion, quantity, begin, end = candidates[rng.integers(len(candidates))]
        limit = Limit("end_of_life", motion, ((quantity, float(end), bool(end > begin)),))
        over = limit.exceeded(limit.evaluate(self.theta(np.arange(1, len(self.noise) + 1))))
        first = int(np.argmax(over)) + 1
        enough = over.any() and first > self.change + 0.1 * (self.operations - self.change)
        return (limit, first) if enough else None


def judge_lives(
    name: str,
    family: Family,
    models: Mapping[str, Model],
    learned: xr.Dataset,
    numbers: Sequence[int],
    judged: Mapping,
    wear_model: Mapping,
) -> pd.DataFrame:
    """Follow lives of rigs, at every scale, and keep what is inferred beside the truth.

    Args:
        models: Model of each motion, without an error of its own.
        judged, wear_model: Sections of the configuration.

    Returns:
        Rows of one ``score`` each: "level" and "slope" (percent per thousand operations) of every
        parameter; "remaining" at ``FRACTIONS`` of the way; "alarm" and "step" with their
        ``operation``; and "life", one per followed source. ``change``, ``faster`` and ``ratio``
        are those of the life.
    """
    rows = []
    for number in tqdm(numbers, desc=f"lives {name}", mininterval=5, unit="life"):
        rng = generator(judged["seed"], "judged life", name, int(number))
        life = RigLife.draw(family, judged, rng)
        worn = family.settings["wear"]["change"]
        limit = life.limit(judged["scatter"], rng)
        operations = np.arange(judged["every"], life.operations + 1, judged["every"])
        drives = [life.condition(operation, worn) for operation in operations]
        records = records_of(drives, models, life.reading, rng)
        begins = {"set": name, "life": number, "change": life.change, "faster": life.faster}
        begins["ratio"] = ratio_of(life, models, judged)
        for scale in judged["scales"]:
            start = operations, records, models, learned, scale, wear_model, judged["seed"]
            for source, follower, state, series in followers(*start):
                found = _follow(follower, state, series, life, limit)
                kept = begins | {"scale": scale, "source": source}
                rows += [kept | each for each in found]
    return pd.DataFrame(rows)


def ratio_of(life: RigLife, models: Mapping[str, Model], judged: Mapping) -> float:
    """Return the largest change of a parameter's slope over its standard error; nan without one.

    The error is that of an observer who knows the model to be right (``lives.slope_error``), so a
    ratio of 5 is a clear change in a drive of the model.
    """
    if not life.changes:
        return np.nan
    prior = next(iter(models.values())).prior
    every = judged["every"]
    z = prior.standardise(life.theta(life.change + every * np.array([-1.0, 0.0, 1.0])))
    bend = np.abs(np.diff(z, n=2, axis=0)[0]) / (every / 1000.0)
    worn = np.not_equal(life.new.theta, life.worn.theta)
    scatter = judged["scatter"] / prior.log_sds * worn
    return float((bend / slope_error(models, z[1], scatter, life.change, judged)).max())


def followers(
    operations: np.ndarray,
    records: Mapping[str, np.ndarray],
    models: Mapping[str, Model],
    learned: xr.Dataset,
    scale: float,
    wear_model: Mapping,
    seed: int,
) -> Iterator[tuple[str, Follower, State, Series]]:
    """Yield what follows a rig, its state before the first operation, and the series, by source.

    Both motions together where they agree, else each of them. Modes are searched from the mode of
    the first record.
    """
    outputs = {}
    for motion, model in models.items():
        left_out = Discrepancy.from_dataset(learned.sel(motion=motion)).scaled(scale)
        there = np.isfinite(records[motion]).any(axis=1)
        mode = mode_of(model.leaving_out(left_out), records[motion][there.argmax()])
        start = np.append(mode, 0.0)[: len(model.names)]
        outputs[motion] = np.tile(start, (len(operations), 1))
    series = Series(operations, records, outputs)
    sources = {"both": list(models)} | {motion: [motion] for motion in models}
    for source, motions in sources.items():
        known = None
        if scale:
            sds = {"rough_sd": wear_model["rough_sd"]}
            sds["noise_sd"] = models[motions[0]].sensor.noise_sd
            known = Learned.from_dataset(learned, motions, scale, **sds)
        some = {motion: models[motion] for motion in motions}
        follower = Follower.from_settings(some, [], wear_model, seed, known)
        state = follower.begin(series)
        if follower.together(state):
            yield source, follower, state, series
            if source == "both":
                return


def _follow(
    follower: Follower, state: State, series: Series, life: RigLife, limit: tuple[Limit, int] | None
) -> Iterator[dict]:
    """Yield the rows of one life and source."""
    usable = {motion: series.usable(motion) for motion in follower.models}
    mark = _nearest(series, _BEFORE * life.change if life.changes else life.operations)
    marks = {}
    if limit is not None:
        way = life.change + np.array(FRACTIONS) * (limit[1] - life.change)
        marks = {_nearest(series, o): share for o, share in zip(way, FRACTIONS, strict=True)}
    yield {"score": "life"}
    for i, operation in enumerate(series.operations):
        limits = [limit[0]] if i in marks else []
        state, row, _ = replace(follower, limits=limits).step(state, series, i, usable)
        for event in ("alarm", "step"):
            if row[event][1]:
                yield {"score": event, "operation": operation}
        if i == mark:
            yield from _levels(row, life, operation, series.operations[0])
        if i in marks:
            ends = dict(zip(("lower", "median", "upper"), row["remaining"][1][0], strict=True))
            truth = {"name": f"{marks[i]:g}", "truth": limit[1] - operation}
            yield {"score": "remaining", "operation": operation} | truth | ends


def _levels(row: Mapping, life: RigLife, operation: int, every: int) -> Iterator[dict]:
    """Yield level and slope of each parameter at an operation beside the true ones."""
    before, now = life.theta(np.array([operation - every, operation]))
    slopes = 100.0 * np.log(now / before) / (every / 1000.0)
    for score, truth in (("level", now), ("slope", slopes)):
        places, ends = row[score][1], row[f"{score}_interval"][1]
        for k, name in enumerate(NAMES):
            lower, upper = ends[k]
            values = {"truth": truth[k], "lower": lower, "median": places[k], "upper": upper}
            yield {"score": score, "name": name, "operation": operation} | values


def _nearest(series: Series, operation: float) -> int:
    """Index of the record nearest to an operation."""
    return int(np.abs(series.operations - operation).argmin())
