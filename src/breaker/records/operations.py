"""The table ``operations.csv``: which file, or which part of a file, is which operation.

Each column has its own reader of cells, which says what is wrong with a cell and how to mend it.
Light to import.
"""

import csv
import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from datetime import datetime
from io import StringIO
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

from breaker.common.numerals import in_digits
from breaker.common.safe_text import as_meant
from breaker.model.parameters import MOTIONS
from breaker.records.dates import earlier
from breaker.records.file_names import LARGEST_COUNTER
from breaker.records.files import RejectedCurveError, printable, read_bytes
from breaker.records.settings import FORMAT, TO_MM, TO_MS

MANIFEST = "operations.csv"
"""Name of the table, in the folder of the curve files."""

_REQUIRED = ("file", "motion", "operation")
FILL_IN = "FILL IN"
"""Cell of what a file does not tell, so that the table is refused until it is filled in."""

_SHOWN = 10  # mistakes in a message
# A number with a decimal comma: 21,5 but not 1,000, which may be a thousand.
_DECIMAL = re.compile("[+-]?(?![0-9]{1,3},[0-9]{3}$)[0-9]+,[0-9]+")

EVENTS: dict[str, tuple[str, ...]] = {
    "maintenance, overhaul, repair, adjusted, adjustment": ("all",),
    "greased, greasing, lubricated, lubrication": ("all",),
    "opening spring replaced, contact spring replaced, closing spring replaced": ("all",),
    "contacts replaced, interrupter replaced": ("all",),
    "remounted, remounting, transducer remounted, transducer replaced": ("transducer",),
    "inspected, inspection, cleaned": (),
}
"""Usual events, and what starts anew: the whole drive, what its transducer shows, or nothing."""

_LONGEST = 200  # signs of a text
_MOST_COLUMNS = 1000
_PLAIN = re.compile(r"[\w-][\w.-]*(?:/[\w-][\w.-]*)*")  # paths of which nothing is to be said
_ISO = re.compile(
    r"[0-9]{4}-[0-9]{2}-[0-9]{2}"
    r"(?:[T ][0-9]{2}:[0-9]{2}(?::[0-9]{2}(?:\.[0-9]{1,6})?)?(?:Z|[+-][0-9]{2}:[0-9]{2})?)?"
)
_POINTS = re.compile(r"([0-9]{2})\.([0-9]{2})\.([0-9]{4})((?: [0-9]{2}:[0-9]{2}(?::[0-9]{2})?)?)")


@dataclass(frozen=True)
class Operation:
    """One motion of one operation, and where its record is.

    Attributes:
        number: Counter of the operation.
        file: File of the record.
        channel: Column of the travel in the file; that of ``endurance.format`` if empty.
        line: Line of the file that holds this operation, where each line is a record; 0 for all of
            the file.
        begin, end: Part of the record in which the motion is, ms of the file's time; nan for its
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


def read_manifest(
    file: str | Path,
    events: Collection[str] | None = None,
    breakers: Collection[str] | None = None,
) -> list[tuple[str, Operation]]:
    """Read the table of a folder.

    The text is UTF-8, with or without a byte order mark; commas or semicolons separate its cells.
    Where semicolons do, a comma may be the decimal sign.

    Args:
        file: The table.
        events: Events that it may name beside the usual ones; None for any text.
        breakers: Those whose rows are read; None for all.

    Returns:
        Motion and operation of each row. That the files are there is not looked at.

    Raises:
        ValueError: If anything is wrong; the message has one line for each of the first mistakes,
            with line, column and remedy.
    """
    file = Path(file)
    names, rows = _rows(file)
    found: list[tuple[str, Operation]] = []
    wrong = list(_wrong_names(names))
    if not wrong and not rows:
        wrong.append("line 1: no operation follows the names of the columns; add one row for each")
    if breakers is not None and "breaker" in names:
        place = names.index("breaker")
        rows = [row for row in rows if len(row[1]) <= place or row[1][place] in breakers]
    lines: dict[tuple, int] = {}
    readers = READ if events is None else READ | {"event": event_reader(events)}
    for line, cells in rows if not wrong else ():
        row, mistakes = _row(names, cells, file.parent, readers)
        if row:
            motion, operation = row
            key = (operation.breaker, operation.phase, motion, operation.number)
            if (first := lines.setdefault(key, line)) != line:
                mistakes.append(
                    f"column operation: {motion} {operation.number} is in line {first} already; "
                    "give each its own number, or breaker or phase"
                )
            found.append(row)
        wrong += [f"line {line}, {mistake}" for mistake in mistakes]
    wrong = wrong or _out_of_order(found, lines)
    if wrong:
        more = len(wrong) - _SHOWN
        rest = [f"and {more} more"] if more > 0 else []
        raise ValueError("\n  ".join([f"{printable(file)} is wrong:", *wrong[:_SHOWN], *rest]))
    return found


def _out_of_order(rows: Collection[tuple[str, Operation]], lines: Mapping) -> list[str]:
    """Say where numbers of operations rise while their dates fall."""
    last: dict[tuple, tuple[str, int]] = {}
    wrong = []
    for motion, each in sorted(rows, key=lambda row: row[1].number):
        if not each.date:
            continue
        of = each.breaker, each.phase, motion
        date, number = last.get(of, ("", 0))
        if earlier(date, each.date):
            wrong.append(
                f"line {lines[(*of, each.number)]}, column date: {each.date}, of {motion} "
                f"{each.number}, is earlier than {date}, of {number}: mend the number or the "
                "date, or leave the date empty where a clock was wrong"
            )
        last[of] = each.date, each.number
    return wrong


def breakers_in(file: str | Path) -> list[str]:
    """Return the names of the breakers in a table, in the order of their first rows.

    Raises:
        RejectedCurveError: If it is no table.
    """
    names, rows = _rows(Path(file))
    place = names.index("breaker") if "breaker" in names else len(names)
    return list(dict.fromkeys(name for _, cells in rows for name in cells[place : place + 1]))


def _rows(file: Path) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Names of the columns, and line and cells of each row that is not empty."""
    try:
        text = read_bytes(file).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        reason = "is not UTF-8; save the table as CSV UTF-8"
        raise RejectedCurveError(file, reason, line=line) from error
    head = text.split("\n", 1)[0]
    delimiter = ";" if ";" in head else ","
    # Lines as they end in the file: a cell in quotation marks may have several.
    reader = csv.reader(StringIO(text, newline=""), delimiter=delimiter, strict=True)
    rows, line = [], 1
    try:
        for cells in reader:
            cells = [as_meant(cell.strip()) for cell in cells]
            if any(cells):
                rows.append((line, cells))
            line = reader.line_num + 1
    except csv.Error as error:
        reason = f"is no table: {error}; are quotation marks closed?"
        raise RejectedCurveError(file, reason, line=line) from error
    if not rows:
        raise RejectedCurveError(file, f"is empty; its first line names {', '.join(_REQUIRED)}")
    (_, names), *rows = rows
    if delimiter == ";":
        rows = [
            (at, [each.replace(",", ".") if _DECIMAL.fullmatch(each) else each for each in cells])
            for at, cells in rows
        ]
    return names, rows


def _wrong_names(names: list[str]) -> Iterator[str]:
    """Say what is wrong with the names of the columns."""
    for place, name in enumerate(names, start=1):
        if name not in READ:
            known = ", ".join(READ)
            yield f"line 1, column {place}: {name!r} is none of {known}; rename it, or leave it out"
        elif name in names[: place - 1]:
            yield f"line 1, column {place}: {name} is there twice; leave one of them out"
    if lacking := [name for name in _REQUIRED if name not in names]:
        yield (
            f"line 1: there is no column {' nor '.join(lacking)}; the first line must name the "
            "columns, with commas or semicolons between"
        )


def _row(
    names: list[str], cells: list[str], folder: Path, readers: Mapping[str, Callable]
) -> tuple[tuple[str, Operation] | None, list[str]]:
    """Motion and operation of a row, and what is wrong with it, by column."""
    if len(cells) != len(names):
        return None, [
            f"column {min(len(cells), len(names)) + 1}: the line has {len(cells)} cells, but "
            f"{len(names)} columns have names; set a cell with a comma in quotation marks"
        ]
    read, mistakes = {}, []
    for name, cell in zip(names, cells, strict=True):
        if not cell and name not in _REQUIRED:
            continue
        try:
            if cell.upper() == FILL_IN:
                raise ValueError(
                    f"is to be filled in for {cells[names.index('file')]}, which does not state it "
                    "for sure: `breaker inspect` says why; see the analyser's settings"
                )
            read[name] = readers[name](cell)
        except ValueError as error:
            mistakes.append(f"column {name}: {error}")
    begin, end = read.pop("from", math.nan), read.pop("to", math.nan)
    if begin >= end:
        mistakes.append(f"column to: {in_digits(end, 9)} is not after from, {in_digits(begin, 9)}")
    if mistakes:
        return None, mistakes
    file, motion, number = (read.pop(name) for name in _REQUIRED)
    read["settings"] = {name: read.pop(name) for name in FORMAT if name in read}
    return (motion, Operation(number, folder / file, begin=begin, end=end, **read)), []


def event_words(event: str) -> tuple[str, ...]:
    """Return the events in a cell, which commas, semicolons or plus signs separate.

    >>> event_words("Greased; spring-replaced")
    ('greased', 'spring replaced')
    """
    found = (" ".join(re.split(r"[\s_-]+", each.strip())) for each in re.split("[,;+]", event))
    return tuple(dict.fromkeys(each.lower() for each in found if each))


def event_reader(known: Collection[str]) -> Callable[[str], str]:
    """A reader of cells that name usual events, or others that are known."""
    known = sorted({word for each in (*EVENTS, *known) for word in event_words(each)})

    def read(cell: str) -> str:
        for word in event_words(_text(cell)):
            if word not in known:
                raise ValueError(
                    f"{word!r} is no event that is known: {', '.join(known)}; write one of these, "
                    "several with commas between, or say in endurance.events what it starts anew"
                )
        return cell

    return read


def _file(cell: str) -> str:
    """A path in the folder, with / between its parts."""
    if len(cell) <= _LONGEST and _PLAIN.fullmatch(cell):
        return cell
    _text(cell)
    if not cell:
        raise ValueError("is empty; name the file of the record")
    parts = PurePosixPath(cell).parts
    if ".." in parts or PurePosixPath(cell).is_absolute() or PureWindowsPath(cell).drive:
        raise ValueError(
            f"{cell!r} is not in the folder of the table; put it there, and name it from there"
        )
    if "\\" in cell:
        raise ValueError(f"{cell!r} has a \\; write / between folder and file")
    return cell


def _motion(cell: str) -> str:
    if cell.lower() not in MOTIONS:
        raise ValueError(f"{cell!r} is neither {' nor '.join(MOTIONS)}")
    return cell.lower()


def _one_of(values: Mapping[str, str | int]) -> Callable[[str], str | int]:
    """A reader of a few words, and what each stands for."""

    def read(cell: str) -> str | int:
        if cell not in values:
            raise ValueError(f"{cell!r} is none of {', '.join(values)}")
        return values[cell]

    return read


def _column(least: int) -> Callable[[str], str | int | None]:
    """A reader of the name or number of a column; none is that there is no such column."""

    def read(cell: str) -> str | int | None:
        if cell.lower() == "none":
            return None
        if not re.fullmatch("[0-9]+", cell):
            return _text(cell)
        if len(cell) > 20 or not least <= int(cell) <= _MOST_COLUMNS:
            raise ValueError(f"{cell} is no number of a column, {least} to {_MOST_COLUMNS}")
        return int(cell)

    return read


def _counter(cell: str) -> int:
    if not re.fullmatch("[0-9]+", cell):
        raise ValueError(f"{cell!r} is no counter; write it with the digits 0 to 9 only")
    if len(cell) > 20 or int(cell) > LARGEST_COUNTER:
        raise ValueError(
            f"{cell} is no counter of operations, which is at most {LARGEST_COUNTER}; count "
            "operations from 1, and write dates into the column date"
        )
    return int(cell)


def _number(least: float, most: float, unit: str) -> Callable[[str], float]:
    """A reader of numbers of a range."""

    def read(cell: str) -> float:
        if not re.fullmatch(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]{1,3})?", cell):
            raise ValueError(f"{cell!r} is no number; write it as 21.5 or -3")
        value = float(cell)
        if not least <= value <= most:
            raise ValueError(
                f"{cell} is not between {in_digits(least, 9)} and {in_digits(most, 9)} {unit}"
            )
        return value

    return read


def _zero(cell: str) -> float | str:
    return "rest" if cell.lower() == "rest" else _number(-1e6, 1e6, "units of the travel")(cell)


def _text(cell: str) -> str:
    if not cell.isprintable():
        raise ValueError(f"{cell!r} has signs that cannot be printed; remove them")
    if len(cell) > _LONGEST:
        raise ValueError(f"has {len(cell)} signs; use at most {_LONGEST}")
    return cell


def iso_date(text: str) -> str:
    """Return a date, or date and time, as ISO 8601.

    Taken are ISO 8601 itself, with a blank or T before the time, and day.month.year.

    >>> iso_date("20.11.2024 15:13")
    '2024-11-20T15:13:00'

    Raises:
        ValueError: If it is none of these, or there is no such day or time.
    """
    points = _POINTS.fullmatch(text)
    iso = f"{points[3]}-{points[2]}-{points[1]}{points[4]}" if points else text
    if not _ISO.fullmatch(iso):
        raise ValueError(f"{text!r} is no date; write it as 2024-11-20 or 2024-11-20T15:13:07")
    try:
        when = datetime.fromisoformat(iso)
    except ValueError as error:
        raise ValueError(f"{text!r} is no date: {error}") from error
    return when.isoformat() if len(iso) > len("2024-11-20") else iso


def _line(cell: str) -> int:
    if not re.fullmatch("[1-9][0-9]{0,8}", cell):
        raise ValueError(f"{cell!r} is not a line of a file; count lines from 1")
    return int(cell)


_TIME = _number(-1e7, 1e7, "ms")
# Columns that the table may have, in this order, and what reads their cells.
READ: dict[str, Callable] = {
    "file": _file,
    "motion": _motion,
    "operation": _counter,
    "channel": _text,
    "line": _line,
    "breaker": _text,
    "phase": _text,
    "type": _text,
    "date": iso_date,
    "temperature": _number(-60.0, 120.0, "°C"),
    "voltage": _number(1.0, 1000.0, "V or % of the rated one"),
    "event": _text,
    "from": _TIME,
    "to": _TIME,
    # Of endurance.format, for this record alone.
    "encoding": _text,
    "delimiter": _one_of({sign: sign for sign in ",;|"} | {"tab": "\t", "blank": " "}),
    "decimal": _one_of({sign: sign for sign in ".,"}),
    "time_column": _column(1),
    "time_unit": _one_of({unit: unit for unit in TO_MS}),
    "rate": _number(0.5, 1000.0, "kHz"),
    "travel_unit": _one_of({unit: unit for unit in (*TO_MM, "deg", "rad", "V", "counts", "%")}),
    "ratio": _number(1e-6, 1e6, "mm for one unit of the reading"),
    "zero": _zero,
    "sign": _one_of({"1": 1, "+1": 1, "-1": -1}),
    "contact_column": _column(1),
    "current_column": _column(1),
    "trigger_column": _column(0),
    "motor_column": _column(1),
}
