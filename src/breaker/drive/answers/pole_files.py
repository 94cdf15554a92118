"""Poles of a breaker in files of their own: which files are of one operation.

An analyser writes a file for each pole, seconds or minutes apart. Files are of one operation where
no phase stands in two of them and they are close in time; of several such the first counts.
"""

import re
from collections.abc import Mapping, Sequence
from datetime import datetime, timedelta
from pathlib import Path
from typing import NamedTuple

from breaker.reading.files.lexicon import SYSTEMS
from breaker.reading.files.word_meanings import IN_FILE

_CLOSE = timedelta(hours=1)  # between poles of one operation, where times are stated


class PoleFile(NamedTuple):
    """A file of a visit.

    Attributes:
        phases: Of its channels; empty where one is not known.
        date: As ISO 8601, with its time if that is stated; empty where nothing states it.
    """

    phases: tuple[str, ...]
    date: str = ""


def phases_in_names(files: Sequence[Path]) -> dict[Path, str]:
    """Return the phase that the name of each file has: where names are alike but for it, and for
    digits, and all phases are of one system.

    >>> names = ["108-R 24-12-2020.csv", "108-Y 24-12-2020.csv"]
    >>> [*phases_in_names([Path(name) for name in names]).values()]
    ['R', 'Y']
    >>> phases_in_names([Path("A.csv"), Path("C.csv"), Path("O.csv")])
    {}
    """
    found: dict[str, dict[Path, str]] = {}
    for file in files:
        if len(each := IN_FILE.findall(file.stem)) == 1:
            alike = re.sub(r"\d", "0", IN_FILE.sub("", file.stem))
            found.setdefault(alike, {})[file] = each[0]
    named = {}
    for some in found.values():
        there = {*some.values()}
        named |= (
            some if len(there) > 1 and any(there <= {*system.split()} for system in SYSTEMS) else {}
        )
    return named if len(named) == len(files) else {}


def operations_of_poles(files: Mapping[Path, PoleFile]) -> dict[Path, int]:
    """Return the number of the operation of each file, from 1 in the order of the files.

    Example:
        >>> times = {"R": "2020-12-24T06:07:25", "Y": "2020-12-24T06:07:26"}
        >>> files = {Path(p): PoleFile((p,), time) for p, time in times.items()}
        >>> [*operations_of_poles(files | {Path("R 2"): PoleFile(("R",))}).values()]
        [1, 1, 2]
    """
    groups: list[list[PoleFile]] = []
    found = {}
    for path, each in sorted(files.items(), key=lambda item: item[1].date or "9999"):
        found[path] = next((k for k, own in enumerate(groups) if _beside(own, each)), len(groups))
        groups += [[]] if found[path] == len(groups) else []
        groups[found[path]].append(each)
    order = {of: k for k, of in enumerate(dict.fromkeys(found[path] for path in files), start=1)}
    return {path: order[found[path]] for path in files}


def _beside(group: Sequence[PoleFile], one: PoleFile) -> bool:
    """Whether a file is of the same operation as others, by phases and dates."""
    there = {phase for each in group for phase in each.phases}
    known = bool(one.phases) and all(each.phases for each in group)
    return known and not there & {*one.phases} and all(_near(each.date, one.date) for each in group)


def _near(first: str, second: str) -> bool:
    """Whether two dates are close, or nothing is known against it."""
    if not (first and second):
        return True
    if "T" in first and "T" in second:
        both = (datetime.fromisoformat(each).replace(tzinfo=None) for each in (first, second))
        return abs(next(both) - next(both)) <= _CLOSE
    return first[:10] == second[:10]
