"""List the operations in the table ``operations.csv`` of a folder.

Light to import, since the plan of the workflow depends on it.
"""

import hashlib
import math
import os
from bisect import bisect_left
from collections import defaultdict
from collections.abc import Collection, Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, lru_cache
from itertools import pairwise
from pathlib import Path
from statistics import fmean

from breaker.common.numerals import natural
from breaker.model.quantities import CONDITIONS
from breaker.records.files import printable
from breaker.records.formats.detection import ENDINGS, records_in
from breaker.records.operations import MANIFEST, Operation, read_manifest

_Row = tuple[str, Operation]


def record_files(folder: str | Path) -> list[Path]:
    """List the files in a folder that have the ending of a record, except the table, hidden files
    and locks of open workbooks (``~$``); return an empty list if the folder does not exist.
    """
    return [
        Path(folder, name)
        for name in (sorted(os.listdir(folder)) if os.path.isdir(folder) else ())
        if os.path.splitext(name)[1].lower() in ENDINGS
        and not name.startswith((".", "~$"))
        and name != MANIFEST
    ]


def each_once(paths: Iterable[str | Path]) -> list:
    """Return files or folders in natural order, each once, even if several names lead to it.

    Posterior draws depend on the number of a record, but must not depend on the order of arguments.
    """
    rising = sorted(paths, key=natural, reverse=True)
    return [*{os.path.realpath(path): path for path in rising}.values()][::-1]


def list_operations(
    folder: str | Path, motion: str, *, breaker: str | None = None, phase: str | None = None
) -> list[Operation]:
    """List the operations of one motion in a folder, in the order of their numbers.

    The operations are the rows of the table, restricted to a breaker and phase.

    Raises:
        FileNotFoundError: If there is no table, or no operation of this motion.
        ValueError: If the table is wrong, two records have the same number, or a choice is lacking.
    """
    rows = table_rows(folder)
    for name, value in {"breaker": breaker, "phase": phase}.items():
        there = sorted({getattr(operation, name) for _, operation in rows})
        if (value is None and len(there) > 1) or (value is not None and value not in there):
            shown = ", ".join(printable(item) or "(empty)" for item in there)
            reason = f"endurance.{name} is {value}, but {printable(folder)} has {shown}"
            raise ValueError(f"{reason}; choose one, in a command by --{name} NAME, or null")
        rows = [row for row in rows if value is None or getattr(row[1], name) == value]
    operations = [operation for row_motion, operation in rows if row_motion == motion]
    if not operations:
        reason = f"{printable(Path(folder, MANIFEST))} has no operation of motion {motion}"
        raise FileNotFoundError(f"{reason}; add its rows, or leave it out of motions")
    if not any(os.path.exists(operation.file) for operation in operations):
        what = f"none of {len(operations)} files of {motion} is there, such as {operations[0].file}"
        raise ValueError(f"{printable(what)}; put them there, or correct {MANIFEST}")
    operations = sorted(each_line(operations), key=lambda operation: operation.number)
    for first, second in pairwise(operations):
        if first.number == second.number:
            what = " and ".join(f"{e.file}, line {e.line}" for e in (first, second))
            what = f"{what} are both operation {first.number}"
            raise ValueError(f"{printable(what)}; number them in {MANIFEST}")
    return operations


def each_line(operations: Iterable[Operation]) -> list[Operation]:
    """Return operations, with an operation for each line, with its number and date, if a file has a
    record on each line and the operation does not name a line.
    """
    listed_operations = []
    for operation in operations:
        rows = [] if operation.line else records_in(operation.file)
        listed_operations += [
            replace(operation, line=row.line, number=row.number, date=row.date or operation.date)
            for row in rows
        ] or [operation]
    return listed_operations


# ---- the table -----------------------------------------------------------------------------------


# All rules of a plan read the table, which may have half a million rows.
_read = lru_cache(maxsize=2)(lambda table, state: read_manifest(table))


def table_rows(folder: str | Path) -> list[_Row]:
    """Return motion and operation of each row of the table of a folder.

    Raises:
        FileNotFoundError: If there is no table.
        ValueError: If the table is wrong.
    """
    if not os.path.lexists(table := Path(folder, MANIFEST)):
        what = f"{printable(folder)} has no table {MANIFEST} of its operations"
        raise FileNotFoundError(f"{what}: `breaker inspect {printable(folder)}` proposes one")
    return _read(table, _state(table))


def list_fleet(
    folder: str | Path, *, breakers: Collection[str] | None = None, phase: str | None = None
) -> dict[str, list[_Row]]:
    """List motion and operation of each row of a table, by breaker, in the order of the table.

    Arguments and errors are those of ``list_operations``; all breakers and phases by default.
    """
    fleet: dict[str, list[_Row]] = {}
    for motion, row in table_rows(folder):
        if breakers is None or row.breaker in breakers:
            rows = fleet.setdefault(row.breaker, [])
            rows += [(motion, e) for e in each_line([row] if phase in (None, row.phase) else [])]
    if lacking := [breaker for breaker, rows in fleet.items() if not rows]:
        reason = f"{printable(folder)} does not have for {printable(lacking[0])}"
        raise ValueError(f"endurance.phase is {phase}, which {reason}; choose another phase")
    return fleet


def known_of(
    rows: Iterable[Operation], numbers: Sequence[int]
) -> tuple[dict[int, str], dict[str, dict[int, float]]]:
    """Return events and conditions that rows of a table state for a drive: events by the first of
    the increasing ``numbers`` at or after the row's, and means by ``CONDITIONS`` and operation.
    """
    events: dict[int, dict[str, None]] = defaultdict(dict)
    values: dict[str, dict[int, list[float]]] = defaultdict(lambda: defaultdict(list))
    for row in sorted(rows, key=lambda row: row.number):
        if row.event and (place := bisect_left(numbers, row.number)) < len(numbers):
            events[numbers[place]][row.event] = None
        for name in CONDITIONS:
            if not math.isnan(value := getattr(row, name)):
                values[name][row.number].append(value)
    means = {name: {i: fmean(items) for i, items in by.items()} for name, by in values.items()}
    return {number: ", ".join(texts) for number, texts in events.items()}, means


def fingerprint(operations: Iterable[Operation]) -> str:
    """Return a text that changes with the operations, and the name, size or time of any file."""
    digest, state_of = hashlib.sha256(), cache(_state)
    for operation in operations:
        file = Path(operation.file)
        states = [*map(state_of, (file, file.with_suffix(".dat"), file.with_suffix(".DAT")))]
        digest.update(f"{operation!r} {states}".encode(errors="backslashreplace"))
    return digest.hexdigest()


def _state(file: Path) -> tuple[str, int, int]:
    with suppress(OSError):
        state = file.stat()
        return str(file), state.st_size, state.st_mtime_ns
    return str(file), 0, 0
