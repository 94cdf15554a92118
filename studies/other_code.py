"""Drives of other code: how much intervals hold where the simulator is not that of the family.

    python -m studies.other_code --drives 80 --pairs 60 --table docs/other_code.csv

It writes the share of 95 % intervals of single operations that contain the truth, and of 90 %
intervals of changes between visits of three records of each motion.

The drives share the seven parameters with the model and nothing else: a contact carrier on a soft
stop with preload, a stiff fixed contact, Stribeck friction, a progressive main spring, a cam whose
force falls and builds up, a ripple of the transmission, an air cushion, an oil damper and Hertzian
bumpers. ``scipy.integrate.solve_ivp`` integrates them; no line of the package does.
"""

import argparse
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from breaker.common.randomness import generator
from breaker.configuration.loading import load
from breaker.diagnosis.changes import changes, compare
from breaker.family.inputs import network_record
from breaker.family.network_files import shipped_networks
from breaker.family.shape import shape_of
from breaker.model.parameters import MOTIONS, NAMES, Size
from breaker.model.prior import Prior
from breaker.model.sensor import Sensor
from tests.raws import raw_of

TIMES, LEAD = np.arange(-8.0, 58.0, 0.2), 8.0  # ms, of records that are compared
SCATTER = {"f": 0.002, "gamma_a": 0.005}  # of operations
NOISE = 0.05  # mm, of these records
WEAR = {"f": -0.08, "k_a": -0.08, "k_b": -0.2, "gamma_a": 0.2, "gamma_b": 0.2, "L": 0.08}
WALL = 12.0  # 1/ms^2, of the fixed contact
P_VALUE = 0.001


@dataclass
class Other:
    """A drive: ``theta`` as in the model, and numbers of its own, forces per drive mass."""

    theta: np.ndarray
    more: dict

    @classmethod
    def drawn(cls, prior: Prior, rng: np.random.Generator) -> "Other":
        """Draw one that closes."""
        ranges = {
            "stop": (3.0, 8.0), "stribeck": (0.0, 0.03), "slip": (0.02, 0.1), "dry": (0.0, 0.02),
            "drag": (0.0, 0.03), "progress": (-0.02, 0.02), "fall": (0.0, 0.1),
            "latch": (0.05, 0.4), "air": (0.02, 0.5), "air_power": (0.5, 1.5),
            "air_way": (1.0, 4.0), "hertz": (0.02, 0.2), "oil": (0.1, 1.5), "oil_way": (0.5, 2.0),
            "ripple": (0.0, 0.2), "preload": (0.05, 0.3),
        }  # fmt: skip
        while True:
            theta = prior.sample(1, rng)[0]
            more = {name: rng.uniform(*each) for name, each in ranges.items()}
            more["preload"] *= theta[NAMES.index("f")]
            drive = cls(theta, more)
            if drive.excess(theta[NAMES.index("L")]) > 0.02:
                return drive

    def excess(self, x: float) -> float:
        """Force that closes further where the drive rests at x."""
        _, k_a, k_b, _, _, f, gap = self.theta
        m = self.more
        springs = k_a * x * (1.0 + m["progress"] * x / 10.0) + k_b * (x - gap) + m["preload"]
        return f * (1.0 - m["fall"] * x / 10.0) - springs

    def rates(self, time, state, closing, rest):
        """Time derivatives of position and speed of drive and contact."""
        mu, k_a, k_b, gamma_a, gamma_b, f, gap = self.theta
        m, (x, v, y, w) = self.more, state
        lag, rate = x - y, v - w
        carried = k_b * lag + gamma_b * rate + m["preload"]
        if lag < 0.0:
            carried += m["stop"] * lag + 0.3 * rate
        grown = 1.0 - np.exp(-time / m["latch"])
        force = f * (1.0 - m["fall"] * x / 10.0) * (grown if closing else 1.0 - grown)
        force += 0.02 * f * m["ripple"] * np.sin(2.0 * np.pi * x / 7.0) * abs(v) / (abs(v) + 0.1)
        dry = m["dry"] + m["stribeck"] * np.exp(-abs(v) / m["slip"])
        force -= gamma_a * v + dry * np.tanh(v / 0.01) + m["drag"] * v * abs(v)
        force -= k_a * x * (1.0 + m["progress"] * x / 10.0) + carried
        way = m["air_way"]
        if x < way and v < 0.0:
            open_way = (max(x, 0.0) / way + 0.15) ** m["air_power"]
            force -= 0.3 * m["air"] * v * (1.0 - x / way) / open_way
        if x < 0.0:
            force += m["hertz"] * (-x) ** 1.5 * (1.0 - 0.3 * np.tanh(3.0 * v))
        left = rest - x
        if left < m["oil_way"] and v > 0.0:
            force -= m["oil"] * v**1.7 * (1.0 - max(left, 0.0) / m["oil_way"])
        if left < 0.0:
            force -= 0.3 * m["hertz"] * (-left) ** 1.5
        wall = WALL * (y - gap) + max(w, 0.0) if y > gap else 0.0
        return [v, force, w, mu * (carried - wall)]

    def travel(self, motion: str, times: np.ndarray) -> tuple[np.ndarray, float]:
        """Travel at times after the release, mm, and when the contact touches or parts, ms."""
        gap, preload = self.theta[NAMES.index("L")], self.more["preload"]
        rest = brentq(self.excess, gap, gap + 30.0)
        pressed = self.theta[NAMES.index("k_b")] * (rest - gap) + preload
        start = [rest, 0.0, gap + pressed / WALL, 0.0]
        if motion == "closing":
            start = [0.0, 0.0, preload / self.more["stop"], 0.0]
        found = solve_ivp(
            *(self.rates, (0.0, times[-1]), start, "LSODA"),
            **{"rtol": 1e-7, "atol": 1e-9, "max_step": 0.25, "dense_output": True},
            events=lambda time, state, *_: state[2] - gap,
            args=(motion == "closing", rest),
        )
        switches = found.t_events[0][found.t_events[0] > 1e-3]
        curve = np.where(times < 0.0, start[0], found.sol(np.maximum(times, 0.0))[0])
        return curve, float(switches[0]) if switches.size else np.nan


def levels(prior: Prior, sensor: Sensor, count: int) -> list[dict]:
    """Return which share of 95 % intervals contains the truth, one operation of each drive."""
    (network, _), held = next(shipped_networks()), defaultdict(list)
    step = float(sensor.times[1] - sensor.times[0])
    for number in range(count):
        rng = generator(1, "other code", number)
        drive, seen, switching = Other.drawn(prior, rng), {}, {}
        for motion in MOTIONS:
            late = sensor.onset_sd * rng.standard_normal()
            curve, switching[motion] = drive.travel(motion, sensor.times - late)
            record = sensor.corrupt(curve[None], rng)[0]
            shape = shape_of(record if motion == "closing" else -record, step)
            seen[motion] = network_record(shape, sensor.noise_sd, 0.0, step)
            member = network.match(motion, seen[motion]).p_value >= P_VALUE
            held[motion, "of the family"].append(member)
        for motions in (*((m,) for m in MOTIONS), MOTIONS):
            draws = network.draw({m: seen[m] for m in motions}, 2000, rng, size=Size())
            values = dict(zip(NAMES, zip(draws.theta.T, drive.theta, strict=True), strict=True))
            for m in motions:
                values[f"switching {m}"] = draws.switching[m] - draws.release[m], switching[m]
            for name, (drawn, truth) in values.items():
                low, high = np.quantile(drawn, [0.025, 0.975])
                held[" and ".join(motions), name].append(low <= truth <= high)
    return [
        {"of": "level", "drives": motions, "name": name, "count": len(each), "hold": np.mean(each)}
        for (motions, name), each in held.items()
    ]


def visit(drive: Other, count: int, rng: np.random.Generator) -> dict:
    """Records of a visit by motion."""
    found = {motion: [] for motion in MOTIONS}
    for motion, raws in found.items():
        for _ in range(count):
            theta = drive.theta.copy()
            for name, sd in SCATTER.items():
                theta[NAMES.index(name)] *= 1.0 + sd * rng.standard_normal()
            late = 0.3 * rng.standard_normal()
            way = Other(theta, drive.more).travel(motion, TIMES - late)[0]
            way = way + NOISE * rng.standard_normal(TIMES.size)
            raws.append(raw_of(way if motion == "closing" else 3.0 - way, 0.2, LEAD, motion))
    return found


def visits(prior: Prior, count: int, records: int = 3) -> list[dict]:
    """Return how well changes are known; every other drive has one or two, by up to ``WEAR``."""
    networks = [*shipped_networks()]
    rows, found = defaultdict(list), []
    for number in range(count):
        rng = generator(1, "other code, changes", number)
        drive, factors = Other.drawn(prior, rng), np.ones(len(NAMES))
        for name in rng.choice(list(WEAR), rng.integers(1, 3) * (number % 2), replace=False):
            factors[NAMES.index(name)] += WEAR[name] * rng.uniform(0.3, 1.0)
        later = Other(drive.theta * factors, drive.more)
        both = compare(visit(drive, records, rng), visit(later, records, rng), networks, rng)
        for row in changes(both):
            if row.kind == "parameter" and not row.motion:
                low, _, high = row.change
                truth = 100.0 * (factors[NAMES.index(row.name)] - 1.0)
                holds = low - 1e-9 <= truth <= high + 1e-9
                rows[number % 2, row.name].append((holds, high - low, row.verdict, truth))
    for (changed, name), each in sorted(rows.items()):
        holds, width, verdicts, truths = zip(*each, strict=True)
        told = [(truth != 0.0, word) for truth, word in zip(truths, verdicts, strict=True)]
        row = {"of": "change", "drives": "changed" if changed else "unchanged", "name": name}
        row |= {"count": len(each), "hold": np.mean(holds), "half_width": np.median(width) / 2.0}
        row |= {"truly_changed": sum(truly for truly, _ in told)}
        row |= {"reported": told.count((True, "changed")), "false": told.count((False, "changed"))}
        found.append(row)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drives", type=int, default=80)
    parser.add_argument("--pairs", type=int, default=60)
    parser.add_argument("--table", type=Path, metavar="CSV")
    options = parser.parse_args()
    config = load()
    prior, sensor = Prior.from_settings(config["prior"]), Sensor(**config["sensor"])
    rows = [*levels(prior, sensor, options.drives), *visits(prior, options.pairs)]
    table = pd.DataFrame(rows)
    print(table.to_string(index=False))
    if options.table:
        table.to_csv(options.table, index=False, float_format="%.3g")


if __name__ == "__main__":
    main()
