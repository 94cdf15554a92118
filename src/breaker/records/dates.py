"""Dates and times above the samples, in cells of a table and in names of files. Light to import.

A date such as 03/04/2026 has two readings. Other dates of its kind decide between them
(``day_order``): a column of a table, or the headers of a folder. Without such a date neither
reading is taken. A record has one date (``one_date``), the same in all commands.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from datetime import UTC, date, datetime
from pathlib import Path
from typing import NamedTuple

from breaker.records.lexicon import WORDS

_DIGITS = re.compile(r"(?<!\d)(\d{1,2})\s?([-/.])\s?(\d{1,2})\s?\2\s?(\d{4}|\d{2})(?!\d)")
_OFFSET = r"Z|[+-](?:0\d|1[0-4]):?(?:00|30|45)(?![:\d])"
_CLOCK = re.compile(
    r"(?<![\d:.])(\d{1,2})[:h](\d{2})(?::(\d{2})(?:[.,]\d+)?"
    rf"(?P<offset>{_OFFSET})?)?(?:[.,]\d+)?\s*(?P<half>[ap]\.?m)?",
    re.IGNORECASE,
)
_CELL = re.compile(  # of a table: four digits of the year, the day or the year first, then a time
    r"(?:[0-9]{1,2}([-/.])[0-9]{1,2}\1[0-9]{4}|[0-9]{4}([-/.])[0-9]{1,2}\2[0-9]{1,2})"
    r"(?:,? +[0-9]{1,2}:[0-9]{2}(?::[0-9]{2})?(?: ?[AaPp][Mm])?)?"
)
_ISO = re.compile(r"[0-9]{4}-[0-9]{2}-[0-9]{2}(?:[T ][0-9]{2}:[0-9]{2}[0-9:.Z+-]*)?")

_MONTHS_OF = {
    name: month
    for names in WORDS["months"].values()
    for month, name in enumerate(["", *names.split()])
    if name
}
_NAME = rf"(?P<name>{'|'.join(_MONTHS_OF)})"
_YEAR = r"(?P<year>(?:19|20)[0-9]{2})"
_GAP = r"(?P<gap>[-_. /]?)"
_DATES = [
    rf"{_YEAR}{_GAP}(?P<month>[0-9]{{2}})(?P=gap)(?P<day>[0-9]{{2}})",
    rf"(?P<day>[0-9]{{2}}){_GAP}(?P<month>[0-9]{{2}})(?P=gap){_YEAR}",
    rf"(?P<day>[0-9]{{1,2}})(?P<gap>[-_. /])(?P<month>[0-9]{{1,2}})(?P=gap){_YEAR}",
    rf"(?P<day>[0-9]{{1,2}})[-_. ]?{_NAME}[a-z]*[-_. ]?{_YEAR}",
    rf"{_YEAR}[-_. ]?{_NAME}[a-z]*[-_. ]?(?P<day>[0-9]{{1,2}})",
    # With two digits for the year only where no digit is near: 20-11-24, 24_11_20.
    r"(?P<day>[0-9]{2})(?P<gap>[-_. /])(?P<month>[0-9]{2})(?P=gap)(?P<short>[0-9]{2})",
    r"(?P<short>[0-9]{2})(?P<gap>[-_. /])(?P<month>[0-9]{2})(?P=gap)(?P<day>[0-9]{2})",
]
_TIME = (
    r"(?:[T_ ,.-]{0,3}(?P<hour>[0-9]{2})(?P<between>[-_.:h ]?)(?P<minute>[0-9]{2})"
    r"(?:[-_.:m ]?(?P<second>[0-9]{2}))?s?)?"
)
# A day, or a month with its year: the name of the month is a word, as in 20-nov and March 5.
_WORD = rf"(?<![^\W\d_]){_NAME}(?:{WORDS['month_ends']})?(?![^\W\d_])"
_DAY = "(?:0?[1-9]|[12][0-9]|3[01])"
_PATTERNS = [
    re.compile(rf"(?<![0-9]){pattern}(?![0-9])", re.IGNORECASE)
    for pattern in (
        *(each + _TIME for each in _DATES),
        *_DATES,  # what follows is not a time
        r"(?P<hour>[0-9]{2})([-_.:])(?P<minute>[0-9]{2})\2(?P<second>[0-9]{2})",
        r"(?P<hour>[0-9]{1,2})h(?P<minute>[0-9]{2})(?:m(?P<second>[0-9]{2}))?",
        rf"{_DAY}[-_. ]*{_WORD}",
        rf"{_WORD}[-_. ]*{_DAY}",
        rf"{_YEAR}[-_.](?:0[1-9]|1[0-2])",
    )
]


# ---- one text ------------------------------------------------------------------------------------


def dates_of(text: str) -> dict[bool, str]:
    """Return the readings of the date in a text as ISO 8601, by whether the day stands first.

    An unambiguous date, such as 2021-03-02 or 2.3.2021, has the same reading twice; a date in which
    only one order is possible has one.

    >>> dates_of("14/03/2021"), dates_of("2/3/2021")[True], dates_of("2021-03-02")[False]
    ({True: '2021-03-14'}, '2021-03-02', '2021-03-02')
    """
    match = _DIGITS.search(text)
    if not match:
        day = next((m.when.date().isoformat() for m in moments(text) if m.when), None)
        return {} if day is None else {True: day, False: day}
    first, sign, second, year = match.groups()
    year = int(year) + 2000 * (len(year) == 2)
    found = {}
    for day_first in (True, False):
        # Between points the day comes first, by the standards of all who write them.
        day, month = (first, second) if day_first or sign == "." else (second, first)
        with suppress(ValueError):
            found[day_first] = date(year, int(month), int(day)).isoformat()
    return found


def clock_of(text: str) -> str:
    """Return the time of day in a text as ISO 8601, with a T before it; empty if there is none.

    >>> clock_of("2/3/2021 1:05 PM"), clock_of("02:10:00+01:00"), clock_of("400 ms")
    ('T13:05:00', 'T02:10:00+01:00', '')
    """
    match = _CLOCK.search(text)
    if not match:
        return ""
    hour, minute, second = (int(part or 0) for part in match.groups()[:3])
    if half := (match["half"] or "").lower():
        hour = hour % 12 + 12 * half.startswith("p")
    offset = (match["offset"] or "").upper().replace("Z", "+00:00").replace(":", "")
    offset = f"{offset[:3]}:{offset[3:]}" if offset else ""
    fine = hour < 24 and minute < 60 and second < 60
    return f"T{hour:02}:{minute:02}:{second:02}{offset}" if fine else ""


def day_order(dates: Iterable[Mapping[bool, str]]) -> bool | None:
    """Return whether the day stands first in dates of one kind, by their readings.

    Dates in which only one order is possible decide, such as 14/03/2026.

    Returns:
        True or False; None where no date decides, or dates contradict each other.
    """
    orders = {order for readings in dates if len(readings) == 1 for order in readings}
    return orders.pop() if len(orders) == 1 else None


def in_order(readings: Mapping[bool, str], order: bool | None) -> tuple[str, ...]:
    """Return the readings of a date that remain in an order of day and month: one or two.

    >>> in_order(dates_of("03/04/2026"), True), in_order(dates_of("04/16/2026"), True)
    (('2026-04-03',), ('2026-04-16',))
    """
    kept = readings if order not in readings else {order: readings[order]}
    return tuple(dict.fromkeys(kept[first] for first in sorted(kept, reverse=True)))


def cell_date(cell: str, order: bool | None = None) -> str:
    """Return a cell's date, or date and time, as ISO 8601.

    Args:
        cell: ISO 8601, or day, month and year as spreadsheets write them.
        order: Whether the day stands first, as of ``day_order``.

    >>> cell_date("20.11.2024 15:13"), cell_date("3/14/2026 1:05 PM")
    ('2024-11-20T15:13:00', '2026-03-14T13:05:00')

    Raises:
        ValueError: If it is not a date, or has two readings.
    """
    form = "write it as 2024-11-20 or 2024-11-20T15:13:07"
    if _ISO.fullmatch(cell):
        try:
            when = datetime.fromisoformat(cell)
        except ValueError as error:
            raise ValueError(f"{cell!r} is not a date: {error}; {form}") from error
        return cell if len(cell) == len("2024-11-20") else when.isoformat()
    found = in_order(dates_of(cell), order) if _CELL.fullmatch(cell) else ()
    clock = clock_of(cell)
    if not found or (":" in cell and not clock):
        raise ValueError(f"{cell!r} is not a date; {form}")
    if len(found) > 1:
        raise ValueError(
            f"{cell!r} is {' or '.join(found)}, and no other date of the column decides; {form}"
        )
    return found[0] + clock


# ---- dates of records ----------------------------------------------------------------------------


def one_date(cell: str, stated: Sequence[str], file: str | Path) -> str:
    """Return the date of a record: the first of three that there is.

    Args:
        cell: Date in the table ``operations.csv``, "" for none.
        stated: Readings of the date above the samples.
        file: File of the record; its name counts last.

    Returns:
        ISO 8601; "" where nothing states a date, or the date has two readings.
    """
    found = [cell] if cell else stated or in_order(name_dates(Path(file).stem), None)
    return found[0] if len(found) == 1 else ""


def name_dates(stem: str) -> dict[bool, str]:
    """Return the readings of the date in a name of a file, with its time, as of ``dates_of``.

    Only one date with four digits of the year counts, not 20-11-24, nor 20112024.

    >>> name_dates("closing_20-11-2024_15-13-07")
    {True: '2024-11-20T15:13:07'}
    """
    found = [each for each in moments(stem) if each.when]
    if len(found) != 1:
        return {}
    text, when = stem[found[0].start : found[0].stop].replace("_", "-"), found[0].when
    year_last = not text.startswith(str(when.year))
    if str(when.year) not in text or (year_last and re.match("[0-9]{8}", text)):
        return {}
    clock = f"T{when.time()}" if when.hour or when.minute or when.second else ""
    digits = _DIGITS.match(text)
    days = dates_of(digits[0]) if digits else dict.fromkeys((True, False), str(when.date()))
    return {first: day + clock for first, day in days.items()}


def instant(when: str) -> datetime:
    """Return a date as an instant without offset: UTC where an offset is stated, else as it is."""
    found = datetime.fromisoformat(when)
    return found if found.tzinfo is None else found.astimezone(UTC).replace(tzinfo=None)


def earlier(first: str, second: str) -> bool:
    """Return whether the second of two dates, as ISO 8601, is certainly before the first.

    Instants are compared where both times have an offset, and clocks where neither has; else days.
    Nothing is certain about an empty date.

    >>> earlier("2024-10-27T02:50:00+02:00", "2024-10-27T02:10:00+01:00")
    False
    """
    if not (first and second):
        return False
    one, other = map(datetime.fromisoformat, (first, second))
    timed = "T" in first and "T" in second and (one.tzinfo is None) == (other.tzinfo is None)
    return other < one if timed else other.date() < one.date()


# ---- what looks like a date ----------------------------------------------------------------------


class Moment(NamedTuple):
    """A date or time in a text.

    Attributes:
        start, stop: Place in the text.
        when: Its date; None for a time without a date, and for part of a date.
    """

    start: int
    stop: int
    when: datetime | None


def moments(text: str) -> list[Moment]:
    """Find what looks like a date or a time in a text, in the order of the text.

    >>> [str(each.when) for each in moments("closing_20-11-2024_15-13-07")]
    ['2024-11-20 15:13:07']
    >>> moments("operation_0007_10kHz")
    []
    """
    found: list[Moment] = []
    if not re.search("[0-9]", text):
        return found
    for pattern in _PATTERNS:
        for match in pattern.finditer(text):
            moment = _moment(match)
            apart = all(match.end() <= each.start or each.stop <= match.start() for each in found)
            if moment and apart:
                found.append(moment)
    return sorted(found)


def _moment(match: re.Match) -> Moment | None:
    """Return what a match states; None if there is no such day or time."""
    parts = {name: text for name, text in match.groupdict().items() if text}
    clock = [int(parts.get(name, 0)) for name in ("hour", "minute", "second")]
    if "day" not in parts:
        fine = clock[0] < 24 and clock[1] < 60 and clock[2] < 60
        return Moment(match.start(), match.end(), None) if fine else None
    year = int(parts["year"]) if "year" in parts else 2000 + int(parts["short"])
    day = int(parts["day"])
    month = _MONTHS_OF[parts["name"].lower()] if "name" in parts else int(parts["month"])
    # The day first; the month first where only that is possible. ``dates_of`` has both readings.
    for one, other in ((month, day), (day, month)):
        with suppress(ValueError):
            return Moment(match.start(), match.end(), datetime(year, one, other, *clock))
    return None
