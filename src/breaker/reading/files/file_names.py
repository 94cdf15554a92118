"""Number and dates of an operation in the name of its file. Light to import.

A number is one where the names leave no doubt. Names of one kind differ in their digits only. The
counter of a kind is its only number, or the only one that varies. So a name that is added can make
a number vary that did not, and with it the names ambiguous, which is an error; but it never makes
another number the counter.
"""

import re
from collections.abc import Sequence
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from breaker.reading.files.lexicon import BEHIND_NUMBER, LABELS, MONTH_ENDS, MONTHS
from breaker.reading.files.word_meanings import any_of

LARGEST_COUNTER = 9_999_999
"""More than any drive operates; what is larger is a date, a stamp or a serial number."""

_RUN = re.compile("[0-9]+")
_UNIT = re.compile(rf"[ _-]?(?:{BEHIND_NUMBER})\b")
_LABEL = re.compile(
    rf"(?:^|[^a-z])(?:{any_of(LABELS['no counter'])}[ _-]?|{any_of(LABELS['breaker'])})$",
    re.IGNORECASE,
)
_COUNTS = re.compile(
    rf"(?:^|[^a-z]){any_of(LABELS['counter'])}[ _.#°-]*$|[#№][ _-]*$", re.IGNORECASE
)


def numbers_in(stems: Sequence[str]) -> list[int | str]:
    """Return the operation number in each name, or why there is none.

    Args:
        stems: Names of the files of one folder, without their endings.

    >>> numbers_in(["op_0007_10kHz", "op_0008_10kHz", "notes"])
    [7, 8, 'has no number']
    >>> numbers_in(["op_0007_10kHz"])
    ['has 2 numbers, 7 and 10, and no other name shows which one counts']
    """
    kinds: dict[str, list[int]] = {}
    for i, stem in enumerate(stems):
        kinds.setdefault(_RUN.sub("\0", stem), []).append(i)
    found: list[int | str] = [""] * len(stems)
    for places in kinds.values():
        numbers = _numbers_of_kind([stems[i] for i in places])
        for i, number in zip(places, numbers, strict=True):
            found[i] = number
    return found


def _numbers_of_kind(stems: Sequence[str]) -> Sequence[int | str]:
    """The same for names that differ in their digits only."""
    runs = [list(_RUN.finditer(stem)) for stem in stems]
    columns = list(zip(*runs, strict=True))
    varying = [column for column in columns if len({int(run[0]) for run in column}) > 1]
    if not columns:
        return ["has no number"] * len(stems)
    if len(columns) > 1 and len(varying) != 1:
        return [_ambiguous([str(int(run[0])) for run in each], len(varying)) for each in runs]
    counters = varying[0] if varying else columns[0]
    digits = [run[0] for run in counters]
    why = _no_counter(stems, counters) or _date_alone(digits)
    counted = _COUNTS.search(stems[0][: counters[0].start()])
    # A counter that passes through 2000 has others, too.
    if not why and not counted and all(len(d) == 4 and 1950 <= int(d) <= 2060 for d in digits):
        why = "looks like a year"
    if why:
        return [f"has the number {each}, which {why}" for each in digits]
    return [
        int(each)
        if int(each) <= LARGEST_COUNTER
        else f"has the number {each}, which is too large for a counter of operations"
        for each in digits
    ]


def _ambiguous(numbers: list[str], varying: int) -> str:
    listed = f"{', '.join(numbers[:-1])} and {numbers[-1]}"
    vary = f"{varying} of them vary" if varying else "no other name shows which one counts"
    return f"has {len(numbers)} numbers, {listed}, and {vary}"


def _no_counter(stems: Sequence[str], runs: Sequence[re.Match]) -> str:
    """Say why a number counts no operations, by what stands around it in the first name that has
    that; empty if nothing speaks against it."""
    # A counter beside other numbers looks like a time at times; a time does so always.
    if all(
        any(m.start <= run.start() and run.end() <= m.stop for m in moments(stem))
        for stem, run in zip(stems, runs, strict=True)
    ):
        return "looks like part of a date or time"
    for stem, run in zip(stems, runs, strict=True):
        before, after = stem[: run.start()], stem[run.end() :]
        if _UNIT.match(after) or (after[:1].isalpha() or after[:1] in ("%", "°")):
            return f"belongs to {after.split('_')[0].strip()!r} after it, such as a unit"
        if label := _LABEL.search(before):
            return f"belongs to {label[0].strip(' _-')!r} before it"
        if re.search("[0-9][.,]$", before) or re.match("[.,][0-9]", after):
            return "is part of a number with a point, a date or a version"
    return ""


def _date_alone(digits: Sequence[str]) -> str:
    """Say so if all numbers of a column look like dates or times without anything between."""
    wide = [each for each in digits if not each.startswith("0")]
    if any(len(each) == 6 and _parses(each, "%y%m%d %d%m%y %m%d%y %H%M%S") for each in wide):
        return "looks like a date or time"
    if all(len(each) == 6 and _parses(each, "%d%m%y %m%d%y") for each in digits):
        return "looks like a date"
    if all(len(each) in (7, 8) and _parses(each, "%Y%j %Y%m%d %d%m%Y %m%d%Y") for each in digits):
        return "looks like a date"
    return ""


def _parses(digits: str, forms: str) -> bool:
    """Whether digits are a date of the last decades, or a time, in one of some forms."""
    for form in forms.split():
        with suppress(ValueError):
            if 2005 <= datetime.strptime(digits, form).year <= 2060 or "%H" in form:
                return True
    return False


def natural(path: str | Path) -> list[tuple[int, str]]:
    """Return a key by which 9 comes before 10.

    >>> sorted(["b 10", "b 9"], key=natural)
    ['b 9', 'b 10']
    """
    return [
        (int(part), "") if part.isdecimal() else (0, part)
        for part in re.split("([0-9]+)", str(path))
    ]


# ---- dates ---------------------------------------------------------------------------------------

_MONTHS_OF = {
    name: month for names in MONTHS.values() for month, name in enumerate(names.split(), start=1)
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
_WORD = rf"(?<![^\W\d_]){_NAME}(?:{MONTH_ENDS})?(?![^\W\d_])"
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

    @property
    def iso(self) -> str:
        """The date, with the time if it says one, as ISO 8601."""
        return (self.when if self.timed else self.when.date()).isoformat()


def moments(text: str) -> list[Moment]:
    """Find what looks like a date or a time in the name of a file, in the order of the text.

    >>> [str(each.when) for each in moments("closing_20-11-2024_15-13-07")]
    ['2024-11-20 15:13:07']
    >>> moments("operation_0007_10kHz")
    []
    """
    found: list[Moment] = []
    if not _RUN.search(text):
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
    timed = "hour" in parts
    if "day" not in parts:
        fine = clock[0] < 24 and clock[1] < 60 and clock[2] < 60
        return Moment(match.start(), match.end(), None, timed) if fine else None
    year = int(parts["year"]) if "year" in parts else 2000 + int(parts["short"])
    day = int(parts["day"])
    month = _MONTHS_OF[parts["name"].lower()] if "name" in parts else int(parts["month"])
    # The day first, as nearly everywhere; the month first where it can only be so.
    for one, other in ((month, day), (day, month)):
        with suppress(ValueError):
            return Moment(match.start(), match.end(), datetime(year, one, other, *clock), timed)
    return None
