"""Fleets in which a few breakers are odd: how many of them are found, and how many others named.

    python -m studies.fleet --first 11 --table docs/fleet.csv

Sixty breakers of two types and sizes, alternately; drives of a type have the same elements that the
model lacks, and parameters that differ by ``SPREAD``. Of three, one parameter is off the median of
its type. Each has a visit of some records of either motion, with the usual noise and a scatter of
0.4 % from operation to operation, in files with their table, which are answered as the workflow
does. A drive is found where it is odd in the parameter that was planted. The first ten fleets chose
the evidence that is asked for, so others are stated. A fleet takes some 15 s.
"""

import argparse
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from breaker.common.randomness import generator
from breaker.configuration.loading import read
from breaker.drive.fleet.drive_dataset import stored
from breaker.drive.fleet.examination import examine
from breaker.drive.fleet.members import members_of
from breaker.drive.fleet.ranking import fleet_table, learn_types
from breaker.drive.simulation.drive_family import Family
from breaker.drive.simulation.rich_drive import Drive
from breaker.mechanism.prior import Prior
from breaker.quantities.parameters import MOTIONS, NAMES
from breaker.quantities.size import Size
from breaker.reading.files.folder_listing import list_fleet
from breaker.reading.instruments.export import write_curve
from breaker.shipped import DEFAULTS

SIZES = {"MV 12": Size(), "HV 145": Size(8.0, 3.0)}
SPREAD = dict(zip(NAMES, (0.015, 0.015, 0.03, 0.05, 0.08, 0.015, 0.01), strict=True))  # log-sds
ODD = {3: ("gamma_a", 1.4), 17: ("k_a", 0.88), 40: ("L", 1.12)}  # of the type's median
TIMES, SCATTER = 0.1 * np.arange(900), 0.004  # ms


def drives_of(config: Mapping, odd: Mapping, count: int, rng) -> list[tuple[str, Drive]]:
    """Type and drive of each breaker, in new condition and of size 1."""
    usual = Prior.from_settings(config["prior"])
    types = {}
    for name in SIZES:
        medians = usual.medians * np.exp(0.7 * usual.log_sds * rng.standard_normal(len(NAMES)))
        family = Family(Prior(medians, np.array([*SPREAD.values()])), config["rigs"])
        types[name] = family, family.new(rng).elements
    found: list[tuple[str, Drive]] = []
    while len(found) < count:
        name = list(SIZES)[len(found) % len(SIZES)]
        family, elements = types[name]
        drive = replace(family.new(rng), elements=elements)
        if len(found) in odd:
            parameter, factor = odd[len(found)]
            median = float(family.prior.medians[NAMES.index(parameter)])
            drive = drive.changed(**{parameter: factor * median})
        if drive.holds:
            found.append((name, drive))
    return found


def write_fleet(folder: Path, drives: list[tuple[str, Drive]], records: int, rng) -> None:
    """Write the files of a visit to each breaker, and their table."""
    lines = ["file,motion,operation,breaker,type,date"]
    for b, (name, drive) in enumerate(drives):
        size = SIZES[name]
        (folder / f"Q{b}").mkdir()
        for motion in MOTIONS:
            for operation in range(1, records + 1):
                factors = np.exp(SCATTER * rng.standard_normal(len(NAMES)))
                moved = drive.changed(**dict(zip(NAMES, drive.theta * factors, strict=True)))
                late = 15.0 + 0.3 * rng.standard_normal()
                curve = moved.scaled(size).travel(motion, size.times * (TIMES - late))
                curve += 0.1 * size.lengths * rng.standard_normal(TIMES.size)
                file = f"Q{b}/{motion}_{operation}.csv"
                write_curve(
                    folder / file, size.times * TIMES, curve, motion=motion, operation=operation
                )
                lines.append(f"{file},{motion},{operation},Q{b},{name},2026-05-01")
    (folder / "operations.csv").write_text("\n".join([*lines, ""]), encoding="utf-8")


def answered(folder: Path, config: Mapping) -> pd.DataFrame:
    """The table of a fleet, as the workflow makes it."""
    members = members_of(list_fleet(folder), MOTIONS)
    drives: xr.Dataset = stored([examine(each, config) for each in members])
    types = learn_types(drives, Prior.from_settings(config["prior"]))
    return fleet_table(drives, types, config["fleet"]["evidence"])


def one_fleet(seed: int, records: int, config: Mapping) -> dict:
    """What is found in a fleet."""
    rng = generator(seed, "study of fleets")
    with tempfile.TemporaryDirectory() as folder:
        write_fleet(Path(folder), drives_of(config, ODD, 60, rng), records, rng)
        table = answered(Path(folder), config).set_index("breaker")
    planted = {f"Q{b}": name for b, (name, _) in ODD.items()}
    row = {"fleet": seed, "records": records}
    row |= {f"found_{name}": int(table.odd[b] == name) for b, name in planted.items()}
    row |= {f"nats_{name}": table.evidence[b] for b, name in planted.items()}
    others = table.drop(index=[*planted])
    row["otherwise"] = sum(table.odd[b] not in ("", name) for b, name in planted.items())
    return row | {"others": int((others.odd != "").sum()), "nats_other": others.evidence.max()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--fleets", type=int, default=10)
    parser.add_argument("--first", type=int, default=1, help="number of the first fleet")
    parser.add_argument("--records", type=int, nargs="+", default=[5, 3], help="of each motion")
    parser.add_argument("--table", type=Path, required=True, metavar="CSV")
    options = parser.parse_args()
    config = read(DEFAULTS)
    rows = []
    for records in options.records:
        for seed in range(options.first, options.first + options.fleets):
            rows.append(one_fleet(seed, records, config))
            pd.DataFrame(rows).to_csv(options.table, index=False, float_format="%.1f")


if __name__ == "__main__":
    main()
