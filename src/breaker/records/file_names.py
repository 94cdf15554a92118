"""The number of an operation, and its phase, in the name of its file. Light to import.

Names of one kind differ in their digits only. The counter of a kind is its only number, or the only
one that varies: names that are added may make it ambiguous, but never make another the counter.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from breaker.records.dates import MONTHS, STAMP
from breaker.records.words import IN_FILE, WORDS, any_of

_RUN = re.compile("[0-9]+")
_DIGITS = 5  # of a counter: six are a date or a time, too
_YEAR = re.compile("19[5-9][0-9]|20[0-5][0-9]")
# What stands before a number that is a channel, a version, a day, or part of a fraction or a time.
_LABELS = "|".join(any_of(WORDS["labels"][kind]) for kind in ("no counter", "breaker"))
_NOT_BEHIND = re.compile(rf"(?:^|[^a-z])(?:{_LABELS}|{MONTHS})[ _-]?$|[0-9][^ _]$", re.IGNORECASE)
_OF_BREAK = re.compile(rf"{IN_FILE.pattern}-[0-9]( [CPV]T)?(?![^\W_]|-[0-9])")
_NOT_BEFORE = re.compile(rf"[ _-]?(?:{WORDS['behind_number']})\b|[^\W\d_]|[%°]|[^ _][0-9]")


def numbers_in(stems: Sequence[str]) -> list[int | None]:
    """Return the operation number in the name of each file of a folder; None where it is in doubt.

    >>> numbers_in(["op_0007_10kHz", "op_0008_10kHz", "notes"]), numbers_in(["op_0007_10kHz"])
    ([7, 8, None], [None])
    """
    kinds: dict[str, list[list[re.Match]]] = defaultdict(list)
    for stem in stems:
        kinds[_RUN.sub("\0", stem)].append([*_RUN.finditer(stem)])
    numbers: dict[str, int] = {}
    for rows in kinds.values():
        columns = [*zip(*rows, strict=True)]
        varying = [column for column in columns if len({int(run[0]) for run in column}) > 1]
        chosen = varying if len(varying) == 1 else columns
        if len(chosen) == 1 and _count(chosen[0]):
            numbers |= {run.string: int(run[0]) for run in chosen[0]}
    return [numbers.get(stem) for stem in stems]


def _count(runs: Sequence[re.Match]) -> bool:
    """Return whether numbers in names may count operations, by their sizes and what is near."""
    return not all(_YEAR.fullmatch(run[0]) for run in runs) and all(
        len(run[0]) <= _DIGITS
        and not _NOT_BEHIND.search(run.string[: run.start()])
        and not _NOT_BEFORE.match(run.string[run.end() :])
        and not any(m.start() <= run.start() < m.end() for m in STAMP.finditer(run.string))
        for run in runs
    )


def phases_in_names(files: Iterable[Path]) -> dict[Path, str]:
    """Return the phase in the name of each file; of no file where one of them has none.

    A letter is a phase where names differ in it and in digits alone, and all are of one system. A
    break behind it counts where some names state a side, too: ``Y-1 CT``.

    >>> [*phases_in_names([Path("108-R 1.csv"), Path("108-Y 1.csv")]).values()]
    ['R', 'Y']
    """
    files, groups = [*files], defaultdict(dict)
    sides = any(match[2] for file in files for match in _OF_BREAK.finditer(file.stem))
    form = _OF_BREAK if sides else IN_FILE
    for file in files:
        matches = [*form.finditer(file.stem)]
        other = re.sub("[0-9]", "0", form.sub("", file.stem))
        groups[other][file] = matches[0] if len(matches) == 1 else [""] * 2
    named = {}
    for phases in groups.values():
        there = {phase[1] for phase in phases.values()}
        if len(there) < 2 or not any(there <= {*system.split()} for system in WORDS["systems"]):
            return {}
        named |= {file: phase[0] for file, phase in phases.items()}
    return named


def number_poles(files: Mapping[Path, tuple[Sequence[str], str]]) -> dict[Path, int]:
    """Return the number of the operation of each file, from 1, by its phases and its day.

    The first files of several phases on one day are poles of one operation, their second files are
    the next operation. A file without a stated phase is an operation of its own.
    """
    turns, operations, poles = Counter(), {}, {}
    for path, (phases, day) in files.items():
        turns.update((day, phase) for phase in {*phases})
        turn = max((turns[day, phase] for phase in phases), default=path)
        poles[path] = operations.setdefault((day, turn), len(operations) + 1)
    return poles
