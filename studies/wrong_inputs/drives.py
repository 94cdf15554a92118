"""Drives of other code, their wear, and the records that an analyser makes of them."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from breaker.configuration.loading import load
from breaker.model.prior import Prior
from studies.mechanisms import drawn, simulated

UNTIL = 140.0  # ms of the reference drive that are simulated; all of them rest by then
SCATTER = {"f": 0.002, "gamma_a": 0.005}  # from operation to operation


@cache
def prior() -> Prior:
    """Return the default prior, of which drives are drawn."""
    return Prior.from_settings(load()["prior"])


@dataclass(frozen=True)
class Record:
    """One motion: ms, mm, and what is true of it."""

    motion: str
    time: np.ndarray
    travel: np.ndarray
    first: float
    contact: float
    coil: float
    truth: dict

    @property
    def step(self) -> float:
        """Return the step of the time, ms."""
        return float(self.time[1] - self.time[0])

    def reached(self, share: float) -> float:
        """Return the time at which a share of the way is first gone."""
        way = np.abs(self.travel - np.median(self.travel[self.time < self.first]))
        return float(self.time[np.argmax(way >= share * self.truth["stroke"])])

    def cut(self, begin: float, end: float) -> "Record":
        """Return the part between two times, which counts from its own begin."""
        kept = (self.time >= begin) & (self.time <= end)
        time = self.time[kept]
        return replace(self, time=time - time[0], travel=self.travel[kept])

    def changed(self, **values) -> "Record":
        """Return this record with other samples."""
        return replace(self, **values)


@dataclass(frozen=True)
class Drive:
    """A drive of the two-mass model with small mechanisms of its own, at some size."""

    drive: np.ndarray
    lengths: float
    times: float

    @classmethod
    def draw(cls, rng: np.random.Generator, stroke=None, times=None) -> "Drive":
        """Draw a medium-voltage drive, or one of a stroke (mm)."""
        drive, curves = drawn("all", prior(), rng, 0.3, UNTIL)
        natural = np.ptp(curves["closing"].travel[[0, -1]])
        stroke = rng.uniform(12.5, 14.5) if stroke is None else stroke
        return cls(drive, stroke / natural, rng.uniform(1.0, 1.5) if times is None else times)

    @classmethod
    def high(cls, rng: np.random.Generator) -> "Drive":
        """Draw a high-voltage drive."""
        return cls.draw(rng, rng.uniform(100.0, 200.0), rng.uniform(3.5, 5.0))

    def worn(self, **factors) -> "Drive":
        """Return the drive with some parameters multiplied."""
        drive = self.drive.copy()
        for name, factor in factors.items():
            drive[name] *= factor
        return replace(self, drive=drive)

    def record(self, rng: np.random.Generator, motion: str, bench: "Bench") -> Record:
        """Record one operation, with what operations differ by."""
        own = self.worn(**{n: 1.0 + sd * rng.standard_normal() for n, sd in SCATTER.items()})
        curve = simulated(own.drive, motion, UNTIL)
        after, way = curve.time * self.times, curve.travel * self.lengths
        stroke = abs(way[-1] - way[0])
        gone = np.abs(way - way[0]) / stroke
        tenth, most = (after[np.argmax(gone >= share)] for share in (0.1, 0.9))
        first = bench.lead * self.times + 0.3 * rng.standard_normal()
        time = np.arange(0.0, first + 80.0 * self.times, 1.0 / bench.rate)
        travel = np.interp(time - first, after, way)
        travel += bench.noise * stroke * rng.standard_normal(time.size)
        latch = bench.latch + 0.2 * rng.standard_normal()
        contact = first + curve.switching * self.times
        truth = {
            "stroke": stroke,
            "travel_time": most - tenth,
            f"{motion}_time": contact - first + latch,
        }
        return Record(motion, time, travel, first, contact, first - latch, truth)


@dataclass(frozen=True)
class Bench:
    """An instrument: kHz, noise as a share of the stroke, and ms of the rest and the latch."""

    rate: float
    noise: float
    lead: float
    latch: float

    @classmethod
    def draw(cls, rng: np.random.Generator) -> "Bench":
        """Draw one."""
        rate = float(rng.choice([5.0, 10.0, 10.0, 20.0, 40.0]))
        noise = float(np.exp(rng.uniform(np.log(0.001), np.log(0.007))))
        return cls(rate, noise, rng.uniform(25.0, 40.0), rng.uniform(8.0, 15.0))
