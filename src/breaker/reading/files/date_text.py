"""Dates and times that a text states, with both readings where day and month may be either."""

import re
from contextlib import suppress
from datetime import date

from breaker.reading.files.file_names import moments

_DIGITS = re.compile(r"(?<!\d)(\d{1,2})\s?([-/.])\s?(\d{1,2})\s?\2\s?(\d{4}|\d{2})(?!\d)")
_CLOCK = re.compile(r"(?<![\d:.])(\d{1,2})[:h](\d{2})(?::(\d{2}))?(?:[.,]\d+)?\s*([ap]\.?m)?", re.I)


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
