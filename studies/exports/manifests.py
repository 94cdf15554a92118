"""Tables of folders of exports: how many cells ``breaker manifest`` leaves to change by hand.

    python -m studies.exports.manifests --sheets 60 --seed 5 --table docs/manifests.csv

A folder has several visits to several breakers, copies of files under another name, files that are
no record, times of files that contradict the dates in names and, in some, one serial number in two
bays. A cell is *wrong* where it differs from the truth, *needless* where it is FILL IN though the
files state it, *guessed* where it has a value that no file states, and *fill in* where it rightly
is to be filled in. What a file does not state, but names and other files do, may be either.
"""

import argparse
import csv
import json
import os
import re
import shutil
import tempfile
from collections import Counter, defaultdict
from concurrent.futures import ProcessPoolExecutor
from datetime import datetime, timedelta
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from studies.exports.__main__ import call
from studies.exports.cells import KINDS, NAMES, compared, filled, states_all, true_rows
from studies.exports.layouts import PHASES, pick, write_export

COPIES = ["Copy of {}", "{} - Kopie", "{} (2)", "backup {}", "x"]
NO_RECORDS = {
    "notes.txt": "Visit with two fitters.\nThe motor runs 11 s, see photo 12.\n",
    "limits.csv": "quantity,least,most\nclosing time,60,75\nopening time,18,24\n",
    "temperatures.csv": "hour,degC\n" + "".join(f"{i},{15 + i % 9}\n" for i in range(200)),
    "empty.csv": "",
}


def write_folder(folder: Path, rng: np.random.Generator) -> dict:
    """Write visits to breakers with all that a folder has beside; return the truth."""
    visits: list[dict] = []
    sorted_in, twins, telling = rng.random() < 0.3, rng.random() < 0.4, rng.random() < 0.5
    for k in range(int(rng.integers(2, 4))):
        known = {"plain": rng.random() < 0.3, "form": int(rng.integers(3))}
        known |= {"equipment": f"{rng.integers(10**7, 10**8)}", "bay": f"{k + 1}0{k + 2}  Line"}
        known |= {"serial": f"{rng.integers(10**3, 10**6)}/{rng.integers(1, 30)}"}
        known |= {"phases": pick(rng, PHASES).split()}
        if telling:
            known |= {"bare": False, "stated": True, "dcrm": True, "rows": True, "wired": 0.7}
            known |= {"plain": rng.random() < 0.15, "form": pick(rng, [0, 2])}
        if twins and visits and not (known["plain"] or visits[0]["known"]["plain"]):
            known["serial"] = visits[0]["serial"]
        date = datetime(2012, 1, 1) + timedelta(seconds=int(rng.integers(5 * 365 * 86400)))
        for _ in range(int(rng.integers(1, 4))):
            where = folder / known["equipment"] if sorted_in else folder
            visit = write_export(where, rng, known | {"date": date})
            for truth in visit["files"]:
                truth["path"] = (where / truth["file"]).relative_to(folder).as_posix()
            visits.append(visit | {"known": known, "sorted": sorted_in})
            date += timedelta(seconds=int(rng.integers(60 * 86400, 900 * 86400)))
    paths = [truth["path"] for visit in visits for truth in visit["files"]]
    for path in paths:  # whenever they were copied to this folder
        when = int(rng.integers(1.6e9, 1.7e9))
        os.utime(folder / path, (when, when))
    copies = {}
    for path in rng.permutation(paths)[: int(rng.integers(0, 3))]:
        file = folder / str(path)
        copy = file.with_stem(pick(rng, COPIES).format(file.stem))
        shutil.copy(file, copy)
        copies[copy.relative_to(folder).as_posix()] = str(path)
    for name in rng.permutation(list(NO_RECORDS))[: int(rng.integers(0, 4))]:
        (folder / str(name)).write_text(NO_RECORDS[name], encoding="utf-8")
    others = [name for name in NO_RECORDS if (folder / name).exists()]
    return {"visits": visits, "copies": copies, "others": others}


def accepted(folder: Path, settings: list[str], hints: list[str]) -> Counter:
    """Return whether `breaker check` accepts a folder, with the lines of configuration that
    `manifest` asks for, and how many of its records.
    """
    own = folder.with_suffix(".yaml")
    own.write_text("\n".join(settings or ["{}"]) + "\n", encoding="utf-8")
    status, text, err = call("check", folder, "--config", own, limit=600)
    lines = [re.search(r"  (\d+) +(\d+) +\d+ +\d+(?:  |$)", line) for line in text.splitlines()]
    found = [(int(line[2]), int(line[1])) for line in lines if line]
    counts = {"records": sum(n for _, n in found), "accepted": sum(a for a, _ in found)}
    reasons = re.findall(r"^  - (?:.|\n    )*", text.partition("\n\nRemarks")[0], re.MULTILINE)
    hints += [f"{folder.name}: check: {' '.join(each.split())}" for each in reasons]
    hints += [] if found else [f"{folder.name}: check: {status} {text} {err}"]
    return Counter(counts | {"folders accepted": not status})


def one_folder(number: int, seed: int, keep: Path | None) -> tuple[list[dict], Counter, list[str]]:
    """Return cells, counts and what went wrong in a folder."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = (keep or Path(scratch)) / f"{number:04}"
        truth = write_folder(folder, np.random.default_rng([seed, number]))
        table = folder / "operations.csv"
        status, _, err = call("manifest", folder, "--output", table, limit=600)
        if not table.exists():
            return [], Counter({"folders": 1}), [f"{number}: manifest: {status} {err}"]
        with table.open(encoding="utf-8", newline="") as lines:
            rows = list(csv.DictReader(lines))
        true = true_rows(truth)
        scored, counts = compared(rows, true, truth["copies"])
        hints = [
            f"{number}: {each['true']['layout']}: {each['row']['file']} {each['row']['channel']}: "
            f"{column} is {kind}: {each['row'].get(NAMES.get(column, column), '')!r}"
            for each in scored
            for column, kind in each["kinds"].items()
            if kind in ("wrong", "needless", "guessed")
        ]
        hints += [f"{number}: {kind} rows: {n}" for kind, n in counts.items() if n]
        left = [*truth["others"]]
        left += [c if p in {r["file"] for r in rows} else p for c, p in truth["copies"].items()]
        silent = [name for name in left if not re.search(rf"left out: {re.escape(name)} ", err)]
        hints += [f"{number}: left out without a reason: {name}" for name in silent]
        bays: dict[str, set] = defaultdict(set)
        for each in true:
            if each["shared"] and each["sure breaker"] == "yes":
                bays[each["breaker"]].add(each["drive"])
        twins = {serial for serial, drives in bays.items() if len(drives) > 1}
        quiet = [s for s in twins if not re.search(rf"serial number {re.escape(s)}.* bays", err)]
        hints += [f"{number}: serial number of two bays not flagged: {each}" for each in quiet]
        counts.update({"folders": 1, "left out": len(left), "left out silently": len(silent)})
        counts.update(
            {"serial numbers in two bays": len(twins), "of these not flagged": len(quiet)}
        )
        whole = all(map(states_all, true))
        if not whole:
            rows = filled(scored)
            with table.open("w", encoding="utf-8", newline="") as lines:
                writer = csv.DictWriter(lines, list(rows[0]))
                writer.writeheader()
                writer.writerows(rows)
        found = accepted(folder, re.findall(r"set (motions: .*) in the conf", err), hints)
        counts.update({"rows": len(true), **found})
        counts.update({"folders that state all": whole})
        counts.update({"of these accepted at once": whole and found["folders accepted"]})
        if keep:
            (folder / "truth.json").write_text(json.dumps(true, indent=1), encoding="utf-8")
        cells = [
            {"folder": number, "layout": each["true"]["layout"], "column": column, "kind": kind}
            | {"all": states_all(each["true"])}
            for each in scored
            for column, kind in each["kinds"].items()
        ]
    return cells, counts, hints


def summary(cells: pd.DataFrame, counts: Counter) -> pd.DataFrame:
    """Return kinds of cells by layout and column, of files that state all apart, and counts."""
    states = cells["all"].map({True: "all stated", False: "not all stated"})
    tables = []
    for by, keys in (("states", states), ("layout", cells["layout"]), ("column", cells["column"])):
        found = pd.crosstab(keys, cells["kind"]).reindex(columns=KINDS, fill_value=0)
        found.insert(0, "count", found.sum(axis=1))
        tables.append(found.rename_axis("of").reset_index().assign(by=by))
    rest = pd.DataFrame({"of": list(counts), "count": list(counts.values())}).assign(by="counted")
    table = pd.concat([*tables, rest], ignore_index=True)
    return table[["by", "of", "count", *KINDS]].astype({kind: "Int64" for kind in KINDS})


def main() -> None:
    """Write folders, ask for their tables, and print what is to be changed by hand."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sheets", type=int, default=60, help="number of folders")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--cores", type=int, default=1)
    parser.add_argument("--table", type=Path, metavar="CSV")
    parser.add_argument("--keep", type=Path, metavar="FOLDER")
    args = parser.parse_args()
    cells: list[dict] = []
    counts, hints = Counter(), []
    numbers = range(args.first, args.first + args.sheets)
    with ProcessPoolExecutor(args.cores) as pool:
        for found in pool.map(partial(one_folder, seed=args.seed, keep=args.keep), numbers):
            cells += found[0]
            counts.update(found[1])
            hints += found[2]
    table = summary(pd.DataFrame(cells), counts)
    print(*hints, table.to_string(index=False, na_rep=""), sep="\n")
    if args.table:
        table.to_csv(args.table, index=False)


if __name__ == "__main__":
    main()
