"""A weaker force or another ratio of the transducer: which of both a comparison reports.

    python -m studies.force_or_ratio --table docs/force_or_ratio.csv --cores 2

Drives of the model, and of the independent simulator in ``studies.other_code``. One parameter, or
the ratio of the transducer, changes between two inspections of three records of each motion, with
noise of 0.1 mm. All parameters scatter by 0.4 % from operation to operation.
"""

from collections.abc import Mapping, Sequence
from itertools import product
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd

from breaker.common.randomness import generator
from breaker.configuration.loading import load
from breaker.diagnosis.changes import Pair, compare
from breaker.diagnosis.estimate import DriveRecord
from breaker.diagnosis.explanations import explain
from breaker.diagnosis.inspection_change import inspection_change
from breaker.diagnosis.reading import read_operations
from breaker.family.endurance import write_curve
from breaker.family.networks import shipped_networks
from breaker.family.sensitivities import shipped_sensitivities
from breaker.model.curves import travel
from breaker.model.equations import closed_rest
from breaker.model.parameters import MOTIONS, NAMES
from breaker.model.prior import Prior
from breaker.model.quantities import SPEEDS
from breaker.records.operations import Operation
from studies.other_code import Other
from studies.shared import in_pool, parser, report, sampled

TIMES, START_SD = np.arange(-10.0, 70.0, 0.1), 0.3  # ms
NOISE, SCATTER = 0.1, 0.004  # mm of a sample, and share of a parameter by operation
ROOM = 1e-9  # percent by which a change may be outside its interval: of one that is zero
CHANGES = {
    "unchanged": {}, "f -3": {"f": 0.97}, "f -5": {"f": 0.95}, "f -8": {"f": 0.92},
    "ratio -6": {"ratio": 0.94}, "ratio +6": {"ratio": 1.06},
    "gamma_a +5": {"gamma_a": 1.05}, "gamma_a +10": {"gamma_a": 1.1},
    "k_a -2": {"k_a": 0.98}, "k_a -4": {"k_a": 0.96}, "L +2": {"L": 1.02}, "L +4": {"L": 1.04},
}  # fmt: skip

Records = Sequence[DriveRecord]


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


def compared(change: str, before: Records, today: Records) -> list[dict]:
    """Compare two inspections as `breaker compare` does, the transducer the same, or unknown."""
    usable = [[record for record in records if not record.reason] for records in (before, today)]
    raws = [{m: [r.raw for r in records if r.motion == m] for m in MOTIONS} for records in usable]
    rows, pair, name = [], Pair.of(*raws), change.split()[0]
    changes = compare(pair, [*shipped_networks()], generator(1, "force or ratio"))
    regressions = shipped_sensitivities(changes.family)
    for same in (False, True):
        explanations = explain(pair, regressions, same_transducer=same)
        about = {"settings": {"seed": 1}, "rejected": ()}
        document = inspection_change(pair, changes, explanations, SPEEDS, **about)
        reported = [item.name for item in document.reported]
        covered = {}
        for item in document.inferred:
            if item.name in NAMES and np.isfinite(item.change).all():
                truth = 100.0 * (CHANGES[change].get(item.name, 1.0) - 1.0)
                covered[item.name] = item.change[0] - ROOM <= truth <= item.change[2] + ROOM
        row = {"change": change, "same": same, "any": bool(reported), "own": name in reported}
        row |= {"intervals": len(covered), "covered": sum(covered.values())}
        row |= {"own_interval": name in covered, "own_covered": covered.get(name, False)}
        rows.append(row)
    return rows


def one_drive(simulator: str, number: int) -> list[dict]:
    """Return the comparisons of a drive with each of its changes."""
    rng = generator(61, "force or ratio", simulator, number)
    drive, rows = Drive(simulator, Prior.from_settings(load()["prior"]), rng), []
    before = drive.inspection({}, rng)
    for change, factors in CHANGES.items():
        rows += compared(change, before, drive.inspection(factors, rng))
    return [{"simulator": simulator} | row for row in rows]


def main() -> None:
    given = sampled(parser(__doc__), drives=14).parse_args()
    jobs = [(name, number) for name in ("model", "other") for number in range(given.drives)]
    rows = pd.DataFrame([row for own in in_pool(one_drive, jobs, given.cores) for row in own])
    keys = ["simulator", "change", "same"]
    table = rows.assign(drives=1).groupby(keys, sort=False).sum().astype(int).reset_index()
    report(given, table, rows)


if __name__ == "__main__":
    main()
