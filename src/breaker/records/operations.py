"""Read the table ``operations.csv``, which assigns files, or parts of files, to operations.

Light to import.
"""

import csv
import math
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from io import StringIO
from pathlib import Path
from typing import Any, NamedTuple

from breaker.model.parameters import MOTIONS
from breaker.records.dates import cell_date, dates_of, day_order, earlier
from breaker.records.files import MOST_COLUMNS, RejectedCurveError, printable, read_bytes
from breaker.records.settings import FORMAT, READABLE, TO_MM, TO_MS

MANIFEST = "operations.csv"  # name of the table, in the folder of the curve files
FILL_IN = "FILL IN"  # cell of a value that a file does not state; a table with it is rejected
LONGEST = 200  # most characters of a name or a text in a cell
SHOWN = 10  # most mistakes, or files, in one message

EVENTS: dict[str, tuple[str, ...]] = {
    "maintenance, overhaul, repair, adjusted, adjustment": ("all",),
    "greased, greasing, lubricated, lubrication": ("all",),
    "opening spring replaced, contact spring replaced, closing spring replaced": ("all",),
    "contacts replaced, interrupter replaced": ("all",),
    "remounted, remounting, transducer remounted, transducer replaced": ("transducer",),
    "inspected, inspection, cleaned": (),
}
"""Usual events, and what each renews: the entire drive, the reading of its transducer, nothing."""

_REQUIRED = ("file", "motion", "operation")


@dataclass(frozen=True)
class Operation:
    """One motion of one operation, and the place of its record.

    Attributes:
        number: Counter of the operation. Closing and opening with one number are one operation.
        file: Path of the file, from the folder of the table.
        channel: Column of the travel, in place of the one in ``endurance.format``.
        begin, end: Begin and end of the part with the motion, ms of the file's time.
        breaker: Name of the breaker. A table of several breakers is a fleet.
        phase: Phase or pole.
        type: Type of the breaker.
        date: Date and time as ISO 8601.
        temperature: Temperature of the drive, °C.
        voltage: Voltage of the control circuit, V or % of the rated voltage.
        event: Work since the operation before.
        settings: What the table states in place of keys of ``endurance.format``.
        transducer: Name of the transducer, with its mounting and ratio.
        line: Line of the file that is the record, if each line is a record.
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
    transducer: str = ""


_Row = tuple[int, str, Operation]  # line, motion and operation


def read_manifest(file: str | Path) -> list[tuple[str, Operation]]:
    """Return motion and operation of each row of a folder's table, also as spreadsheets write it.

    Raises:
        ValueError: If anything is wrong, with line, column, value and remedy for several rows.
    """
    file = Path(file)
    rows = _rows(file)
    order = day_order(dates_of(cells.get("date", "")) for _, cells in rows)
    nameless = _Cell("below the name of a column", "(?!)")
    kinds = READ | {"": nameless, "date": _Cell("", read=partial(cell_date, order=order))}
    manifest: list[_Row] = []
    wrong = []
    for line, cells in rows:
        try:
            manifest.append((line, *_operation(file.parent, cells, kinds)))
        except ValueError as error:
            wrong.append(f"line {line}, column {error}")
    if wrong := wrong or _contradictions(manifest):
        more = [f"and {len(wrong) - SHOWN} more"] if len(wrong) > SHOWN else []
        raise ValueError("\n  ".join([f"{printable(file)} is wrong:", *wrong[:SHOWN], *more]))
    return [(motion, operation) for _, motion, operation in manifest]


def _rows(file: Path) -> list[tuple[int, dict[str, str]]]:
    """Return the line of each row below the names of columns, and its cells by column."""
    try:
        text = read_bytes(file).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise RejectedCurveError(file, "is not UTF-8; save it as CSV UTF-8") from error
    delimiter = max(",;\t", key=re.match("[^\r\n]*", text)[0].count)
    below = StringIO(text, newline="")
    reader = csv.DictReader(below, delimiter=delimiter, restkey="", strict=True)
    rows_read, names = [], []
    try:
        names = reader.fieldnames = [name.strip().lower() for name in reader.fieldnames or ()]
        for row in reader:
            row[""] = "".join(row.get("") or "")
            cells = {name: (cell or "").strip() for name, cell in row.items()}
            if any(cells.values()):
                rows_read.append((reader.line_num, cells))
    except csv.Error as error:
        reason = f"is not a table: {error}; are quotation marks closed?"
        raise RejectedCurveError(file, reason, line=reader.line_num + 1) from error
    wrong = [name for name in names if name and (name not in READ or names.count(name) > 1)]
    if wrong or not rows_read or not {*_REQUIRED} <= {*names}:
        what = f"cannot have {', '.join(map(repr, wrong))}" if wrong else "is not complete"
        every = f"{', '.join(_REQUIRED)} and any of {', '.join(READ)}, each once"
        reason = f"{what}: name the columns {every}, with a row for each operation below"
        raise RejectedCurveError(file, reason, line=1)
    return rows_read


def _operation(
    folder: Path, cells: Mapping[str, str], kinds: "Mapping[str, _Cell]"
) -> tuple[str, Operation]:
    """Return the motion and the operation of a row; raise ValueError for its first mistake."""
    read: dict[str, Any] = {}
    for name, cell in cells.items():
        if cell or name in _REQUIRED:
            try:
                read[name] = kinds[name].value(cell)
            except ValueError as error:
                raise ValueError(f"{name or 'without a name'}: {error}") from None
    file, motion, number = (read.pop(name) for name in _REQUIRED)
    begin, end = read.pop("from", math.nan), read.pop("to", math.nan)
    if begin >= end:
        raise ValueError(f"to: {end:.9g} is not after from, {begin:.9g}; correct one")
    settings = {name: read.pop(name) for name in FORMAT if name in read}
    return motion, Operation(number, folder / file, begin=begin, end=end, settings=settings, **read)


def _contradictions(rows: Collection[_Row]) -> list[str]:
    """Return messages where rows repeat an operation, or dates decrease while numbers increase."""
    last: dict[tuple, tuple[int, int, str]] = {}
    wrong = []
    for line, motion, operation in sorted(rows, key=lambda row: row[2].number):
        name = f"{motion} {operation.number}"
        pole = operation.breaker, operation.phase, motion
        above, number, date = last.get(pole, (0, -1, ""))
        if number == operation.number:
            what = f"{name} is in line {above} already; give it its own number, breaker or phase"
            wrong.append(f"line {line}, column operation: {what}")
        elif earlier(date, operation.date):
            what = f"{operation.date} of {name} is earlier than {date} of {motion} {number}"
            wrong.append(f"line {line}, column date: {what}; correct the number or the date")
        last[pole] = line, operation.number, operation.date or date
    return wrong


# ---- cells ---------------------------------------------------------------------------------------


def event_words(event: str) -> tuple[str, ...]:
    """Return the events in a cell, which commas, semicolons or plus signs separate.

    >>> event_words("Greased; spring-replaced")
    ('greased', 'spring replaced')
    """
    words = (" ".join(re.split(r"[\s_-]+", part.strip())) for part in re.split("[,;+]", event))
    return tuple(dict.fromkeys(word.lower() for word in words if word))


def renewed_by(more: Mapping[str, Sequence[str]]) -> dict[str, Sequence[str]]:
    """Return what each event renews, by the words of ``event_words``; ``more`` is the section
    ``endurance.events``.
    """
    definitions = {**EVENTS, **more}.items()
    return {word: parts for events, parts in definitions for word in event_words(events)}


_ANY = f".{{1,{LONGEST}}}"
_COUNTER = "[0-9]{1,7}"
_INSIDE = r"(?!/|[A-Z]:|(?:.*/)?\.\.(?:/|$))[^\\]{1,200}"  # nothing outside the folder
# A comma may be the decimal sign, but 1,000 is ambiguous and so not a number.
_NUMBER = r"(?![+-]?[0-9]{1,3},[0-9]{3}$)[+-]?([0-9]+[.,]?[0-9]*|[.,][0-9]+)(e[+-]?[0-9]{1,3})?"


class _Cell(NamedTuple):
    """Kind of cell: its description, pattern and reader, and the range of a number."""

    what: str
    pattern: str = _ANY
    read: Callable[[str], Any] = str
    least: float = -math.inf
    most: float = math.inf

    def value(self, cell: str) -> Any:
        """Return the value of a cell; raise ValueError if the cell is not of this kind."""
        if cell.upper() == FILL_IN:
            raise ValueError("is to be filled in: the file does not state it (`breaker inspect`)")
        if cell.isprintable() and re.fullmatch(self.pattern, cell, re.IGNORECASE):
            value = self.read(cell)
            if not isinstance(value, int | float) or self.least <= value <= self.most:
                return value
        raise ValueError(f"{cell[:40]!r} is not {self.what}; correct the cell")


def _float(cell: str) -> float | str:
    return "rest" if cell.lower() == "rest" else float(cell.replace(",", "."))


def _number(unit: str, least: float, most: float) -> _Cell:
    what = f"a number from {least:g} to {most:g} {unit}"
    return _Cell(what, _NUMBER, _float, least, most)


def _words(words: Mapping[str, Any]) -> _Cell:
    pattern = "|".join(map(re.escape, words))
    return _Cell(f"one of {' '.join(words)}", pattern, lambda cell: words[cell.lower()])


def _column(cell: str) -> str | int | None:
    return None if cell.lower() == "none" else int(cell) if cell.isdecimal() else cell


_TEXT = _Cell(f"a text of at most {LONGEST} signs that can be printed")
_MS = _number("ms", -1e7, 1e7)
_COLUMN = _Cell("the name or the number of a column, or none", _ANY, _column, 1, MOST_COLUMNS)
_UNITS = (*TO_MM, "deg", "rad", "V", "counts", "%")

READ: dict[str, _Cell] = {
    "file": _Cell("in the folder of the table; write its path from there, with /", _INSIDE),
    "motion": _words({motion: motion for motion in MOTIONS}),
    "operation": _Cell("a counter of at most 7 digits", _COUNTER, int),
    **dict.fromkeys(
        ("channel", "breaker", "phase", "type", "event", "transducer", "encoding"), _TEXT
    ),
    "line": _Cell("the number of a line, from 1", _COUNTER, int, 1),
    "date": _Cell("", read=cell_date),
    "temperature": _number("°C", -60.0, 120.0),
    "voltage": _number("V, or % of the rated voltage", 1.0, 1000.0),
    "from": _MS,
    "to": _MS,
    "delimiter": _words({",": ",", ";": ";", "|": "|", "tab": "\t", "blank": " "}),
    "decimal": _words({".": ".", ",": ","}),
    "time_unit": _words({unit: unit for unit in TO_MS}),
    "rate": _number("kHz", *READABLE),
    "travel_unit": _words({unit.lower(): unit for unit in _UNITS}),
    "ratio": _number("mm for one unit of the reading", 1e-6, 1e6),
    "zero": _Cell("rest, or a number", f"rest|{_NUMBER}", _float),
    "sign": _words({"1": 1, "+1": 1, "-1": -1}),
    **dict.fromkeys(("time_column", "contact_column", "current_column"), _COLUMN),
    "trigger_column": _COLUMN._replace(least=0),
}
"""Columns that the table may have, with the kinds of their cells."""
