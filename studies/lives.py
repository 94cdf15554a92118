"""Lives of drives from new to failure, followed and decided on as one would act.

    python -m studies.lives follow develop lives.csv          # or calibrate, score, fresh
    python -m studies.lives table lives.csv docs/lives.csv    # sums one or more up
    python -m studies.lives table few.csv docs/few.csv        # the same of few records
    python -m studies.lives plans lives.csv docs/plans.csv    # and how lives were serviced
    python -m studies.lives alarms lives.csv docs/alarms.csv  # and false alarms

Seeds: to develop by, to calibrate by (threshold in ``trend``, and ``Future``), to score, and fresh,
to score what was changed since.
Drives of the family that networks are trained on, and foreign ones, wear along a straight
line in their parameters and elements; half of them faster from 30 to 90 % of the life on. All that
wears and all parameters scatter by 0.4 %; sensors round, and have coloured noise
(``studies.sensors``). A record every fifth operation. Each life has a limit on a measured
quantity, and one on the change of a parameter, at what the drive reaches at a random share of its
wear; where nothing changes enough for that, it has none. ``steady`` lives have no change of rate,
``faults`` a sudden one of a parameter. ``unworn`` drives do not wear, ``slow`` ones a quarter as
fast as their limits are set for: every alarm is a false one. ``few`` drives are of the
family, and have one or two records at each of ten inspections. ``other`` are lives of drives of an
independent simulator, by other laws of wear, of other lengths (``studies.other_lives``).

A service is done at the operation by which it is planned, in two ways: ``monitoring`` reads every
record, and ``inspections`` read the records at each twentieth of the life. The cost of a life,
divided by its operations, is compared with a service at a fixed interval, of all intervals
the one that would have been cheapest in all other lives of the set. A life that is never serviced
fails.
"""

import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from scipy.stats import chi2
from tqdm import tqdm

from breaker.common.randomness import generator
from breaker.configuration.definitions import family_of
from breaker.configuration.loading import load
from breaker.family.drive_family import Family
from breaker.family.inputs import network_record
from breaker.family.networks import shipped_networks
from breaker.family.rich_drive import Drive
from breaker.family.shape import shape_of
from breaker.model.limits import UNRESOLVED, Limit
from breaker.model.parameters import NAMES
from breaker.model.prior import Prior
from breaker.model.sensor import Sensor
from breaker.prognosis.forecast import Future
from breaker.prognosis.life import forecast_of
from breaker.prognosis.readout import Readout
from breaker.prognosis.series import MotionRecords, Series, inspections_of, new_of
from breaker.prognosis.states import STATES, states_of
from breaker.prognosis.trend import Follower
from breaker.records.measurements import Measured, measure_curve
from breaker.shipped import HELD_BACK
from studies.other_lives import Curves, OtherLife, records_of, truth_of
from studies.sensors import Reading
from studies.shared import append

SEEDS = {"develop": 71, "calibrate": 72, "score": 73, "fresh": 75}
SETS = {"family": 200, "foreign": 100, "steady": 200, "faults": 100, "other": 60}
PACES = {"unworn": 0.0, "slow": 0.25, "few unworn": 0.0}  # of the wear that limits are set for
FEW = ("few", "few unworn")
SETS |= dict.fromkeys((*PACES, *FEW), 60)
LIFE, EVERY, LONGER = 2000, 5, 1.3
KNEE, FASTER = (0.3, 0.9), (3.0, 8.0)  # share of the life, times
FAILS = (0.7, 0.97)  # share of the wear at which a limit is reached
SCATTER, ONSET, STEP = 0.004, 0.3, 0.2  # share, ms, ms
TRIES = 100
TIMES = np.arange(-8.0, 64.0, STEP)
MEASURED = {"closing": ["stroke", "travel_time"], "opening": ["stroke", "travel_time"]}
FOREIGN = {"force_fall": [0.0, 0.15], "drag": [0.005, 0.05], "linkage": [0.5, 2.0]}
FAULT = (3.0, 12.0)  # percent of a parameter
CLEAR = 6.0  # percent of a parameter, or scatters of a measured quantity, that make a limit
NEVER = Limit("never", "", (("f", -100.0, False),), of="change")  # of a life without limits
FEWEST = 10  # new records from which on their own scatter counts, not that of all
TOLERANCE = {"measured": 0.05, "changed": 0.1}  # shares, of drives that do not wear
ASKED = 3  # operations of a life at which it is asked
INTERVAL = ("low", "middle", "high")  # columns of an answer
INSPECTIONS, FEW_INSPECTIONS = 20, 10  # in a life, where nobody watches
LEAD = "lead of the plan, share of the life"
UNCHANGED = 0.05  # probability of no change, below which a parameter is reported as changed
RESAMPLES, ABOUT = 2000, 31  # lives drawn again; readings about an operation


@dataclass
class Life:
    """A drive that wears: new, worn, and how fast."""

    new: Drive
    worn: Drive
    knee: float
    faster: float
    fault: tuple[float, str, float] = (np.inf, "", 0.0)
    pace: float = 1.0
    batch: int = 0
    length, every = LIFE, EVERY

    @property
    def operations(self) -> np.ndarray:
        """Operations with a record: each fifth, or some at each of a few inspections."""
        if not self.batch:
            return np.arange(EVERY, LIFE + 1, EVERY)
        first = LIFE // FEW_INSPECTIONS * np.arange(1, FEW_INSPECTIONS + 1) - self.batch + 1
        return (first[:, None] + np.arange(self.batch)).ravel()

    @classmethod
    def drawn(cls, name: str, config: Mapping, rng: np.random.Generator) -> "Life":
        """Draw one of a set."""
        prior = Prior.from_settings(config["prior"])
        settings = family_of("medium_voltage")
        if name == "foreign":
            settings = family_of(HELD_BACK)
            settings["effects"] |= FOREIGN
        family = Family(prior, settings)
        worn = None
        while worn is None:
            new = family.new(rng)
            with suppress(RuntimeError):  # hardly a worn condition of this drive holds
                worn = family.worn(new, rng, *(["sparse"] if name != "foreign" else []))
        knee = LIFE * rng.uniform(*KNEE)
        faster = float(np.exp(rng.uniform(*np.log(FASTER))))
        if rng.random() < 0.5 or name in ("steady", "faults", *PACES):
            knee, faster = LIFE, 1.0
        batch = int(rng.integers(1, 3)) if name in FEW else 0
        life = cls(new, worn, knee, faster, pace=PACES.get(name, 1.0), batch=batch)
        while name == "faults" and (not life.fault[1] or not life.at(LIFE).holds):
            ranges = family_of("medium_voltage")["wear"]["change"]
            which = str(rng.choice([n for n in NAMES if n in ranges]))
            size = np.exp(rng.uniform(*np.log(FAULT))) * np.sign(np.sum(ranges[which]))
            life.fault = LIFE * rng.uniform(0.6, 0.9), which, float(size)
        return life

    def reached(self, share: float) -> float:
        """Return the operation at which a share of the wear is reached."""
        way = share * (self.knee + self.faster * (LIFE - self.knee))
        return way if way <= self.knee else self.knee + (way - self.knee) / self.faster

    def at(self, operation: float, noise: Mapping[str, float] | None = None) -> Drive:
        """Return the drive at an operation; its numbers times ``1 + noise``."""
        operation = self.pace * operation
        way = min(operation, self.knee) + self.faster * max(operation - self.knee, 0.0)
        share = way / (self.knee + self.faster * (LIFE - self.knee))
        changed = {}
        for name in (*NAMES, *(noise or {})):
            new, worn = self.new.value(name), self.worn.value(name)
            value = new + share * (worn - new)
            if self.fault[1] == name and operation > self.fault[0]:
                value *= 1.0 + self.fault[2] / 100.0
            changed[name] = value * (1.0 + (noise or {}).get(name, 0.0))
        return self.new.changed(**changed)


def simulate(life: Life, config: Mapping, rng: np.random.Generator) -> tuple[Series, pd.DataFrame]:
    """Records of a life, and its truth: parameters, and what curves without a sensor show.

    The truth is that at a pace of 1, by which limits are set.
    """
    sensor, reading = Sensor(**config["sensor"]), Reading.draw(rng)
    ranges = family_of("medium_voltage")["wear"]["change"]
    worn = [name for name in ranges if life.new.value(name) != life.worn.value(name)]
    names, operations = sorted({*NAMES, *worn}), life.operations
    drives = []
    for operation in operations:
        for _ in range(TRIES):
            noise = dict(zip(names, SCATTER * rng.standard_normal(len(names)), strict=True))
            drive = life.at(operation, noise)
            if drive.holds:
                break
        drives.append(drive)
    travels = {m: [partial(drive.travel, m) for drive in drives] for m in MEASURED}
    motions = {m: recorded(travels[m], m, sensor, reading, rng) for m in MEASURED}
    stages = np.unique(np.append(np.linspace(0.0, LONGER * LIFE, 53).round(), round(life.knee)))
    rows = []
    for stage in stages:
        drive = replace(life, pace=1.0).at(stage)
        if not drive.holds:
            break
        row = dict(zip(NAMES, drive.theta, strict=True)) | {"operation": stage}
        for motion, quantities in MEASURED.items():
            found = measured(drive.travel(motion, TIMES), motion)
            row |= {f"{motion} {q}": found[q].value if found else np.nan for q in quantities}
        rows.append(row)
    return series_of(operations, motions), pd.DataFrame(rows).set_index("operation")


def series_of(operations: np.ndarray, motions: Mapping[str, MotionRecords]) -> Series:
    """The series of records of which none is missing."""
    inspections = inspections_of(operations)
    new = new_of({motion: each.there for motion, each in motions.items()}, inspections)
    return Series(operations, motions, new, {}, inspections=inspections)


def measured(curve: np.ndarray, motion: str) -> dict[str, Measured]:
    """Quantities of a curve; none of one that shows no motion."""
    with suppress(ValueError, FloatingPointError):
        return measure_curve(TIMES, curve, motion, speeds=())
    return {}


def simulate_other(
    life: OtherLife, config: Mapping, rng: np.random.Generator
) -> tuple[Series, pd.DataFrame]:
    """The same of a drive of other code."""
    sensor, reading = Sensor(**config["sensor"]), Reading.draw(rng)
    curves, operations = Curves(life), life.operations
    travels = records_of(life, curves, operations, rng)
    motions = {m: recorded(travels[m], m, sensor, reading, rng) for m in MEASURED}
    series = series_of(operations, motions)
    truth = truth_of(life, curves, TIMES, measured)
    return series, truth[[*NAMES, *(f"{m} {q}" for m in MEASURED for q in MEASURED[m])]]


def recorded(travels, motion: str, sensor: Sensor, reading: Reading, rng) -> MotionRecords:
    """Records of travels, functions of times after the release, normalised."""
    sign = 1.0 if motion == "closing" else -1.0
    ways, presents, noises, rows, like = [], [], [], [], None
    for travel in travels:
        late = ONSET * rng.standard_normal()
        record = reading.corrupt(travel(TIMES - late), sensor, rng)
        like = like or shape_of(sign * record, STEP)
        shape = shape_of(sign * record, STEP, like)
        rest = record[:35]
        sd = max(float(rest.std()), reading.quantum / np.sqrt(12.0))
        noises.append(network_record(shape, sd, reading.colour, STEP, like).noise[0])
        ways.append(shape.way)
        presents.append(shape.present)
        rows.append(measured(record, motion))
    none = Measured(np.nan, np.nan, "")
    read = {q: np.array([row.get(q, none)[:2] for row in rows]).T for q in MEASURED[motion]}
    found, stated = ({q: each[k] for q, each in read.items()} for k in (0, 1))
    units = like.stroke, like.duration
    return MotionRecords(
        np.array(ways), np.array(presents), np.array(noises), *units, found, stated
    )


def limits_of(
    truth: pd.DataFrame, series: Series, life: Life, rng, *, every: bool = False
) -> dict[Limit, float]:
    """Choose limits that the drive reaches, one of each kind or every one, and when it does."""
    share = rng.uniform(*FAILS)
    fails = life.reached(share)
    whole, found = np.arange(0.0, LONGER * life.length), {}
    dense = {n: np.interp(whole, truth.index, truth[n]) for n in truth.columns}
    new = slice(0, int(series.operations[series.new[-1]]) + 1)

    def add(name: str, of: str, motion: str, quantity: str, values: np.ndarray, end: float) -> None:
        upper = bool(end > values[new].mean())
        over = values > end if upper else values < end
        if over.any() and not over[new].any():
            limit = Limit(name, motion, ((quantity, end, upper),), of=of)
            found[limit] = float(whole[over.argmax()])

    candidates = []
    for motion, each in series.motions.items():
        for name, values in each.measured.items():
            scatter = np.nanstd(np.diff(values[: series.new.size])) / np.sqrt(2.0)
            if series.new.size < FEWEST:  # of all, next to a line from each to the next but one
                scatter = np.nanstd(np.diff(values, 2)) / np.sqrt(6.0)
            end = np.interp(fails, whole, dense[f"{motion} {name}"])
            if abs(end - np.nanmean(values[: series.new.size])) > CLEAR * scatter:
                candidates.append((motion, name, float(end)))
    for motion, name, end in candidates if every else one_of(candidates, rng):
        kind = f"measured {motion} {name}" if every else "measured"
        add(kind, "record", motion, name, dense[f"{motion} {name}"], end)
    percent = {n: 100.0 * (dense[n] / dense[n][new].mean() - 1.0) for n in NAMES}
    ends = {n: float(np.interp(fails, whole, percent[n])) for n in NAMES}
    clear = [n for n in NAMES if n not in UNRESOLVED and abs(ends[n]) > CLEAR]
    for name in clear if every else one_of(clear, rng):
        kind = f"changed {name}" if every else "changed"
        add(kind, "change", "", name, percent[name], ends[name])
    return found


def tolerances(series: Series, ranges: Mapping[str, list[float]]) -> list[Limit]:
    """Limits as users have them, by ``TOLERANCE`` from new, of a drive that does not reach them.

    Args:
        ranges: By what wear of the family changes parameters.
    """
    found = []
    for motion, each in series.motions.items():
        for name, values in each.measured.items():
            upper, new = name == "travel_time", float(np.nanmean(values[series.new]))
            end = new * (1.0 + TOLERANCE["measured"] * (1.0 if upper else -1.0))
            parts = ((name, end, upper),)
            found.append(Limit(f"measured {motion} {name}", motion, parts, of="record"))
    for name, span in ranges.items():
        if name in NAMES and name not in UNRESOLVED:
            end = 100.0 * TOLERANCE["changed"] * float(np.sign(np.sum(span)))
            found.append(Limit(f"changed {name}", "", ((name, end, end > 0.0),), of="change"))
    return found


def one_of(some: list, rng) -> list:
    """One of them, if there is any."""
    return [some[rng.integers(len(some))]] if some else []


def simulated(
    of: str, name: str, number: int, seed: int, config: Mapping
) -> tuple[Life, Series, pd.DataFrame, np.random.Generator]:
    """Draw and simulate one life of a benchmark; also returns the generator, for what follows."""
    for attempt in range(TRIES):
        rng = generator(seed, f"benchmark of {of}", name, number, attempt)
        with suppress(ValueError):  # a drive that does not hold all along its life
            if name == "other":
                other = OtherLife.drawn(Prior.from_settings(config["prior"]), rng)
                return other, *simulate_other(other, config, rng), rng
            life = Life.drawn(name, config, rng)
            return life, *simulate(life, config, rng), rng
    raise RuntimeError(f"none of {TRIES} drives of '{name}' holds all along its life")


def followed(name: str, number: int, seed: int, config: Mapping, networks) -> tuple:
    """Simulate and follow one life."""
    life, series, truth, rng = simulated("lives", name, number, seed, config)
    limits = limits_of(truth, series, life, rng, every=name in PACES)
    if PACES.get(name) == 0.0:
        limits = dict.fromkeys(
            tolerances(series, family_of("medium_voltage")["wear"]["change"]), np.inf
        )
    settings = config["trend"]
    readout = Readout.of(series, networks, draws=settings["draws"], seed=seed, misfit_p_value=0.001)
    path = Follower(series, readout.coordinates.blocks(series), settings["threshold"]).path()
    data = forecast_of(readout, path, list(limits) or [NEVER], Future(settings["horizon"]))
    return life, truth, limits, readout, data


def scored(name: str, number: int, seed: int, config: Mapping, networks) -> list[dict]:
    """Rows of one life."""
    life, truth, limits, readout, data = followed(name, number, seed, config, networks)
    about = {"set": name, "life": number, "family": data.attrs["family"]}
    if isinstance(life, Life):
        about |= {"knee": life.knee, "faster": life.faster}
    rng = generator(seed, "benchmark of lives, asked", name, number)
    rows = [] if name in ("other", *FEW) else changes_of(life, data, readout)
    rows = [about | each for each in rows]
    reported, looks = data.attrs["reported_from"], looked_at(life, data, config["planning"])
    if name in PACES:
        return rows + [about | each for each in alarms_of(data, looks, worn=life.pace > 0.0)]
    for limit, fails in limits.items():
        left = left_of(limit.name, fails, data, reported, rng)
        rows += [about | each | {"names": " ".join(limit.quantities)} for each in left]
        shown = shown_beyond(limit, readout.series)
        for way, stands in looks.items():
            done = acted(limit.name, fails, stands)
            rows.append(about | {"kind": way, "shown": shown} | done)
    where = rng.choice(data.asked.values[data.asked.values >= reported], ASKED, replace=False)
    new = readout.series.operations[readout.series.new]
    reference = np.mean([_at(truth[list(NAMES)], each) for each in new], axis=0)
    for operation in where:
        true = 100.0 * (_at(truth[list(NAMES)], operation) / reference - 1.0)
        intervals = data.changed.sel(asked=operation).values
        for parameter, truly, interval in zip(NAMES, true, intervals, strict=True):
            change = {"score": "change", "name": parameter, "truth": truly}
            rows.append(about | change | dict(zip(INTERVAL, interval, strict=True)))
    return rows


def looked_at(life, data: xr.Dataset, planning: Mapping) -> dict[str, xr.Dataset]:
    """How the drive stands, where every record is looked at, and where inspections read them."""
    if getattr(life, "batch", 0):
        planning = {**planning, "inspection": f"{LIFE // FEW_INSPECTIONS} operations"}
        return {"inspections": states_of(data, planning)}
    interval = max(round(life.length / INSPECTIONS), 1)
    asked = data.asked.values
    ends = np.arange(interval, asked[-1] + 1, interval)
    last = np.unique(asked[np.maximum(np.searchsorted(asked, ends, side="right") - 1, 0)])
    ways = {"monitoring": (data, life.every), "inspections": (data.sel(asked=last), interval)}
    return {
        way: states_of(each, {**planning, "inspection": f"{apart} operations"})
        for way, (each, apart) in ways.items()
    }


def _at(table: pd.DataFrame, operation: float) -> np.ndarray:
    return np.array([np.interp(operation, table.index, table[n]) for n in table])


def jump_of(life: Life, readout: Readout) -> float:
    """How far a fault moves the curves, in the scatter of single records."""
    after, before, square = life.fault[0] + 1.0, life.fault[0], 0.0
    for motion, curve in readout.coordinates.curves.items():
        each, sign = readout.series.motions[motion], 1.0 if motion == "closing" else -1.0
        like = shape_of(sign * life.at(0.0).travel(motion, TIMES), STEP)
        like = like._replace(stroke=each.stroke, duration=each.duration)
        ways = [
            shape_of(sign * life.at(o).travel(motion, TIMES), STEP, like).way
            for o in (before, after)
        ]
        seen = curve.project(np.array(ways), np.ones((2, ways[0].size), dtype=bool))
        square += np.square(np.diff(seen[:, :12], axis=0)).sum()
    return float(np.sqrt(square))


def changes_of(life: Life, data: xr.Dataset, readout: Readout) -> list[dict]:
    """Whether a change was noticed, when, and by whom; and false ones."""
    true = life.fault[0] if life.fault[1] else life.knee if life.knee < LIFE else np.inf
    rows = []
    for k in range(data.sizes["change"]):
        noticed = float(data.noticed[k])
        false = noticed <= true
        rows.append(
            {
                "score": "false" if false else "noticed",
                "operation": noticed,
                "late": noticed - true,
                "start": float(data.start[k]) - true,
                "kind": data.kind[k].item(),
            }
        )
    quiet = np.isfinite(data.evidence.values) & (data.operation.values <= true)
    most = np.nanmax(data.evidence.values, initial=-np.inf, where=quiet)
    rows.append(
        {
            "score": "quiet",
            "records": int(quiet.sum()),
            "evidence": most,
            "truth": true,
            "size": jump_of(life, readout) if life.fault[1] else 0.0,
            "name": life.fault[1],
        }
    )
    return rows


def alarms_of(data: xr.Dataset, looks: Mapping[str, xr.Dataset], *, worn: bool) -> list[dict]:
    """False alarms of a drive: rows of when first, and of how long it was followed.

    Args:
        worn: Whether the drive wears, so that its parameters are rightly reported as changed.
    """
    reported, end, found = data.attrs["reported_from"], float(data.operation[-1]), []

    def add(way: str, what: str, limit: str, operations: np.ndarray) -> None:
        first = float(operations[0]) if operations.size else np.inf
        about = {"kind": way, "names": what, "name": limit, "first": first}
        about["count"] = operations.size
        found.append({"score": "alarm", "operation": min(first, end) - reported} | about)

    way = next(iter(looks))  # of what is reported at every record, whoever looks
    for each, stands in looks.items():
        for limit in stands.limit.values:
            for state in ("planned", "due"):
                on = stands.state.sel(limit=limit).values >= STATES.index(state)
                add(each, state, limit, stands.operation.values[on])
    if not worn:
        named = (data.unchanged.values < UNCHANGED).any(axis=1) & (data.asked.values >= reported)
        add(way, "worn", "", data.asked.values[named])
    add(way, "change", "", data.noticed.values)
    return found


def left_of(limit: str, fails: float, data: xr.Dataset, reported: int, rng) -> list[dict]:
    """Operations left at random operations before a failure."""
    asked = data.asked.values[(data.asked.values >= reported) & (data.asked.values < fails)]
    some = rng.choice(asked, min(ASKED, asked.size), replace=False) if asked.size else []
    rows = []
    for operation in some:
        one = data.sel(asked=operation, limit=limit)
        left = {"score": "left", "name": limit, "operation": operation, "truth": fails - operation}
        rows.append(left | dict(zip(INTERVAL, one.remaining.values, strict=True)))
    return rows


def shown_beyond(limit: Limit, series: Series) -> float:
    """First operation about which records show a measured quantity beyond its limit; inf if none.

    That is the median of ``ABOUT`` readings; nan of what is inferred.
    """
    if limit.of != "record":
        return np.nan
    ((quantity, bound, upper),) = limit.parts
    readings = pd.Series(series.motions[limit.motion].measured[quantity])
    middle = readings.rolling(ABOUT, center=True, min_periods=1).median().values
    beyond = middle > bound if upper else middle < bound
    return float(series.operations[beyond.argmax()]) if beyond.any() else np.inf


def acted(limit: str, fails: float, stands: xr.Dataset) -> dict:
    """What it costs to obey: when a service is first planned, when it is due, moves of the date.

    ``known`` is whether anything is said of the limit when it fails, or when its service is due;
    ``count`` of ``records`` rows that plan have it behind the 5 % quantile of the operations left.
    """
    one, operations = stands.sel(limit=limit), stands.operation.values
    state = one.state.values
    planned = np.flatnonzero(state >= STATES.index("planned"))
    # A planned service is done at its operation, if that comes before the next look.
    due, by = state == STATES.index("due"), np.maximum(one.service_by.values, operations)
    done = np.where(due, operations, np.where(by < np.append(operations[1:], np.inf), by, np.inf))
    first = float(operations[planned[0]]) if planned.size else np.nan
    service = float(done[np.isfinite(done)][0]) if np.isfinite(done).any() else np.inf
    at = np.searchsorted(operations, min(service, fails), side="right") - 1
    until = (operations <= min(service, fails)) & (state == STATES.index("planned"))
    by = one.service_by.values[until]
    moves = int((by[1:] != by[:-1]).sum()) if by.size else 0
    planned = np.isfinite(one.service_by.values) & one.remaining.notnull().all("quantile").values
    last = operations + one.remaining.values[:, 0].round()
    return {
        "records": int(planned.sum()),
        "count": int((one.service_by.values > last)[planned].sum()),
        "score": "acted",
        "name": limit,
        "fails": fails,
        "first": first,
        "service": service,
        "moves": moves,
        "known": bool(state[max(at, 0)] != STATES.index("unknown")),
    }


def follow(seed_name: str, file: str, *sets: str) -> None:
    """Follow all lives of a seed, and add their rows to a file; those that are there are done."""
    config, seed = load(), SEEDS[seed_name]
    networks = [*shipped_networks()]
    done = pd.read_csv(file)[["set", "life"]].drop_duplicates() if Path(file).exists() else None
    known = set() if done is None else set(done.itertuples(index=False, name=None))
    for name in sets or SETS:
        for number in tqdm(range(SETS[name]), desc=name, mininterval=10):
            if (name, number) in known:
                continue
            rows = pd.DataFrame(scored(name, number, seed, config, networks))
            append(rows.reindex(columns=COLUMNS), file)


COLUMNS = [
    *("set", "life", "knee", "faster", "family", "score", "name", "truth", *INTERVAL),
    *("operation", "late", "start", "kind", "names", "size", "count", "records"),
    *("evidence", "fails", "first", "service", "moves", "known", "shown"),
]


def drawn_again(count: int) -> np.ndarray:
    """Indices of lives drawn again, ``(RESAMPLES, count)``."""
    return generator(1, "lives drawn again").integers(count, size=(RESAMPLES, count))


class Score(NamedTuple):
    """A score, how many numbers it is of, and its 90 % interval over lives drawn again."""

    value: float
    count: int
    low: float = np.nan
    high: float = np.nan

    @classmethod
    def share(cls, holds: pd.Series, lives: pd.Series) -> "Score":
        """Return how often something holds, of rows of lives."""
        each = holds.astype(float).groupby(lives.values).agg(["sum", "size"]).values
        if not len(each):
            return cls(np.nan, 0)
        sums, sizes = each[drawn_again(len(each))].sum(axis=1).T
        return cls(holds.mean(), len(holds), *np.quantile(sums / sizes, [0.05, 0.95]).tolist())

    def __str__(self) -> str:
        of = f" from {self.low:.2g} to {self.high:.2g}" if np.isfinite(self.low) else ""
        return "" if np.isnan(self.value) else f"{self.value:.2g}{of} ({self.count})"


def summed(some: pd.DataFrame) -> dict[str, Score]:
    """Sum up the rows of a set: what each score is, and of how many."""
    found: dict[str, Score] = {}
    change = some[(some.score == "change") & some.low.notna()]
    for name, each in change.groupby("name"):
        holds = (each.low - 0.05 <= each.truth) & (each.truth <= each.high + 0.05)
        found[f"change of {name}: coverage of 90 % intervals"] = Score.share(holds, each.life)
        half = ((each.high - each.low) / 2.0)[each.truth.abs() > 1.0]
        found[f"change of {name}: half width, %, where it changed"] = Score(
            half.median(), len(half)
        )
    quiet, false = (some[some.score == each] for each in ("quiet", "false"))
    if len(quiet):
        rate = 1e4 * len(false) / quiet.records.sum()
        found["false changes in 10,000 records"] = Score(rate, len(quiet))
    changed = quiet[np.isfinite(quiet.truth)].set_index("life")
    if len(changed):
        late = some[some.score == "noticed"].groupby("life").late.min().reindex(changed.index)
        found["changes found"] = Score.share(late.notna(), late.index.to_series())
        found["records late"] = Score(late.median() / EVERY, int(late.notna().sum()))
        for low, high in ((3, 6), (6, 12), (12, np.inf)):
            of = changed.index[(changed["size"] >= low) & (changed["size"] < high)]
            if len(of):
                soon = late.reindex(of) <= 3 * EVERY
                words = f"faults of {low} to {high} sd found within 3 records"
                found[words] = Score.share(soon, of.to_series())
    for name, each in some[(some.score == "left") & some.low.notna()].groupby("name"):
        holds = (each.low <= each.truth) & (each.truth <= each.high)
        words = f"{name} limits: coverage of operations left"
        found[words] = Score.share(holds, each.life)
    for name, each in some[(some.score == "acted") & (some.kind == "inspections")].groupby("name"):
        intime = each.service.fillna(np.inf) <= each.fails
        found[f"{name} limits: serviced in time, by inspections"] = Score.share(intime, each.life)
    return found


def planned_of(lives: pd.DataFrame) -> dict[str, float]:
    """Sum up how lives were serviced, by one way of looking, each of one limit."""
    fails, service = lives.fails.values, lives.service.fillna(np.inf).values
    intime, rows = service <= fails, int(lives.records.sum())
    found = {"recommended": lives.known.astype(bool).mean(), "serviced in time": intime.mean()}
    if lives.shown.notna().any():
        found["serviced before records show it"] = (service <= lives.shown).mean()
    behind = lives["count"].sum() / rows if rows else np.nan
    found["rows with service_by behind the 5 % quantile"] = behind
    away, lead = (fails - service) / fails, (service - lives["first"].values) / fails
    for name, each in (("share of the life given away", away), (LEAD, lead)):
        found[name] = float(np.median(each[intime])) if intime.any() else np.nan
    found["moves of service_by"] = float(lives.moves.median())
    if len(lives) > 2:
        words = "cost relative to a fixed interval", "the same, from (90 %)", "the same, to (90 %)"
        found |= dict(zip(words, against_fixed(service, fails), strict=True))
    return found


def against_fixed(service: np.ndarray, fails: np.ndarray) -> tuple[float, float, float]:
    """Cost of an operation relative to a service at the interval that is best in all other lives.

    Returns:
        The ratio, and its 90 % interval over lives drawn again.
    """
    settings = load()["planning"]
    costs = np.array([settings["service_cost"], settings["failure_cost"]])
    each = costs[(service > fails).astype(int)], np.minimum(service, fails)
    tried = np.append(np.sort(fails), np.inf)
    over = tried[:, None] > fails  # an interval of just what a life lasts is in time
    cost, made = costs[over.astype(int)], np.minimum(tried[:, None], fails)
    others = (cost.sum(axis=1, keepdims=True) - cost) / (made.sum(axis=1, keepdims=True) - made)
    best, lives = others.argmin(axis=0), np.arange(len(fails))
    fixed = cost[best, lives], made[best, lives]

    def ratio(some: np.ndarray) -> np.ndarray:
        ours, theirs = ((c[some].sum(-1) / m[some].sum(-1)) for c, m in (each, fixed))
        return ours / theirs

    again = ratio(drawn_again(len(fails)))
    return float(ratio(lives)), *np.quantile(again, [0.05, 0.95]).tolist()


def plans(*files: str) -> None:
    """Sum up how lives were serviced; the last file is written, and the table in the evidence."""
    rows = pd.concat([pd.read_csv(file) for file in files[:-1]])
    acts, data = rows[rows.score == "acted"], []
    for (of, name, way), each in acts.groupby(["set", "name", "kind"]):
        about = {"set": of, "limit": name, "looked at": way, "lives": len(each)}
        data.append(about | planned_of(each))
    left = rows[(rows.score == "left") & rows.low.notna()]
    holds = (left.low <= left.truth) & (left.truth <= left.high)
    for row in data:
        some = holds[(left.set == row["set"]) & (left.name == row["limit"])]
        row |= {"coverage of operations left": some.mean(), "of": len(some)}
    pd.DataFrame(data).to_csv(files[-1], index=False, float_format="%.3g")


def alarms(*files: str) -> None:
    """Sum up false alarms; the last file is written."""
    rows, planning = pd.concat([pd.read_csv(file) for file in files[:-1]]), load()
    yearly = planning["planning"]["operations"] / planning["planning"]["years"]
    some, data = rows[rows.score == "alarm"], []
    some = some.assign(name=some.name.fillna("").str.partition(" ")[0])
    for (of, what, limit, way), each in some.groupby(["set", "names", "name", "kind"]):
        made, false = each.operation.sum() / 1000.0, int(np.isfinite(each["first"]).sum())
        rate = false / made if made else np.nan
        most = chi2.ppf(0.95, 2 * (false + 1)) / 2.0 / made if made else np.nan
        data.append(
            {"drives": of, "reported": what, "limit": limit, "looked at": way}
            | {"lives": each.life.nunique(), "of": len(each), "false": false}
            | {"operations": round(1000 * made), "in 1,000 operations": rate}
            | {"at most (95 %)": most, "a year": rate * yearly / 1000.0}
            | {"a year, at most (95 %)": most * yearly / 1000.0}
        )
    pd.DataFrame(data).to_csv(files[-1], index=False, float_format="%.3g")


def table(*files: str) -> None:
    """Sum rows up; the last file is written."""
    rows = pd.concat([pd.read_csv(file) for file in files[:-1]])
    each = {name: summed(some) for name, some in rows.groupby("set")}
    sets = [name for name in SETS if name in each]
    scores = list(dict.fromkeys(score for name in sets for score in each[name]))
    data = []
    for score in scores:
        cells = [each[name].get(score, Score(np.nan, 0)) for name in sets]
        data.append([score, *(number for cell in cells for number in cell)])
    of = ("", "_count", "_low", "_high")
    columns = ["score", *(f"{name}{part}" for name in sets for part in of)]
    pd.DataFrame(data, columns=columns).to_csv(files[-1], index=False, float_format="%.3g")


if __name__ == "__main__":
    {"follow": follow, "table": table, "plans": plans, "alarms": alarms}[sys.argv[1]](*sys.argv[2:])
