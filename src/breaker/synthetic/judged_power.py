"""Faults at one operation of a followed rig: how often a change is reported at once.

The faults are made of the rig's elements, and sized by what an engineer measures: a damper at half
its strength, 1 mm more rebound, 2 ms of contact bounce, 5 % less closing force. A rig in which no
change of the element has that effect is left out of that fault.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pandas as pd
import xarray as xr
from tqdm import tqdm

from breaker.mechanism import NAMES
from breaker.model import Model, generator
from breaker.synthetic.drive import Drive
from breaker.synthetic.family import Family
from breaker.synthetic.judged import Reading, records_of
from breaker.synthetic.judged_lives import RigLife, followers
from breaker.wear import Follower, Series, State

__all__ = ["FAULTS", "bounce_time", "factors_of", "judge_power"]

FAULTS = (
    "closing damper halved",
    "opening damper halved",
    "1 mm more rebound",
    "2 ms of bounce",
    "5 % less force",
    "nothing",
)
"""What is changed at one operation; nothing, to count reports without a fault."""

_AFTER = 3  # operations in which a change is to be reported
_REBOUND = 1.0  # mm
_BOUNCE = 2.0  # ms
_HALVINGS = 20  # in search of an element's value
_STEP = 0.02  # ms
_TIMES = np.arange(0.0, 60.0, _STEP)
_MOST = 0.95  # restitution
_SLOWEST = 0.02  # mm/ms, as of the integrator: a contact that bounces with less stays
_SMOOTH_WAY = 0.3  # mm, as of the integrator: beyond it a preload is fully there


def factors_of(drive: Drive, fault: str) -> dict[str, float] | None:
    """Return what one of the ``FAULTS`` multiplies in a drive, by name; None without its effect."""
    if fault.endswith("damper halved"):
        return {f"{fault.split()[0]}_stop.damping": 0.5}
    if fault == "5 % less force":
        return {"f": 0.95}
    if fault == "nothing":
        return {}
    if fault == "1 mm more rebound":
        target = _rebound(drive) + _REBOUND
        lost = _search(lambda x: _rebound(_times(drive, _opening_stop(1.0 - x))), target, 0.0, 1.0)
        return None if lost is None else _opening_stop(1.0 - lost)
    begin = drive.elements.restitution
    end = _search(lambda e: bounce_time(drive.changed(restitution=e)), _BOUNCE, begin, _MOST)
    return None if end is None or not begin else {"restitution": end / begin}


def bounce_time(drive: Drive) -> float:
    """Return how long after the first touch of a closing the contact comes to stay, ms.

    The contact is driven by the contact spring alone, whose other end moves with the drive's curve.
    """
    way = drive.travel("closing", _TIMES)
    speed = np.gradient(way, _STEP)
    theta, elements = dict(zip(NAMES, drive.theta, strict=True)), drive.elements
    position, contact_speed, first = 0.0, 0.0, np.nan
    for time, x, v in zip(_TIMES, way, speed, strict=True):
        spring = theta["k_b"] * (x - position) + theta["gamma_b"] * (v - contact_speed)
        spring += elements.contact_preload * np.tanh((x - position) / _SMOOTH_WAY)
        contact_speed += _STEP * theta["mu"] * spring
        position += _STEP * contact_speed
        if position < theta["L"]:
            continue
        first = time if np.isnan(first) else first
        position, contact_speed = theta["L"], -elements.restitution * contact_speed
        if -contact_speed <= _SLOWEST:
            return float(time - first)
    return np.nan


def judge_power(
    family: Family,
    models: Mapping[str, Model],
    learned: xr.Dataset,
    numbers: Sequence[int],
    judged: Mapping,
    wear_model: Mapping,
) -> pd.DataFrame:
    """Follow rigs of the family, and let each of the ``FAULTS`` happen to them at the same place.

    Args:
        family: The rigs; they wear as in a life, without a change.
        models: Model of each motion, without an error of its own.
        judged, wear_model: Sections of the configuration.

    Returns:
        A row per rig and fault: the ``operation`` of the fault; ``after`` how many records a change
        is reported, nan where none is; and its ``kind``, alarm or step, "none", or "left out" where
        the fault cannot be made. ``clear`` is the change of both curves, as sensors of the model
        would have it, in standard deviations of the noise. A report before the fault is a row of
        the fault "before".
    """
    rows = []
    for number in tqdm(numbers, desc="faults", mininterval=5, unit="rig"):
        rng = generator(judged["seed"], "judged power", int(number))
        drives, reading = _drives(family, judged, rng)
        records = records_of(drives[:-_AFTER], models, reading, rng)
        operations = judged["every"] * np.arange(1, len(drives) + 1)
        watches, scale = [], max(judged["scales"])
        start = operations[:-_AFTER], records, models, learned, scale, wear_model, judged["seed"]
        for _, follower, state, series in followers(*start):
            state, reports = _through(follower, state, series)
            watches.append((follower, state))
            before = {"rig": number, "fault": "before"}
            rows += [before | {"operation": operations[i], "kind": kind} for i, kind in reports]
        last = operations[-_AFTER:]
        for fault in FAULTS:
            row = {"rig": number, "fault": fault, "operation": last[0]}
            factors = factors_of(drives[-_AFTER], fault)
            changed = [_times(drive, factors or {}) for drive in drives[-_AFTER:]]
            if factors is None or not all(drive.holds for drive in changed):
                rows.append(row | {"kind": "left out"})
                continue
            row["clear"] = _clear(drives[-_AFTER], changed[0], models)
            new = records_of(changed, models, reading, rng)
            outputs = {m: np.tile(each[:1], (_AFTER, 1)) for m, each in series.outputs.items()}
            rows.append(row | _first(watches, Series(last, new, outputs)))
    return pd.DataFrame(rows)


def _drives(
    family: Family, judged: Mapping, rng: np.random.Generator
) -> tuple[list[Drive], Reading]:
    """The conditions of a rig without a change, up to the last record after its fault."""
    life = RigLife.draw(family, {**judged, "change": [1.0, 1.0]}, rng)
    names = family.settings["wear"]["change"]
    count = judged["fault_records"] + _AFTER
    operations = judged["every"] * np.arange(1, count + 1)
    return [life.condition(operation, names) for operation in operations], life.reading


def _first(watches: Sequence[tuple[Follower, State]], series: Series) -> dict:
    """After how many records of a series any source reports a change, and as what."""
    found = [each for watch in watches for each in _through(*watch, series)[1]]
    first, kind = min(found, key=lambda each: each[0], default=(np.nan, "none"))
    return {"after": first + 1, "kind": kind}


def _clear(before: Drive, after: Drive, models: Mapping[str, Model]) -> float:
    """Change of the curves of all motions, in standard deviations of noise and zero."""
    square = 0.0
    for motion, model in models.items():
        sensor = model.sensor.noise_and_zero
        curves = (drive.travel(motion, sensor.times) for drive in (before, after))
        square += float(sensor.chi_square(*curves))
    return np.sqrt(square)


def _through(
    follower: Follower, state: State, series: Series
) -> tuple[State, list[tuple[int, str]]]:
    """Follow a series, and list the records at which a change is reported, and of which kind."""
    usable, reports = {m: series.usable(m) for m in follower.models}, []
    for i in range(len(series.operations)):
        state, row, _ = follower.step(state, series, i, usable)
        reports += [(i, kind) for kind in ("step", "alarm") if row[kind][1]]
    return state, reports


def _times(drive: Drive, factors: Mapping[str, float]) -> Drive:
    """A drive with some of its numbers multiplied, by name."""
    return drive.changed(**{name: by * drive.value(name) for name, by in factors.items()})


def _opening_stop(left: float) -> dict[str, float]:
    """Factors that leave a share of the opening damper and its bumper."""
    return {"opening_stop.damping": left, "opening_stop.stiffness": left}


def _rebound(drive: Drive) -> float:
    """Largest travel beyond the open rest position, mm."""
    return float(-drive.travel("opening", _TIMES).min())


def _search(
    effect: Callable[[float], float], target: float, low: float, high: float
) -> float | None:
    """Find the cause of an effect that grows with it, by bisection; None where none has it."""
    if not effect(low) < target <= effect(high):
        return None
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if effect(middle) < target else (low, middle)
    return high
