"""Plausible but wrong inputs before the commands, and their right twins.

    python -m studies.wrong_inputs --cases 20 --seed 1 --table wrong_inputs.csv --rows rows.csv
    python -m studies.wrong_inputs --cases 3 --kinds "own copy" "two serials" --keep folder

Asks whether anything false is told of a wrong input without a word that names its trouble, and
whether the right twin, made from the same draws, is warned about falsely. A case takes a second or
two of a core.
"""

import argparse
import sys
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from itertools import starmap
from pathlib import Path

import pandas as pd

from studies.wrong_inputs.kinds import KINDS, one_case


def summary(rows: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each kind: how many wrong inputs are silent, how many twins are warned.

    `silent`, `warned`, `beside` (a word, and false nevertheless), `inspect_only` (no word with the
    answer itself) and `false_warnings` are shares of cases; `twins_false` is the
    share of right twins of which something false is told.
    """
    found = []
    for kind, own in rows.groupby("kind", sort=False):
        wrong, right = own[own["wrong"]], own[~own["wrong"]]
        found.append(
            {
                "kind": kind,
                "cases": len(wrong),
                "silent": wrong["silent"].mean(),
                "warned": wrong["warned"].mean(),
                "beside": wrong["beside"].mean(),
                "inspect_only": wrong["inspect_only"].mean(),
                "false_warnings": right["warned"].mean(),
                "twins_false": (right["false"] != "").mean(),
                "crashed": int(own["crashed"].sum()),
                "seconds": own["seconds"].max(),
            }
        )
    return pd.DataFrame(found).round(3)


def run(kinds: Iterable[str], cases: int, seed: int, processes: int, keep=None) -> pd.DataFrame:
    """Return the verdicts on so many cases of each kind."""
    jobs = [(kind, number, seed, keep) for kind in kinds for number in range(cases)]
    rows: list[dict] = []
    with ProcessPoolExecutor(processes) as pool:
        asked = (
            starmap(one_case, jobs)
            if processes == 1
            else pool.map(one_case, *zip(*jobs, strict=True))
        )
        for done, found in enumerate(asked, 1):
            rows += found
            _progress(done, len(jobs), found)
    return pd.DataFrame(rows)


def _progress(done: int, total: int, found: list[dict]) -> None:
    wrong, right = found
    state = "SILENT" if wrong["silent"] else "warned" if wrong["warned"] else "no answer"
    more = f", twin warned: {right['word'][:60]}" if right["warned"] else ""
    print(f"{done}/{total} {wrong['kind']}: {state}{more}", file=sys.stderr, flush=True)


def main() -> int:
    """Make inputs, ask, and print the table and what was silent."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=20, help="of each kind")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=[*KINDS], metavar="KIND")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--table", type=Path, metavar="CSV")
    parser.add_argument("--rows", type=Path, metavar="CSV")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="keep the inputs there")
    args = parser.parse_args()
    rows = run(args.kinds, args.cases, args.seed, args.processes, args.keep)
    table = summary(rows)
    print(table.to_string(index=False))
    for row in rows[rows["silent"] | rows["crashed"]].itertuples():
        print(f"{row.kind} {row.number}: {row.false or 'crashed'}\n  {row.commands}")
    if args.table:
        table.to_csv(args.table, index=False)
    if args.rows:
        rows.to_csv(args.rows, index=False)
    return 0


if __name__ == "__main__":
    sys.exit(main())
