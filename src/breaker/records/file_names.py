"""Find the number and the phase of an operation in the name of its file. Light to import.

A single number in a name counts operations, unless it is a year or a word next to it contradicts.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from breaker.records.dates import MONTHS
from breaker.records.words import IN_FILE, WORDS, any_of

_YEAR = re.compile("19[5-9][0-9]|20[0-5][0-9]")
_UNIT = rf"[ _-]?(?:{WORDS['behind_number']})\b"
_COUNTER = re.compile(  # six digits are a date or a time, too
    rf"(?P<before>[^0-9]*)(?P<number>[0-9]{{1,5}})(?!{_UNIT})(?:(?:[^\w%°.,]|_)[^0-9]*)?"
)
# Words before a number that show a channel, a version or a date.
_LABELS = any_of(WORDS["labels"]["no counter"])
_NOT_BEHIND = re.compile(rf"(?:^|[^a-z])(?:{_LABELS}|{MONTHS})[ _-]?$", re.IGNORECASE)


def numbers_in(stems: Sequence[str]) -> list[int | None]:
    """Return the operation number in the name of each file of a folder; None if it is ambiguous.

    >>> numbers_in(["op_0007", "op_0008_closing", "op_0009_10kHz", "notes"])
    [7, 8, None, None]
    """
    matches = [*map(_COUNTER.fullmatch, stems)]
    numbers = [m["number"] if m and not _NOT_BEHIND.search(m["before"]) else "" for m in matches]
    years = all(map(_YEAR.fullmatch, numbers))
    return [None if years or not number else int(number) for number in numbers]


def phases_in_names(files: Iterable[Path]) -> dict[Path, str]:
    """Return the phase in the name of each file; nothing if a name lacks a phase.

    A letter is a phase if names differ only in it and in digits, and all letters are of one system.

    >>> [*phases_in_names([Path("108-R 1.csv"), Path("108-Y 1.csv")]).values()]
    ['R', 'Y']
    """
    groups: dict[str, dict[Path, str]] = defaultdict(dict)
    for file in files:
        matches = IN_FILE.findall(file.stem)
        other = re.sub("[0-9]", "0", IN_FILE.sub("", file.stem))
        groups[other][file] = matches[0] if len(matches) == 1 else ""
    named = {}
    for phases in groups.values():
        there = {*phases.values()}
        if len(there) < 2 or not any(there <= {*system.split()} for system in WORDS["systems"]):
            return {}
        named |= phases
    return named


def number_poles(files: Mapping[Path, tuple[Sequence[str], str]]) -> dict[Path, int]:
    """Return the number of the operation of each file, from 1, by its phases and its day.

    On one day, the first files of several phases are poles of one operation, their second files
    are the next operation. A file without a stated phase is a separate operation.
    """
    turns, operations, poles = Counter(), {}, {}
    for path, (phases, day) in files.items():
        turns.update((day, phase) for phase in {*phases})
        turn = max((turns[day, phase] for phase in phases), default=path)
        poles[path] = operations.setdefault((day, turn), len(operations) + 1)
    return poles
