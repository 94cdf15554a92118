"""A weaker force or another ratio of the transducer: which of both a comparison reports.

    python -m studies.force_or_ratio --rows rows.csv --table docs/force_or_ratio.csv

Drives of the model, and of the independent simulator in ``studies.other_code``. One parameter, or
the ratio of the transducer, changes between two inspections of three records of each motion, with
noise of 0.1 mm. All parameters scatter by 0.4 % from operation to operation.
"""

import argparse
from collections.abc import Mapping
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd

from breaker.common.randomness import generator
from breaker.configuration.loading import load
from breaker.diagnosis.changes import Pair, compare
from breaker.diagnosis.explanations import explain
from breaker.diagnosis.inspection_change import inspection_change
from breaker.diagnosis.reading import read_operations
from breaker.family.curve_file import write_curve
from breaker.family.networks import shipped_networks
from breaker.family.sensitivities import shipped_sensitivities
from breaker.model.curves import travel
from breaker.model.equations import closed_rest
from breaker.model.parameters import MOTIONS, NAMES
from breaker.model.prior import Prior
from breaker.model.quantities import SPEEDS
from breaker.records.operations import Operation
from studies.other_code import Other
from studies.shared import append

TIMES, START_SD = np.arange(-10.0, 70.0, 0.1), 0.3  # ms
NOISE, SCATTER = 0.1, 0.004  # mm of a sample, and share of a parameter by operation
CHANGES = {
    "unchanged": {}, "f -3": {"f": 0.97}, "f -5": {"f": 0.95}, "f -8": {"f": 0.92},
    "ratio -6": {"ratio": 0.94}, "ratio +6": {"ratio": 1.06},
    "gamma_a +5": {"gamma_a": 1.05}, "gamma_a +10": {"gamma_a": 1.1},
    "k_a -2": {"k_a": 0.98}, "k_a -4": {"k_a": 0.96}, "L +2": {"L": 1.02}, "L +4": {"L": 1.04},
}  # fmt: skip

COLUMNS = ["simulator", "drive", "change", "same", "family", "state", "parameter", "reported",
           *(f"p_{cause}" for cause in ("none", "drive", "ratio", "rate")), "ratio_0", "ratio_2",
           *(f"{name}_{k}" for name in NAMES for k in range(3))]  # fmt: skip


class Drive:
    """A drive of one of the simulators, whose parameters change by factors."""

    def __init__(self, simulator: str, prior: Prior, rng: np.random.Generator):
        self.more = None
        while True:
            if simulator == "other":
                drive = Other.drawn(prior, rng)
                self.theta, self.more = drive.theta, drive.more
            else:
                self.theta = prior.sample(1, rng)[0]
            if all(self._closes(factors) for factors in CHANGES.values()):
                break

    def changed(self, factors: Mapping[str, float]) -> np.ndarray:
        """Return the parameters times factors."""
        return self.theta * [factors.get(name, 1.0) for name in NAMES]

    def travel(self, theta: np.ndarray, motion: str, start: float) -> np.ndarray:
        """Simulate a motion with changed parameters, sampled at ``TIMES``, mm."""
        if self.more is None:
            return travel(theta[None], TIMES, motion, onset=start).travel[0]
        return Other(theta, self.more).travel(motion, TIMES - start)[0]

    def _closes(self, factors: Mapping[str, float]) -> bool:
        """Whether the contact is still pressed, with 3 % to spare for the scatter."""
        theta = self.changed(factors | {"f": 0.97 * factors.get("f", 1.0)})
        gap = theta[NAMES.index("L")]
        if self.more is None:
            return bool(closed_rest(theta) > gap)
        return Other(theta, self.more).excess(gap)[0] > 0.0

    def inspection(self, change: Mapping[str, float], rng: np.random.Generator, count: int = 3):
        """Return records of both motions, written and read."""
        records, ratio = [], change.get("ratio", 1.0)
        with TemporaryDirectory() as folder:
            for motion, number in product(MOTIONS, range(1, count + 1)):
                scatter = np.exp(SCATTER * rng.standard_normal(len(NAMES)))
                theta = self.changed(change) * scatter
                way = self.travel(theta, motion, START_SD * rng.standard_normal())
                way = ratio * way + NOISE * rng.standard_normal(TIMES.size)
                file = f"{folder}/{motion}{number}.csv"
                write_curve(file, TIMES, way, motion=motion, operation=number)
                records += read_operations({motion: [Operation(number, file)]}, {})
        return records


def compared(before, today) -> list[dict]:
    """Compare two inspections as `breaker compare` does, the transducer the same, or unknown."""
    usable = [[record for record in records if not record.reason] for records in (before, today)]
    raws = [{m: [r.raw for r in records if r.motion == m] for m in MOTIONS} for records in usable]
    rows, pair = [], Pair.of(*raws)
    change = compare(pair, [*shipped_networks()], generator(1, "force or ratio"))
    about = {"settings": {"seed": 1}, "rejected": ()}
    for same in (False, True):
        regressions = shipped_sensitivities(change.family)
        explanations = explain(pair, regressions, same_transducer=same)
        document = inspection_change(pair, change, explanations, SPEEDS, **about)
        row = {"same": same, "family": change.family, "state": document.state}
        for cause in explanations:
            row[f"p_{cause.cause}"] = cause.probability
            if cause.cause == "drive":
                row["parameter"] = cause.parameter
            if cause.cause == "ratio":
                row["ratio_0"], _, row["ratio_2"] = cause.change
        row["reported"] = " ".join(reported.name for reported in document.reported)
        for inferred in document.inferred:
            if inferred.name in NAMES:
                row |= {f"{inferred.name}_{k}": inferred.change[k] for k in range(3)}
        rows.append(row)
    return rows


def summed(rows: pd.DataFrame) -> pd.DataFrame:
    """Count drives by simulator, change, and whether the transducer is known as the same."""
    rows = rows.fillna({"p_ratio": 0.0, "p_rate": 0.0, "reported": ""})
    rows["any"] = rows.reported != ""
    own = zip(rows.change.str.split().str[0], rows.reported, strict=True)
    rows["own"] = [name in reported.split() for name, reported in own]
    rows["drive_or_ratio_95"] = rows.p_drive + rows.p_ratio >= 0.95
    rows["drive_90"], rows["ratio_90"] = rows.p_drive >= 0.9, rows.p_ratio >= 0.9
    rows["f_90"] = rows.drive_90 & (rows.parameter == "f")
    names = ["any", "own", "drive_or_ratio_95", "drive_90", "f_90", "ratio_90"]
    by = rows.groupby(["simulator", "change", "same"], sort=False)
    return by.agg(drives=("any", "size"), **{name: (name, "sum") for name in names}).reset_index()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--simulators", nargs="+", default=["model", "other"])
    parser.add_argument("--changes", nargs="+", default=[*CHANGES], choices=[*CHANGES])
    parser.add_argument("--drives", type=int, nargs=2, default=(0, 14), help="first, and end")
    parser.add_argument("--rows", type=Path, required=True, metavar="CSV")
    parser.add_argument("--table", type=Path, metavar="CSV")
    options = parser.parse_args()
    prior = Prior.from_settings(load()["prior"])
    for simulator in options.simulators:
        for number in range(*options.drives):
            rng = generator(61, "force or ratio", simulator, number)
            drive = Drive(simulator, prior, rng)
            before = drive.inspection({}, rng)
            for change in options.changes:
                rows = pd.DataFrame(compared(before, drive.inspection(CHANGES[change], rng)))
                rows = rows.assign(simulator=simulator, drive=number, change=change)
                append(rows.reindex(columns=COLUMNS), options.rows, float_format="%.4g")
    if options.table:
        summed(pd.read_csv(options.rows)).to_csv(options.table, index=False)


if __name__ == "__main__":
    main()
