"""The table ``operations.csv``: which file, or which part of a file, is which operation.

Each column has its own reader of cells, which states what is wrong with a cell and what to write.
Light to import.
"""

import csv
import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from io import StringIO
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

from breaker.common.numerals import in_digits
from breaker.common.safe_text import as_meant
from breaker.model.parameters import MOTIONS
from breaker.records.dates import cell_date, dates_of, day_order, earlier
from breaker.records.file_names import LARGEST_COUNTER
from breaker.records.files import MOST_COLUMNS, RejectedCurveError, printable, read_bytes
from breaker.records.settings import FORMAT, READABLE, TO_MM, TO_MS

MANIFEST = "operations.csv"
"""Name of the table, in the folder of the curve files."""

FILL_IN = "FILL IN"
"""Cell of a value that a file does not state; the table is refused until it is filled in."""

LONGEST = 200
"""Characters of a name or a text in a cell."""

SHOWN = 10
"""Mistakes, or files, in one message."""

EVENTS: dict[str, tuple[str, ...]] = {
    "maintenance, overhaul, repair, adjusted, adjustment": ("all",),
    "greased, greasing, lubricated, lubrication": ("all",),
    "opening spring replaced, contact spring replaced, closing spring replaced": ("all",),
    "contacts replaced, interrupter replaced": ("all",),
    "remounted, remounting, transducer remounted, transducer replaced": ("transducer",),
    "inspected, inspection, cleaned": (),
}
"""Usual events, and what starts anew: the entire drive, the reading of its transducer, nothing."""

_REQUIRED = ("file", "motion", "operation")
_PLAIN = re.compile(r"[\w-][\w.-]*(?:/[\w-][\w.-]*)*")  # most paths; others take longer to check
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]{1,3})?")
_DECIMAL = re.compile("[+-]?(?![0-9]{1,3},[0-9]{3}$)[0-9]+,[0-9]+")  # not 1,000: a thousand?


@dataclass(frozen=True)
class Operation:
    """One motion of one operation, and where its record is.

    Attributes:
        number: Counter of the operation.
        file: File of the record.
        channel: Column of the travel in the file; that of ``endurance.format`` if empty.
        line: Line of the file that holds this operation, where each line is a record; 0 for all of
            the file.
        begin, end: Part of the record that contains the motion, ms of the file's time; NaN for its
            beginning and end.
        breaker, phase, type: Names, where a table gives them.
        date: Date and time as ISO 8601.
        temperature: Of the drive, °C.
        voltage: Of the control circuit, V or % of the rated one.
        event: What was done before this operation, since the one before it: see ``event_words``.
        settings: What the table states in place of keys of ``endurance.format``.
    """

    number: int
    file: str | Path
    channel: str = ""
    begin: float = math.nan
    end: float = math.nan
    breaker: str = ""
    phase: str = ""
    type: str = ""
    date: str = ""
    temperature: float = math.nan
    voltage: float = math.nan
    event: str = ""
    settings: Mapping[str, Any] = field(default_factory=dict, hash=False)
    line: int = 0


# ---- the table -----------------------------------------------------------------------------------


def read_manifest(
    file: str | Path,
    events: Collection[str] | None = None,
    breakers: Collection[str] | None = None,
) -> list[tuple[str, Operation]]:
    """Read the table of a folder, also as spreadsheets write it.

    The text is UTF-8, or UTF-16 with a byte order mark. Commas, semicolons or tabs separate cells.
    Empty lines, empty columns and empty cells behind the last name are left out.

    Args:
        file: The table.
        events: Events that it may name in addition to the usual ones; None for any text.
        breakers: Those whose rows are read; None for all.

    Returns:
        Motion and operation of each row. Whether the files exist is not checked.

    Raises:
        ValueError: If anything is wrong; the message has one line for each of the first mistakes,
            with line, column, value and remedy.
    """
    file = Path(file)
    head, names, rows = _rows(file)
    found: list[tuple[str, Operation]] = []
    wrong = list(_wrong_names(head, names))
    if not wrong and not rows:
        wrong = [f"line {head}: no operation follows the names of the columns; add a row for each"]
    if breakers is not None and "breaker" in names:
        place = names.index("breaker")
        rows = [row for row in rows if len(row[1]) <= place or row[1][place] in breakers]
    readers = {**READ}
    if events is not None:
        readers["event"] = _event_reader(events)
    if "date" in names:
        place = names.index("date")
        dates = ("".join(cells[place : place + 1]) for _, cells in rows)
        order = day_order(dates_of(cell) for cell in dates if not cell[:4].isdigit())
        readers["date"] = partial(cell_date, order=order)
    lines: dict[tuple, int] = {}
    for line, cells in rows if not wrong else ():
        row, mistakes = _row(names, cells, file.parent, readers)
        if row:
            motion, each = row
            first = lines.setdefault((each.breaker, each.phase, motion, each.number), line)
            if first != line:
                mistakes.append(
                    f"column operation: {motion} {each.number} is in line {first} already; give "
                    "each its own number, breaker or phase"
                )
            found.append(row)
        wrong += [f"line {line}, {mistake}" for mistake in mistakes]
    if wrong := wrong or _out_of_order(found, lines):
        more = [f"and {len(wrong) - SHOWN} more"] if len(wrong) > SHOWN else []
        raise ValueError("\n  ".join([f"{printable(file)} is wrong:", *wrong[:SHOWN], *more]))
    return found


def breakers_in(file: str | Path) -> list[str]:
    """Return the names of the breakers in a table, in the order of their first rows.

    Raises:
        RejectedCurveError: If it is not a table.
    """
    _, names, rows = _rows(Path(file))
    if "breaker" not in names:
        return []
    place = names.index("breaker")
    return list(dict.fromkeys("".join(cells[place : place + 1]) for _, cells in rows))


def _rows(file: Path) -> tuple[int, list[str], list[tuple[int, list[str]]]]:
    """Return the line of the names, the names, and line and cells of each row that has any."""
    content = read_bytes(file)
    encoding = "utf-16" if content[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        reason = "is not UTF-8; save the table as CSV UTF-8"
        raise RejectedCurveError(file, reason, line=line) from error
    # Lines as they end in the file: a cell in quotation marks may have several.
    reader = csv.reader(StringIO(text, newline=""), delimiter=_delimiter(text), strict=True)
    rows, line = [], 1
    try:
        for cells in reader:
            cells = [as_meant(cell.strip()) for cell in cells]
            while cells and not cells[-1]:
                cells.pop()
            if cells:
                rows.append((line, cells))
            line = reader.line_num + 1
    except csv.Error as error:
        reason = f"is not a table: {error}; are quotation marks closed?"
        raise RejectedCurveError(file, reason, line=line) from error
    if rows and rows[0][1][0].startswith("sep="):
        del rows[0]
    if not rows:
        raise RejectedCurveError(file, f"is empty; its first line names {', '.join(_REQUIRED)}")
    (head, names), *rows = rows
    return head, [name.lower() if name.lower() in READ else name for name in names], rows


def _delimiter(text: str) -> str:
    """Return the sign that separates the names of columns, in the first line that has any."""
    found = re.search(r"[^\r\n]*[^\W_][^\r\n]*", text)
    head = found[0].strip() if found else ""
    if head.startswith("sep="):  # as spreadsheets name it
        return head.removeprefix("sep=") or ","
    counts = {sign: sum(n.strip(' "').lower() in READ for n in head.split(sign)) for sign in ",;\t"}
    return max(counts, key=counts.__getitem__)


def _wrong_names(head: int, names: Sequence[str]) -> Iterator[str]:
    """Yield what is wrong with the names of the columns."""
    for place, name in enumerate(names, start=1):
        if name and name not in READ:
            known = ", ".join(READ)
            yield (
                f"line {head}, column {place}: {name!r} is not one of {known}; rename it, or leave "
                "it out"
            )
        elif name and name in names[: place - 1]:
            yield f"line {head}, column {place}: {name} is there twice; leave one of them out"
    if lacking := [name for name in _REQUIRED if name not in names]:
        yield (
            f"line {head}: the column {' and '.join(lacking)} is missing; the first line must name "
            "the columns, with commas or semicolons between"
        )


def _row(
    names: Sequence[str], cells: Sequence[str], folder: Path, readers: Mapping[str, Callable]
) -> tuple[tuple[str, Operation] | None, list[str]]:
    """Return motion and operation of a row, and what is wrong with it, by column."""
    read, mistakes = {}, []
    for place, cell in enumerate(cells):
        name = names[place] if place < len(names) else ""
        try:
            if not name and cell:
                mistakes.append(
                    f"column {place + 1}: {cell!r} stands under no name; name the column, or set a "
                    "cell with a comma in quotation marks"
                )
            elif cell.upper() == FILL_IN:
                raise ValueError(
                    f"is to be filled in for {cells[names.index('file')]}, which does not state it "
                    "for sure: `breaker inspect` shows why; see the analyser's settings"
                )
            elif cell:
                read[name] = readers[name](cell)
        except ValueError as error:
            mistakes.append(f"column {name}: {error}")
            read.setdefault(name, None)
    mistakes += [f"column {name}: is empty; fill it in" for name in _REQUIRED if name not in read]
    if mistakes:
        return None, mistakes
    begin, end = read.pop("from", math.nan), read.pop("to", math.nan)
    if begin >= end:
        what = f"{in_digits(end, 9)} is not after from, {in_digits(begin, 9)}; mend one of them"
        return None, [f"column to: {what}"]
    file, motion, number = (read.pop(name) for name in _REQUIRED)
    read["settings"] = {name: read.pop(name) for name in FORMAT if name in read}
    return (motion, Operation(number, folder / file, begin=begin, end=end, **read)), []


def _out_of_order(rows: Collection[tuple[str, Operation]], lines: Mapping) -> list[str]:
    """Return where numbers of operations rise while their dates fall."""
    last: dict[tuple, Operation] = {}
    wrong = []
    for motion, each in sorted(rows, key=lambda row: row[1].number):
        if each.date:
            of = each.breaker, each.phase, motion
            before = last.get(of, each)
            if earlier(before.date, each.date):
                wrong.append(
                    f"line {lines[(*of, each.number)]}, column date: {each.date}, of {motion} "
                    f"{each.number}, is earlier than {before.date}, of {before.number}: mend the "
                    "number or the date, or leave the date empty where a clock was wrong"
                )
            last[of] = each
    return wrong


# ---- cells ---------------------------------------------------------------------------------------


def event_words(event: str) -> tuple[str, ...]:
    """Return the events in a cell, which commas, semicolons or plus signs separate.

    >>> event_words("Greased; spring-replaced")
    ('greased', 'spring replaced')
    """
    found = (" ".join(re.split(r"[\s_-]+", part.strip())) for part in re.split("[,;+]", event))
    return tuple(dict.fromkeys(part.lower() for part in found if part))


def _event_reader(known: Collection[str]) -> Callable[[str], str]:
    """Return a reader of cells that name usual events, or others that are known."""
    known = sorted({word for events in (*EVENTS, *known) for word in event_words(events)})

    def read(cell: str) -> str:
        for word in event_words(_text(cell)):
            if word not in known:
                raise ValueError(
                    f"{word!r} is not a known event ({', '.join(known)}); write one of these, "
                    "several with commas between, or add it to endurance.events"
                )
        return cell

    return read


def _text(cell: str) -> str:
    if not cell.isprintable():
        raise ValueError(f"{cell!r} has signs that cannot be printed; remove them")
    if len(cell) > LONGEST:
        raise ValueError(f"has {len(cell)} signs; use at most {LONGEST}")
    return cell


def _file(cell: str) -> str:
    if _PLAIN.fullmatch(cell) and len(cell) <= LONGEST:
        return cell
    path = PurePosixPath(_text(cell))
    if ".." in path.parts or path.is_absolute() or PureWindowsPath(cell).drive:
        raise ValueError(
            f"{cell!r} is not in the folder of the table; put it there, and name it from there"
        )
    if "\\" in cell:
        raise ValueError(f"{cell!r} has a \\; write / between folder and file")
    return cell


def _one_of(values: Mapping[str, Any]) -> Callable[[str], Any]:
    """Return a reader of a few words, and what each stands for."""

    def read(cell: str) -> Any:
        if cell.lower() not in values:
            raise ValueError(f"{cell!r} is not one of {', '.join(values)}; write one of these")
        return values[cell.lower()]

    return read


def _whole(least: int, most: int, what: str, remedy: str) -> Callable[[str], int]:
    """Return a reader of the digits of a number within a range."""

    def read(cell: str) -> int:
        number = int(cell[-LONGEST:]) if re.fullmatch("[0-9]+", cell) else -1
        if not least <= number <= most:
            raise ValueError(f"{cell!r} is not {what}, {least} to {most}; {remedy}")
        return number

    return read


def _column(least: int) -> Callable[[str], str | int | None]:
    """Return a reader of the name or number of a column; none is that there is no such column."""
    number = _whole(least, MOST_COLUMNS, "the number of a column", "count columns from 1")

    def read(cell: str) -> str | int | None:
        if cell.lower() == "none":
            return None
        return number(cell) if re.fullmatch("[0-9]+", cell) else _text(cell)

    return read


def _number(least: float, most: float, unit: str, *words: str) -> Callable[[str], float | str]:
    """Return a reader of numbers within a range, or of words; a comma may be the decimal sign."""

    def read(cell: str) -> float | str:
        text = cell.replace(",", ".") if _DECIMAL.fullmatch(cell) else cell
        if cell.lower() in words:
            return cell.lower()
        if not _NUMBER.fullmatch(text):
            raise ValueError(f"{cell!r} is not a number; write it as 21.5 or -3")
        if not least <= float(text) <= most:
            ends = f"{in_digits(least, 9)} and {in_digits(most, 9)} {unit}"
            raise ValueError(f"{cell} is not between {ends}; mend it, or its unit")
        return float(text)

    return read


# Columns that the table may have, and what reads their cells; ranges refuse other units.
READ: dict[str, Callable] = {
    "file": _file,
    "motion": _one_of({motion: motion for motion in MOTIONS}),
    "operation": _whole(
        0, LARGEST_COUNTER, "a counter of operations", "write dates into the column date"
    ),
    "channel": _text,
    "line": _whole(1, LARGEST_COUNTER, "a line of a file", "count lines from 1"),
    "breaker": _text,
    "phase": _text,
    "type": _text,
    "date": cell_date,
    "temperature": _number(-60.0, 120.0, "°C"),
    "voltage": _number(1.0, 1000.0, "V or % of the rated one"),
    "event": _text,
    "from": _number(-1e7, 1e7, "ms"),
    "to": _number(-1e7, 1e7, "ms"),
    # Of endurance.format, for this record alone.
    "encoding": _text,
    "delimiter": _one_of({sign: sign for sign in ",;|"} | {"tab": "\t", "blank": " "}),
    "decimal": _one_of({sign: sign for sign in ".,"}),
    "time_column": _column(1),
    "time_unit": _one_of({unit: unit for unit in TO_MS}),
    "rate": _number(*READABLE, "kHz"),
    "travel_unit": _one_of(
        {unit.lower(): unit for unit in (*TO_MM, "deg", "rad", "V", "counts", "%")}
    ),
    "ratio": _number(1e-6, 1e6, "mm for one unit of the reading"),
    "zero": _number(-1e6, 1e6, "units of the travel", "rest"),
    "sign": _one_of({"1": 1, "+1": 1, "-1": -1}),
    "contact_column": _column(1),
    "current_column": _column(1),
    "trigger_column": _column(0),
    "motor_column": _column(1),
}
