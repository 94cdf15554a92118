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

from breaker.model.quantities import CONDITIONS
from breaker.records.file_names import numbers_in
from breaker.records.files import RejectedCurveError, is_store, no_file, printable
from breaker.records.formats.registry import ENDINGS, records_in
from breaker.records.operations import MANIFEST, SHOWN, Operation, breakers_in, read_manifest

# ---- files ---------------------------------------------------------------------------------------


def record_files(folder: str | Path) -> list[Path]:
    """List the files in a folder that have the ending of a record, in any case, by name.

    Hidden files, locks of open workbooks (``~$``) and the table of operations are left out. The
    list is empty if there is no such folder.
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


def is_odd(path: str | Path) -> bool:
    """Return whether a path has a sign that no path of a record may have.

    Snakemake takes braces and angle brackets for a pattern; signs that cannot be printed and
    backslashes are in no table.
    """
    text = Path(path).as_posix()
    return not text.isprintable() or any(sign in text for sign in "{}<>\\")


def why_no_record(file: Path) -> str:
    """Return why a file cannot be a record, by its name and kind; empty if it may be one."""
    if is_odd(file):
        return "has a sign in its name that a table cannot hold; rename it"
    return "" if is_store(file) and file.is_dir() else no_file(file)


def _require_files(operations: Iterable[Operation]) -> None:
    """Refuse what is not a file, and names that stand for something else than themselves.

    A missing file is rejected when it is read, so that it does not end the others; all missing
    files are refused.
    """
    files = dict.fromkeys(each.file for each in operations)
    whys = {file: why for file in files if (why := why_no_record(Path(file)))}
    wrong = [f"{f} {why}" for f, why in whys.items() if os.path.exists(f) or is_odd(f)]
    if wrong or (len(whys) == len(files) and (wrong := [f"{f} {w}" for f, w in whys.items()])):
        raise ValueError(f"{_first(wrong)}; put the file there, or leave it out")


def _first(wrong: Sequence[str]) -> str:
    more = [f"{len(wrong) - SHOWN} more"] if len(wrong) > SHOWN else []
    return "; ".join([*map(printable, wrong[:SHOWN]), *more])


# ---- operations ----------------------------------------------------------------------------------


def list_operations(
    folder: str | Path,
    motion: str,
    *,
    breaker: str | None = None,
    phase: str | None = None,
    events: Collection[str] | None = None,
) -> list[Operation]:
    """List the operations of one motion in a folder, in the order of their numbers.

    With a table ``operations.csv`` in the folder, they are its rows. Without one they are the files
    in ``folder/motion``, and a name must leave no doubt about the number.

    Args:
        folder: Folder of the curve files, ``endurance.curves``.
        motion: "closing" or "opening".
        breaker, phase: ``endurance.breaker`` and ``endurance.phase``: which of those in the table,
            if there are several.
        events: ``endurance.events``: what the table may name in addition to the usual events; None
            for any text.

    Raises:
        FileNotFoundError: If there is no operation of this motion.
        ValueError: If the table is wrong, a name has no number, two records have the same one,
            there are several breakers or phases and none is chosen, or something cannot be a file
            of a record. The message states what to do.
    """
    table, chosen = Path(folder, MANIFEST), {"breaker": breaker, "phase": phase}
    if os.path.lexists(table):
        operations = [each for of, each in _chosen_rows(table, chosen, events) if of == motion]
        if not operations:
            raise FileNotFoundError(
                f"{table} has no operation of motion {motion}; add its rows, or leave it out of "
                "motions"
            )
    elif given := " and ".join(f"endurance.{k} is {v}" for k, v in chosen.items() if v):
        raise ValueError(
            f"{given}, but {printable(folder)} has no table {MANIFEST} that names any; set it to "
            "null, or add the table"
        )
    else:
        operations = _from_names(Path(folder, motion))
    _require_files(operations)
    found = sorted(each_line(operations), key=lambda each: each.number)
    for one, other in pairwise(found):
        if one.number == other.number:
            raise ValueError(
                f"{_place(one)} and {_place(other)} are both operation {one.number}; rename one of "
                f"the files, or state which file is which operation in a table {MANIFEST}: "
                f"`breaker inspect {printable(folder)}` proposes one"
            )
    return found


@lru_cache
def list_once(
    folder: str, motion: str, breaker: str | None, phase: str | None, *events: str
) -> list[Operation]:
    """List as ``list_operations``, once, which takes a while where there are many thousand files.

    A folder changes: ``list_once.cache_clear()`` before a plan.
    """
    return list_operations(folder, motion, breaker=breaker, phase=phase, events=events)


def each_line(operations: Iterable[Operation]) -> list[Operation]:
    """Return operations; one for each line, with its number and date, where a file has one record
    per line and the operation names no line.
    """
    found = []
    for one in operations:
        rows = [] if one.line else records_in(one.file)
        found += [
            replace(one, line=row.line, number=row.number, date=row.date or one.date)
            for row in rows
        ] or [one]
    return found


def _place(operation: Operation) -> str:
    line = f", line {operation.line}" if operation.line else ""
    return f"{printable(operation.file)}{line}"


def _chosen_rows(
    table: Path, chosen: Mapping[str, str | None], events: Collection[str] | None
) -> list[tuple[str, Operation]]:
    """Return the rows of a table that are of the chosen breaker and phase."""
    rows = read_manifest(table, events)
    for name, value in chosen.items():
        there = sorted({getattr(each, name) for _, each in rows})
        shown = ", ".join(printable(each) or "(empty)" for each in there)
        if value is None and len(there) > 1:
            raise ValueError(
                f"{table} has {len(there)} different values in its column {name}: {shown}; choose "
                f"one by endurance.{name}, or in a command by --{name} NAME"
            )
        if value is not None and value not in there:
            raise ValueError(f"endurance.{name} is {value}, but {table} has {shown}")
        rows = [row for row in rows if value is None or getattr(row[1], name) == value]
    return rows


def _from_names(folder: Path) -> list[Operation]:
    """Return the operations in the folder of a motion, by the names of its files."""
    files = record_files(folder)
    if not files:
        raise FileNotFoundError(
            f"{printable(folder)}/ has no file of a record ({' '.join(ENDINGS)}); endurance.curves "
            f"must name a folder with a subfolder for each motion, or with a table {MANIFEST}"
        )
    many = each_line([Operation(0, file) for file in files])
    many = [each for each in many if each.line]
    files = sorted({*files} - {each.file for each in many})
    named = list(zip(files, numbers_in([file.stem for file in files]), strict=True))
    if unclear := [f"{file} {why}" for file, why in named if isinstance(why, str)]:
        raise ValueError(
            f"{_first(unclear)}. Rename it, or state which file is which operation in a table "
            f"{MANIFEST}: `breaker inspect {printable(folder.parent)}` proposes one"
        )
    return [*many, *(Operation(number, file) for file, number in named)]


# ---- several breakers ----------------------------------------------------------------------------


def list_breakers(folder: str | Path) -> Sequence[str]:
    """List the breakers in the table of a folder, in the order of their first rows.

    None where there is no table, or one that cannot be read: ``list_fleet`` states why.
    """
    table = Path(folder, MANIFEST)
    return _breakers(table, _state(table))


@lru_cache(maxsize=1)
def _breakers(table: Path, state: tuple[int, int]) -> Sequence[str]:
    try:
        return tuple(breakers_in(table))
    except RejectedCurveError:
        return ()


def list_fleet(
    folder: str | Path,
    *,
    breakers: Collection[str] | None = None,
    phase: str | None = None,
    events: Collection[str] | None = None,
) -> dict[str, list[tuple[str, Operation]]]:
    """List motion and operation of each row of a table, by breaker, in the order of the table.

    Args:
        folder, phase, events: As of ``list_operations``; without a phase, all of them.
        breakers: Those that are listed; None for all. Files of others are not looked at.

    Raises:
        ValueError: If the table is wrong, has no such phase, or something cannot be a file.
    """
    table = Path(folder, MANIFEST)
    some, names = (each if each is None else tuple(each) for each in (events, breakers))
    return _fleet(table, _state(table), some, names, phase)


@lru_cache(maxsize=1)  # all rules ask for it, and it may have half a million rows
def _fleet(
    table: Path,
    state: tuple[int, int],
    events: tuple[str, ...] | None,
    breakers: tuple[str, ...] | None,
    phase: str | None,
) -> dict[str, list[tuple[str, Operation]]]:
    rows = read_manifest(table, events, breakers and frozenset(breakers))
    found: dict[str, list[tuple[str, Operation]]] = {}
    for motion, row in rows:
        if phase in (None, row.phase):
            found.setdefault(row.breaker, []).extend((motion, each) for each in each_line([row]))
    if lacking := {row.breaker for _, row in rows} - found.keys():
        raise ValueError(f"endurance.phase is {phase}, which {table} has not of {min(lacking)}")
    _require_files(each for some in found.values() for _, each in some)
    return found


# ---- what is known of operations -----------------------------------------------------------------


def list_known(
    folder: str | Path,
    numbers: Sequence[int],
    *,
    breaker: str | None = None,
    phase: str | None = None,
) -> tuple[dict[int, str], dict[str, dict[int, float]]]:
    """List what the table of a folder, if there is one, states of operations: see ``known_of``.

    Args:
        folder, breaker, phase: As of ``list_operations``.
    """
    if not os.path.lexists(Path(folder, MANIFEST)):
        return {}, {}
    chosen = {"breaker": breaker, "phase": phase}
    rows = _chosen_rows(Path(folder, MANIFEST), chosen, None)
    return known_of(each_line(row for _, row in rows), numbers)


def known_of(
    rows: Iterable[Operation], numbers: Sequence[int]
) -> tuple[dict[int, str], dict[str, dict[int, float]]]:
    """Return what rows of a table, of any motion, state of a drive's operations.

    Args:
        numbers: Operations that are looked at, rising. An event belongs to the first of them that
            comes after it.

    Returns:
        Events by operation, and by name of ``CONDITIONS`` their mean values by operation, where
        there are any.

    Example:
        >>> rows = [Operation(1, "a.csv", temperature=each) for each in (20.0, 24.0)]
        >>> known_of(rows, [1])
        ({}, {'temperature': {1: 22.0}})
    """
    events: dict[int, list[str]] = {}
    conditions: dict[str, dict[int, list[float]]] = {name: {} for name in CONDITIONS}
    for row in sorted(rows, key=lambda row: row.number):
        if row.event and (next_one := bisect_left(numbers, row.number)) < len(numbers):
            events.setdefault(numbers[next_one], []).append(row.event)
        for name, values in conditions.items():
            if not math.isnan(value := getattr(row, name)):
                values.setdefault(row.number, []).append(value)
    means = {
        name: {number: sum(some) / len(some) for number, some in values.items()}
        for name, values in conditions.items()
        if values
    }
    return {number: ", ".join(dict.fromkeys(texts)) for number, texts in events.items()}, means


def fingerprint(operations: Iterable[Operation]) -> str:
    """Return a text that changes with the operations, and the name, size or time of any file."""
    states: dict[str | Path, list] = {}
    found = hashlib.sha256()
    for each in operations:
        if each.file not in states:
            states[each.file] = [(str(part), *_state(part)) for part in _parts(Path(each.file))]
        found.update(f"{each!r} {states[each.file]}".encode(errors="backslashreplace"))
    return found.hexdigest()


def _parts(file: Path) -> list[Path]:
    """Return the files of a record."""
    if is_store(file):
        return sorted(file.rglob("*"))
    return [file, *map(file.with_suffix, (".dat", ".DAT") if file.suffix.lower() == ".cfg" else ())]


def _state(file: Path) -> tuple[int, int]:
    try:
        found = file.stat()
    except OSError:
        return 0, 0
    return found.st_size, found.st_mtime_ns
