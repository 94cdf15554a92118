"""Dates and times in texts and in names of files, also where day and month may be either."""

import re
from contextlib import suppress
from datetime import date, datetime
from typing import NamedTuple

from breaker.records.lexicon import WORDS

_DIGITS = re.compile(r"(?<!\d)(\d{1,2})\s?([-/.])\s?(\d{1,2})\s?\2\s?(\d{4}|\d{2})(?!\d)")
_CLOCK = re.compile(r"(?<![\d:.])(\d{1,2})[:h](\d{2})(?::(\d{2}))?(?:[.,]\d+)?\s*([ap]\.?m)?", re.I)

_MONTHS_OF = {
    name: month
    for names in WORDS["months"].values()
    for month, name in enumerate(names.split(), start=1)
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
    r"(?P<hour>[0-9]{2})(?P<between>[-_.:h ]?)(?P<minute>[0-9]{2})"
    r"(?:[-_.:m ]?(?P<second>[0-9]{2}))?s?"
)
_MOMENTS = [
    re.compile(rf"(?<![0-9]){date}(?:[T_ ,.-]{{0,3}}{_TIME})?(?![0-9])", re.IGNORECASE)
    for date in _DATES
] + [
    re.compile(rf"(?<![0-9]){date}(?![0-9])", re.IGNORECASE)  # what follows is no time
    for date in _DATES
]
# A day, or a month with its year: the name of the month is a word, as in 20-nov and March 5.
_WORD = rf"(?<![^\W\d_]){_NAME}(?:{WORDS['month_ends']})?(?![^\W\d_])"
_DAY = "(?:0?[1-9]|[12][0-9]|3[01])"
_PARTS = [
    re.compile(rf"(?<![0-9]){part}(?![0-9])", re.IGNORECASE)
    for part in (
        rf"{_DAY}[-_. ]*{_WORD}",
        rf"{_WORD}[-_. ]*{_DAY}",
        rf"{_YEAR}[-_.](?:0[1-9]|1[0-2])",
    )
]
_TIMES = [
    re.compile(r"(?<![0-9])(?P<hour>[0-9]{2})([-_.:])(?P<minute>[0-9]{2})\2(?P<second>[0-9]{2})"),
    re.compile(r"(?<![0-9])(?P<hour>[0-9]{1,2})h(?P<minute>[0-9]{2})(?:m(?P<second>[0-9]{2}))?"),
]


def dates_of(text: str) -> dict[bool, str]:
    """Return the date in a text as ISO 8601, by whether its day stands before its month: both where
    it may be either, the same twice where it is neither, and none where there is no date.

    >>> dates_of("14/03/2021"), dates_of("2/3/2021")[True], dates_of("2021-03-02")[False]
    ({True: '2021-03-14'}, '2021-03-02', '2021-03-02')
    """
    match = _DIGITS.search(text)
    if not match:
        said = next((m.when.date().isoformat() for m in moments(text) if m.when), None)
        return {} if said is None else {True: said, False: said}
    first, sign, second, year = match.groups()
    year = int(year) + 2000 * (len(year) == 2)
    found = {}
    # Between points the day comes first, by the standards of all who write them.
    for day_first in (True,) if sign == "." else (True, False):
        day, month = (first, second) if day_first else (second, first)
        with suppress(ValueError):
            found[day_first] = date(year, int(month), int(day)).isoformat()
    return found


def earlier(first: str, second: str) -> bool:
    """Say whether the second of two dates, as ISO 8601, is before the first; of one without a time
    the day alone counts, and of none nothing is known.
    """
    length = min(len(first), len(second))
    return bool(length) and second[:length] < first[:length]


def clock_of(text: str) -> str:
    """Return the time of the day in a text as ISO 8601, with a T before it; empty if none is there.

    >>> clock_of("2/3/2021 1:05 PM"), clock_of("400 ms")
    ('T13:05:00', '')
    """
    match = _CLOCK.search(text)
    if not match:
        return ""
    hour, minute, second = (int(part or 0) for part in match.groups()[:3])
    if half := (match[4] or "").lower():
        hour = hour % 12 + 12 * half.startswith("p")
    fine = hour < 24 and minute < 60 and second < 60
    return f"T{hour:02}:{minute:02}:{second:02}" if fine else ""


class Moment(NamedTuple):
    """A date or time in a text.

    Attributes:
        start, stop: Where it stands in the text.
        when: What it says; None for a time without a date, and for part of a date.
    """

    start: int
    stop: int
    when: datetime | None


def moments(text: str) -> list[Moment]:
    """Find what looks like a date or a time in the name of a file, in the order of the text.

    >>> [str(each.when) for each in moments("closing_20-11-2024_15-13-07")]
    ['2024-11-20 15:13:07']
    >>> moments("operation_0007_10kHz")
    []
    """
    found: list[Moment] = []
    if not re.search("[0-9]", text):
        return found
    for pattern in (*_MOMENTS, *_TIMES, *_PARTS):
        for match in pattern.finditer(text):
            moment = _moment(match)
            apart = all(match.end() <= each.start or each.stop <= match.start() for each in found)
            if moment and apart:
                found.append(moment)
    return sorted(found)


def _moment(match: re.Match) -> Moment | None:
    """What a match says, None if there is no such day or time."""
    parts = {name: text for name, text in match.groupdict().items() if text}
    clock = [int(parts.get(name, 0)) for name in ("hour", "minute", "second")]
    if "day" not in parts:
        fine = clock[0] < 24 and clock[1] < 60 and clock[2] < 60
        return Moment(match.start(), match.end(), None) if fine else None
    year = int(parts["year"]) if "year" in parts else 2000 + int(parts["short"])
    day = int(parts["day"])
    month = _MONTHS_OF[parts["name"].lower()] if "name" in parts else int(parts["month"])
    # The day first, as nearly everywhere; the month first where it can only be so.
    for one, other in ((month, day), (day, month)):
        with suppress(ValueError):
            return Moment(match.start(), match.end(), datetime(year, one, other, *clock))
    return None
