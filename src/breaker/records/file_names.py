"""The number of an operation, and its phase, in the name of its file. Light to import.

A number is one where the names leave no doubt. Names of one kind differ in their digits only. The
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

_RUN = re.compile("[0-9]+")
_MOST_DIGITS = 5  # of a counter in a name: six are a date or a time, too
# What belongs to a number, and a number to which it belongs: a unit, a fraction; a channel, a date.
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
        if len(there) > 1 and any(there <= {*system.split()} for system in WORDS["systems"]):
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
    whys = [_no_counter(stem, run) for stem, run in zip(stems, counters, strict=True)]
    if why := next(filter(None, whys), "") or _years(stems[0], counters):
        return [f"has the number {run[0]}, which {why}" for run in counters]
    return [int(run[0]) for run in counters]


def _ambiguous(numbers: list[str], varying: int) -> str:
    listed = f"{', '.join(numbers[:-1])} and {numbers[-1]}"
    vary = f"{varying} of them vary" if varying else "no other name shows which one counts"
    return f"has {len(numbers)} numbers, {listed}, and {vary}"


def _no_counter(stem: str, run: re.Match) -> str:
    """Say why a number of a name counts no operations; empty if nothing speaks against it."""
    before, after = stem[: run.start()], stem[run.end() :]
    if len(run[0]) > _MOST_DIGITS:
        return f"has more than {_MOST_DIGITS} digits, as a date or a stamp"
    if any(m.start <= run.start() and run.end() <= m.stop for m in moments(stem)):
        return "looks like part of a date or time"
    if _UNIT.match(after) or _LABEL.search(before):
        return "belongs to what stands beside it, such as a unit"
    return ""


def _years(stem: str, runs: Sequence[re.Match]) -> str:
    """Say so if numbers look like years. A counter that passes through 2000 has others, too."""
    all_years = all(len(run[0]) == 4 and 1950 <= int(run[0]) <= 2060 for run in runs)
    counted = _COUNTS.search(stem[: runs[0].start()])
    return "looks like a year" if all_years and not counted else ""
