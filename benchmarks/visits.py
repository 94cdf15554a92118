"""Two visits of few records each: how often intervals of a change hold, and what is noticed.

    python -m benchmarks.visits --records 3 --rows visits.csv
    python -m benchmarks.visits --records 3 --rows visits.csv --change 10
    python -m benchmarks.visits --rows visits.csv --table docs/visits.csv

Rigs of the family held back (docs/rigs.md), a third of them unchanged, the others worn as over a
life; sensors round and have coloured noise as there; all seven parameters scatter by 0.4 % from
operation to operation. With ``--change`` each rig has one parameter changed by so many percent
instead, by turns and in the way that it wears, and elements worn as drawn. Each visit has so many
records of each motion; the noise is known as a reader sees it at rest, rounding included. The rows
of each rig are added to a file, so that an interrupted run continues; ``--table`` sums them up.
"""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd

from breaker.answers import changes
from breaker.mechanism import MOTIONS, NAMES, UNIT
from breaker.model import generator, reference_model
from breaker.posterior import Compared, compare_visits
from breaker.posterior.sizing import at_size
from breaker.shipped import DEFAULTS
from breaker.synthetic import Drive, Family, Reading, family_of
from breaker.synthetic.judged import record_of
from breaker.workflow import read

SCATTER = 0.004
LEFT_OUT = 0.02  # mm, as posterior.sizing adds to the noise that is read


def visit(drive: Drive, models: dict, count: int, reading: Reading, rng) -> dict:
    """Records of a visit by motion, ``(count, t)``, mm."""
    found = {}
    for motion, model in models.items():
        records = []
        while len(records) < count:
            factors = np.exp(SCATTER * rng.standard_normal(len(NAMES)))
            moved = dict(zip(NAMES, np.array(drive.theta) * factors, strict=True))
            record = record_of(drive.changed(**moved), model.sensor, motion, reading, rng)
            records += [record] if np.isfinite(record).all() else []
        found[motion] = np.array(records)
    return found


def planted(family: Family, number: int, change: float, rng) -> tuple[Drive, Drive]:
    """A drive, and the same with one parameter changed by percent, and elements as they wear."""
    ranges = family.settings["wear"]["change"]
    worn = [name for name in NAMES if name in ranges]
    name = worn[number % len(worn)]
    factor = 1.0 + np.copysign(change, np.sum(ranges[name])) / 100.0
    while True:
        new = family.new(rng)
        elements = {key: by for key, by in family.wear(rng).items() if key not in NAMES}
        changed = {key: new.value(key) * (1.0 + by) for key, by in elements.items()}
        later = new.changed(**changed, **{name: new.value(name) * factor})
        if later.holds and family.prior.supported(np.array(later.theta)):
            return new, later


def one_rig(
    number: int, count: int, change: float | None, config: dict, models: dict
) -> pd.DataFrame:
    """Compare two visits to a rig; a row for each parameter and quantity."""
    family = family_of("held_back", models["closing"].prior, config["rigs"], config["judged"])
    rng = generator(51, "benchmark of visits", number)
    if change is None:
        new = family.new(rng)
        worn = family.worn(new, rng)
        drives = new, new if number % 3 == 0 else worn
    else:
        drives = planted(family, number, change, rng)
    reading = Reading.draw(config["judged"], rng)
    noise = float(np.hypot(np.hypot(0.1, LEFT_OUT), reading.quantum / np.sqrt(12.0)))
    known = {m: at_size(model, UNIT, 0.0, noise) for m, model in models.items()}
    before, after = (visit(each, models, count, reading, rng) for each in drives)
    records = {m: np.concatenate([before[m], after[m]]) for m in models}
    today = dict.fromkeys(models, np.arange(2 * count) >= count)
    rows = []
    for found in compare_visits(known, records, today, config["correction"], rng):
        thetas = (np.array([each.theta]) for each in drives)
        truth = Compared(found.motions, *thetas, True, "", found.importance, 1.0, 1.0)
        table, true = changes(found), changes(truth)
        lower, median, upper = table.change.values.T
        about = {
            "motion": table.motion.values,
            "name": table["name"].values,
            "truth": true.change.sel(quantile=0.5).values,
            **{"lower": lower, "median": median, "upper": upper},
            "beyond": table.beyond.values,
        }
        whole = {"rig": number, "records": count, "change": change}
        whole |= {"worn": drives[0] is not drives[1]}
        whole |= {"resolved": found.resolved, "apart": len(found.motions) == 1}
        whole |= {"size": found.importance.size, "p_value": found.p_value}
        rows.append(pd.DataFrame(whole | about))
    return pd.concat(rows)


def summed(rows: pd.DataFrame) -> pd.DataFrame:
    """Coverage and what is noticed, by records of a visit and parameter or quantity.

    ``holds``: share of 90 % intervals with the truth, ``holds_changed`` where it is beyond 1 %;
    ``half_width``: median, percent; ``sure_N`` and ``seen_N``: share of planted changes of N %
    (of parameters) that are told to be beyond 5 %, and whose interval does not hold 0;
    ``false_sure`` and ``false_seen``: the same of parameters and quantities that have not changed;
    ``ruled_out``: share of these that are told not to have changed beyond 5 %.
    """
    rows = rows[rows.resolved & rows.truth.notna() & rows.lower.notna()].copy()
    rows["holds"] = (rows.lower <= rows.truth) & (rows.truth <= rows.upper)
    rows["half_width"] = 0.5 * (rows.upper - rows.lower)
    rows["sure"], rows["ruled_out"] = rows.beyond >= 0.95, rows.beyond <= 0.05
    rows["seen"] = (rows.lower > 0.0) | (rows.upper < 0.0)
    by = ["records", "name", "motion"]
    drawn, own = rows[rows.change.isna()], rows[rows.change.notna()]

    def of(some: pd.DataFrame, value: str) -> pd.Series:
        return some.groupby(by, dropna=False, sort=False)[value]

    found = of(drawn, "holds").agg(rigs="size", holds="mean")
    found["holds_changed"] = of(drawn[drawn.truth.abs() > 1.0], "holds").mean()
    found["half_width"] = of(drawn, "half_width").median()
    for change, some in own.groupby("change"):
        there = some[some.truth.abs().sub(change).abs() < 0.01 * change]
        there = there[there["name"].isin(NAMES)]
        for value in ("sure", "seen"):
            found[f"{value}_{change:g}"] = of(there, value).mean()
    still = drawn[~drawn.worn]
    for name, value in {
        "false_sure": "sure",
        "false_seen": "seen",
        "ruled_out": "ruled_out",
    }.items():
        found[name] = of(still, value).mean()
    return found.reset_index()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--rigs", type=int, default=60)
    parser.add_argument("--records", type=int, help="of each motion and visit")
    parser.add_argument("--change", type=float, metavar="PERCENT")
    parser.add_argument("--rows", type=Path, required=True, metavar="CSV")
    parser.add_argument("--table", type=Path, metavar="CSV")
    options = parser.parse_args()
    if options.records:
        config, models = read(DEFAULTS), {motion: reference_model(motion) for motion in MOTIONS}
        done = set()
        if options.rows.exists():
            there = pd.read_csv(options.rows)
            same = there.change.fillna(0.0) == (options.change or 0.0)
            done = {*there.rig[same & (there.records == options.records)]}
        for number in sorted(set(range(options.rigs)) - done):
            rows = one_rig(number, options.records, options.change, config, models)
            new = not options.rows.exists()
            rows.to_csv(options.rows, mode="a", header=new, index=False, float_format="%.6g")
    if options.table:
        summed(pd.read_csv(options.rows)).to_csv(options.table, index=False, float_format="%.3g")


if __name__ == "__main__":
    main()
