"""Other tools beside this one: train and judge arms at equal budgets, seeds and motions.

    python -m studies.peers --seconds 120 --seeds 3

One run is one process, and writes one JSON file; what is there is skipped, so that the study goes
on where it was interrupted, and any arm can be run alone; delete a file to have it made anew. The
machine should do nothing else: budgets are of wall time by default. table.py makes the table.
"""

import argparse
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

from studies.peers.arms import ARMS
from studies.peers.common import CLOCKS, RESULTS


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
    given = options.parse_args()

    failed = []
    for job in [job for job in jobs(given) if not job.makes.exists()]:
        print(job.makes, flush=True)
        failed += [job] * bool(start(job))
    for job in failed:
        print(f"failed: {job.makes}; see {job.makes.with_suffix('.log')}")
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
