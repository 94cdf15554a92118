"""Drives of an independent simulator: coverage of intervals.

    python -m studies.other_code --drives 40 --pairs 60 --table docs/other_code.csv

The study writes the coverage of 95 % intervals of single operations, with one additional effect or
all, and of 90 % intervals of changes between inspections of three records of each motion. Times of
the contact count from 10 % of the travel.

The drives share the seven parameters with the model and nothing else: a lever between the shaft,
whose angle the sensor reads, and the pushrod; a contact carrier on a soft stop with preload; an
elastic fixed contact; friction; a progressive main spring; a cam whose force falls and builds up; a
ripple of the transmission, an air cushion, an oil damper and Hertzian bumpers.
``scipy.integrate.solve_ivp`` integrates them; no line of the package does.
"""

import argparse
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from breaker.common.randomness import generator
from breaker.configuration.loading import load
from breaker.diagnosis.changes import Pair, compare, parameter_change
from breaker.diagnosis.estimate import Estimate, Given
from breaker.diagnosis.reading import read_operations
from breaker.diagnosis.session import Diagnosis
from breaker.family.networks import shipped_networks
from breaker.model.parameters import MOTIONS, NAMES, Size
from breaker.model.prior import Prior
from breaker.records.operations import Operation
from tests.raws import raw_of

LENGTH, RATE, LEAD = 75.0, 10.0, 8.0  # ms, kHz, ms, of records of single operations
NOISE, ONSET_SD = 0.1, 0.3  # mm and ms, of these records
SWITCHING = {"closing": "touch_from_10", "opening": "separation_from_10"}
TIMES = np.arange(-LEAD, 58.0, 0.2)  # ms, of records of inspections
SCATTER = {"f": 0.002, "gamma_a": 0.005}  # of operations of an inspection, shares
COMPARED_NOISE = 0.05  # mm, of records of inspections
WEAR = {"f": -0.08, "k_a": -0.08, "k_b": -0.2, "gamma_a": 0.2, "gamma_b": 0.2, "L": 0.08}
WALL = 12.0  # 1/ms^2, of the fixed contact
NOTHING = {"radius": 1e4, "damped": 6, "full": 0.01, "slip": 0.1, "air_way": 1, "oil_way": 1}
# Additional effects, by group: mm, ms, forces per drive mass; the preload as a share of f.
EFFECTS = {
    "none": {},
    **{f"lever of {r} mm": {"radius": (r, r)} for r in (80, 16)},
    "preload": {"preload": (0.05, 0.3), "stop": (3.0, 8.0)},
    "bounce": {"damped": (0.0, 1.0)},
    "build-up": {"latch": (0.3, 2.0)},
    **{f"friction from {v} m/s": {"dry": (0.02, 0.1), "full": (v, v)} for v in (0.02, 0.05, 0.1)},
    "all": {
        "radius": (80.0, 80.0), "stop": (3.0, 8.0), "preload": (0.05, 0.3),
        "damped": (0.0, 1.0), "dry": (0.0, 0.02), "stribeck": (0.0, 0.03),
        "slip": (0.02, 0.1), "full": (0.01, 0.1), "drag": (0.0, 0.03), "progress": (-0.02, 0.02),
        "fall": (0.0, 0.1), "latch": (0.1, 1.0), "air": (0.02, 0.5), "air_power": (0.5, 1.5),
        "air_way": (1.0, 4.0), "hertz": (0.02, 0.2), "oil": (0.1, 1.5), "oil_way": (0.5, 2.0),
        "ripple": (0.0, 0.2),
    },
}  # fmt: skip


class Curve(NamedTuple):
    """A motion without noise, from the start of motion on; ``tenth``: time of 10 % of travel."""

    time: np.ndarray
    travel: np.ndarray
    tenth: float
    switching: float


@dataclass
class Other:
    """A drive: ``theta`` as in the model, and numbers of its effects, forces per drive mass."""

    theta: np.ndarray
    more: dict

    @classmethod
    def drawn(cls, prior: Prior, rng: np.random.Generator, group: str = "all") -> "Other":
        """Draw a drive that closes."""
        while True:
            theta = prior.sample(1, rng)[0]
            more = dict.fromkeys(EFFECTS["all"], 0.0) | NOTHING
            more |= {name: rng.uniform(*effect) for name, effect in EFFECTS[group].items()}
            more["preload"] *= theta[NAMES.index("f")]
            if (drive := cls(theta, more)).excess(theta[NAMES.index("L")])[0] > 0.02:
                return drive

    def lever(self, s: float) -> tuple[float, float]:
        """Return the travel of the pushrod, and its derivative, at an arc of the shaft."""
        turn = s / self.more["radius"] - np.arcsin(6.0 / self.more["radius"])  # 0 is halfway
        return self.more["radius"] * np.sin(turn) + 6.0, np.cos(turn)

    def excess(self, s: float) -> tuple[float, float]:
        """Return the closing force on a drive at rest at s, and the depth of the contact."""
        (_, k_a, k_b, _, _, f, gap), m, (x, ratio) = self.theta, self.more, self.lever(s)
        depth = (k_b * (x - gap) + m["preload"]) / (WALL + k_b)
        spring = k_a * s * (1.0 + m["progress"] * s / 10.0)
        return f * (1.0 - m["fall"] * s / 10.0) - spring - ratio * WALL * depth, depth

    def rates(self, time, state, closing, rest):
        """Return time derivatives of position and speed of drive and contact."""
        mu, k_a, k_b, gamma_a, gamma_b, f, gap = self.theta
        m, (s, v, y, w) = self.more, state
        x, ratio = self.lever(s)
        lag, rate = x - y, ratio * v - w
        carried = k_b * lag + gamma_b * rate + m["preload"]
        carried += m["stop"] * (lag + 0.05 * rate) * (lag < 0.0)
        grown = 0.5 - 0.5 * np.cos(np.pi * min(time / max(m["latch"], 1e-9), 1.0))
        force = f * (1.0 - m["fall"] * s / 10.0) * (grown if closing else 1.0 - grown)
        force += 0.02 * f * m["ripple"] * np.sin(2.0 * np.pi * s / 7.0) * abs(v) / (abs(v) + 0.1)
        dry = m["dry"] + m["stribeck"] * np.exp(-abs(v) / m["slip"])
        force -= gamma_a * v + dry * np.clip(v / m["full"], -1.0, 1.0) + m["drag"] * v * abs(v)
        force -= k_a * s * (1.0 + m["progress"] * s / 10.0) + ratio * carried
        way, left = m["air_way"], rest - s
        if s < way and v < 0.0:
            opened = (max(s, 0.0) / way + 0.15) ** m["air_power"]
            force -= 0.3 * m["air"] * v * (1.0 - s / way) / opened
        if left < m["oil_way"] and v > 0.0:
            force -= m["oil"] * v**1.7 * (1.0 - max(left, 0.0) / m["oil_way"])
        force += m["hertz"] * max(-s, 0.0) ** 1.5 * (1.0 - 0.3 * np.tanh(3.0 * v))
        force -= 0.3 * m["hertz"] * max(-left, 0.0) ** 1.5
        wall = WALL * (y - gap) + m["damped"] * max(w, 0.0) if y > gap else 0.0
        return [v, force, w, mu * (carried - wall)]

    def travel(self, motion: str, times: np.ndarray) -> tuple[np.ndarray, float]:
        """Return travel at times after the start of motion, mm, and touch or separation, ms."""
        k_b, gap = (self.theta[NAMES.index(name)] for name in ("k_b", "L"))
        rest = brentq(lambda s: self.excess(s)[0], gap, gap + 30.0)
        start = [rest, 0.0, gap + self.excess(rest)[1], 0.0]
        if motion == "closing":
            start = [0.0, 0.0, self.more["preload"] / (self.more["stop"] + k_b), 0.0]
        result = solve_ivp(
            *(self.rates, (0.0, times[-1]), start, "LSODA"),
            **{"rtol": 1e-7, "atol": 1e-9, "max_step": 0.25, "dense_output": True},
            events=lambda time, state, *_: state[2] - gap,
            args=(motion == "closing", rest),
        )
        switches = [event for event in result.t_events[0] if event > 1e-3]
        curve = np.where(times < 0.0, start[0], result.sol(np.maximum(times, 0.0))[0])
        return curve, min(switches, default=np.nan)

    def curve(self, motion: str) -> Curve:
        """Simulate a motion, sampled densely."""
        time = np.arange(0.0, LENGTH + 2.0, 0.01)
        travel, switching = self.travel(motion, time)
        done = (travel - travel[0]) / (travel[-1] - travel[0])
        tenth = np.argmax(done > 0.1) + np.array([-1, 0])
        return Curve(time, travel, float(np.interp(0.1, done[tenth], time[tenth])), switching)


def records_of(curves: Mapping, number: int, rng: np.random.Generator, form: Mapping) -> list:
    """Write records of an operation to files, and read them like a user's files."""
    time = np.arange(0.0, LENGTH, 1.0 / RATE)
    with TemporaryDirectory() as folder:
        files = {motion: Path(folder, f"{motion}.csv") for motion in MOTIONS}
        for motion, file in files.items():
            start = LEAD + ONSET_SD * rng.standard_normal()
            travel = np.interp(time - start, curves[motion].time, curves[motion].travel)
            travel += NOISE * rng.standard_normal(time.size)
            columns = np.c_[time, np.round(travel, 5)]
            np.savetxt(file, columns, "%.5f", ",", header="time,travel", comments="")
        operations = {motion: [Operation(number + 1, file)] for motion, file in files.items()}
        return [*read_operations(operations, form | {"time_unit": "ms"})]


def judge(answers: Sequence[Estimate], theta: np.ndarray, curves: Mapping, lists: Mapping) -> None:
    """Append, by name, whether 95 % intervals contain the truth."""
    for k, answer in enumerate(answers):
        if answer.draws is None:
            continue
        motion, curve = answer.record.motion, curves[answer.record.motion]
        own = answer.draws.switching[motion], curve.switching - curve.tenth
        truths = {SWITCHING[motion]: own}
        if k == 0 or len(answer.motions) == 1:  # else both records have the same parameters
            truths |= {n: (answer.inferred(n), x) for n, x in zip(NAMES, theta, strict=True)}
        for name, (draws, truth) in truths.items():
            low, high = np.quantile(draws, [0.025, 0.975])
            lists[name].append(low <= truth <= high)


def levels(prior: Prior, config: dict, group: str, count: int) -> pd.DataFrame:
    """Return the coverage of 95 % intervals, one operation of each drive."""
    rows, diagnosis = [], Diagnosis(config, given=Given(Size()))
    for number in range(count):
        drive = Other.drawn(prior, rng := generator(1, "other code", group, number), group)
        curves = {motion: drive.curve(motion) for motion in MOTIONS}
        records = records_of(curves, number, rng, config["endurance"]["format"])
        for motions, lists in ((m, defaultdict(list)) for m in (*MOTIONS, "both")):
            answers = diagnosis.infer([r for r in records if motions in ("both", r.motion)])
            judge(answers, drive.theta, curves, lists)
            for name, values in lists.items():
                rows += [("level", group, motions, name, inside) for inside in values]
    columns = ["of", "group", "drives", "name", "holds"]
    parts = pd.DataFrame(rows, columns=columns).groupby(columns[:4], sort=False)
    return parts.agg(count=("holds", "size"), hold=("holds", "mean")).reset_index()


def inspection(drive: Other, count: int, rng: np.random.Generator) -> dict:
    """Simulate the records of an inspection, by motion."""
    result = {motion: [] for motion in MOTIONS}
    for motion in np.repeat(MOTIONS, count):
        theta = drive.theta.copy()
        for name, sd in SCATTER.items():
            theta[NAMES.index(name)] *= 1.0 + sd * rng.standard_normal()
        way = Other(theta, drive.more).travel(motion, TIMES - 0.3 * rng.standard_normal())[0]
        way = way + COMPARED_NOISE * rng.standard_normal(TIMES.size)
        result[motion].append(raw_of(way if motion == "closing" else 3.0 - way, 0.2, LEAD, motion))
    return result


def changes(prior: Prior, count: int, records: int = 3) -> pd.DataFrame:
    """Return coverage and reports of changes; every other drive has one or two, up to ``WEAR``."""
    networks, rows = [*shipped_networks()], []
    for number in range(count):
        rng = generator(1, "other code, changes", number)
        while True:
            drive, factors = Other.drawn(prior, rng), np.ones(len(NAMES))
            for name in rng.choice(list(WEAR), rng.integers(1, 3) * (number % 2), replace=False):
                factors[NAMES.index(name)] += WEAR[name] * rng.uniform(0.3, 1.0)
            later = Other(drive.theta * factors, drive.more)
            if later.excess(later.theta[NAMES.index("L")])[0] > 0.01:  # closes with scatter, too
                break
        pair = Pair.of(*(inspection(state, records, rng) for state in (drive, later)))
        both = compare(pair, networks, rng)
        key = "change", "changed" if number % 2 else "unchanged"
        for name in filter(both.draws.__contains__, NAMES):
            row = parameter_change(name, both.draws[name])
            low, _, high = row.change
            truth = 100.0 * (factors[NAMES.index(name)] - 1.0)
            inside, reported = low - 1e-9 <= truth <= high + 1e-9, row.changed
            result = truth != 0.0, reported and truth != 0.0, reported and truth == 0.0
            rows.append((*key, name, inside, *result))
    columns = ["of", "drives", "name", "hold", "truly_changed", "reported", "false"]
    parts = pd.DataFrame(rows, columns=columns).groupby(columns[:3])
    how = {"hold": "mean"} | dict.fromkeys(columns[4:], "sum")
    return parts.agg(how).assign(count=parts.size()).reset_index()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drives", type=int, default=40)
    parser.add_argument("--pairs", type=int, default=60)
    parser.add_argument("--table", type=Path, metavar="CSV")
    options, config = parser.parse_args(), load()
    prior = Prior.from_settings(config["prior"])
    parts = [levels(prior, config, group, options.drives) for group in EFFECTS]
    table = pd.concat([*parts, changes(prior, options.pairs)])
    print(table.to_string(index=False))
    if options.table:
        table.to_csv(options.table, index=False, float_format="%.3g")


if __name__ == "__main__":
    main()
