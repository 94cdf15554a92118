"""One mechanism at a time that the model lacks: which answers hold, and which do not.

    python -m studies.mechanisms none build-up drag --drives 40 --strength 1 --rows rows.csv
    python -m studies.mechanisms all --length 75 --lead 8 --rate 10 --motions both --seed 1

Drives are the model's two masses and springs with parameters of the default prior, and on top of
it one mechanism (of ``MECHANISMS``), or ``all``. Each has three laws or more; a drive has one of
them by chance, with sizes by chance, which ``--strength`` multiplies. The simulator, fixed steps
of Runge and Kutta, is the study's own, without a line of the package. Records (length and lead in
ms, rate in kHz, ``--quantum`` in mm) are files, read and inferred as a user's are, the size known;
with ``--contact SD`` beside the times of their contacts, known to so many ms. ``--wipe`` is the
least wipe of a drive as a share of its way: strong preloads leave many a drive next to none.

It prints for closing alone, opening alone and both how many 95 % intervals hold the truth, the mean
error of the median and the median half width (% of parameters, ms of times), and how the records
fit the families. Times of touch and separation count from 10 % of the way, or from the release.
"""

import argparse
from collections import ChainMap, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import brentq

from breaker.common.computing import compiled
from breaker.common.randomness import generator
from breaker.configuration.loading import load
from breaker.diagnosis.estimate import Estimate, Given
from breaker.diagnosis.reading import read_operations
from breaker.diagnosis.session import Diagnosis
from breaker.model.parameters import MOTIONS, NAMES, Size
from breaker.model.prior import Prior
from breaker.model.quantities import AFTER_RELEASE
from breaker.records.contacts import ContactTimes
from breaker.records.operations import Operation

NOISE, TRIGGER = 0.1, 0.3  # mm and ms, sd of a sample and of the release
TIMES = ("touch_from_10", "separation_from_10", "touch_from_release", "separation_from_release")
MOTIONS_SHOWN = (*MOTIONS, "both")
OPTIONS = dict(
    drives=40,
    strength=1.0,
    length=75.0,
    lead=8.0,
    rate=10.0,
    quantum=0.0,
    contact=0.0,
    wipe=0.0,
    seed=1,
)
TITLES = {
    "held": "Share of 95 % intervals that hold the truth",
    "error": "Mean error of the median (% of parameters, ms of times)",
    "width": "Median half width of 95 % intervals (%, ms)",
}

# Of a mechanism: fields with their number of laws; sizes, which the strength multiplies; the rest.
# fmt: off
MECHANISMS = {
    "none": ({}, {}, {}),
    # Exponential, ramp, half a cosine, logistic, delayed exponential, overshoot; constants in ms.
    "build-up": (
        {"rise_form": 6, "fall_form": 6}, {"rise": (0.05, 0.8), "fall": (0.05, 0.8)},
        {"wait": (0.3, 1.0), "ring": (0.3, 0.7)},
    ),
    # Share of the closing force; a rigid stop, a soft one (1/ms^2), a Hertzian one.
    "preload": ({"stop_form": 3}, {"preload": (0.05, 0.3)}, {"soft": (2, 10), "hertz": (5, 40)}),
    # |v|^1.5, v^2, v^2 that grows in the last third of the way; mm/ms^2 at 1 mm/ms.
    "drag": ({"drag_form": 3}, {"drag": (0.01, 0.05)}, {}),
    # Coulomb, Stribeck, with the load of the springs; mm/ms^2.
    "friction": ({"dry_form": 3}, {"dry": (0.005, 0.03)}, {"slip": (0.05, 0.3)}),
    # Linear, square, an orifice that closes; size beside ``_DAMPS``, reach in mm, dead share of it.
    "closing damper": (
        {"shut_form": 3}, {"shut": (0.2, 1.0)}, {"shut_way": (0.3, 2.5), "shut_dead": (0.0, 0.3)},
    ),
    "opening damper": (
        {"open_form": 3}, {"open": (0.2, 1.0)}, {"open_way": (0.5, 5.0), "open_dead": (0.0, 0.3)},
    ),
    # Stiffness of the main spring over the stroke, that of the contact spring, hysteresis.
    "springs": ({"spring_form": 3}, {"bend": (-0.1, 0.1)}, {}),
    # Along the way linearly, as half a cosine, in its last third.
    "falling force": ({"sink_form": 3}, {"sink": (0.03, 0.15)}, {}),
    # Mass and friction of a closing: all along, geared out along the way, until the first return.
    "train": ({"train_form": 3}, {"train": (0.03, 0.15), "rub": (0.0, 0.15)}, {}),
    # Travel beside the shaft: quadratic, half a sine, a full one; greatest deviation of the ratio.
    "lever": ({"lever_form": 3}, {"lever": (-0.1, 0.1)}, {}),
    # Linear, hardening, with play; period in ms.
    "linkage": ({"link_form": 3}, {"period": (0.4, 2)}, {"link": (0.02, 0.1), "play": (0, 0.05)}),
    # Elastic with some damping, well damped, Hertzian; how far it gives, mm at 1 mm/ms^2.
    "contact": ({"wall_form": 3}, {"give": (0.03, 0.12)}, {"loss": (0.0, 1.0)}),
}
# fmt: on
_ALL = [dict(ChainMap(*parts)) for parts in zip(*MECHANISMS.values(), strict=True)]
MECHANISMS["all"] = _ALL
# Preloaded stops that give, by their stiffness in 1/ms^2: between a rigid stop and none at all.
STOPS = {
    f"stop of {low:g} to {high:g}": (
        {},
        {"preload": (0.05, 0.3)},
        {"stop_form": (2, 2), "soft": (low, high)},
    )
    for low, high in ((0.2, 1), (1, 10), (10, 100))
}
_VALUES = (*NAMES, "reach", "wipe", *_ALL[1], *_ALL[2])
DRIVE = np.dtype([*((name, "f8") for name in _VALUES), *((name, "i8") for name in _ALL[0])])
"""A drive: the parameters, the model's stroke and wipe, and its laws; a form of 0 is none."""

STEP = 0.01  # ms
_DAMPS = (0.5, 0.5, 1.0), (0.25, 0.6, 1.5)  # closing and opening damper by law, 1/ms or 1/mm
_RIGID, _RUNS = 400.0, 0.002  # 1/ms^2 of a rigid stop; mm/ms from which dry friction is full
_fast = compiled()  # also where nothing can be written


@_fast
def _growth(form, constant, time, wait, ring):
    """Share of a force that has built up at a time after its release."""
    if form == 0 or constant <= 0.0:
        return 1.0
    t = max(time / constant - (wait if form == 5 else 0.0), 0.0)
    start, turn = 1.0 / (1.0 + np.exp(4.0)), np.sqrt(1.0 / ring**2 - 1.0)
    laws = (
        1.0 - np.exp(-t),
        min(t / 2.0, 1.0),
        0.5 - 0.5 * np.cos(np.pi * min(t / 2.5, 1.0)),
        (1.0 / (1.0 + np.exp(4.0 - 2.0 * t)) - start) / (1.0 - start),
        1.0 - np.exp(-t),
        1.0 - np.exp(-t) * (np.cos(turn * t) + np.sin(turn * t) / turn),
    )
    return laws[form - 1]


@_fast
def _drives(d, x, v, share):
    """A share of the closing force less that of the opening spring."""
    way = min(max(x / d.reach, 0.0), 1.0)
    sinks = (0.0, way, 0.5 - 0.5 * np.cos(np.pi * way), max(3.0 * way - 2.0, 0.0))
    bend = 0.5 * d.bend * (x / d.reach - 1.0) if d.spring_form == 1 else 0.0
    if d.spring_form == 3:
        bend = 0.5 * abs(d.bend) * np.tanh(v / 0.02)
    return d.f * share * (1.0 - d.sink * sinks[d.sink_form]) - d.k_a * x * (1.0 + bend)


@_fast
def _carried(d, lag, rate):
    """Force of the carrier on the contact, that of the stop included."""
    bend = 0.5 * d.bend if d.spring_form == 2 else 0.0
    stiffness = d.k_b * (1.0 + bend * (min(max(lag / d.wipe, 0.0), 2.0) - 1.0))
    force = d.preload * d.f + stiffness * lag + d.gamma_b * rate
    if d.stop_form > 0 and lag < 0.0:
        stop = (_RIGID, d.soft, d.hertz * np.sqrt(-lag))[d.stop_form - 1]
        force -= max(-stop * lag - np.sqrt(stop / (1.0 + d.mu)) * rate, 0.0)
    return force


@_fast
def _wall(d, depth, speed):
    """Force of an elastic fixed contact; below 0 where the contact does not touch it."""
    if depth <= 0.0:
        return depth / d.give
    if d.wall_form == 3:
        return depth**1.5 / d.give * (1.0 + (1.0 + d.loss) * speed)
    share = 0.35 + 0.15 * d.loss if d.wall_form == 1 else 0.6 + 0.4 * d.loss
    return depth / d.give + 2.0 * share * speed / np.sqrt(d.give * d.mu)


@_fast
def _damper(form, size, sizes, depth, dead, speed):
    """Force of a damper that a drive enters at a speed, at a depth as a share of its reach."""
    share = min((depth - dead) / (1.0 - dead), 1.0)
    if form == 0 or share <= 0.0 or speed <= 0.0:
        return 0.0
    laws = (share * speed, share * speed**2, 0.15 / (1.15 - share) * speed**2)
    return size * sizes[form - 1] * laws[form - 1]


@_fast
def _resists(d, x, v, lag, closing, rest):
    """Drag, dry friction and dampers."""
    way = min(max(x / d.reach, 0.0), 1.0)
    last = max(3.0 * (way if closing else 1.0 - way) - 2.0, 0.0)
    share = 0.25 + 0.75 * last if d.drag_form == 3 else 1.0
    force = d.drag * share * v * abs(v) ** (0.5 if d.drag_form == 1 else 1.0)
    load = min((d.k_a * abs(x) + d.k_b * abs(lag)) / d.f, 1.5)
    slips = 0.5 + 0.5 * np.exp(-abs(v) / d.slip) if d.dry_form == 2 else 1.0
    force += d.dry * (load if d.dry_form == 3 else slips) * np.tanh(v / _RUNS)
    shut, opened = 1.0 + (x - rest) / d.shut_way, 1.0 - x / d.open_way
    force += _damper(d.shut_form, d.shut, _DAMPS[0], shut, d.shut_dead, v)
    return force - _damper(d.open_form, d.open, _DAMPS[1], opened, d.open_dead, -v)


@_fast
def _slopes(time, state, touches, d, closing, rest, out):
    """Time derivatives of position and speed of drive, contact and transducer."""
    x, v, y, w, z, u = state[0], state[1], state[2], state[3], state[4], state[5]
    share = _growth(d.rise_form, d.rise, time, d.wait, d.ring)
    if not closing:
        share = max(1.0 - _growth(d.fall_form, d.fall, time, d.wait, d.ring), 0.0)
    carried = _carried(d, x - y, v - w)
    force = _drives(d, x, v, share) - carried - _resists(d, x, v, x - y, closing, rest)
    gears = 1.0 if closing and (d.train_form < 3 or v > 0.0) else 0.0
    if closing and d.train_form == 2:
        way = np.pi * min(max(x / d.reach, 0.0), 1.0)
        gears = 0.5 + 0.5 * np.cos(way)
        force += 0.25 * d.train * np.pi / d.reach * np.sin(way) * v**2
    force -= d.gamma_a * (1.0 + d.rub * gears) * v
    out[0], out[1], out[2], out[3] = v, force / (1.0 + d.train * gears), w, 0.0
    if d.wall_form > 0 or not touches:
        wall = max(_wall(d, y - d.L, w), 0.0) if d.wall_form > 0 and y > d.L else 0.0
        out[3] = d.mu * (carried - wall)
    out[4], out[5] = u, 0.0
    if d.link_form > 0:
        stretch, turn = x - z, 2.0 * np.pi / d.period
        free = min(max(stretch, -0.5 * d.play), 0.5 * d.play)
        laws = (stretch, stretch + stretch**3 / 0.05**2, stretch - free)
        out[5] = turn**2 * laws[d.link_form - 1] + 2.0 * d.link * turn * (v - u)


@_fast
def _stepped(time, h, state, *more):
    """The state after a step of Runge and Kutta."""
    k = np.empty((4, 6))
    _slopes(time, state, *more, k[0])
    _slopes(time + 0.5 * h, state + 0.5 * h * k[0], *more, k[1])
    _slopes(time + 0.5 * h, state + 0.5 * h * k[1], *more, k[2])
    _slopes(time + h, state + h * k[2], *more, k[3])
    return state + h / 6.0 * (k[0] + 2.0 * k[1] + 2.0 * k[2] + k[3])


@_fast
def _past(state, touches, d):
    """Above 0 where the contact has gone through the fixed one, or this would have to pull."""
    depth = state[2] - d.L
    if touches and d.wall_form > 0:
        return -_wall(d, depth, state[3])
    return -_carried(d, state[0] - state[2], state[1] - state[3]) if touches else depth


@_fast
def _integrate(drives, closing, rest, state, travel):
    """Fill the travel of each step; return when the contact touches or parts, inf if never."""
    d, found, touches = drives[0], np.inf, not closing
    for step in range(travel.size):
        travel[step] = state[4] if d.link_form > 0 else state[0]
        time, left = step * STEP, STEP
        for switches in range(8):
            after = _stepped(time, left, state, touches, d, closing, rest)
            if switches == 7 or not _past(after, touches, d) > 1e-10:
                break
            low, high = 0.0, left
            for _ in range(40 if _past(state, touches, d) < 0.0 else 0):  # bisect the switching
                middle = 0.5 * (low + high)
                tried = _stepped(time, middle, state, touches, d, closing, rest)
                past = _past(tried, touches, d) > 0.0
                low, high = (low, middle) if past else (middle, high)
            state = _stepped(time, low, state, touches, d, closing, rest)
            touches, time, left = not touches, time + low, left - low
            if touches == closing and found == np.inf:
                found = time
            if d.wall_form == 0:  # rigid, and it takes all of the speed
                state[2], state[3] = d.L, 0.0
        state = after
    return found


class Curve(NamedTuple):
    """A motion without noise; times are after the release, ``tenth`` that of 10 % of the way."""

    time: np.ndarray
    travel: np.ndarray
    tenth: float
    switching: float


def closed(drive: np.ndarray) -> tuple[float, float]:
    """Return where drive and contact rest if closed, mm; nan of a drive that does not close."""
    d, gap = drive[0], float(drive["L"][0])

    def contact(x: float) -> float:
        left = lambda y: _carried(d, x - y, 0.0) - _wall(d, y - gap, 0.0)  # noqa: E731
        return brentq(left, gap, x + 1.0) if d["wall_form"] else gap

    def excess(x: float) -> float:
        return _drives(d, x, 0.0, 1.0) - _carried(d, x - contact(x), 0.0)

    if excess(gap) <= 0.0:
        return np.nan, np.nan
    rest = brentq(excess, gap, gap + 30.0)
    return rest, contact(rest)


def simulated(drive: np.ndarray, motion: str, until: float) -> Curve:
    """Simulate a drive, ``(1,)`` of ``DRIVE``, until a time after its release, ms."""
    d, closing, time = drive[0], motion == "closing", STEP * np.arange(round(until / STEP) + 1)
    travel, (rest, pressed) = np.empty(time.size), closed(drive)
    x, y = (0.0, 0.0) if closing else (rest, pressed)
    if closing and d["stop_form"]:
        y = -brentq(lambda lag: _carried(d, lag, 0.0), -1.0, 0.0)
    switching = _integrate(drive, closing, rest, np.array([x, 0.0, y, 0.0, x, 0.0]), travel)
    way, turns = travel / d["reach"], np.pi * max(1, d["lever_form"] - 1)
    bent = way * (1.0 - way) if d["lever_form"] == 1 else np.sin(turns * way) / turns
    travel += d["lever"] * d["reach"] * bent
    way = (travel - travel[0]) / (travel[-1] - travel[0])
    k = max(int(np.argmax(way > 0.1)), 1)
    tenth = STEP * (k - (way[k] - 0.1) / (way[k] - way[k - 1]))
    return Curve(time, travel, tenth, switching)


def drive_of(theta: np.ndarray) -> np.ndarray:
    """Return the drive of the model, ``(1,)`` of ``DRIVE``."""
    _, k_a, k_b, _, _, f, gap = theta
    drive, reach = np.zeros(1, DRIVE), (f + k_b * gap) / (k_a + k_b)
    drive[[*NAMES, "reach", "wipe"]] = (*theta, reach, reach - gap)
    return drive


def drawn(
    name: str,
    prior: Prior,
    rng: np.random.Generator,
    strength: float = 1.0,
    until: float = 120.0,
    wipe: float = 0.0,
) -> tuple:
    """Draw drives with a mechanism until one closes with a wipe of at least a share of its way.

    Returns:
        The drive, and its curves by motion.
    """
    forms, sizes, more = (MECHANISMS | STOPS)[name]
    while True:
        theta = prior.sample(1, rng)[0]
        drive = drive_of(theta)
        for field, count in forms.items():
            drive[field] = rng.integers(1, count + 1)
        for field, ends in (sizes | more).items():
            drive[field] = rng.uniform(*ends) * (strength if field in sizes else 1.0)
        curves = {motion: simulated(drive, motion, until) for motion in MOTIONS}
        rest, _ = closed(drive)
        pressed = rest - drive["L"][0] >= wipe * rest
        if pressed and np.isfinite([each[2:] for each in curves.values()]).all():
            return drive, curves


def write(file: Path, curve: Curve, rng: np.random.Generator, options: argparse.Namespace) -> float:
    """Write a record of a curve, and return the time of its release."""
    time = np.arange(0.0, options.length, 1.0 / options.rate)
    release = options.lead + TRIGGER * rng.standard_normal()
    travel = np.interp(time - release, curve.time, curve.travel) + NOISE * rng.standard_normal(
        time.size
    )
    step = max(options.quantum, 1e-5)
    columns = np.c_[time, step * np.round(travel / step)]
    np.savetxt(file, columns, "%.5f", ",", header="time,travel", comments="")
    return release


def timed(record, begins: Mapping, curves: Mapping, rng: np.random.Generator, sd: float):
    """A record whose contact was seen to switch, with an error of a standard deviation in ms."""
    at = begins[record.motion] + curves[record.motion].switching + sd * rng.standard_normal()
    return (
        replace(record, raw=replace(record.raw, contact=ContactTimes(at, sd)))
        if record.raw
        else record
    )


def records_of(curves: Mapping, number: int, rng: np.random.Generator, options, form: Mapping):
    """Records of an operation, as files that are read, and the times of their releases."""
    with TemporaryDirectory() as folder:
        files = {motion: Path(folder, f"{motion}.csv") for motion in MOTIONS}
        begins = {m: write(file, curves[m], rng, options) for m, file in files.items()}
        operations = {motion: [Operation(number + 1, file)] for motion, file in files.items()}
        return [*read_operations(operations, form | {"time_unit": "ms"})], begins


def judge(answers: Sequence[Estimate], drive: np.ndarray, curves: Mapping, lists: Mapping) -> None:
    """Append to lists by name how 95 % intervals of an operation hold, and how its records fit."""
    for k, answer in enumerate(answers):
        lists["withheld"].append(answer.draws is None)
        if answer.match is not None:
            lists["family"].append(answer.levels.settings["family"])
            lists["p_value"].append(answer.match.p_value)
        if answer.draws is None:
            continue
        motion, curve = answer.record.motion, curves[answer.record.motion]
        own = answer.draws.switching[motion], curve.switching - curve.tenth
        pairs = own, (answer.inferred(AFTER_RELEASE[motion]), curve.switching)
        truths = dict(zip(TIMES[MOTIONS.index(motion) :: 2], pairs, strict=True))
        if k == 0 or len(answer.motions) == 1:  # else its parameters are those of the first record
            truths |= {name: (answer.inferred(name), float(drive[name][0])) for name in NAMES}
        for name, (draws, truth) in truths.items():
            low, median, high = np.quantile(draws, [0.025, 0.5, 0.975])
            unit = 0.01 * truth if name in NAMES else 1.0
            errors = (median - truth) / unit, (high - low) / 2.0 / unit
            lists[name].append((low <= truth <= high, *errors))


def row_of(lists: Mapping[str, list]) -> dict:
    """Summary of what ``judge`` found of many drives."""
    row = {}
    for name in (*NAMES, *TIMES):
        held, errors, widths = np.reshape(lists[name] or [np.nan] * 3, (-1, 3)).T
        found = {"held": held.mean(), "error": errors.mean(), "width": np.median(widths)}
        row |= {f"{key} {name}": value for key, value in found.items()}
    shares = pd.Series(lists["family"], dtype=str).value_counts(normalize=True)
    row["families"] = ", ".join(f"{each} {share:.0%}" for each, share in shares.items())
    row["p_value"] = np.median(lists["p_value"] or np.nan)
    return row | {"withheld": np.mean(lists["withheld"])}


def rows_of(name: str, options: argparse.Namespace) -> list[dict]:
    """Rows of the table of a mechanism, one for each of the motions."""
    config = load()
    prior, endurance = Prior.from_settings(config["prior"]), config["endurance"]
    assessment = Diagnosis(config | {"seed": options.seed}, given=Given(Size()))
    lists = {motions: defaultdict(list) for motions in options.motions}
    for number in range(options.drives):
        rng = generator(options.seed, "mechanisms", name, number)
        until = max(120.0, options.length)
        drive, curves = drawn(name, prior, rng, options.strength, until, options.wipe)
        records, begins = records_of(curves, number, rng, options, endurance["format"])
        if options.contact:
            records = [timed(each, begins, curves, rng, options.contact) for each in records]
        for motions, found in lists.items():
            some = [each for each in records if motions in ("both", each.motion)]
            judge(assessment.infer(some), drive, curves, found)
    return [{"mechanism": name, "motions": m} | row_of(found) for m, found in lists.items()]


def main(arguments: Iterable[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("mechanisms", nargs="+", choices=MECHANISMS | STOPS, metavar="MECHANISM")
    parser.add_argument("--motions", nargs="+", choices=MOTIONS_SHOWN, default=MOTIONS_SHOWN)
    parser.add_argument("--rows", type=Path, metavar="CSV")
    for name, default in OPTIONS.items():
        parser.add_argument(f"--{name}", type=type(default), default=default)
    options = parser.parse_args(arguments)
    table = pd.DataFrame([row for name in options.mechanisms for row in rows_of(name, options)])
    shown = table.set_index(["mechanism", "motions"]).round(3)
    for key, title in TITLES.items():
        part = shown.filter(regex=f"^{key} ").round(2).rename(columns=lambda name: name.split()[1])
        print(f"{title}\n{part.to_string(na_rep='')}\n")
    print("Families, median p-value of membership, share withheld")
    print(shown[["families", "p_value", "withheld"]].to_string())
    if options.rows:
        table[[*OPTIONS]] = [getattr(options, key) for key in OPTIONS]
        table.to_csv(options.rows, mode="a", header=not options.rows.exists(), index=False)


if __name__ == "__main__":
    main()
