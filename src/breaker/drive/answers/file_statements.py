"""What files state of the records of a visit: dates, and of which breaker they are."""

import re
from collections.abc import Iterable

from breaker.reading.files.word_meanings import channel_of, phase_in


def date_of(record) -> str:
    """Return the date of a record as ISO 8601: of its table, or else as its file states it; empty
    where neither does, or day and month may be either.
    """
    return record.operation.date or record.stated.date


def dates_in_words(records: Iterable) -> str:
    """Return the days of a visit, the first and the last, both readings of a day and month that may
    be either; empty where nothing states any.
    """
    days = {
        date_of(each)[:10] or " or ".join(day[:10] for day in each.stated.dates) for each in records
    }
    days = sorted(filter(None, days))
    return " to ".join(dict.fromkeys([*days[:1], *days[-1:]]))


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
