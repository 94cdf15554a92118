"""Two visits of few records each: how often intervals of a change hold, and what is noticed.

    python -m benchmarks.visits --records 3 --rows visits.csv
    python -m benchmarks.visits --rows visits.csv --table docs/visits.csv

Rigs of the family held back (docs/rigs.md), a third of them unchanged, the others worn as over a
life; sensors round and have coloured noise as there; all seven parameters scatter by 0.4 % from
operation to operation. Each visit has so many records of each motion. The rows of each rig are
added to a file, so that an interrupted run continues; ``--table`` sums them up.
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
from breaker.synthetic import Drive, Reading, family_of
from breaker.synthetic.judged import record_of
from breaker.workflow import read

SCATTER = 0.004
LEFT_OUT = 0.02  # mm, as posterior.sizing adds to the noise that is read
SIZES = (0.0, 2.0, 5.0, 10.0, 20.0, np.inf)  # percent, of true changes


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


def one_rig(number: int, count: int, config: dict, models: dict) -> pd.DataFrame:
    """Compare two visits to a rig; a row for each parameter and quantity."""
    family = family_of("held_back", models["closing"].prior, config["rigs"], config["judged"])
    rng = generator(51, "benchmark of visits", number)
    new = family.new(rng)
    worn, reading = family.worn(new, rng), Reading.draw(config["judged"], rng)
    noise = float(np.hypot(np.hypot(0.1, LEFT_OUT), reading.quantum / np.sqrt(12.0)))
    known = {m: at_size(model, UNIT, 0.0, noise) for m, model in models.items()}
    drives = new, new if number % 3 == 0 else worn
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
        whole = {"rig": number, "records": count, "worn": number % 3 > 0}
        whole |= {"resolved": found.resolved, "apart": len(found.motions) == 1}
        whole |= {"size": found.importance.size, "p_value": found.p_value}
        rows.append(pd.DataFrame(whole | about))
    return pd.concat(rows)


def summed(rows: pd.DataFrame) -> pd.DataFrame:
    """Coverage and what is noticed, by records of a visit and parameter or quantity."""
    rows = rows[rows.resolved & rows.truth.notna() & rows.lower.notna()].copy()
    rows["holds"] = (rows.lower <= rows.truth) & (rows.truth <= rows.upper)
    rows["width"] = 0.5 * (rows.upper - rows.lower)
    rows["noticed"] = rows.beyond >= 0.95
    rows["ruled_out"] = rows.beyond <= 0.05
    rows["true_change"] = pd.cut(rows.truth.abs(), SIZES, include_lowest=True)
    changed = rows[rows.truth.abs() > 5.0]
    found = rows.groupby(["records", "motion", "name"], dropna=False, sort=False).agg(
        rigs=("holds", "size"), holds=("holds", "mean"), half_width=("width", "median")
    )
    worn = rows[rows.worn].groupby(["records", "motion", "name"], dropna=False, sort=False)
    found["holds_worn"] = worn.holds.mean()
    by = changed.groupby(["records", "motion", "name"], dropna=False, sort=False)
    found["beyond_5"], found["noticed"] = by.size(), by.noticed.mean()
    still = rows[rows.truth.abs() <= 5.0].groupby(["records", "motion", "name"], dropna=False)
    found["false"], found["ruled_out"] = still.noticed.mean(), still.ruled_out.mean()
    return found.reset_index()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--rigs", type=int, default=60)
    parser.add_argument("--records", type=int, help="of each motion and visit")
    parser.add_argument("--rows", type=Path, required=True, metavar="CSV")
    parser.add_argument("--table", type=Path, metavar="CSV")
    options = parser.parse_args()
    if options.records:
        config, models = read(DEFAULTS), {motion: reference_model(motion) for motion in MOTIONS}
        there = pd.read_csv(options.rows) if options.rows.exists() else None
        done = set() if there is None else {*there.rig[there.records == options.records]}
        for number in sorted(set(range(options.rigs)) - done):
            rows = one_rig(number, options.records, config, models)
            rows.to_csv(
                options.rows,
                mode="a",
                header=not options.rows.exists(),
                index=False,
                float_format="%.6g",
            )
    if options.table:
        summed(pd.read_csv(options.rows)).to_csv(options.table, index=False, float_format="%.3g")


if __name__ == "__main__":
    main()
