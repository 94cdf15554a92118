"""The operations in a folder: by its table ``operations.csv``, or by the names of its files.

Light to import: the plan of the workflow is made from it.
"""

import hashlib
import math
import os
from bisect import bisect_left
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

from breaker.common.numerals import first_of
from breaker.model.quantities import CONDITIONS
from breaker.records.file_names import numbers_in
from breaker.records.files import is_store, no_file, printable
from breaker.records.formats.registry import ENDINGS, records_in
from breaker.records.operations import MANIFEST, SHOWN, Operation, read_manifest

_Row = tuple[str, Operation]


def record_files(folder: str | Path) -> list[Path]:
    """List the files in a folder that have the ending of a record; none where it is not there.

    Hidden files, locks of open workbooks (``~$``) and the table of operations are left out.
    """
    return [
        Path(folder, name)
        for name in (sorted(os.listdir(folder)) if os.path.isdir(folder) else ())
        if os.path.splitext(name)[1].lower() in ENDINGS
        and not name.startswith((".", "~$"))
        and name != MANIFEST
    ]


def is_folder(name: str | Path) -> bool:
    """Return whether a name is that of a folder that is not itself a record."""
    return os.path.isdir(name) and not is_store(name)


def why_no_record(file: Path) -> str:
    """Return why a file cannot be a record, by its name and kind; empty if it may be one."""
    # Snakemake takes braces and angle brackets for patterns.
    if not file.as_posix().isprintable() or {*"{}<>\\"} & {*file.as_posix()}:
        return "has a sign in its name that a table cannot hold; rename it"
    return "" if is_store(file) and file.is_dir() else no_file(file)


def _require_files(operations: Iterable[Operation]) -> None:
    """Refuse what cannot be a file, and files of which all are missing.

    One missing file is rejected when it is read, so that it does not end the others.
    """
    files = dict.fromkeys(each.file for each in operations)
    whys = {file: why for file in files if (why := why_no_record(Path(file)))}
    wrong = {file: why for file, why in whys.items() if os.path.exists(file) or "sign" in why}
    if wrong := wrong or (whys if len(whys) == len(files) else {}):
        shown = first_of([printable(f"{file} {why}") for file, why in wrong.items()], SHOWN)
        raise ValueError(f"{shown}; put the file there, or leave it out")


def list_operations(
    folder: str | Path,
    motion: str,
    *,
    breaker: str | None = None,
    phase: str | None = None,
    events: Collection[str] | None = None,
) -> list[Operation]:
    """List the operations of one motion in a folder, in the order of their numbers.

    They are the rows of its table ``operations.csv``, or else the files in ``folder/motion``.

    Args:
        folder, motion: Folder of the curve files, ``endurance.curves``; "closing" or "opening".
        breaker, phase: Which of those in the table, if there are several.
        events: What the table may name in addition to the usual events; None for any text.

    Raises:
        FileNotFoundError: If there is no operation of this motion.
        ValueError: If the table is wrong, a name has no number, two records have the same one, a
            choice is lacking, or something cannot be a file of a record.
    """
    table, chosen = Path(folder, MANIFEST), {"breaker": breaker, "phase": phase}
    if os.path.lexists(table):
        operations = [each for of, each in _chosen_rows(table, chosen, events) if of == motion]
        if not operations:
            remedy = "add its rows, or leave it out of motions"
            raise FileNotFoundError(f"{table} has no operation of motion {motion}; {remedy}")
    elif breaker or phase:
        reason = f"{printable(folder)} has no table {MANIFEST} that names breakers and phases"
        raise ValueError(f"{reason}; set endurance.breaker and endurance.phase to null, or add it")
    else:
        operations = _from_names(Path(folder, motion))
    _require_files(operations)
    found = sorted(each_line(operations), key=lambda each: each.number)
    for one, other in pairwise(found):
        if one.number == other.number:
            places = [f"{e.file}, line {e.line}" if e.line else f"{e.file}" for e in (one, other)]
            what = f"{' and '.join(places)} are both operation {one.number}"
            raise ValueError(f"{printable(what)}; {_REMEDY}")
    return found


_REMEDY = (
    f"rename one of the files, or state which file is which operation in a table {MANIFEST}: "
    "`breaker inspect` for the folder proposes one"
)


def each_line(operations: Iterable[Operation]) -> list[Operation]:
    """Return operations; one for each line, with its number and date, where a file has one record
    on each line and the operation names no line.
    """
    found = []
    for one in operations:
        rows = [] if one.line else records_in(one.file)
        found += [
            replace(one, line=row.line, number=row.number, date=row.date or one.date)
            for row in rows
        ] or [one]
    return found


def _from_names(folder: Path) -> list[Operation]:
    """Return the operations in the folder of a motion, by the names of its files."""
    if not (files := record_files(folder)):
        raise FileNotFoundError(
            f"{printable(folder)}/ has no file of a record ({' '.join(ENDINGS)}); endurance.curves "
            f"must name a folder with a subfolder for each motion, or with a table {MANIFEST}"
        )
    found = [each for each in each_line(Operation(0, file) for file in files) if each.line]
    files = sorted({*files} - {each.file for each in found})
    numbers = dict(zip(files, numbers_in([file.stem for file in files]), strict=True))
    if unclear := [printable(file) for file, number in numbers.items() if number is None]:
        what = "names no counter for sure: a number may be a date, a year, a channel or a quantity"
        raise ValueError(f"{first_of(unclear, SHOWN)} {what}; {_REMEDY}")
    return [*found, *(Operation(number, file) for file, number in numbers.items())]


# ---- the table -----------------------------------------------------------------------------------


# All rules of a plan ask for the table, which may have half a million rows.
_read = lru_cache(maxsize=2)(lambda table, state, events: read_manifest(table, events))


def _rows(table: Path, events: Collection[str] | None) -> list[_Row]:
    return _read(table, _state(table), events if events is None else tuple(events))


def _chosen_rows(
    table: Path, chosen: Mapping[str, str | None], events: Collection[str] | None
) -> list[_Row]:
    """Return the rows of a table that are of the chosen breaker and phase."""
    rows = _rows(table, events)
    for name, value in chosen.items():
        there = sorted({getattr(each, name) for _, each in rows})
        if (value is None and len(there) > 1) or (value is not None and value not in there):
            shown = ", ".join(printable(each) or "(empty)" for each in there)
            reason = f"endurance.{name} is {value}, but {table} has {shown}"
            raise ValueError(f"{reason}; choose one, in a command by --{name} NAME")
        rows = [row for row in rows if value is None or getattr(row[1], name) == value]
    return rows


def list_breakers(folder: str | Path, events: Collection[str] | None = None) -> Sequence[str]:
    """List the breakers in the table of a folder, if it has one, as of ``list_fleet``."""
    table = Path(folder, MANIFEST)
    rows = _rows(table, events) if os.path.lexists(table) else ()
    return list(dict.fromkeys(each.breaker for _, each in rows))


def list_fleet(
    folder: str | Path,
    *,
    breakers: Collection[str] | None = None,
    phase: str | None = None,
    events: Collection[str] | None = None,
) -> dict[str, list[_Row]]:
    """List motion and operation of each row of a table, by breaker, in the order of the table.

    Arguments and errors are those of ``list_operations``; all breakers and phases by default.
    """
    table = Path(folder, MANIFEST)
    rows = [e for e in _rows(table, events) if breakers is None or e[1].breaker in breakers]
    found: dict[str, list[_Row]] = {}
    for motion, row in rows:
        if phase in (None, row.phase):
            found.setdefault(row.breaker, []).extend((motion, each) for each in each_line([row]))
    if lacking := {row.breaker for _, row in rows} - found.keys():
        raise ValueError(f"endurance.phase is {phase}, which {table} has not of {min(lacking)}")
    _require_files(each for some in found.values() for _, each in some)
    return found


def known_of(
    rows: Iterable[Operation], numbers: Sequence[int]
) -> tuple[dict[int, str], dict[str, dict[int, float]]]:
    """Return what rows of a table, of any motion, state of a drive's operations: events by
    operation, and mean values by name of ``CONDITIONS`` and by operation.

    An event belongs to the first of the numbers, which rise, that is not before it.
    """
    events: dict[int, list[str]] = {}
    values: dict[str, dict[int, list[float]]] = {}
    for row in sorted(rows, key=lambda row: row.number):
        if row.event and (place := bisect_left(numbers, row.number)) < len(numbers):
            events.setdefault(numbers[place], []).append(row.event)
        for name in CONDITIONS:
            if not math.isnan(value := getattr(row, name)):
                values.setdefault(name, {}).setdefault(row.number, []).append(value)
    texts = {number: ", ".join(dict.fromkeys(some)) for number, some in events.items()}
    means = {n: {i: sum(v) / len(v) for i, v in of.items()} for n, of in values.items()}
    return texts, means


def fingerprint(operations: Iterable[Operation]) -> str:
    """Return a text that changes with the operations, and the name, size or time of any file."""
    states: dict[str | Path, list] = {}
    found = hashlib.sha256()
    for each in operations:
        if each.file not in states:
            file = Path(each.file)
            data = [file.with_suffix(end) for end in (".dat", ".DAT")]
            parts = sorted(file.rglob("*")) if is_store(file) else [file, *data]
            states[each.file] = [(str(part), *_state(part)) for part in parts]
        found.update(f"{each!r} {states[each.file]}".encode(errors="backslashreplace"))
    return found.hexdigest()


def _state(file: Path) -> tuple[int, int]:
    try:
        state = file.stat()
    except OSError:
        return 0, 0
    return state.st_size, state.st_mtime_ns
