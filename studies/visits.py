"""Two visits of few records each: how often intervals of a change hold, and what is noticed.

    python -m studies.visits --records 3 --rows visits.csv
    python -m studies.visits --records 3 --rows visits.csv --change 10
    python -m studies.visits --rows visits.csv --table docs/visits.csv

Rigs of the family held back (section `rigs` of the configuration), a third of them unchanged, the
others worn as over a life; half of the sensors round, and a quarter have coloured noise; all seven
parameters scatter by 0.4 % from operation to operation. With ``--change`` each rig has one of them
changed by so many percent instead, by turns and in the way that it wears, and elements worn as
drawn; with 0 nothing changes. Each visit has so many records of each motion, in files, which are
compared as `breaker compare` does. The rows of each rig are added to a file, so that an interrupted
run continues; ``--table`` sums them up.
"""

import argparse
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from breaker.common.randomness import generator
from breaker.configuration.definitions import family_of
from breaker.configuration.loading import defaults
from breaker.diagnosis.changes import Pair, compare, measured_changes
from breaker.diagnosis.reading import read_operations
from breaker.family.curve_file import write_curve
from breaker.family.drive_family import Family
from breaker.family.networks import shipped_networks
from breaker.family.rich_drive import Drive
from breaker.model.parameters import MOTIONS, NAMES
from breaker.model.prior import Prior
from breaker.model.quantities import speeds_of
from breaker.model.sensor import Sensor
from breaker.records.operations import Operation
from breaker.shipped import HELD_BACK
from studies.measuring import own_quantities
from studies.sensors import Reading
from studies.shared import append

SCATTER = 0.004
TIMES, RELEASE = 0.1 * np.arange(900), 15.0  # ms
SPEEDS = speeds_of(
    {f"{m}_speed_{a}_{b}": [f"{a} % of stroke", f"{b} % of stroke"]
     for m in MOTIONS for a, b in ((10, 50), (50, 90))}
)  # fmt: skip
OF_STROKE = ("over_travel", "opening_over_travel")


def visit(
    drive: Drive, count: int, sensor: Sensor, reading: Reading, rng: np.random.Generator
) -> dict[str, list]:
    """Records of a visit by motion, written and read; another one for each that cannot be used."""
    found: dict[str, list] = {motion: [] for motion in MOTIONS}
    with tempfile.TemporaryDirectory() as folder:
        for motion, raws in found.items():
            while len(raws) < count:
                factors = np.exp(SCATTER * rng.standard_normal(len(NAMES)))
                moved = drive.changed(**dict(zip(NAMES, drive.theta * factors, strict=True)))
                if not moved.holds:
                    continue
                late = RELEASE + sensor.onset_sd * rng.standard_normal()
                record = reading.corrupt(moved.travel(motion, TIMES - late), sensor, rng)
                write_curve(f"{folder}/a.csv", TIMES, record, motion=motion, operation=1)
                read_in = read_operations({motion: [Operation(1, f"{folder}/a.csv")]}, {})
                raws += [each.raw for each in read_in if not each.reason]
    return found


def planted(family: Family, number: int, change: float, rng) -> tuple[Drive, Drive]:
    """A drive, and the same with one parameter changed by percent, and elements as they wear."""
    ranges = family.settings["wear"]["change"]
    worn = [name for name in NAMES if name in ranges]
    name = worn[number % len(worn)]
    factor = 1.0 + np.copysign(change, np.sum(ranges[name])) / 100.0
    while True:
        new = family.new(rng)
        if not change:
            return new, new
        elements = {key: by for key, by in family.wear(rng).items() if key not in NAMES}
        changed = {key: new.value(key) * (1.0 + by) for key, by in elements.items()}
        later = new.changed(**changed, **{name: new.value(name) * factor})
        if later.holds and family.prior.supported(np.array(later.theta)):
            return new, later


def truth(drives: tuple[Drive, Drive]) -> dict[tuple[str, str], float]:
    """Changes of a drive in percent, of parameters, and of quantities by motion."""
    before, after = (np.array(each.theta) for each in drives)
    found = dict(zip([(name, "") for name in NAMES], 100.0 * (after / before - 1.0), strict=True))
    for motion in MOTIONS:
        first, second = (own_quantities(each, motion, SPEEDS) for each in drives)
        for name, value in first.items():
            of = first["stroke"] if name in OF_STROKE else value
            found[name, motion] = 100.0 * (second[name] - value) / of if of else np.nan
    return found


def one_rig(number: int, count: int, change: float | None, config: Mapping) -> pd.DataFrame:
    """Compare two visits to a rig; a row for each measured quantity and parameter."""
    prior, sensor = Prior.from_settings(config["prior"]), Sensor(**config["sensor"])
    family = Family(prior, family_of(HELD_BACK))
    rng = generator(51, "benchmark of visits", number)
    if change is None:
        new = family.new(rng)
        worn = family.worn(new, rng)
        drives = new, new if number % 3 == 0 else worn
    else:
        drives = planted(family, number, change, rng)
    reading = Reading.draw(rng)
    before, today = (visit(each, count, sensor, reading, rng) for each in drives)
    misfit = config["endurance"]["misfit_p_value"]
    pair = Pair.of(before, today)
    found = compare(pair, [*shipped_networks()], rng, misfit_p_value=misfit)
    parameters = [row for row in found.rows if row.name in NAMES]
    rows = pd.DataFrame([*measured_changes(pair, SPEEDS), *parameters])
    true = truth(drives)
    whole = {"rig": number, "records": count, "change": change}
    whole |= {"still": drives[0] is drives[1], "agreement": found.agreement["p_value"]}
    whole |= {"outside": found.state == "outside_family"}
    whole |= {"disagree": found.state == "operations_disagree"}
    rows["kind"] = np.where(rows.motion == "", "parameter", "measured")
    lower, median, upper = np.array(rows["change"].tolist()).T
    rows = rows[["kind", "name", "motion", "p_unchanged", "changed"]]
    right = [true[key] for key in zip(rows["name"], rows["motion"], strict=True)]
    return rows.assign(truth=right, lower=lower, median=median, upper=upper, **whole)


def summed(rows: pd.DataFrame) -> pd.DataFrame:
    """Coverage and what is noticed, by records of a visit and parameter or quantity.

    ``holds``: share of 90 % intervals with the truth, ``holds_changed`` where it is beyond 1 %;
    ``half_width``: median, percent; ``same_still`` and ``same_changed``: mean probability of no
    change where there is none, and where it is beyond 1 %; ``sure_N``: share of changes of N % that
    were planted in this parameter that are reported; ``false_sure``: the same of unchanged
    quantities, in drives in which nothing changed. Rows of the ``drive`` have the share of drives
    with any parameter that is reported, ``outside`` of drives outside the families, and
    ``disagree`` of drives whose closing and opening contradict each other.
    """
    rows = rows.copy()
    rows["holds"] = (rows.lower <= rows.truth) & (rows.truth <= rows.upper)
    rows["half_width"] = 0.5 * (rows.upper - rows.lower)
    inferred = rows.kind != "measured"
    by = ["records", "kind", "name", "motion"]
    there = rows[rows.truth.notna()]
    drawn, still = there[there.change.isna()], there[there.still]

    def of(some: pd.DataFrame, value: str, keys: list = by) -> pd.Series:
        return some.groupby(keys, dropna=False, sort=False)[value].mean()

    changed = drawn[drawn.truth.abs() > 1.0]
    found = drawn.groupby(by, dropna=False, sort=False).agg(
        rigs=("holds", "size"), holds=("holds", "mean"), half_width=("half_width", "median")
    )
    found["holds_changed"] = of(changed, "holds")
    found["same_still"], found["same_changed"] = (
        of(still, "p_unchanged"),
        of(changed, "p_unchanged"),
    )
    for change, some in there[there.change > 0.0].groupby("change"):
        own = some[
            (some.kind == "parameter") & (some.truth.abs().sub(change).abs() < 0.01 * change)
        ]
        found[f"sure_{change:g}"] = of(own, "changed")
    found["false_sure"] = of(still, "changed")
    drive = ["records", "still", "change", "rig"]
    whole = rows.assign(sure=rows.changed & inferred)
    whole = whole.groupby(drive, dropna=False)[["sure", "outside", "disagree"]].any().reset_index()
    ends = whole.groupby("records")[["outside", "disagree"]].mean()
    ends["false_sure"] = whole[whole.still].groupby("records").sure.mean()
    ends["rigs"] = whole.groupby("records").size()
    ends = ends.reset_index().assign(kind="drive", name="", motion="")
    return pd.concat([ends, found.reset_index()])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--rigs", type=int, default=60)
    parser.add_argument("--records", type=int, help="of each motion and visit")
    parser.add_argument("--change", type=float, metavar="PERCENT")
    parser.add_argument("--rows", type=Path, required=True, metavar="CSV")
    parser.add_argument("--table", type=Path, metavar="CSV")
    options = parser.parse_args()
    if options.records:
        config, done = defaults(), set()
        if options.rows.exists():
            there = pd.read_csv(options.rows)
            same = there.change.isna() if options.change is None else there.change == options.change
            done = {*there.rig[same & (there.records == options.records)]}
        for number in sorted(set(range(options.rigs)) - done):
            rows = one_rig(number, options.records, options.change, config)
            append(rows, options.rows, float_format="%.6g")
    if options.table:
        rows = pd.read_csv(options.rows, keep_default_na=True).fillna({"motion": ""})
        summed(rows).to_csv(options.table, index=False, float_format="%.3g")


if __name__ == "__main__":
    main()
