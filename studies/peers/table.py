"""Turn the results of the peers into a table.

    python -m studies.peers.table --table peers.csv

The table has one row for each motion and arm: means over the seeds, and their range where the seeds
differ. The last line that the command prints names the machine; all results must come from one.
"""

import argparse
import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from breaker.model.parameters import MOTIONS
from studies.peers.arms import ARMS
from studies.peers.common import RESULTS

_SCORES: dict[str, Callable[[dict], float]] = {
    "log density, nats": lambda run: run["log_density"][0],
    "divergence, nats": lambda run: run["gap"][0],
    "relative effective sample size": lambda run: run["efficiency_quartiles"][1],
    "C2ST": lambda run: run["c2st"][0],
    "calibration p": lambda run: run["calibration_p"],
    "draws a second": lambda run: run["draws_per_second"],
    "training, s": lambda run: run["seconds"]["training"],
    "training, s of processors": lambda run: run["processor_seconds"],
    "steps": lambda run: run["plan"]["steps"],
    "weights": lambda run: run["parameters"],
}
_COUNTS = ("weighed", "c2st_curves", "calibration_curves")
_TEXTS = ("estimator", "optimiser", "deviations")


def read(path: Path) -> dict:
    """Return a record."""
    return json.loads(path.read_text(encoding="utf-8"))


def row_of(runs: Sequence[dict]) -> dict[str, object]:
    """Return the row of one arm and motion from its runs, one for each seed."""
    row: dict[str, object] = {"seeds": len(runs)}
    for name, score in _SCORES.items():
        values = [score(run) for run in runs]
        row |= {name: np.mean(values), f"{name}, least": min(values), f"{name}, most": max(values)}
    row |= {count: min(run[count] for run in runs) for count in _COUNTS}
    return row | {text: runs[0]["settings"][text] for text in _TEXTS}


def machine(results: Path) -> str:
    """Return a sentence on machine, date and versions, which all records must share."""
    found = [read(path)["machine"] for path in sorted(results.rglob("*.json"))]
    dates = sorted({one.pop("date") for one in found})
    if any(one != found[0] for one in found):
        raise ValueError("the results come from more than one machine or environment; redo them")
    versions = ", ".join(f"{name} {number}" for name, number in found[0]["versions"].items())
    return (
        f"{found[0]['processor']}, {found[0]['cores']} cores, {found[0]['system']}; "
        f"{dates[0]} to {dates[-1]}; {versions}."
    )


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--results", type=Path, default=RESULTS)
    options.add_argument("--table", type=Path, metavar="CSV")
    given = options.parse_args()
    rows = []
    for motion in MOTIONS:
        for arm, words in ARMS.items():
            files = sorted((given.results / motion / "runs").glob(f"{arm}_[0-9]*.json"))
            if files:
                rows.append({"motion": motion, "arm": words} | row_of([read(f) for f in files]))
    table = pd.DataFrame(rows)
    print(table.to_string(index=False, float_format="%.4g"))
    print(machine(given.results))
    if given.table:
        table.to_csv(given.table, index=False, float_format="%.4g")


if __name__ == "__main__":
    main()
