"""What files state of the records of a visit: dates, and of which breaker they are."""

import re
from collections.abc import Iterable
from pathlib import Path

from breaker.reading.files.date_text import dates_of
from breaker.reading.files.preamble import Preamble
from breaker.reading.files.word_meanings import channel_of, phase_in


def date_of(record) -> str:
    """Return the date of a record as ISO 8601: of its table, or what its file or name states;
    empty where none does, or day and month may be either.
    """
    named = {*_dates_in_name(record.operation.file)}
    return record.operation.date or record.stated.date or (named.pop() if len(named) == 1 else "")


def date_in(file: str | Path, stated: Preamble) -> str:
    """Return the date that a file states, or its name, as ISO 8601; of two readings, as of day and
    month, the first.
    """
    return next(iter([*stated.dates, *_dates_in_name(file)]), "")


def _dates_in_name(file: str | Path) -> Iterable[str]:
    return dates_of(Path(file).name).values()


def dates_in_words(records: Iterable) -> str:
    """Return the days of a visit, the first and the last; of day and month in either order both
    readings, where no other record is of either; empty where nothing states any.
    """
    days: set[str] = set()
    either: list[dict[str, None]] = []
    for each in records:
        if date := date_of(each):
            days.add(date[:10])
        else:
            either.append(dict.fromkeys(day[:10] for day in each.stated.dates))
    ends = dict.fromkeys([*sorted(days)[:1], *sorted(days)[-1:]])
    others = {" or ".join(each) for each in either if not days & each.keys()}
    return ", ".join(filter(None, [" to ".join(ends), *sorted(others)]))


def stated_of(records: Iterable) -> dict[str, float | str]:
    """Return what files state of a visit by what it is called: the ratio of the linkage, serial
    number, bay, phase and channel; what they do not, or differently, is left out.
    """
    found: dict[str, set] = {}
    for each in records:
        said = {"linkage ratio": each.stated.ratio, "serial number": each.stated.serial}
        said |= {"bay": each.stated.bay, "phase": _phase(each), "channel": _channel(each)}
        for name, value in said.items():
            if value and value == value:
                found.setdefault(name, set()).add(value)
    return {name: values.pop() for name, values in found.items() if len(values) == 1}


def _channel(record) -> str:
    """Number of a record's channel among those of the same name; empty where it has none."""
    column = record.operation.channel or (
        record.raw.settings["travel_column"] if record.raw else ""
    )
    number = re.fullmatch(r"(\D*[^\W\d_])[\W_]*(\d)\W*", str(column))
    return f"{number[1].casefold()} {number[2]}" if number else ""


def _phase(record) -> str:
    """Phase of a record's channel, by its name or its number."""
    phases, operation = record.stated.phases, record.operation
    column = operation.channel or str(record.raw.settings["travel_column"] if record.raw else "")
    return phase_in(column) or phases.get(channel_of(column), phases.get(0, ""))
