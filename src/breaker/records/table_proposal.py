"""Propose an ``operations.csv`` for a folder, to be checked and completed.

Statements in files take precedence over their names. Values that neither states are FILL IN, so
that the table is rejected until it is completed.
"""

import os
import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from breaker.common.clean_text import table_text
from breaker.common.numerals import natural
from breaker.model.parameters import MOTIONS
from breaker.model.quantities import ABOUT
from breaker.records.dates import dates_of, in_order
from breaker.records.description import Description, InspectedMotion, describe_file
from breaker.records.files import Opened, printable
from breaker.records.folder import record_files
from breaker.records.formats.detection import records_in
from breaker.records.formats.lines import RecordLine
from breaker.records.operations import FILL_IN, LONGEST
from breaker.records.settings import FORMAT
from breaker.records.words import motions_in, phases_in_names

_COLUMNS = ("file", "motion", "operation", "channel", *ABOUT, "from", "to")
_Row = dict[str, Any]  # cells of a row of the table
# The only number in the name of a file, without a unit behind it; six digits are a date or a time.
_COUNTER = re.compile(r"[^0-9]*([0-9]{1,5})(?:(?:[^\w%°.,]|_)[^0-9]*)?")


def propose_manifest(
    folder: str | Path, motions: Sequence[str] = MOTIONS, *, configured: bool = False
) -> tuple[str, list[str]]:
    """Propose the table of a folder and those below it.

    Statements in files take precedence over names. A folder named after a motion contains this
    motion; other folders are breakers. The counter comes from the names if they are unambiguous;
    otherwise operations are numbered from 1.

    Args:
        folder: Folder of the curve files.
        motions: Motions that have rows; files of other motions are left out.
        configured: Whether a configuration, and not the files, states the settings.

    Returns:
        The text of the table, and remarks on what to check in it.

    Raises:
        FileNotFoundError: If the folder does not exist, or has no record of these motions.
    """
    if not os.path.isdir(folder):
        raise FileNotFoundError(f"there is no folder {printable(folder)!r}; name that of the files")
    remarks: list[str] = []
    rows: list[_Row] = []
    for path, record, seen in _records(Path(folder), configured, remarks):
        rows += _rows(path, record, seen, folder)
    rows = [row for row in rows if row["motion"] in (*motions, FILL_IN)]
    if not rows:
        reason = f"{printable(folder)} has no file of a record of {' or '.join(motions)}"
        raise FileNotFoundError("; ".join([reason, *remarks]))
    stated, groups = any(row["breaker"] for row in rows), defaultdict(list)
    for row in rows:
        row["breaker"] = (row["breaker"] or (FILL_IN if stated else row["folder"]))[:LONGEST]
        groups[row["breaker"]].append(row)
    for breaker, group in groups.items():
        if not _number(group):
            text = f"{len(group)} rows are numbered from 1 in the order of dates or names"
            remarks.append(f"{breaker}: {text}" if breaker else text)
    rows.sort(key=lambda row: (row["breaker"], row["operation"], row["motion"]))
    default = {"line": "", **{name: _cell(value) for name, value in FORMAT.items()}}
    names = [k for k in default if any(row.get(k, "") not in ("", default[k]) for row in rows)]
    return table_text([*_COLUMNS, *names], rows), remarks


def _records(
    folder: Path, configured: bool, remarks: list[str]
) -> Iterator[tuple[str, RecordLine, Description]]:
    """Yield the path, line and content of files in a folder and below that may be records, but only
    the first of copies. Add remarks on files that are left out.
    """
    first: dict[str, str] = {}
    for place, folders, _ in os.walk(folder):
        folders[:] = sorted(e for e in folders if not e.startswith("."))
        for file in sorted(record_files(place), key=natural):
            path, opened, left = file.relative_to(folder).as_posix(), Opened(file), []
            for record in records_in(opened) or [RecordLine(0, 0, "")]:
                seen = describe_file(opened, record.line)
                if configured:
                    seen = seen._replace(settings={}, sure=True, reason="")
                name = f"{path}, line {record.line}" if record.line else path
                other = first.setdefault(seen.samples or name, name)
                if not path.isprintable():
                    why = "has a sign in its name that a table cannot hold; rename it"
                elif seen.reason and not _motions_of(path, folder):
                    why = f"is not a record: {seen.reason}"
                elif other != name:
                    why = f"has the samples of {other}; export it again if it is of another record"
                else:
                    yield path, record, seen
                    continue
                left.append(f"left out: {printable(name)} {why}")
            more = [f"left out: {len(left) - 1} more lines of {printable(path)}"] * (len(left) > 1)
            remarks += [*left[:1], *more]


def _motions_of(path: str, folder: str | Path) -> tuple[str, ...]:
    """Return the motions that the nearest folder, the name of a file, or the folder states."""
    *above, name = path.split("/")
    texts = [*reversed(above), Path(name).stem, Path(folder).resolve().name]
    return next(filter(None, map(motions_in, texts)), ())


# ---- rows ----------------------------------------------------------------------------------------


def _rows(path: str, record: RecordLine, seen: Description, folder: str | Path) -> list[_Row]:
    """Return a row for each motion of each channel in a file, without a counter."""
    shown, motions = {part.motion for part in seen.parts}, _motions_of(path, folder)
    line, number, date = record
    dates = (date,) if date else seen.preamble.dates or in_order(dates_of(Path(path).stem))
    date = FILL_IN if len(dates) > 1 else "".join(dates)  # the order of day and month is unknown
    cells: _Row = {"file": path, "line": line or "", "operation": number or None, "date": date}
    cells["breaker"] = seen.preamble.serial or " ".join(seen.preamble.bay.split())
    cells["folder"] = "/".join(e for e in path.split("/")[:-1] if not motions_in(e))
    if seen.settings:
        cells |= {key: _cell(value) for key, value in {**FORMAT, **seen.settings}.items()}
        cells["time_column"] = cells["time_column"] or "none"
    parts = seen.parts or [InspectedMotion(motion, "") for motion in motions or (FILL_IN,)]
    phases = {part.column: part.phase for part in parts}
    if len(phases) > 1 and len({*phases.values()} - {""}) < len(phases):
        phases = {column: str(column) for column in phases}
    sure = seen.sure or shown <= {*motions}
    # All lines of a file have the same sign, which determines their motions.
    unsure = {} if sure else {"sign": FILL_IN} if line else {"motion": FILL_IN, "sign": FILL_IN}
    if cells.get("rate") == FILL_IN and len(parts) > len(phases):
        unsure |= {"from": FILL_IN, "to": FILL_IN}
    rows = []
    for part in parts:
        row = {"motion": part.motion, "channel": part.column, "phase": phases[part.column]}
        row |= {"from": _cell(part.begin), "to": _cell(part.end), **part.paired}
        rows.append({**cells, **row, **unsure})
    return rows


def _cell(value: object) -> str:
    """Return the cell of a setting or a number; empty for None or NaN."""
    if value is None or value != value:
        return ""
    if isinstance(value, float):
        return f"{value:.6g}"
    return {"\t": "tab", " ": "blank"}.get(str(value), str(value))


def _number(rows: Sequence[_Row]) -> bool:
    """Add phases from names, and counters. Counters come from names if these are unambiguous, else
    they start at 1, in the order of dates, if all rows have one, and names. Each day continues the
    numbers of the day before, in all motions and phases. Return whether names are unambiguous.
    """
    named = phases_in_names({Path(row["file"]) for row in rows if not row["phase"]})
    poles: dict[tuple[str, str], list[_Row]] = defaultdict(list)
    for row in rows:
        row["phase"] = row["phase"] or named.get(Path(row["file"]), "")
        if not row["operation"] and (match := _COUNTER.fullmatch(Path(row["file"]).stem)):
            row["operation"] = int(match[1])
        poles[row["motion"], row["phase"]].append(row)
    if all(len({row["operation"] for row in p} - {None}) == len(p) for p in poles.values()):
        return True
    dated = all(row["date"] not in ("", FILL_IN) for row in rows)
    counts: Counter = Counter()
    for row in sorted(rows, key=lambda row: (dated and row["date"], natural(row["file"]))):
        day = row["date"][:10] if dated else ""
        counts[day, row["motion"], row["phase"]] += 1
        row["operation"] = day, counts[day, row["motion"], row["phase"]]
    ranks = {item: n for n, item in enumerate(sorted({row["operation"] for row in rows}), start=1)}
    for row in rows:
        row["operation"] = ranks[row["operation"]]
    return False
