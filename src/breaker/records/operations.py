"""The table ``operations.csv``: which file, or which part of a file, is which operation.

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

from breaker.common.safe_text import as_meant
from breaker.model.parameters import MOTIONS
from breaker.records.dates import cell_date, dates_of, day_order, earlier
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
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]{1,3})?")
_DECIMAL = re.compile("[+-]?(?![0-9]{1,3},[0-9]{3}$)[0-9]+,[0-9]+")  # not 1,000: a thousand?


@dataclass(frozen=True)
class Operation:
    """One motion of one operation, and where its record is.

    Attributes:
        number: Counter of the operation.
        channel: Column of the travel in the file; that of ``endurance.format`` if empty.
        begin, end: Part of the record with the motion, ms of the file's time; NaN for its ends.
        date: Date and time as ISO 8601.
        temperature, voltage: Of the drive, °C; of the control circuit, V or % of the rated one.
        event: What was done since the operation before: see ``event_words``.
        settings: What the table states in place of keys of ``endurance.format``.
        line: Line of the file that is the record; 0 if the entire file is.
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
    file: str | Path, events: Collection[str] | None = None
) -> list[tuple[str, Operation]]:
    """Read the table of a folder, also as spreadsheets write it.

    Args:
        file: The table.
        events: Events that it may name in addition to the usual ones; None for any text.

    Returns:
        Motion and operation of each row. Whether the files exist is not checked.

    Raises:
        ValueError: If anything is wrong; with line, column, value and remedy of each mistake.
    """
    file = Path(file)
    (head, names), *rows = _rows(file)
    wrong = [f"line {head}{text}" for text in _wrong_names(names, rows)]
    place = names.index("date") if "date" in names else len(names)
    dates = (dates_of("".join(cells[place : place + 1])) for _, cells in rows)
    readers = {name: reader for name, (reader, _) in READ.items()}
    readers["date"] = partial(cell_date, order=day_order(dates))
    if events is not None:
        readers["event"] = partial(_event, events)
    found: list[tuple[str, Operation]] = []
    lines: dict[tuple, int] = {}
    for line, cells in rows if not wrong else ():
        read, mistakes = _read_row(names, cells, readers)
        if not mistakes:
            motion, each = row = _operation(file.parent, read)
            found.append(row)
            if (of := (each.breaker, each.phase, motion, each.number)) in lines:
                what = f"{motion} {each.number} is in line {lines[of]} already"
                mistakes = [f"column operation: {what}; give it its own number, breaker or phase"]
            lines.setdefault(of, line)
        wrong += [f"line {line}, {mistake}" for mistake in mistakes]
    if wrong := wrong or _out_of_order(found, lines):
        more = [f"and {len(wrong) - SHOWN} more"] if len(wrong) > SHOWN else []
        raise ValueError("\n  ".join([f"{printable(file)} is wrong:", *wrong[:SHOWN], *more]))
    return found


def _rows(file: Path) -> list[tuple[int, list[str]]]:
    """Return line and cells of each row that has any; the first has the names of the columns."""
    content = read_bytes(file)
    encoding = "utf-16" if content[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        reason = "is not UTF-8; save the table as CSV UTF-8"
        raise RejectedCurveError(file, reason, line=line) from error
    named = re.search(r"^(?!sep=)[^\r\n]*[^\W_][^\r\n]*", text, re.MULTILINE)
    delimiter = max(",;\t", key=named[0].count) if named else ","
    # Lines as they end in the file: a cell in quotation marks may have several.
    reader = csv.reader(StringIO(text, newline=""), delimiter=delimiter, strict=True)
    rows, line = [], 1
    try:
        for cells in reader:
            cells = [as_meant(cell.strip()) for cell in cells]
            while cells and not cells[-1]:
                cells.pop()
            if cells and not cells[0].startswith("sep="):  # the delimiter, as spreadsheets name it
                rows.append((line, cells))
            line = reader.line_num + 1
    except csv.Error as error:
        reason = f"is not a table: {error}; are quotation marks closed?"
        raise RejectedCurveError(file, reason, line=line) from error
    if not rows:
        raise RejectedCurveError(file, f"is empty; its first line names {', '.join(_REQUIRED)}")
    rows[0][1][:] = [name.lower() if name.lower() in READ else name for name in rows[0][1]]
    return rows


def _wrong_names(names: Sequence[str], rows: Sequence) -> Iterator[str]:
    """Yield what is wrong with the names of the columns, or that no row follows."""
    for place, name in enumerate(names, start=1):
        if name and (name not in READ or name in names[: place - 1]):
            known = f"one of {', '.join(READ)}, each once"
            yield f", column {place}: {name!r} is not {known}; rename it, or leave it out"
    if lacking := [name for name in _REQUIRED if name not in names]:
        yield f": the first line must name the columns; add {' and '.join(lacking)}"
    elif not rows:
        yield ": no operation follows the names of the columns; add a row for each"


def _read_row(
    names: Sequence[str], cells: Sequence[str], readers: Mapping[str, Callable]
) -> tuple[dict[str, Any], list[str]]:
    """Return what the cells of a row state, and what is wrong with it, by column."""
    read: dict[str, Any] = {}
    mistakes = []
    for place, cell in enumerate(cells):
        name = names[place] if place < len(names) else ""
        if cell and not name:
            what = f"{cell!r} stands under no name; name the column, or put the cell in quotes"
            mistakes.append(f"column {place + 1}: {what}")
        elif cell:
            read[name] = None
            try:
                read[name] = readers[name](cell)
            except ValueError as error:
                what = str(error) or f"{cell[:40]!r} is not {READ[name][1]}; correct the cell"
                if cell.upper() == FILL_IN:
                    what = "is to be filled in: the file does not state it (`breaker inspect`)"
                mistakes.append(f"column {name}: {what}")
    mistakes += [f"column {name}: is empty; fill it in" for name in _REQUIRED if name not in read]
    if not mistakes and read.get("from", -math.inf) >= read.get("to", math.inf):
        mistakes = [f"column to: {read['to']:.9g} is not after from, {read['from']:.9g}"]
    return read, mistakes


def _operation(folder: Path, read: dict[str, Any]) -> tuple[str, Operation]:
    """Return the motion and the operation of a row in a folder, by its cells."""
    file, motion, number = (read.pop(name) for name in _REQUIRED)
    begin, end = read.pop("from", math.nan), read.pop("to", math.nan)
    read["settings"] = {name: read.pop(name) for name in FORMAT if name in read}
    return motion, Operation(number, folder / file, begin=begin, end=end, **read)


def _out_of_order(rows: Collection[tuple[str, Operation]], lines: Mapping) -> list[str]:
    """Return where numbers of operations rise while their dates fall."""
    last: dict[tuple, Operation] = {}
    wrong = []
    for motion, each in sorted(rows, key=lambda row: row[1].number):
        before = last.get(of := (each.breaker, each.phase, motion), each)
        if earlier(before.date, each.date):
            wrong.append(
                f"line {lines[(*of, each.number)]}, column date: {each.date} of {motion} "
                f"{each.number} is earlier than {before.date} of {before.number}; correct the "
                "number, or the date where a clock was wrong"
            )
        last |= {of: each} if each.date else {}
    return wrong


# ---- cells ---------------------------------------------------------------------------------------


def event_words(event: str) -> tuple[str, ...]:
    """Return the events in a cell, which commas, semicolons or plus signs separate.

    >>> event_words("Greased; spring-replaced")
    ('greased', 'spring replaced')
    """
    words = (" ".join(re.split(r"[\s_-]+", part.strip())) for part in re.split("[,;+]", event))
    return tuple(dict.fromkeys(word.lower() for word in words if word))


def _event(more: Collection[str], cell: str) -> str:
    """Read a cell that names usual events, or more that are known."""
    known = {word for events in (*EVENTS, *more) for word in event_words(events)}
    if unknown := [word for word in event_words(_text(cell)) if word not in known]:
        raise ValueError(
            f"{unknown[0]!r} is not a known event ({', '.join(sorted(known))}); write some of "
            "these with commas between, or add it to endurance.events"
        )
    return cell


def _require(fine: object) -> None:
    if not fine:
        raise ValueError  # READ states what is needed


def _text(cell: str) -> str:
    _require(cell.isprintable() and len(cell) <= LONGEST and cell.upper() != FILL_IN)
    return cell


def _file(cell: str) -> str:
    path = PurePosixPath(_text(cell))
    _require(not (path.is_absolute() or PureWindowsPath(cell).drive or "\\" in cell))
    _require(".." not in path.parts)
    return cell


def _words(words: Mapping[str, Any]) -> tuple[Callable[[str], Any], str]:
    """Return a reader of a few words, as what each stands for, and what they are."""

    def read(cell: str) -> Any:
        _require(cell.lower() in words)
        return words[cell.lower()]

    return read, f"one of {' '.join(words)}"


def _number(least: float, most: float, cell: str) -> float:
    """Read a number in a range; a comma may be the decimal sign."""
    text = cell.replace(",", ".") if _DECIMAL.fullmatch(cell) else cell
    _require(_NUMBER.fullmatch(text) and least <= float(text) <= most)
    return float(text)


def _zero(cell: str) -> float | str:
    return "rest" if cell.lower() == "rest" else _number(-1e6, 1e6, cell)


def _whole(least: int, most: int, cell: str) -> int:
    _require(re.fullmatch("[0-9]{1,20}", cell) and least <= int(cell) <= most)
    return int(cell)


def _column(least: int, cell: str) -> str | int | None:
    if cell.lower() == "none":
        return None
    return _whole(least, MOST_COLUMNS, cell) if cell.isdecimal() else _text(cell)


_TEXT = (_text, f"a text of at most {LONGEST} signs that can be printed")
_COLUMN = (partial(_column, 1), "the name of a column, its number from 1, or none")
_UNITS = (*TO_MM, "deg", "rad", "V", "counts", "%")

# Columns that the table may have: the reader of a cell, and what a cell must be.
READ: dict[str, tuple[Callable[[str], Any], str]] = {
    "file": (_file, "in the folder of the table; write its path from there, with /"),
    "motion": _words({motion: motion for motion in MOTIONS}),
    "operation": (partial(_whole, 0, 9_999_999), "a counter of at most 7 digits"),
    **dict.fromkeys(("channel", "breaker", "phase", "type", "event"), _TEXT),
    "line": (partial(_whole, 1, 9_999_999), "the number of a line, from 1"),
    "date": (cell_date, ""),
    "temperature": (partial(_number, -60.0, 120.0), "a number of °C from -60 to 120"),
    "voltage": (partial(_number, 1.0, 1000.0), "a number from 1 to 1000, V or % of the rated one"),
    **dict.fromkeys(("from", "to"), (partial(_number, -1e7, 1e7), "a number of ms")),
    # Of endurance.format, for this record alone.
    "encoding": _TEXT,
    "delimiter": _words({",": ",", ";": ";", "|": "|", "tab": "\t", "blank": " "}),
    "decimal": _words({".": ".", ",": ","}),
    "time_unit": _words({unit: unit for unit in TO_MS}),
    "rate": (partial(_number, *READABLE), f"a number of kHz from {READABLE[0]} to {READABLE[1]}"),
    "travel_unit": _words({unit.lower(): unit for unit in _UNITS}),
    "ratio": (partial(_number, 1e-6, 1e6), "a number of mm for one unit of the reading"),
    "zero": (_zero, "a number in the unit of the travel, or rest"),
    "sign": _words({"1": 1, "+1": 1, "-1": -1}),
    **dict.fromkeys(("time_column", "contact_column", "current_column", "motor_column"), _COLUMN),
    "trigger_column": (partial(_column, 0), "the name of a column, its number, 0 or none"),
}
