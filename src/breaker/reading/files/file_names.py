"""The number of an operation, and its phase, in the name of its file. Light to import.

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

from breaker.reading.files.date_text import moments
from breaker.reading.files.lexicon import BEHIND_NUMBER, LABELS, SYSTEMS
from breaker.reading.files.word_meanings import IN_FILE, any_of

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


def phases_in_names(files: Sequence[Path]) -> dict[Path, str]:
    """Return the phase that the name of each file has: where names are alike but for it, and for
    digits, and all phases are of one system; of no file where one of them lacks it.

    >>> names = ["108-R 24-12-2020.csv", "108-Y 24-12-2020.csv"]
    >>> [*phases_in_names([Path(name) for name in names]).values()]
    ['R', 'Y']
    >>> phases_in_names([Path("A.csv"), Path("C.csv"), Path("O.csv")])
    {}
    """
    groups: dict[str, dict[Path, str]] = {}
    for file in files:
        if len(each := IN_FILE.findall(file.stem)) == 1:
            alike = re.sub("[0-9]", "0", IN_FILE.sub("", file.stem))
            groups.setdefault(alike, {})[file] = each[0]
    named = {}
    for some in groups.values():
        there = {*some.values()}
        if len(there) > 1 and any(there <= {*system.split()} for system in SYSTEMS):
            named |= some
    return named if len(named) == len(files) else {}


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
