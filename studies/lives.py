"""Lives of drives from new to failure, followed and decided on as a user would.

    python -m studies.lives follow fresh lives.csv other      # add the rows of a set to a file
    python -m studies.lives table lives.csv docs/lives.csv    # coverage, and services in time
    python -m studies.lives plans lives.csv docs/plans.csv    # what services cost
    python -m studies.lives alarms lives.csv docs/alarms.csv  # what is reported without cause

Seeds: to develop by, to calibrate by (threshold in ``trend``, and ``Future``), to score, and fresh,
to score what was changed since. Sets: ``family``, drives of the family of the networks, which wear
along a straight line, half of them faster from 30 to 90 % of the life on; ``few``, the same with
one or two records at each of ten inspections; ``few unworn``, whose drives do not wear, so that
each report is a false alarm; ``other``, of ``studies.other_lives``. All that wears scatters by
0.4 %; sensors round, and have coloured noise (``studies.sensors``).

Each life has a limit on a measured quantity, and one on the change of a parameter, at what the
drive reaches at a random share of its wear, if that changes enough. A service is done at the
operation by which it is planned, by ``MONITORING``, with a record at every fifth operation, and by
``INSPECTION``, where the records are read at each twentieth of the life. The cost of a life,
divided by its operations, is compared with a service at a fixed interval: of all intervals the one
that would have been cheapest in all other lives of the set. A life that is never serviced fails.
"""

import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
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
from studies.other_lives import Curves, OtherLife, records_of, truth_of
from studies.sensors import Reading
from studies.shared import append

SEEDS = {"develop": 71, "calibrate": 72, "score": 73, "fresh": 75}
SETS = {"family": 200, "other": 60, "few": 60, "few unworn": 60}
FEW, UNWORN = ("few", "few unworn"), "few unworn"
MONITORING, INSPECTION = "monitoring", "inspections"
LIFE, EVERY, LONGER = 2000, 5, 1.3
KNEE, FASTER = (0.3, 0.9), (3.0, 8.0)  # share of the life at which the rate changes; its factor
FAILS = (0.7, 0.97)  # share of the wear at which a limit is reached
SCATTER, ONSET, STEP = 0.004, 0.3, 0.2  # share, ms, ms
TRIES = 100
TIMES = np.arange(-8.0, 64.0, STEP)
MEASURED = {"closing": ["stroke", "travel_time"], "opening": ["stroke", "travel_time"]}
CLEAR = 6.0  # percent of a parameter, or scatters of a measured quantity, that make a limit
NEVER = Limit("never", "", (("f", -100.0, False),), of="change")  # of a life without limits
FEWEST = 10  # new records from which on their own scatter counts, not that of all
TOLERANCE = {"measured": 0.05, "changed": 0.1}  # shares, of drives that do not wear
ASKED = 3  # operations of a life at which it is asked
INTERVAL = ("low", "middle", "high")  # columns of an answer
INSPECTIONS, FEW_INSPECTIONS = 20, 10  # in a life, where nobody monitors
LEAD = "lead of the plan, share of the life"
UNCHANGED = 0.05  # probability of no change, below which a parameter is reported as changed
RESAMPLES, ABOUT = 2000, 31  # lives drawn again; readings about an operation
COLUMNS = [
    *("set", "life", "family", "score", "name", "truth", *INTERVAL, "operation", "kind", "names"),
    *("count", "records", "fails", "first", "service", "moves", "known", "shown"),
]


@dataclass
class Life:
    """A drive that wears: new, worn, and how fast."""

    new: Drive
    worn: Drive
    knee: float
    faster: float
    pace: float = 1.0  # of the wear for which limits are set
    at_inspection: int = 0  # records, where there are few
    length, every = LIFE, EVERY

    @property
    def operations(self) -> np.ndarray:
        """Operations with a record: each fifth, or some at each of a few inspections."""
        if not self.at_inspection:
            return np.arange(EVERY, LIFE + 1, EVERY)
        first = LIFE // FEW_INSPECTIONS * np.arange(1, FEW_INSPECTIONS + 1) - self.at_inspection + 1
        return (first[:, None] + np.arange(self.at_inspection)).ravel()

    @classmethod
    def drawn(cls, name: str, config: Mapping, rng: np.random.Generator) -> "Life":
        """Draw a life of a set."""
        family = Family(Prior.from_settings(config["prior"]), family_of("medium_voltage"))
        worn = None
        while worn is None:
            new = family.new(rng)
            with suppress(RuntimeError):  # hardly any worn condition of this drive is possible
                worn = family.worn(new, rng, "sparse")
        knee = LIFE * rng.uniform(*KNEE)
        faster = float(np.exp(rng.uniform(*np.log(FASTER))))
        if rng.random() < 0.5 or name == UNWORN:
            knee, faster = LIFE, 1.0
        few = int(rng.integers(1, 3)) if name in FEW else 0
        return cls(new, worn, knee, faster, float(name != UNWORN), few)

    def reached(self, share: float) -> float:
        """Return the operation at which a share of the wear is reached."""
        way = share * (self.knee + self.faster * (LIFE - self.knee))
        return way if way <= self.knee else self.knee + (way - self.knee) / self.faster

    def at(self, operation: float, noise: Mapping[str, float], pace: float) -> Drive:
        """Return the drive at an operation; its numbers times ``1 + noise``."""
        way = min(pace * operation, self.knee)
        way += self.faster * max(pace * operation - self.knee, 0.0)
        share = way / (self.knee + self.faster * (LIFE - self.knee))
        changed = {}
        for name in (*NAMES, *noise):
            new, worn = self.new.value(name), self.worn.value(name)
            changed[name] = (new + share * (worn - new)) * (1.0 + noise.get(name, 0.0))
        return self.new.changed(**changed)


def simulate(life: Life, config: Mapping, rng: np.random.Generator) -> tuple[Series, pd.DataFrame]:
    """Return records of a life, and its truth: parameters, and quantities of curves without noise.

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
            drive = life.at(operation, noise, life.pace)
            if drive.holds:
                break
        drives.append(drive)
    travels = {m: [partial(drive.travel, m) for drive in drives] for m in MEASURED}
    motions = {m: recorded(travels[m], m, sensor, reading, rng) for m in MEASURED}
    stages = np.unique(np.append(np.linspace(0.0, LONGER * LIFE, 53).round(), round(life.knee)))
    rows = []
    for stage in stages:
        drive = life.at(stage, {}, 1.0)
        if not drive.holds:
            break
        row = dict(zip(NAMES, drive.theta, strict=True)) | {"operation": stage}
        for motion, quantities in MEASURED.items():
            values = measured(drive.travel(motion, TIMES), motion)
            row |= {f"{motion} {q}": values[q].value if values else np.nan for q in quantities}
        rows.append(row)
    return series_of(operations, motions), pd.DataFrame(rows).set_index("operation")


def series_of(operations: np.ndarray, motions: Mapping[str, MotionRecords]) -> Series:
    """Return the series of records of which none is missing."""
    inspections = inspections_of(operations)
    new = new_of({motion: records.there for motion, records in motions.items()}, inspections)
    return Series(operations, motions, new, {}, inspections=inspections)


def measured(curve: np.ndarray, motion: str) -> dict[str, Measured]:
    """Measure a curve; a curve without a motion has no quantities."""
    with suppress(ValueError, FloatingPointError):
        return measure_curve(TIMES, curve, motion, speeds=())
    return {}


def simulate_other(
    life: OtherLife, config: Mapping, rng: np.random.Generator
) -> tuple[Series, pd.DataFrame]:
    """Return the same of a drive of the independent simulator."""
    sensor, reading = Sensor(**config["sensor"]), Reading.draw(rng)
    curves, operations = Curves(life), life.operations
    travels = records_of(life, curves, operations, rng)
    motions = {m: recorded(travels[m], m, sensor, reading, rng) for m in MEASURED}
    truth = truth_of(life, curves, TIMES, measured)
    columns = [*NAMES, *(f"{m} {q}" for m in MEASURED for q in MEASURED[m])]
    return series_of(operations, motions), truth[columns]


def recorded(travels, motion: str, sensor: Sensor, reading: Reading, rng) -> MotionRecords:
    """Record travels, functions of times after the start of motion, normalised."""
    sign = 1.0 if motion == "closing" else -1.0
    ways, presents, noises, rows, like = [], [], [], [], None
    for travel in travels:
        late = ONSET * rng.standard_normal()
        record = reading.corrupt(travel(TIMES - late), sensor, rng)
        like = like or shape_of(sign * record, STEP)
        shape = shape_of(sign * record, STEP, like)
        sd = max(float(record[:35].std()), reading.quantum / np.sqrt(12.0))
        noises.append(network_record(shape, sd, reading.colour, STEP, like).noise[0])
        ways.append(shape.way)
        presents.append(shape.present)
        rows.append(measured(record, motion))
    none = Measured(np.nan, np.nan, "")
    read = {q: np.array([row.get(q, none)[:2] for row in rows]).T for q in MEASURED[motion]}
    values, sds = ({q: pair[k] for q, pair in read.items()} for k in (0, 1))
    units = like.stroke, like.duration
    return MotionRecords(np.array(ways), np.array(presents), np.array(noises), *units, values, sds)


def limits_of(truth: pd.DataFrame, series: Series, life, rng) -> dict[Limit, float]:
    """Choose limits that the drive reaches, one of each kind, and return when it does."""
    fails = life.reached(rng.uniform(*FAILS))
    whole, limits = np.arange(0.0, LONGER * life.length), {}
    dense = {n: np.interp(whole, truth.index, truth[n]) for n in truth.columns}
    new = slice(0, int(series.operations[series.new[-1]]) + 1)

    def add(kind: str, of: str, motion: str, quantity: str, values: np.ndarray, end: float) -> None:
        upper = bool(end > values[new].mean())
        over = values > end if upper else values < end
        if over.any() and not over[new].any():
            limit = Limit(kind, motion, ((quantity, end, upper),), of=of)
            limits[limit] = float(whole[over.argmax()])

    candidates = []
    for motion, records in series.motions.items():
        for name, values in records.measured.items():
            scatter = np.nanstd(np.diff(values[: series.new.size])) / np.sqrt(2.0)
            if series.new.size < FEWEST:  # of all, about a line from a record to the next but one
                scatter = np.nanstd(np.diff(values, 2)) / np.sqrt(6.0)
            end = np.interp(fails, whole, dense[f"{motion} {name}"])
            if abs(end - np.nanmean(values[: series.new.size])) > CLEAR * scatter:
                candidates.append((motion, name, float(end)))
    for motion, name, end in one_of(candidates, rng):
        add("measured", "record", motion, name, dense[f"{motion} {name}"], end)
    percent = {n: 100.0 * (dense[n] / dense[n][new].mean() - 1.0) for n in NAMES}
    ends = {n: float(np.interp(fails, whole, percent[n])) for n in NAMES}
    clear = [n for n in NAMES if n not in UNRESOLVED and abs(ends[n]) > CLEAR]
    for name in one_of(clear, rng):
        add("changed", "change", "", name, percent[name], ends[name])
    return limits


def tolerances(series: Series) -> dict[Limit, float]:
    """Return limits by ``TOLERANCE`` from new, as users have them; the drive reaches none."""
    limits = []
    for motion, records in series.motions.items():
        for name, values in records.measured.items():
            upper, new = name == "travel_time", float(np.nanmean(values[series.new]))
            end = new * (1.0 + TOLERANCE["measured"] * (1.0 if upper else -1.0))
            parts = ((name, end, upper),)
            limits.append(Limit(f"measured {motion} {name}", motion, parts, of="record"))
    for name, span in family_of("medium_voltage")["wear"]["change"].items():
        if name in NAMES and name not in UNRESOLVED:
            end = 100.0 * TOLERANCE["changed"] * float(np.sign(np.sum(span)))
            limits.append(Limit(f"changed {name}", "", ((name, end, end > 0.0),), of="change"))
    return dict.fromkeys(limits, np.inf)


def one_of(some: list, rng) -> list:
    """Draw one of them, if there is any."""
    return [some[rng.integers(len(some))]] if some else []


def simulated(name: str, number: int, seed: int, config: Mapping) -> tuple:
    """Draw and simulate one life; return it, its records and truth, and the generator."""
    for attempt in range(TRIES):
        rng = generator(seed, "benchmark of lives", name, number, attempt)
        with suppress(ValueError):  # a drive that is not possible all along its life
            if name == "other":
                other = OtherLife.drawn(Prior.from_settings(config["prior"]), rng)
                return other, *simulate_other(other, config, rng), rng
            life = Life.drawn(name, config, rng)
            return life, *simulate(life, config, rng), rng
    raise RuntimeError(f"none of {TRIES} drives of '{name}' is possible all along its life")


def scored(name: str, number: int, seed: int, config: Mapping, networks) -> list[dict]:
    """Simulate and follow one life, and return its rows."""
    life, series, truth, rng = simulated(name, number, seed, config)
    limits = tolerances(series) if name == UNWORN else limits_of(truth, series, life, rng)
    settings = config["trend"]
    readout = Readout.of(series, networks, draws=settings["draws"], seed=seed, misfit_p_value=0.001)
    path = Follower(series, readout.coordinates.blocks(series), settings["threshold"]).path()
    data = forecast_of(readout, path, list(limits) or [NEVER], Future(settings["horizon"]))
    about = {"set": name, "life": number, "family": data.attrs["family"]}
    start, looks = data.attrs["reported_from"], looked_at(life, data, config["planning"])
    if name == UNWORN:
        return [about | row for row in alarms_of(data, looks)]
    rng, rows = generator(seed, "benchmark of lives, asked", name, number), []
    for limit, fails in limits.items():
        left = left_of(limit.name, fails, data, start, rng)
        rows += [about | row | {"names": " ".join(limit.quantities)} for row in left]
        shown = shown_beyond(limit, readout.series)
        for way, stands in looks.items():
            rows.append(about | {"kind": way, "shown": shown} | acted(limit.name, fails, stands))
    where = rng.choice(data.asked.values[data.asked.values >= start], ASKED, replace=False)
    new = readout.series.operations[readout.series.new]
    reference = np.mean([_at(truth[list(NAMES)], operation) for operation in new], axis=0)
    for operation in where:
        true = 100.0 * (_at(truth[list(NAMES)], operation) / reference - 1.0)
        intervals = data.changed.sel(asked=operation).values
        for parameter, truly, interval in zip(NAMES, true, intervals, strict=True):
            change = {"score": "change", "name": parameter, "truth": truly}
            rows.append(about | change | dict(zip(INTERVAL, interval, strict=True)))
    return rows


def looked_at(life, data: xr.Dataset, planning: Mapping) -> dict[str, xr.Dataset]:
    """Return the states, where every record is looked at, and where inspections read them."""
    if getattr(life, "at_inspection", 0):
        planning = {**planning, "inspection": f"{LIFE // FEW_INSPECTIONS} operations"}
        return {INSPECTION: states_of(data, planning)}
    between = max(round(life.length / INSPECTIONS), 1)
    asked = data.asked.values
    inspections = np.arange(between, asked[-1] + 1, between)
    last = np.searchsorted(asked, inspections, side="right") - 1
    some = data.sel(asked=np.unique(asked[np.maximum(last, 0)]))
    ways = {MONITORING: (data, life.every), INSPECTION: (some, between)}
    return {
        way: states_of(answers, {**planning, "inspection": f"{apart} operations"})
        for way, (answers, apart) in ways.items()
    }


def _at(table: pd.DataFrame, operation: float) -> np.ndarray:
    return np.array([np.interp(operation, table.index, table[n]) for n in table])


def alarms_of(data: xr.Dataset, looks: Mapping[str, xr.Dataset]) -> list[dict]:
    """Return what is reported of a drive that does not wear: when first, and how long watched."""
    start, end, rows = data.attrs["reported_from"], float(data.operation[-1]), []

    def add(way: str, what: str, limit: str, operations: np.ndarray) -> None:
        first = float(operations[0]) if operations.size else np.inf
        about = {"kind": way, "names": what, "name": limit, "first": first}
        about["count"] = operations.size
        rows.append({"score": "alarm", "operation": min(first, end) - start} | about)

    way = next(iter(looks))  # of what is reported at every record, whoever looks
    for name, stands in looks.items():
        for limit in stands.limit.values:
            for state in ("planned", "due"):
                on = stands.state.sel(limit=limit).values >= STATES.index(state)
                add(name, state, limit, stands.operation.values[on])
    named = (data.unchanged.values < UNCHANGED).any(axis=1) & (data.asked.values >= start)
    add(way, "worn", "", data.asked.values[named])
    add(way, "change", "", data.noticed.values)
    return rows


def left_of(limit: str, fails: float, data: xr.Dataset, start: int, rng) -> list[dict]:
    """Return the operations left, at random operations before a failure."""
    asked = data.asked.values[(data.asked.values >= start) & (data.asked.values < fails)]
    some = rng.choice(asked, min(ASKED, asked.size), replace=False) if asked.size else []
    rows = []
    for operation in some:
        one = data.sel(asked=operation, limit=limit)
        left = {"score": "left", "name": limit, "operation": operation, "truth": fails - operation}
        rows.append(left | dict(zip(INTERVAL, one.remaining.values, strict=True)))
    return rows


def shown_beyond(limit: Limit, series: Series) -> float:
    """Return the first operation about which records show a quantity beyond its limit, or inf.

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
    """Return what obeying leads to: when a service is first planned and done, moves of its date.

    ``known`` is whether anything is reported of the limit when it fails, or at its service;
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
    stated = np.isfinite(one.service_by.values) & one.remaining.notnull().all("quantile").values
    last = operations + one.remaining.values[:, 0].round()
    return {
        "records": int(stated.sum()),
        "count": int((one.service_by.values > last)[stated].sum()),
        "score": "acted",
        "name": limit,
        "fails": fails,
        "first": first,
        "service": service,
        "moves": int((by[1:] != by[:-1]).sum()) if by.size else 0,
        "known": bool(state[max(at, 0)] != STATES.index("unknown")),
    }


def follow(seed_name: str, file: str, *sets: str) -> None:
    """Follow all lives of a seed, and add their rows to a file; those that are there are done."""
    config, seed = load(), SEEDS[seed_name]
    networks = [*shipped_networks()]
    done = pd.read_csv(file)[["set", "life"]] if Path(file).exists() else pd.DataFrame()
    known = set(done.itertuples(index=False, name=None))
    for name in sets or SETS:
        for number in tqdm(range(SETS[name]), desc=name, mininterval=10):
            if (name, number) not in known:
                rows = pd.DataFrame(scored(name, number, seed, config, networks))
                append(rows.reindex(columns=COLUMNS), file)


def drawn_again(count: int) -> np.ndarray:
    """Return indices of lives drawn again, ``(RESAMPLES, count)``."""
    return generator(1, "lives drawn again").integers(count, size=(RESAMPLES, count))


class Score(NamedTuple):
    """A score, how many numbers it is of, and its 90 % interval over lives drawn again."""

    value: float
    count: int
    low: float = np.nan
    high: float = np.nan

    @classmethod
    def share(cls, holds: pd.Series, lives: pd.Series) -> "Score":
        """Return the share of rows of lives for which something is true."""
        sums, sizes = holds.astype(float).groupby(lives.values).agg(["sum", "size"]).values.T
        again = drawn_again(len(sums))
        shares = sums[again].sum(axis=1) / sizes[again].sum(axis=1)
        return cls(holds.mean(), len(holds), *np.quantile(shares, [0.05, 0.95]).tolist())


def summed(some: pd.DataFrame) -> dict[str, Score]:
    """Return the scores of the rows of a set."""
    scores: dict[str, Score] = {}
    change = some[(some.score == "change") & some.low.notna()]
    for name, rows in change.groupby("name"):
        holds = (rows.low - 0.05 <= rows.truth) & (rows.truth <= rows.high + 0.05)
        scores[f"change of {name}: coverage of 90 % intervals"] = Score.share(holds, rows.life)
        half = ((rows.high - rows.low) / 2.0)[rows.truth.abs() > 1.0]
        words = f"change of {name}: half width, %, where it changed"
        scores[words] = Score(half.median(), len(half))
    for name, rows in some[(some.score == "left") & some.low.notna()].groupby("name"):
        holds = (rows.low <= rows.truth) & (rows.truth <= rows.high)
        scores[f"{name} limits: coverage of operations left"] = Score.share(holds, rows.life)
    for name, rows in some[(some.score == "acted") & (some.kind == INSPECTION)].groupby("name"):
        intime = rows.service.fillna(np.inf) <= rows.fails
        scores[f"{name} limits: serviced in time, by inspections"] = Score.share(intime, rows.life)
    return scores


def planned_of(lives: pd.DataFrame) -> dict[str, float]:
    """Sum up how lives were serviced, by one way of looking, for one limit."""
    fails, service = lives.fails.values, lives.service.fillna(np.inf).values
    intime, rows = service <= fails, int(lives.records.sum())
    scores = {"recommended": lives.known.astype(bool).mean(), "serviced in time": intime.mean()}
    if lives.shown.notna().any():
        scores["serviced before records show it"] = (service <= lives.shown).mean()
    behind = lives["count"].sum() / rows if rows else np.nan
    scores["rows with service_by behind the 5 % quantile"] = behind
    away, lead = (fails - service) / fails, (service - lives["first"].values) / fails
    for name, shares in (("share of the life given away", away), (LEAD, lead)):
        scores[name] = float(np.median(shares[intime])) if intime.any() else np.nan
    scores["moves of service_by"] = float(lives.moves.median())
    if len(lives) > 2:
        words = "cost relative to a fixed interval", "the same, from (90 %)", "the same, to (90 %)"
        scores |= dict(zip(words, against_fixed(service, fails), strict=True))
    return scores


def against_fixed(service: np.ndarray, fails: np.ndarray) -> tuple[float, float, float]:
    """Return the cost of an operation, relative to a service at the best interval of other lives.

    Returns:
        The ratio, and its 90 % interval over lives drawn again.
    """
    settings = load()["planning"]
    costs = np.array([settings["service_cost"], settings["failure_cost"]])
    planned = costs[(service > fails).astype(int)], np.minimum(service, fails)
    tried = np.append(np.sort(fails), np.inf)
    over = tried[:, None] > fails  # an interval of just what a life lasts is in time
    cost, made = costs[over.astype(int)], np.minimum(tried[:, None], fails)
    others = (cost.sum(axis=1, keepdims=True) - cost) / (made.sum(axis=1, keepdims=True) - made)
    best, lives = others.argmin(axis=0), np.arange(len(fails))
    fixed = cost[best, lives], made[best, lives]

    def ratio(some: np.ndarray) -> np.ndarray:
        ours, theirs = (c[some].sum(-1) / m[some].sum(-1) for c, m in (planned, fixed))
        return ours / theirs

    again = ratio(drawn_again(len(fails)))
    return float(ratio(lives)), *np.quantile(again, [0.05, 0.95]).tolist()


def plans(rows: pd.DataFrame) -> pd.DataFrame:
    """Sum up how lives were serviced."""
    table = []
    for (of, name, way), lives in rows[rows.score == "acted"].groupby(["set", "name", "kind"]):
        row = {"set": of, "limit": name, "looked at": way, "lives": len(lives)} | planned_of(lives)
        left = rows[(rows.score == "left") & rows.low.notna() & (rows.set == of)]
        left = left[left.name == name]
        holds = (left.low <= left.truth) & (left.truth <= left.high)
        table.append(row | {"coverage of operations left": holds.mean(), "of": len(holds)})
    return pd.DataFrame(table)


def alarms(rows: pd.DataFrame) -> pd.DataFrame:
    """Sum up what was reported without cause."""
    planning = load()["planning"]
    yearly = planning["operations"] / planning["years"]
    some, table = rows[rows.score == "alarm"], []
    some = some.assign(name=some.name.fillna("").str.partition(" ")[0])
    for (of, what, limit, way), lives in some.groupby(["set", "names", "name", "kind"]):
        made, false = lives.operation.sum() / 1000.0, int(np.isfinite(lives["first"]).sum())
        rate = false / made if made else np.nan
        most = chi2.ppf(0.95, 2 * (false + 1)) / 2.0 / made if made else np.nan
        table.append(
            {"drives": of, "reported": what, "limit": limit, "looked at": way}
            | {"lives": lives.life.nunique(), "of": len(lives), "false": false}
            | {"operations": round(1000 * made), "in 1,000 operations": rate}
            | {"at most (95 %)": most, "a year": rate * yearly / 1000.0}
            | {"a year, at most (95 %)": most * yearly / 1000.0}
        )
    return pd.DataFrame(table)


def coverage(rows: pd.DataFrame) -> pd.DataFrame:
    """Sum up coverage and services in time, a column for each set."""
    sets = {name: summed(some) for name, some in rows.groupby("set")}
    scores = dict.fromkeys(score for own in sets.values() for score in own)
    table = []
    for score in scores:
        row = {"score": score}
        for name, own in sets.items():
            columns = (name, f"{name}_count", f"{name}_low", f"{name}_high")
            row |= zip(columns, own.get(score, Score(np.nan, 0)), strict=True)
        table.append(row)
    return pd.DataFrame(table)


def main(command: str, *arguments: str) -> None:
    """Follow lives, or sum up files of rows; the last file is written."""
    if command == "follow":
        follow(*arguments)
        return
    rows = pd.concat([pd.read_csv(file) for file in arguments[:-1]])
    table = {"table": coverage, "plans": plans, "alarms": alarms}[command](rows)
    print(table.to_string(index=False))
    table.to_csv(arguments[-1], index=False, float_format="%.3g")


if __name__ == "__main__":
    main(*sys.argv[1:])
