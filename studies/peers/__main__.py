"""Other tools beside this one: train and judge arms at equal budgets, seeds and motions.

    python -m studies.peers --seconds 120 --seeds 3

One run is one process, and writes one JSON file; what is there is skipped, so that the study goes
on where it was interrupted, and any arm can be run alone; delete a file to have it made anew. The
machine should do nothing else: budgets are of wall time by default.

The table has one row for each motion and arm: means over the seeds, and their range where the seeds
differ. The last line that the command prints names the machine; all results must come from one.
"""

import argparse
import json
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from studies.peers.arms import ARMS
from studies.peers.common import CLOCKS, RESULTS

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


@dataclass(frozen=True)
class Job:
    """One process: the module that it runs, the file that it writes, and its other options."""

    script: str
    makes: Path
    options: dict[str, object] = field(default_factory=dict)


def jobs(given: argparse.Namespace) -> list[Job]:
    """Return all jobs, in an order in which no job waits for a later one."""
    listed = []
    for motion in given.motions:
        exact = given.results / motion / "exact.json"
        listed.append(Job("exact", exact, {"motion": motion, "threads": given.threads}))
    for seed in range(1, given.seeds + 1):
        for motion in given.motions:
            shared = {key: getattr(given, key) for key in ("threads", "seconds", "clock", "cap")}
            exact = given.results / motion / "exact.json"
            shared |= {"motion": motion, "seed": seed, "exact": exact}
            folder = given.results / motion / "runs"
            listed += [
                Job("run", folder / f"{arm}_{seed}.json", {"arm": arm, **shared})
                for arm in given.arms
            ]
    return listed


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--motions", nargs="+", default=["closing", "opening"])
    options.add_argument("--arms", nargs="*", choices=ARMS, default=list(ARMS), metavar="ARM")
    options.add_argument("--seeds", type=int, default=3, help="runs of each arm and motion")
    options.add_argument("--seconds", type=float, default=120.0, help="budget of a training")
    options.add_argument("--clock", choices=CLOCKS, default="wall", help="that the budget is of")
    options.add_argument("--threads", type=int, default=2, help="and processor cores, of a run")
    options.add_argument("--cap", type=float, default=10.0, help="seconds for each of the scores")
    options.add_argument("--results", type=Path, default=RESULTS)
    options.add_argument("--table", type=Path, metavar="CSV")
    given = options.parse_args()

    failed = []
    for job in [job for job in jobs(given) if not job.makes.exists()]:
        print(job.makes, flush=True)
        failed += [job] * bool(start(job))
    for job in failed:
        print(f"failed: {job.makes}; see {job.makes.with_suffix('.log')}")
    rows = []
    for motion in given.motions:
        for arm in given.arms:
            files = sorted((given.results / motion / "runs").glob(f"{arm}_[0-9]*.json"))
            if files:
                row = row_of([read(file) for file in files])
                rows.append({"motion": motion, "arm": ARMS[arm]} | row)
    table = pd.DataFrame(rows)
    print(table.to_string(index=False, float_format="%.4g"))
    print(machine(given.results) if rows else "no results")
    if given.table:
        table.to_csv(given.table, index=False, float_format="%.4g")
    sys.exit(bool(failed))


def start(job: Job) -> int:
    """Run a job and return its exit status."""
    job.makes.parent.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-m", f"studies.peers.{job.script}", "--out", str(job.makes)]
    for name, value in job.options.items():
        command += [f"--{name}", str(value)]
    with job.makes.with_suffix(".log").open("w") as log:
        log.write(" ".join(command) + "\n")
        log.flush()
        return subprocess.run(command, stdout=log, stderr=subprocess.STDOUT).returncode


if __name__ == "__main__":
    main()
