"""Propose an ``operations.csv`` for a folder, to be checked and completed. Light to import.

Statements in files take precedence over their names. Values that neither states are FILL IN, so
that the table is rejected until it is completed.
"""

import math
import os
import re
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from breaker.common.numerals import natural
from breaker.common.text import table_text
from breaker.model.parameters import MOTIONS
from breaker.model.quantities import ABOUT
from breaker.records.dates import dates_of, in_order
from breaker.records.files import Opened, printable
from breaker.records.folder import record_files
from breaker.records.formats.lines import RecordLine
from breaker.records.formats.registry import records_in
from breaker.records.header import Header
from breaker.records.operations import FILL_IN, LONGEST
from breaker.records.settings import FORMAT
from breaker.records.words import motions_in, phases_in_names

if TYPE_CHECKING:  # no record is read here
    from breaker.records.curves import GriddedRecord
    from breaker.records.record import Record

_COLUMNS = ("file", "motion", "operation", "channel", *ABOUT, "from", "to")
_Row = dict[str, Any]  # cells of a row of the table
# The only number in the name of a file, without a unit behind it; six digits are a date or a time.
_COUNTER = re.compile(r"[^0-9]*([0-9]{1,5})(?:(?:[^\w%°.,]|_)[^0-9]*)?")
_YEAR = re.compile("19[5-9][0-9]|20[0-5][0-9]")


class InspectedMotion(NamedTuple):
    """One motion of a channel in a file; times are ms of the file.

    Attributes:
        motion, column: "closing" or "opening", and the column of its travel.
        phase: Phase of the channel, empty if nothing states it.
        begin, end: Part of the record with only this motion; NaN for the ends of the record.
        begins, arrives: Approximate times of its start and of the rest after it.
        paired: Columns that belong to the motion, by key of the settings.
        result, said: Record that was read with a proposal, None if rejected; reasons and remarks.
    """

    motion: str
    column: str | int
    phase: str = ""
    begin: float = math.nan
    end: float = math.nan
    begins: float = math.nan
    arrives: float = math.nan
    paired: Mapping[str, str | int] = MappingProxyType({})
    result: "GriddedRecord | None" = None
    said: tuple[str, ...] = ()

    @property
    def record(self) -> "Record | None":
        """Record that was read; None if it was not."""
        return self.result.record if self.result else None


class Description(NamedTuple):
    """Contents of a file: its header, motions, and settings of ``endurance.format``, FILL IN for
    unknown settings; whether the sign is certain; the reason if the file is not a record; and a
    digest of its travels, which is the same in copies.
    """

    preamble: Header = Header()
    parts: tuple[InspectedMotion, ...] = ()
    settings: Mapping[str, Any] = MappingProxyType({})
    sure: bool = True
    reason: str = ""
    samples: str = ""


_Look = Callable[[Opened, int], Description]


class _File(NamedTuple):
    """File, or line of a file that is a record: its path; the line, 0 for a file; motions in its
    name or folders; its other folders, which name the breaker; and its contents.
    """

    path: str
    record: RecordLine
    motions: tuple[str, ...]
    folder: str
    seen: Description

    @property
    def breaker(self) -> str:
        """Name of the breaker that the header states."""
        return self.seen.preamble.serial or " ".join(self.seen.preamble.bay.split())


def propose_manifest(
    folder: str | Path,
    motions: Sequence[str] = MOTIONS,
    look: _Look = lambda *_: Description(),
) -> tuple[str, list[str]]:
    """Propose the table of a folder and those below it.

    Statements in files take precedence over names. A folder named after a motion contains this
    motion; other folders are breakers. The counter comes from the names if they are unambiguous;
    otherwise operations are numbered from 1.

    Args:
        folder: Folder of the curve files.
        motions: Motions that have rows; files of other motions are left out.
        look: Describes the contents of a file, or of a line that is a record.

    Returns:
        The text of the table, and remarks on what to check in it.

    Raises:
        FileNotFoundError: If the folder does not exist, or has no record of these motions.
    """
    if not os.path.isdir(folder):
        raise FileNotFoundError(f"there is no folder {printable(folder)!r}; name that of the files")
    remarks: list[str] = []
    files = _files(Path(folder), look, remarks)
    stated = any(file.breaker for file in files)
    groups: dict[str, list[_Row]] = defaultdict(list)
    for file in files:
        breaker = (file.breaker or (FILL_IN if stated else file.folder))[:LONGEST]
        kept = (row for row in _rows(file) if row["motion"] in (*motions, FILL_IN))
        groups[breaker] += [{**row, "breaker": breaker} for row in kept]
    rows = [row for group in groups.values() for row in group]
    if not rows:
        reason = f"{printable(folder)} has no file of a record of {' or '.join(motions)}"
        raise FileNotFoundError("; ".join([reason, *remarks]))
    for breaker, group in groups.items():
        if not _number(group):
            text = f"{len(group)} rows are numbered from 1 in the order of dates or names"
            remarks.append(f"{breaker}: {text}" if breaker else text)
    rows.sort(key=lambda row: (row["breaker"], row["operation"], row["motion"]))
    default = {"line": "", **{name: _cell(value) for name, value in FORMAT.items()}}
    names = [k for k in default if any(row.get(k, "") not in ("", default[k]) for row in rows)]
    return table_text([*_COLUMNS, *names], rows), remarks


def _files(folder: Path, look: _Look, remarks: list[str]) -> list[_File]:
    """Return the files in a folder and below, or their lines, that may be records, but only the
    first of copies. Add remarks on files that are left out.
    """
    first: dict[str, tuple[str, _File]] = {}
    for place, folders, _ in os.walk(folder):
        folders[:] = sorted(e for e in folders if not e.startswith("."))
        for file in sorted(record_files(place), key=natural):
            path, opened = file.relative_to(folder).as_posix(), Opened(file)
            parts = path.split("/")[:-1]
            # The nearest folder takes precedence, then the name of the file.
            texts = [*reversed(parts), file.stem, folder.resolve().name]
            motions = next(filter(None, map(motions_in, texts)), ())
            folders_of = "/".join(part for part in parts if not motions_in(part))
            left = []
            for record in records_in(opened) or [RecordLine(0, 0, "")]:
                line, seen = record.line, look(opened, record.line)
                name = f"{path}, line {line}" if line else path
                other, _ = first.get(samples := seen.samples or name, ("", None))
                if not path.isprintable():
                    why = "has a sign in its name that a table cannot hold; rename it"
                elif seen.reason and not motions:
                    why = f"is not a record: {seen.reason}"
                elif other:
                    why = f"has the samples of {other}; export it again if it is of another record"
                else:
                    first[samples] = name, _File(path, record, motions, folders_of, seen)
                    continue
                left.append(f"left out: {printable(name)} {why}")
            more = [f"left out: {len(left) - 1} more lines of {printable(path)}"] * (len(left) > 1)
            remarks += [*left[:1], *more]
    return [file for _, file in first.values()]


# ---- rows ----------------------------------------------------------------------------------------


def _rows(file: _File) -> list[_Row]:
    """Return a row for each motion of each channel in a file, without breaker and counter."""
    seen, shown = file.seen, {part.motion for part in file.seen.parts}
    line, number, date = file.record
    dates = (date,) if date else seen.preamble.dates or in_order(dates_of(Path(file.path).stem))
    date = FILL_IN if len(dates) > 1 else "".join(dates)  # the order of day and month is unknown
    cells: _Row = {"file": file.path, "line": line or "", "operation": number or None, "date": date}
    if seen.settings:
        cells |= {key: _cell(value) for key, value in {**FORMAT, **seen.settings}.items()}
        cells["time_column"] = cells["time_column"] or "none"
    parts = seen.parts or [InspectedMotion(motion, "") for motion in file.motions or (FILL_IN,)]
    phases = {part.column: part.phase for part in parts}
    if len(phases) > 1 and len({*phases.values()} - {""}) < len(phases):
        phases = {column: str(column) for column in phases}
    sure = seen.sure or shown <= {*file.motions}
    # All lines of a file have the same sign, which determines their motions.
    unsure = {} if sure else {"sign": FILL_IN} if line else {"motion": FILL_IN, "sign": FILL_IN}
    if cells.get("rate") == FILL_IN and len(parts) > len(phases):
        unsure |= {"from": FILL_IN, "to": FILL_IN}
    listed_rows = []
    for part in parts:
        row = {"motion": part.motion, "channel": part.column, "phase": phases[part.column]}
        row |= {"from": _cell(part.begin), "to": _cell(part.end), **part.paired}
        listed_rows.append({**cells, **row, **unsure})
    return listed_rows


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
        poles[row["motion"], row["phase"]].append(row)
    for pole in poles.values():
        numbers = _counters([Path(row["file"]).stem for row in pole])
        for row, number in zip(pole, numbers, strict=True):
            row["operation"] = row["operation"] or number
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


def _counters(stems: Sequence[str]) -> list[int | None]:
    """Return the counter in each of the names of files; None if a name is ambiguous, or all are
    years.

    >>> _counters(["op_0007", "op_0008_closing", "op_0009_10kHz", "notes"])
    [7, 8, None, None]
    """
    numbers = [match[1] if (match := _COUNTER.fullmatch(stem)) else "" for stem in stems]
    years = all(map(_YEAR.fullmatch, numbers))
    return [None if years or not number else int(number) for number in numbers]
