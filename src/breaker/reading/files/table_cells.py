"""What may be in a cell of the table ``operations.csv``, by column, and what it means.

Light to import.
"""

import re
from collections.abc import Callable, Collection, Mapping
from datetime import datetime
from pathlib import PurePosixPath, PureWindowsPath

from breaker.common.numerals import in_digits
from breaker.quantities.parameters import MOTIONS
from breaker.reading.files.file_names import LARGEST_COUNTER
from breaker.reading.files.format_settings import TO_MM, TO_MS

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


def _stroke(cell: str) -> list[float]:
    """The least and the largest stroke, mm."""
    ends = re.split(r"\s+to\s+|\s*-\s*|\s*;\s*|\s*,\s+|\s+", cell.strip("[]() "))
    if len(ends) != 2:
        raise ValueError(f"{cell!r} is no range; write the least and the largest, as 160 to 197")
    least, most = (_number(0.001, 1000.0, "mm")(end) for end in ends)
    if not least < most:
        raise ValueError(f"{cell!r} does not rise; write the least and the largest, as 160 to 197")
    return [least, most]


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


_TIME = _number(-1e7, 1e7, "ms")
# Columns that the table may have, in this order, and what reads their cells.
READ: dict[str, Callable] = {
    "file": _file,
    "motion": _motion,
    "operation": _counter,
    "channel": _text,
    "breaker": _text,
    "phase": _text,
    "type": _text,
    "date": iso_date,
    "temperature": _number(-60.0, 120.0, "°C"),
    "voltage": _number(1.0, 1000.0, "V or % of the rated one"),
    "event": _text,
    "from": _TIME,
    "to": _TIME,
    "touch_time": _TIME,
    "part_time": _TIME,
    "trigger": _TIME,
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
    "stroke": _stroke,
    "contact_column": _column(1),
    "timing_sd": _number(0.01, 10.0, "ms"),
    "trigger_column": _column(0),
    "motor_column": _column(1),
}
