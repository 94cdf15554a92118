"""What jobs of a run took, held against what the workflow reserves for them.

python -m tests.workflow.benchmarks FOLDER [OVERLAY ...]
"""

import csv
import re
import sys
from pathlib import Path
from typing import NamedTuple

from tests.workflow.conftest import snakemake

AROUND = 400  # MiB reserved for Snakemake itself, as in workflow/rules/resources.smk


class Job(NamedTuple):
    """A job: name of its rule, its benchmark relative to the folder, and resources by name."""

    rule: str
    benchmark: str
    resources: dict[str, str]


def jobs_of(plan: str) -> list[Job]:
    """Return the jobs with a benchmark in the words of a dry run."""
    blocks = re.findall(r"^rule (\w+):\n((?:    .*\n)+)", plan, re.M)
    found = []
    for rule, lines in blocks:
        stated = dict(re.findall(r"^    (benchmark|resources): (.*)$", lines, re.M))
        if "benchmark" in stated:
            pairs = (each.split("=", 1) for each in stated["resources"].split(", "))
            found.append(Job(rule, stated["benchmark"], dict(pairs)))
    return found


def compare(folder: Path, jobs: list[Job]) -> dict[str, tuple[float, float, float, float]]:
    """Return by rule the MiB and s reserved, and the most that a job in the folder took.

    The memory of Snakemake itself is no part of either.
    """
    most: dict[str, tuple[float, float, float, float]] = {}
    for job in jobs:
        file = folder / job.benchmark
        if not file.exists():
            continue
        with file.open(encoding="utf-8") as text:
            row = next(csv.DictReader(text, delimiter="\t"))
        if row["max_rss"] in ("-", "NA"):  # ended before it was looked at
            continue
        memory = float(job.resources["mem_mb"]) - AROUND, float(row["max_rss"])
        time = 60.0 * float(job.resources["runtime"]), float(row["s"])
        new = (memory[0], time[0], memory[1], time[1])
        most[job.rule] = tuple(map(max, new, most.get(job.rule, new)))
    return most


def main(folder: str, *overlays: str) -> None:
    """Print a table; ``!`` where a job took more, or much less than was reserved.

    The memory of jobs of less than 10 s is looked at once or twice, too seldom for the latter.
    """
    options = ["--configfile", *overlays] if overlays else []
    jobs = jobs_of(snakemake("-n", "--forceall", "all", *options))
    for rule, (memory, seconds, took, lasted) in sorted(compare(Path(folder), jobs).items()):
        fits = took <= memory and lasted <= seconds and (lasted < 10 or memory <= 1.5 * took)
        words = f"{memory:8.0f} MiB, took {took:.0f};{seconds:6.0f} s, took {lasted:.0f}"
        print(f"{rule:30}{words}{'' if fits else ' !'}")


if __name__ == "__main__":
    main(*sys.argv[1:])
