"""The records of a drive, as networks of a family see them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from breaker.family import NormalisedRecords, normalise_record
from breaker.files import Operation
from breaker.mechanism import MOTIONS
from breaker.records import Raw, Shape, read_raws

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
            other is left out, and a file of neither is there once.
    """
    found = {
        motion: [
            _record(operation, motion, raw)
            for operation, raw in zip(each, read_raws(each, settings, motion), strict=True)
        ]
        for motion, each in operations.items()
    }
    if loose and len(found) == len(MOTIONS):
        kept = [_kept(*both) for both in zip(*found.values(), strict=True)]
        found = {m: [each[k] for each in kept if each[k]] for k, m in enumerate(found)}
    return [record for each in found.values() for record in each]


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
            f"{operation.file}: a share of {missing:.2g} of the motion is missing, and "
            f"endurance.format.missing allows {raw.settings['missing']:g}"
        )
        return Record(operation, motion, reason)
    return Record(operation, motion, "", raw, shape, seen)


def _kept(first: Record, second: Record) -> tuple[Record | None, Record | None]:
    """Of two readings of a file, those of a motion that it holds, or why it holds neither."""
    lacks = [f"which is no {each.motion}" in each.reason for each in (first, second)]
    same = bool(first.reason) and first.reason == second.reason
    return (
        None if lacks[0] and not lacks[1] else first,
        None if lacks[1] or same else second,
    )
