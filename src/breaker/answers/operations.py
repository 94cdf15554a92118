"""The records of a drive, as networks of a family see them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from breaker.family import NormalisedRecords, normalise_record
from breaker.files import Operation
from breaker.mechanism import MOTIONS, in_digits
from breaker.records import Raw, Shape, read_raws, taken_apart

__all__ = ["Record", "read_operations"]


@dataclass(frozen=True, eq=False)
class Record:
    """One motion of an operation.

    Attributes:
        operation, motion: What it is of.
        reason: Why it cannot be used; empty if it can.
        raw: The record as it is in its file, if it can be used.
        shape, seen: What networks see of it.
    """

    operation: Operation
    motion: str
    reason: str = ""
    raw: Raw | None = None
    shape: Shape | None = None
    seen: NormalisedRecords | None = None

    @property
    def timed(self) -> bool:
        """Whether its contact was seen to switch."""
        return bool(np.isfinite(self.raw.switching))

    @property
    def tenth(self) -> float:
        """Time of 10 % of the way, from which networks count, ms of the file."""
        return float(self.raw.time[self.raw.segment.begin]) + self.shape.origin


def read_operations(
    operations: Mapping[str, Sequence[Operation]], settings: Mapping, *, loose: bool = False
) -> list[Record]:
    """Read the records of a drive, motion by motion.

    Args:
        operations: By motion.
        settings: The section ``endurance.format`` of the configuration; what it lacks has its
            default.
        loose: Whether each file may hold either motion or both: then of files that hold one, the
            other is left out, and a file of neither is there once. A motion that a file holds more
            than once is there as often, with numbers beyond those of the operations.
    """
    found = {
        motion: [
            _records(operation, motion, raw, settings, beyond=len(each) if loose else 0)
            for operation, raw in zip(each, read_raws(each, settings, motion), strict=True)
        ]
        for motion, each in operations.items()
    }
    if loose and len(found) == len(MOTIONS):
        kept = [_kept(*both) for both in zip(*found.values(), strict=True)]
        found = dict(zip(found, zip(*kept, strict=True), strict=True)) if kept else {}
    return [record for each in found.values() for some in each for record in some]


def _records(
    operation: Operation, motion: str, raw: Raw | Exception, settings: Mapping, *, beyond: int
) -> list[Record]:
    """The records of a motion in a file: one, or each that it has where numbers go beyond."""
    apart = taken_apart(operation, raw) if beyond else []
    if not apart:
        return [_record(operation, motion, raw)]
    each = [replace(one, number=one.number + k * beyond) for k, one in enumerate(apart)]
    raws = read_raws(each, settings, motion)
    return [_record(one, motion, raw) for one, raw in zip(each, raws, strict=True)]


def _record(operation: Operation, motion: str, raw: Raw | Exception) -> Record:
    if not isinstance(raw, Raw):
        return Record(operation, motion, str(raw))
    try:
        shape, seen = normalise_record(raw)
    except ValueError as error:
        return Record(operation, motion, f"{operation.file}: {error}")
    inside = np.flatnonzero(shape.present)
    missing = 1.0 - float(shape.present[inside[0] : inside[-1] + 1].mean()) if inside.size else 1.0
    if missing > raw.settings["missing"]:
        reason = (
            f"{operation.file}: a share of {in_digits(missing, 2)} of the motion is missing, and "
            f"endurance.format.missing allows {in_digits(raw.settings['missing'], 4)}"
        )
        return Record(operation, motion, reason)
    return Record(operation, motion, "", raw, shape, seen)


def _kept(first: list[Record], second: list[Record]) -> tuple[list[Record], list[Record]]:
    """Of two readings of a file, those of a motion that it holds, or why it holds neither."""
    lacks = [f"which is no {some[0].motion}" in some[0].reason for some in (first, second)]
    same = bool(first[0].reason) and first[0].reason == second[0].reason
    return (
        [] if lacks[0] and not lacks[1] else first,
        [] if lacks[1] or same else second,
    )
