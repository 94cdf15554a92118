"""Lives of drives from new to failure, with forecasts and decisions as for a user.

    python -m studies.lives --rows results/lives.csv --cores 2   # makes lives, plans and alarms.csv

Sets: ``other``, drives of the independent simulator (``studies.other_lives``); ``few``, drives of
the family of the networks with few records (``studies.family_lives``); ``few unworn``, the same
without wear, so that each report is a false alarm. Lives in the file of rows are not followed
again. The seed was used neither to develop nor to calibrate ``trend`` and ``Future``.

Each life has a limit on a measured quantity, and one on the change of a parameter. Limits are the
values at a random share of the wear, if these change enough. A service is done at the operation by
which it is planned: with ``MONITORING``, from all records, and with ``INSPECTION``, from records
read at each twentieth of the life. The cost of a life, divided by its operations, is compared with
a service at a fixed interval, which is the cheapest in all other lives of the set. A life that is
never serviced fails.
"""

import argparse
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from scipy.stats import chi2
from tqdm import tqdm

from breaker.common.randomness import generator
from breaker.configuration.data_files import family_of
from breaker.configuration.loading import load
from breaker.family.networks import shipped_networks
from breaker.model.limits import UNRESOLVED, Limit
from breaker.model.parameters import NAMES
from breaker.model.prior import Prior
from breaker.model.sensor import Sensor
from breaker.prognosis.forecast import Future
from breaker.prognosis.life import forecast_of
from breaker.prognosis.limit_states import STATES, states_of
from breaker.prognosis.readout import Readout
from breaker.prognosis.series import Series, inspections_of, new_of
from breaker.prognosis.trend import Follower
from studies.family_lives import INSPECTIONS, LONGER, NAME, FamilyLife
from studies.other_lives import OtherLife
from studies.sensors import Reading, recorded
from studies.shared import append, in_pool, sampled

SEED, SETS = 75, {"other": 20, "few": 24, "few unworn": 24}
MONITORING, INSPECTION = "monitoring", "inspections"
READ = 20  # inspections of a life of ``other``
FAILS = (0.7, 0.97)  # share of the wear at which a limit is reached
CLEAR = 6.0  # least change for a limit: percent of a parameter, scatters of a measured quantity
NEVER = Limit("never", "", (("f", -100.0, False),), of="change")  # for a life without limits
FEWEST = 10  # new records from which their own scatter is used, not the scatter of all records
TOLERANCE = {"measured": 0.05, "changed": 0.1}  # shares, for drives that do not wear
TRIES, ASKED = 100, 3  # draws until a drive is possible; operations of a life that are scored
UNCHANGED = 0.05  # probability of no change, below which a parameter is reported as changed
ROOM = 0.05  # percent by which a change may be outside its interval, for changes of zero
RESAMPLES = 2000  # of lives, for intervals of 90 %
COLUMNS = [
    *("set", "life", "score", "kind", "name", "truth", "low", "high"),
    *("fails", "service", "operations", "false"),
]

Life = OtherLife | FamilyLife


def simulate(name: str, number: int) -> tuple[Life, Series, pd.DataFrame, np.random.Generator]:
    """Draw a life; return it, its records and truth, and the generator."""
    config = load()
    prior, sensor = Prior.from_settings(config["prior"]), Sensor(**config["sensor"])
    for attempt in range(TRIES):
        rng = generator(SEED, "benchmark of lives", name, number, attempt)
        with suppress(ValueError):  # a drive that is not possible all along its life
            if name == "other":
                life = OtherLife.drawn(prior, rng)
            else:
                life = FamilyLife.drawn(prior, rng, wears=name != "few unworn")
            reading, operations = Reading.draw(rng), life.operations
            travels = life.travels(rng).items()
            motions = {m: recorded(own, m, sensor, reading, rng) for m, own in travels}
            inspections = inspections_of(operations)
            new = new_of({m: records.there for m, records in motions.items()}, inspections)
            series = Series(operations, motions, new, {}, inspections=inspections)
            return life, series, life.truth(), rng
    raise RuntimeError(f"none of {TRIES} drives of '{name}' is possible all along its life")


def limits_of(
    truth: pd.DataFrame, series: Series, life: Life, rng: np.random.Generator
) -> dict[Limit, float]:
    """Choose limits that the drive reaches, one of each kind, and return the operations."""
    fails = life.reached(rng.uniform(*FAILS))
    operations, limits = np.arange(0.0, LONGER * life.length), {}
    dense = {n: np.interp(operations, truth.index, truth[n]) for n in truth.columns}
    new = slice(0, int(series.operations[series.new[-1]]) + 1)

    def add(kind: str, of: str, motion: str, quantity: str, values: np.ndarray, end: float) -> None:
        upper = bool(end > values[new].mean())
        over = values > end if upper else values < end
        if over.any() and not over[new].any():
            limit = Limit(kind, motion, ((quantity, end, upper),), of=of)
            limits[limit] = float(operations[over.argmax()])

    candidates = []
    for motion, records in series.motions.items():
        for name, values in records.measured.items():
            scatter = np.nanstd(np.diff(values[: series.new.size])) / np.sqrt(2.0)
            if series.new.size < FEWEST:  # second differences of all records
                scatter = np.nanstd(np.diff(values, 2)) / np.sqrt(6.0)
            end = np.interp(fails, operations, dense[f"{motion} {name}"])
            if abs(end - np.nanmean(values[: series.new.size])) > CLEAR * scatter:
                candidates.append((motion, name, float(end)))
    for motion, name, end in at_most_one(candidates, rng):
        add("measured", "record", motion, name, dense[f"{motion} {name}"], end)
    percent = {n: 100.0 * (dense[n] / dense[n][new].mean() - 1.0) for n in NAMES}
    ends = {n: float(np.interp(fails, operations, percent[n])) for n in NAMES}
    clear = [n for n in NAMES if n not in UNRESOLVED and abs(ends[n]) > CLEAR]
    for name in at_most_one(clear, rng):
        add("changed", "change", "", name, percent[name], ends[name])
    return limits


def at_most_one(candidates: list, rng: np.random.Generator) -> list:
    """Draw one of the candidates, if there are any."""
    return [candidates[rng.integers(len(candidates))]] if candidates else []


def tolerances(series: Series) -> list[Limit]:
    """Return limits at ``TOLERANCE`` from new values, as users define them."""
    limits = []
    for motion, records in series.motions.items():
        for name, values in records.measured.items():
            upper, new = name == "travel_time", float(np.nanmean(values[series.new]))
            end = new * (1.0 + TOLERANCE["measured"] * (1.0 if upper else -1.0))
            parts = ((name, end, upper),)
            limits.append(Limit(f"measured {motion} {name}", motion, parts, of="record"))
    for name, span in family_of(NAME)["wear"]["change"].items():
        if name in NAMES and name not in UNRESOLVED:
            end = 100.0 * TOLERANCE["changed"] * float(np.sign(np.sum(span)))
            limits.append(Limit(f"changed {name}", "", ((name, end, end > 0.0),), of="change"))
    return limits


def scored(name: str, number: int) -> list[dict]:
    """Simulate and follow one life, and return its rows."""
    config, (life, series, truth, rng) = load(), simulate(name, number)
    unworn, settings = name == "few unworn", config["trend"]
    limits = tolerances(series) if unworn else limits_of(truth, series, life, rng)
    fixed = {"draws": settings["draws"], "seed": SEED, "misfit_p_value": 0.001}
    readout = Readout.of(series, shipped_networks(), **fixed)
    path = Follower(series, readout.coordinates.blocks(series), settings["threshold"]).path()
    data = forecast_of(readout, path, list(limits) or [NEVER], Future(settings["horizon"]))
    looks = looked_at(life, data, config["planning"])
    rng = generator(SEED, "benchmark of lives, asked", name, number)
    if unworn:
        rows = alarms_of(data, looks[INSPECTION])
    else:
        rows = [row for limit, fails in limits.items() for row in left_of(limit, fails, data, rng)]
        for limit, fails in limits.items():
            rows += [serviced(limit, fails, mode, stands) for mode, stands in looks.items()]
        rows += changes_of(series, truth, data, rng)
    return [{"set": name, "life": number} | row for row in rows]


def looked_at(life: Life, data: xr.Dataset, planning: Mapping) -> dict[str, xr.Dataset]:
    """Return the states under monitoring of every record, and under periodic inspection."""

    def states(data: xr.Dataset, between: float) -> xr.Dataset:
        return states_of(data, {**planning, "inspection": f"{between} operations"})

    if isinstance(life, FamilyLife):
        return {INSPECTION: states(data, life.length // INSPECTIONS)}
    between, asked = round(life.length / READ), data.asked.values
    inspections = np.arange(between, asked[-1] + 1, between)
    last = np.searchsorted(asked, inspections, side="right") - 1
    inspected = data.sel(asked=np.unique(asked[np.maximum(last, 0)]))
    step = life.length / life.operations.size
    return {MONITORING: states(data, step), INSPECTION: states(inspected, between)}


def left_of(limit: Limit, fails: float, data: xr.Dataset, rng: np.random.Generator) -> list[dict]:
    """Return the true and forecast operations left, at random operations before a failure."""
    asked, rows = data.asked.values, []
    asked = asked[(asked >= data.attrs["reported_from"]) & (asked < fails)]
    for operation in rng.choice(asked, min(ASKED, asked.size), replace=False) if asked.size else []:
        low, _, high = data.remaining.sel(asked=operation, limit=limit.name).values
        row = {"score": "left", "name": limit.name, "truth": fails - operation}
        rows.append(row | {"low": low, "high": high})
    return rows


def changes_of(
    series: Series, truth: pd.DataFrame, data: xr.Dataset, rng: np.random.Generator
) -> list[dict]:
    """Return the true and estimated changes of parameters at random operations, percent."""

    def at(operation: float) -> np.ndarray:
        return np.array([np.interp(operation, truth.index, truth[name]) for name in NAMES])

    asked, rows = data.asked.values, []
    asked = asked[asked >= data.attrs["reported_from"]]
    new = np.mean([at(operation) for operation in series.operations[series.new]], axis=0)
    for operation in rng.choice(asked, ASKED, replace=False):
        true = 100.0 * (at(operation) / new - 1.0)
        intervals = data.changed.sel(asked=operation).values
        for name, truly, (low, _, high) in zip(NAMES, true, intervals, strict=True):
            row = {"score": "change", "name": name, "truth": truly}
            rows.append(row | {"low": low, "high": high})
    return rows


def serviced(limit: Limit, fails: float, mode: str, stands: xr.Dataset) -> dict:
    """Return the operation at which a service is done, inf if never.

    A planned service is done at its operation, if this is before the next inspection.
    """
    own, operations = stands.sel(limit=limit.name), stands.operation.values
    by = np.maximum(own.service_by.values, operations)
    planned = np.where(by < np.append(operations[1:], np.inf), by, np.inf)
    done = np.where(own.state.values == STATES.index("due"), operations, planned)
    row = {"score": "serviced", "kind": mode, "name": limit.name, "fails": fails}
    return row | {"service": float(done.min())}


def alarms_of(data: xr.Dataset, stands: xr.Dataset) -> list[dict]:
    """Return the reports on a drive that does not wear, with the operations until each."""
    start, end, rows = data.attrs["reported_from"], float(data.operation[-1]), []

    def add(kind: str, limit: str, operations: np.ndarray) -> None:
        until = float(operations[0]) if operations.size else end
        row = {"score": "alarm", "kind": kind, "name": limit, "operations": until - start}
        rows.append(row | {"false": int(operations.size > 0)})

    for limit in stands.limit.values:
        for state in ("planned", "due"):
            reached = stands.state.sel(limit=limit).values >= STATES.index(state)
            add(state, limit.partition(" ")[0], stands.operation.values[reached])
    named = (data.unchanged.values < UNCHANGED).any(axis=1) & (data.asked.values >= start)
    add("worn", "", data.asked.values[named])
    add("change", "", data.noticed.values)
    return rows


def resampled(count: int) -> np.ndarray:
    """Return bootstrap indices of lives, ``(RESAMPLES, count)``."""
    return generator(1, "lives drawn again").integers(count, size=(RESAMPLES, count))


def coverage(rows: pd.DataFrame) -> pd.DataFrame:
    """Return coverage by set, with 90 % bootstrap intervals over lives."""
    known, table = rows[rows.score.isin(["change", "left"]) & rows.low.notna()], []
    room = np.where(known.score == "change", ROOM, 0.0)
    inside = (known.low - room <= known.truth) & (known.truth <= known.high + room)
    for key, own in known.assign(inside=inside).groupby(["set", "score", "name"]):
        sums, sizes = own.inside.astype(float).groupby(own.life).agg(["sum", "size"]).values.T
        chosen = resampled(len(sums))
        shares = sums[chosen].sum(axis=1) / sizes[chosen].sum(axis=1)
        table.append([*key, own.inside.mean(), len(own), *np.quantile(shares, [0.05, 0.95])])
    columns = ["set", "score", "name", "coverage", "count", "low", "high"]
    return pd.DataFrame(table, columns=columns)


def plans(rows: pd.DataFrame) -> pd.DataFrame:
    """Return service in time and cost of lives of ``other``, by limit and mode of inspection."""
    table, lives = [], rows[(rows.score == "serviced") & (rows.set == "other")]
    for (limit, mode), own in lives.groupby(["name", "kind"]):
        fails, service = own.fails.values, own.service.fillna(np.inf).values
        row = [limit, mode, len(own), (service <= fails).mean()]
        table.append([*row, *against_fixed(service, fails)])
    columns = ["limit", "looked at", "lives", "serviced in time", "cost", "low", "high"]
    return pd.DataFrame(table, columns=columns)


def against_fixed(service: np.ndarray, fails: np.ndarray) -> tuple[float, float, float]:
    """Return the cost of an operation, relative to a service at the best interval of other lives.

    Returns:
        The ratio, and its 90 % bootstrap interval over lives.
    """
    settings = load()["planning"]
    costs = np.array([settings["service_cost"], settings["failure_cost"]])
    planned = costs[(service > fails).astype(int)], np.minimum(service, fails)
    tried = np.append(np.sort(fails), np.inf)
    over = tried[:, None] > fails  # an interval equal to a life is in time
    cost, made = costs[over.astype(int)], np.minimum(tried[:, None], fails)
    others = (cost.sum(axis=1, keepdims=True) - cost) / (made.sum(axis=1, keepdims=True) - made)
    best, lives = others.argmin(axis=0), np.arange(len(fails))
    fixed = cost[best, lives], made[best, lives]

    def ratio(chosen: np.ndarray) -> np.ndarray:
        ours, theirs = (c[chosen].sum(-1) / m[chosen].sum(-1) for c, m in (planned, fixed))
        return ours / theirs

    ratios = ratio(resampled(len(fails)))
    return float(ratio(lives)), *np.quantile(ratios, [0.05, 0.95]).tolist()


def alarms(rows: pd.DataFrame) -> pd.DataFrame:
    """Return numbers of false alarms, and upper limits of their rates in 1,000 operations, with a
    confidence of 95 %.
    """
    reports, table = rows[rows.score == "alarm"].fillna({"name": ""}), []
    for (kind, limit), own in reports.groupby(["kind", "name"]):
        made, false = own.operations.sum(), int(own.false.sum())
        most = 1000.0 * chi2.ppf(0.95, 2 * (false + 1)) / 2.0 / made if made else np.nan
        table.append([kind, limit, len(own), false, int(made), most])
    columns = ["reported", "limit", "of", "false", "operations", "at_most"]
    return pd.DataFrame(table, columns=columns)


def main() -> None:
    """Follow the lives that a file of rows does not have, and write the tables."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--rows", type=Path, default="results/lives.csv", metavar="CSV")
    given = sampled(options).parse_args()
    given.rows.parent.mkdir(parents=True, exist_ok=True)
    done = pd.read_csv(given.rows)[["set", "life"]] if given.rows.exists() else pd.DataFrame()
    known = set(done.itertuples(index=False, name=None))
    jobs = [(name, number) for name, count in SETS.items() for number in range(count)]
    jobs = [job for job in jobs if job not in known]
    for rows in tqdm(in_pool(scored, jobs, given.cores), total=len(jobs), mininterval=10):
        append(pd.DataFrame(rows).reindex(columns=COLUMNS), given.rows)
    rows = pd.read_csv(given.rows)
    for table in (coverage, plans, alarms):
        name = "lives" if table is coverage else table.__name__
        table(rows).to_csv(f"docs/{name}.csv", index=False, float_format="%.3g")


if __name__ == "__main__":
    main()
