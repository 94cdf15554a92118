"""Visits between which no parameter changed, and one mechanism wore: what is told of them.

    python -m studies.only_mechanisms_wear --drives 20 --table docs/only_mechanisms_wear.csv

Drives are those of ``studies.mechanisms`` with all mechanisms, or with the one that wears alone
(``--alone``), at a strength; its simulator has no line of the package. Of each mechanism one size
is multiplied by a factor. Either visit has so many records of each motion, as files, which are
compared as ``breaker compare`` does. Written are the shares of drives that are answered, and among
these of which a parameter is told as changed, a mechanism, and the one that wore.
"""

import argparse
from collections.abc import Iterable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd

from breaker.common.randomness import generator
from breaker.configuration.loading import load
from breaker.drive.answers.drive_records import read_operations
from breaker.drive.answers.visit_changes import changes, compare, mechanism_changes
from breaker.drive.family.network_files import shipped_networks
from breaker.mechanism.prior import Prior
from breaker.quantities.parameters import MOTIONS
from breaker.reading.files.operations_table import Operation
from breaker.shipped import DEFAULTS
from studies.mechanisms import OPTIONS, drawn, simulated, write

# By what wears: which mechanism of ``studies.mechanisms`` has it, its size and the factor, and the
# mechanism that networks know.
WEAR = {
    "nothing": ("all", "", 1.0, ""),
    "preload": ("preload", "preload", 0.8, "contact_preload"),
    "preload, half": ("preload", "preload", 0.5, "contact_preload"),
    "falling force": ("falling force", "sink", 1.5, "force_fall"),
    "friction": ("friction", "dry", 2.0, "dry_friction"),
    "drag": ("drag", "drag", 1.5, "drag"),
    "build-up": ("build-up", "rise", 1.5, "build_up"),
    "closing damper": ("closing damper", "shut", 0.6, "closing_damper"),
    "opening damper": ("opening damper", "open", 0.6, "opening_damper"),
}
LONG = 120.0  # ms


def visit(curves: dict, count: int, rng: np.random.Generator, options) -> dict[str, list]:
    """Records of a visit by motion, written and read."""
    with TemporaryDirectory() as folder:
        files = {m: [Path(folder, f"{m}_{i}.csv") for i in range(count)] for m in MOTIONS}
        for motion, some in files.items():
            for file in some:
                write(file, curves[motion], rng, options)
        operations = {
            m: [Operation(i + 1, file) for i, file in enumerate(some)] for m, some in files.items()
        }
        records = read_operations(operations, {"time_unit": "ms"})
    return {m: [e.raw for e in records if e.motion == m and not e.reason] for m in MOTIONS}


def rows_of(name: str, options) -> pd.DataFrame:
    """What is told of drives in which a mechanism wears, a row for each."""
    prior = Prior.from_settings(load([DEFAULTS])["prior"])
    mechanism, field, factor, own = WEAR[name]
    rows = []
    for number in range(options.drives):
        rng = generator(options.seed, "only mechanisms wear", name, number)
        kind = mechanism if options.alone else "all"
        drive, before = drawn(kind, prior, rng, options.strength, LONG)
        worn = drive.copy()
        if field:
            worn[field] *= factor
        today = {motion: simulated(worn, motion, LONG) for motion in MOTIONS}
        visits = [visit(curves, options.records, rng, options) for curves in (before, today)]
        if not all(each[motion] for each in visits for motion in MOTIONS):
            continue  # no record of a motion shows its rests
        found = compare(*visits, [*shipped_networks()], rng)
        sure = {row.name for row in changes(found) if row.sure}
        told = {e.name for e in mechanism_changes(found) if e.sure}
        parameters = {e for e in sure if "time" not in e}
        rows.append(
            {"wears": name, "answered": bool(found.ratios), "apart": len(found.ratios) > 1}
            | {"parameter": bool(parameters), "mechanism": bool(told), "own": own in told}
            | {"which": " ".join(sorted(parameters | told))}
        )
    return pd.DataFrame(rows)


def main(arguments: Iterable[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drives", type=int, default=40)
    parser.add_argument("--records", type=int, default=5)
    parser.add_argument("--strength", type=float, default=1.0)
    parser.add_argument("--alone", action="store_true")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--wears", nargs="+", choices=WEAR, default=[*WEAR])
    parser.add_argument("--table", type=Path, metavar="CSV")
    options = parser.parse_args(arguments)
    for key in ("length", "lead", "rate", "quantum"):
        setattr(options, key, OPTIONS[key])
    rows = pd.concat([rows_of(name, options) for name in options.wears])
    one = rows.answered & ~rows.apart
    groups = rows[one].groupby("wears", sort=False)
    table = groups[["parameter", "mechanism", "own"]].mean()
    table.insert(0, "answered", rows.groupby("wears", sort=False).answered.mean())
    table.insert(1, "apart", rows.groupby("wears", sort=False).apart.mean())
    table["told"] = groups.which.agg(lambda each: each[each != ""].value_counts().head(3).to_dict())
    print(table.round(2).to_string())
    if options.table:
        table.drop(columns="told").round(3).to_csv(options.table)


if __name__ == "__main__":
    main()
