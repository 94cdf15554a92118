"""The number of an operation, and its phase, in the name of its file. Light to import.

A number counts where the names leave no doubt. Names of one kind differ in their digits only. The
counter of a kind is its only number, or the only one that varies. So a name that is added can make
a number vary that did not, and with it the names ambiguous, which is an error; but it never makes
another number the counter.
"""

import re
from collections.abc import Sequence
from pathlib import Path

from breaker.records.dates import moments
from breaker.records.lexicon import WORDS
from breaker.records.words import IN_FILE, any_of

LARGEST_COUNTER = 9_999_999
"""More than any drive operates."""

_MOST_DIGITS = 5  # of a counter in a name: six are a date or a time, too

_RUN = re.compile("[0-9]+")
_YEAR = re.compile("19[5-9][0-9]|20[0-5][0-9]|2060")
# A unit or a fraction that belongs to a number; a channel or a date to which the number belongs.
_UNIT = re.compile(rf"[ _-]?(?:{WORDS['behind_number']})\b|[^\W\d_]|[%°]|[.,][0-9]")
_LABEL = re.compile(
    rf"(?:^|[^a-z])(?:{any_of(WORDS['labels']['no counter'])}[ _-]?|"
    rf"{any_of(WORDS['labels']['breaker'])})$|[0-9][.,]$",
    re.IGNORECASE,
)
_COUNTS = re.compile(
    rf"(?:^|[^a-z]){any_of(WORDS['labels']['counter'])}[ _.#°-]*$|[#№][ _-]*$", re.IGNORECASE
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
    """Return the phase in the name of each file; of no file where one of them has none.

    A letter is a phase where names are alike but for it, and for digits, and all phases are of one
    system.

    >>> names = ["108-R 24-12-2020.csv", "108-Y 24-12-2020.csv"]
    >>> [*phases_in_names([Path(name) for name in names]).values()]
    ['R', 'Y']
    >>> phases_in_names([Path("A.csv"), Path("C.csv"), Path("O.csv")])
    {}
    """
    groups: dict[str, dict[Path, str]] = {}
    for file in files:
        if len(letters := IN_FILE.findall(file.stem)) == 1:
            alike = re.sub("[0-9]", "0", IN_FILE.sub("", file.stem))
            groups.setdefault(alike, {})[file] = letters[0]
    named = {}
    for phases in groups.values():
        there = {*phases.values()}
        if len(there) > 1 and any(there <= {*system.split()} for system in WORDS["systems"]):
            named |= phases
    return named if len(named) == len(files) else {}


def _numbers_of_kind(stems: Sequence[str]) -> Sequence[int | str]:
    """Return the same for names that differ in their digits only."""
    runs = [list(_RUN.finditer(stem)) for stem in stems]
    columns = list(zip(*runs, strict=True))
    varying = [column for column in columns if len({int(run[0]) for run in column}) > 1]
    if not columns:
        return ["has no number"] * len(stems)
    if len(columns) > 1 and len(varying) != 1:
        vary = f"{len(varying)} of them vary" if varying else "no other name shows which one counts"
        numbers = [[str(int(run[0])) for run in row] for row in runs]
        return [
            f"has {len(row)} numbers, {', '.join(row[:-1])} and {row[-1]}, and {vary}"
            for row in numbers
        ]
    counters = varying[0] if varying else columns[0]
    whys = [_no_counter(stem, run) for stem, run in zip(stems, counters, strict=True)]
    # A counter that passes through 2000 has other values, too.
    counted = _COUNTS.search(stems[0][: counters[0].start()])
    if not counted and all(_YEAR.fullmatch(run[0]) for run in counters):
        whys = ["looks like a year"]
    if why := next(filter(None, whys), ""):
        return [f"has the number {run[0]}, which {why}" for run in counters]
    return [int(run[0]) for run in counters]


def _no_counter(stem: str, run: re.Match) -> str:
    """Return why a number of a name counts no operations; empty if nothing speaks against it."""
    if len(run[0]) > _MOST_DIGITS:
        return f"has more than {_MOST_DIGITS} digits, as a date or a stamp"
    if any(m.start <= run.start() and run.end() <= m.stop for m in moments(stem)):
        return "looks like part of a date or time"
    if _UNIT.match(stem[run.end() :]) or _LABEL.search(stem[: run.start()]):
        return "belongs to a word or sign next to it, such as a unit"
    return ""
