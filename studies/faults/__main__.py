"""Many damaged files before the judge: ``python -m studies.faults --files 100000``.

Writes a table of what became of each kind of damage, and fails where the reader does: an error that
is no rejection, a file that takes too long, or more than one in a thousand accepted files wrong in
silence.
"""

import argparse
import logging
import sys
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import pandas as pd
from tqdm import tqdm

from studies.faults.judge import APART, KINDS, OUTCOMES, SECONDS, Trial, try_kind

SILENT = 0.001
"""Largest share of silent ones among the files accepted."""
_CHUNK = 100  # files of a job


def run(files: int, seed: int, cores: int = 1) -> list[Trial]:
    """Try so many damaged files, of all kinds alike.

    The result does not depend on the number of cores.
    """
    count = -(-files // len(KINDS))
    jobs = [
        (kind, range(first, min(first + _CHUNK, count)), seed)
        for first in range(0, count, _CHUNK)
        for kind in KINDS
    ]
    if cores == 1:
        return [trial for job in jobs for trial in _try_all(job)]
    with ProcessPoolExecutor(cores, initializer=_be_quiet) as pool:
        results = tqdm(pool.map(_try_all, jobs), total=len(jobs), mininterval=5, unit="job")
        return [trial for result in results for trial in result]


def _be_quiet() -> None:
    logging.getLogger("breaker").setLevel(logging.ERROR)  # each rejection would be a line


def _try_all(job: tuple[str, range, int]) -> list[Trial]:
    kind, numbers, seed = job
    return [try_kind(kind, number, seed) for number in numbers]


def tabulate(trials: Iterable[Trial]) -> pd.DataFrame:
    """Return one row per kind of damage, and ``all``: files, outcomes, the slowest, in seconds.

    ``all`` is without the kinds ``APART``. ``remarked``: how many of those that are right have a
    remark nevertheless.
    """
    trials = list(trials)
    rows = {}
    for kind in [*dict.fromkeys(trial.kind for trial in trials), "all"]:
        those = [t for t in trials if t.kind == kind or (kind == "all" and t.kind not in APART)]
        counts = Counter(trial.outcome for trial in those)
        rows[kind] = {
            "files": len(those),
            **{outcome: counts[outcome] for outcome in OUTCOMES},
            "remarked": sum(trial.outcome == "right" and trial.words != "" for trial in those),
            "slowest": round(max(trial.seconds for trial in those), 3),
        }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("kind")


def defects(table: pd.DataFrame) -> list[str]:
    """Say what is wrong with a reader, from its table."""
    total = table.loc["all"]
    accepted = total[["right", "masked", "flagged", "silent"]].sum()
    found = []
    if total.exception:
        found.append(f"{total.exception:.0f} files end in an error that is no rejection")
    if total.slowest > SECONDS:
        found.append(f"the slowest file takes {total.slowest:.1f} s, more than {SECONDS:g} s")
    if total.silent > SILENT * accepted:
        share = (
            f"{total.silent:.0f} of {accepted:.0f} files accepted, {total.silent / accepted:.2%}"
        )
        found.append(f"{share}, are wrong in silence")
    return found


def main() -> int:
    """Run, write the table and print it; the status is 1 if anything is wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--files", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=41)
    parser.add_argument("--cores", type=int, default=2)
    parser.add_argument("--table", type=Path, default=Path("results/faults.csv"))
    options = parser.parse_args()
    trials = run(options.files, options.seed, options.cores)
    table = tabulate(trials)
    options.table.parent.mkdir(parents=True, exist_ok=True)
    table.to_csv(options.table)
    print(table.to_string())
    for trial in [each for each in trials if each.outcome in ("exception", "silent")][:20]:
        print(f"{trial.outcome}: {trial.kind}, number {trial.number}: {trial.words}")
    for defect in defects(table):
        print(f"faults: {defect}", file=sys.stderr)
    return bool(defects(table))


if __name__ == "__main__":
    sys.exit(main())
