"""The records of a drive, as networks of a family see them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.diagnosis.estimate import DriveRecord
from breaker.diagnosis.identity import without_copies
from breaker.family.inputs import normalise_record
from breaker.family.shape import Shape
from breaker.model.parameters import MOTIONS
from breaker.records.files import Files
from breaker.records.operations import Operation
from breaker.records.reader import Reader, separate_motions
from breaker.records.record import Record
from breaker.records.rejections import OtherMotionError


def read_operations(
    operations: Mapping[str, Sequence[Operation]],
    settings: Mapping,
    *,
    loose: bool = False,
    files: Files | None = None,
) -> list[DriveRecord]:
    """Read the records of a drive, motion by motion.

    Args:
        operations: By motion.
        settings: The section ``endurance.format`` of the configuration; what it lacks has its
            default.
        loose: Whether each file may hold either motion or both: then of files that hold one, the
            other is left out, and a file of neither is there once. A motion that a file holds more
            than once is there as often, with numbers beyond those of the operations.
        files: In which they are opened, where others open them, too.
    """
    reader = Reader(settings, files)
    found = {}
    for each, same in groupby(operations, key=operations.get):  # files of both are read once
        motions = [*same]
        read = reader.read_all(each, *motions)
        for motion, raws in zip(motions, read, strict=True):
            of_motion = _Reader(motion, reader, len(each) if loose else 0)
            found[motion] = [of_motion.records(*row) for row in zip(each, raws, strict=True)]
    if loose and len(found) == len(MOTIONS):
        kept = [_kept(*both) for both in zip(*found.values(), strict=True)]
        found = dict(zip(found, zip(*kept, strict=True), strict=True)) if kept else {}
    return without_copies([one for each in found.values() for some in each for one in some])


class _Reader(NamedTuple):
    """How the records of a motion are read.

    Attributes:
        motion: The motion.
        reader: Reader of the files.
        beyond: From which numbers of operations go on where a motion comes again.
    """

    motion: str
    reader: Reader
    beyond: int

    def records(self, operation: Operation, raw: Record | Exception) -> list[DriveRecord]:
        """The records of a motion in a file: one, or each that it has where numbers go beyond."""
        several = self.beyond and isinstance(raw, Exception)
        apart = separate_motions(operation, raw) if several else []
        if not apart:
            return [self._record(operation, raw)]
        each = [replace(one, number=one.number + k * self.beyond) for k, one in enumerate(apart)]
        (raws,) = self.reader.read_all(each, self.motion)
        return [self._record(*both) for both in zip(each, raws, strict=True)]

    def _record(self, operation: Operation, raw: Record | Exception) -> DriveRecord:
        stated = self.reader.header(operation)
        if not isinstance(raw, Record):
            operation = self.reader.with_stated(operation, self.motion)
            other = isinstance(raw.__cause__, OtherMotionError)
            return DriveRecord(operation, self.motion, stated, str(raw), other=other)
        about = raw.operation, self.motion, stated
        try:
            shape, seen = normalise_record(raw)
        except ValueError as error:
            return DriveRecord(*about, f"{operation.file}: {error}")
        if lacks := _lacks(shape, raw.settings["missing"]):
            return DriveRecord(*about, f"{operation.file}: {lacks}")
        return DriveRecord(*about, "", raw, shape, seen)


def _lacks(shape: Shape, allowed: float) -> str:
    """Say where too large a share of a motion is missing; "" where it is not."""
    inside = np.flatnonzero(shape.present)
    missing = 1.0 - float(shape.present[inside[0] : inside[-1] + 1].mean()) if inside.size else 1.0
    if missing <= allowed:
        return ""
    return (
        f"a share of {in_digits(missing, 2)} of the motion is missing, and "
        f"endurance.format.missing allows {in_digits(allowed, 4)}"
    )


def _kept(
    first: list[DriveRecord], second: list[DriveRecord]
) -> tuple[list[DriveRecord], list[DriveRecord]]:
    """Of two readings of a file, those of a motion that it holds, or why it holds neither."""
    lacks = [some[0].other for some in (first, second)]
    same = bool(first[0].reason) and first[0].reason == second[0].reason
    return (
        [] if lacks[0] and not lacks[1] else first,
        [] if lacks[1] or same else second,
    )
