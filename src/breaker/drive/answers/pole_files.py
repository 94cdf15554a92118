"""Poles of a breaker in files of their own: which files are of one operation.

An analyser writes a file for each pole, seconds or minutes apart. Files are of one operation where
no phase stands in two of them and they state the same day; of several such the first counts.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple


class PoleFile(NamedTuple):
    """A file of a visit.

    Attributes:
        phases: Of its channels; empty where one is not known.
        date: As ISO 8601, with its time if that is stated; empty where the file states none.
    """

    phases: tuple[str, ...]
    date: str = ""


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
    """Whether a file is of the same operation as others, by phases and days."""
    there = {phase for each in group for phase in each.phases}
    known = bool(one.phases) and all(each.phases for each in group)
    days = {each.date[:10] for each in (*group, one)} - {""}
    return known and not there & {*one.phases} and len(days) < 2
