"""Dates and times in the names of files, and in the cells of a table. Light to import."""

import re
from datetime import datetime
from typing import NamedTuple

__all__ = ["Moment", "iso_date", "moments"]

_MONTHS = ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"]
_MONTHS_OF = {name: i for i, name in enumerate(_MONTHS, start=1)}
_MONTHS_OF |= {"mär": 3, "mai": 5, "okt": 10, "dez": 12}  # German, and French where it differs
_MONTHS_OF |= {"fév": 2, "avr": 4, "juin": 6, "juil": 7, "aoû": 8, "déc": 12}
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
_ENDS = "uary?|vier|ruary?|rier|ch|z|s|il|[eiy]|ust|t|let|(?:t?em|o)(?:ber|bre)"
_WORD = rf"(?<![^\W\d_]){_NAME}(?:{_ENDS})?(?![^\W\d_])"
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


class Moment(NamedTuple):
    """A date or time in a text.

    Attributes:
        start, stop: Where it stands in the text.
        when: What it says; None for a time without a date, and for part of a date.
        timed: Whether it says the time of the day.
    """

    start: int
    stop: int
    when: datetime | None
    timed: bool


def moments(text: str) -> list[Moment]:
    """Find what looks like a date or a time in the name of a file, in the order of the text.

    >>> [str(each.when) for each in moments("closing_20-11-2024_15-13-07")]
    ['2024-11-20 15:13:07']
    >>> moments("operation_0007_10kHz")
    []
    """
    found: list[Moment] = []
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
    timed = "hour" in parts
    if "day" not in parts:
        fine = clock[0] < 24 and clock[1] < 60 and clock[2] < 60
        return Moment(match.start(), match.end(), None, timed) if fine else None
    year = int(parts["year"]) if "year" in parts else 2000 + int(parts["short"])
    day = int(parts["day"])
    month = _MONTHS_OF[parts["name"].lower()] if "name" in parts else int(parts["month"])
    # The day first, as nearly everywhere; the month first where it can only be so.
    for one, other in ((month, day), (day, month)):
        try:
            return Moment(match.start(), match.end(), datetime(year, one, other, *clock), timed)
        except ValueError:
            continue
    return None


_ISO = re.compile(
    r"[0-9]{4}-[0-9]{2}-[0-9]{2}"
    r"(?:[T ][0-9]{2}:[0-9]{2}(?::[0-9]{2}(?:\.[0-9]{1,6})?)?(?:Z|[+-][0-9]{2}:[0-9]{2})?)?"
)
_POINTS = re.compile(r"([0-9]{2})\.([0-9]{2})\.([0-9]{4})((?: [0-9]{2}:[0-9]{2}(?::[0-9]{2})?)?)")


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
