"""Damage many files, read them and judge the result: ``python -m studies.faults --files 100000``.

Writes a table of the outcomes of each kind of damage. The status is 1 if a file causes an error
other than a rejection, takes too long, or if over 1 in 1,000 accepted files is silently wrong.
"""

import logging
import sys
from collections import Counter
from collections.abc import Iterable
from itertools import chain

import pandas as pd
from tqdm import tqdm

from studies.faults.judge import KINDS, OUTCOMES, SECONDS, Trial, try_kind
from studies.shared import in_pool, parser, report, sampled

SILENT = 0.001
"""Largest share of silently wrong files among the accepted files."""
_CHUNK = 100  # files in a job


def run(files: int, seed: int, cores: int = 1) -> list[Trial]:
    """Try damaged files, equally many of each kind; the number of cores changes nothing."""
    count = -(-files // len(KINDS))
    firsts = range(0, count, _CHUNK)
    jobs = [
        (kind, range(first, min(first + _CHUNK, count)), seed) for first in firsts for kind in KINDS
    ]
    tried = in_pool(_try_all, jobs, cores)
    return [*chain.from_iterable(tqdm(tried, total=len(jobs), mininterval=5, unit="job"))]


def _try_all(kind: str, numbers: range, seed: int) -> list[Trial]:
    logging.getLogger("breaker").setLevel(logging.ERROR)  # each rejection would be a line
    return [try_kind(kind, number, seed) for number in numbers]


def tabulate(trials: Iterable[Trial]) -> pd.DataFrame:
    """Return one row per kind of damage, and ``all``: files, outcomes, the slowest, in seconds.

    ``all`` is without the undamaged files of the kind ``nothing``.
    """
    trials = list(trials)
    rows = {}
    for kind in [*dict.fromkeys(trial.kind for trial in trials), "all"]:
        kept = [t for t in trials if t.kind == kind or (kind == "all" and t.kind != "nothing")]
        counts = Counter(trial.outcome for trial in kept)
        rows[kind] = {
            "files": len(kept),
            **{outcome: counts[outcome] for outcome in OUTCOMES},
            "slowest": round(max(trial.seconds for trial in kept), 3),
        }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("kind")


def defects(table: pd.DataFrame) -> list[str]:
    """Return the defects of the reader that a table of outcomes shows."""
    total = table.loc["all"]
    accepted = total[["right", "masked", "flagged", "silent"]].sum()
    defects = []
    if total.exception:
        defects.append(f"{total.exception:.0f} files end in an error that is no rejection")
    if total.slowest > SECONDS:
        defects.append(f"the slowest file takes {total.slowest:.1f} s, more than {SECONDS:g} s")
    if total.silent > SILENT * accepted:
        defects.append(f"{total.silent:.0f} of {accepted:.0f} accepted files are silently wrong")
    return defects


def main() -> int:
    """Run, write the table and print it; return 1 if there are defects."""
    options = sampled(parser(__doc__), files=100_000, seed=1).parse_args()
    trials = run(options.files, options.seed, options.cores)
    table = tabulate(trials)
    report(options, table.reset_index(), pd.DataFrame(trials))
    for trial in [trial for trial in trials if trial.outcome in ("exception", "silent")][:20]:
        print(f"{trial.outcome}: {trial.kind}, number {trial.number}: {trial.words}")
    for defect in defects(table):
        print(f"faults: {defect}", file=sys.stderr)
    return bool(defects(table))


if __name__ == "__main__":
    sys.exit(main())
