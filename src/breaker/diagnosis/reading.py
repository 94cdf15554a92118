"""Read and normalise the records of a drive, or give the reason why they cannot be used."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from breaker.common.numerals import in_digits
from breaker.diagnosis.estimate import DriveRecord
from breaker.diagnosis.sentences import say
from breaker.family.inputs import normalise_record
from breaker.model.parameters import MOTIONS
from breaker.records.files import Files, printable
from breaker.records.named import Operations
from breaker.records.operations import Operation
from breaker.records.reader import Reader, separate_motions
from breaker.records.record import Record
from breaker.records.rejections import OtherMotionError
from breaker.records.words import MOTION_OF


def read_operations(
    operations: Operations,
    settings: Mapping,
    *,
    motions: Sequence[str] = MOTIONS,
    files: Files | None = None,
) -> list[DriveRecord]:
    """Read the records of a drive, motion by motion; copies of a record are rejected.

    A file of ``ANY`` has some of the ``motions``; several motions of a kind are as many operations.
    ``settings`` is the section ``endurance.format`` of the configuration.
    """
    reader, operations_listed = Reader(settings, files), []
    for key, listed in operations.items():
        wanted = [key] if key else [*motions]
        records: list[DriveRecord] = []
        for operation, *raws in zip(listed, *reader.read_all(listed, *wanted), strict=True):
            read = dict(zip(wanted, raws, strict=True))
            records += _records_in(reader, operation, read, 0 if key else len(listed))
        operations_listed += sorted(records, key=lambda record: MOTIONS.index(record.motion))
    return without_copies(operations_listed)


def _records_in(
    reader: Reader, operation: Operation, raws: Mapping[str, Record | Exception], beyond: int
) -> list[DriveRecord]:
    """Return the records of the motions that a file has or states, or one with the reason if it has
    none.

    Each later motion of a kind has a number higher by ``beyond``; with 0, a kind has one motion.
    """
    cause = {motion: getattr(raw, "__cause__", None) for motion, raw in raws.items()}
    letters = reader.header(operation).operation.split("-")
    stated = {MOTION_OF.get(letter) for letter in letters if len(letters) > 1}
    other = {motion for motion in raws if isinstance(cause[motion], OtherMotionError)} - stated
    present = [motion for motion in raws if motion not in other]
    records: dict[object, DriveRecord] = {}
    for motion in present or [*raws][:1]:
        parts = separate_motions(operation, raws[motion]) if beyond and cause[motion] else []
        parts = [replace(e, number=e.number + k * beyond) for k, e in enumerate(parts)]
        (reread,) = reader.read_all(parts, motion)
        for part, raw in zip(parts or [operation], reread or [raws[motion]], strict=True):
            record = _record(reader, part, motion, raw)
            if isinstance(cause[motion], OtherMotionError) and motion in stated:
                values = {"file": printable(operation.file), "stated": record.stated.operation}
                reason = say("stated-motion-missing", motion=motion, **values)
                record = replace(record, reason=reason)
            key = record.reason or (motion, part.number)  # a reason for both motions counts once
            records.setdefault(key, record)
    return [*records.values()]


def _record(
    reader: Reader, operation: Operation, motion: str, raw: Record | Exception
) -> DriveRecord:
    """Return a normalised record, or the reason why it cannot be used."""
    stated = reader.header(operation)
    if not isinstance(raw, Record):
        return DriveRecord(reader.with_stated(operation, motion), motion, stated, str(raw))
    record = DriveRecord(raw.operation, motion, stated)
    try:
        shape, seen = normalise_record(raw)
    except ValueError as error:
        return replace(record, reason=f"{operation.file}: {error}")
    missing = 1.0 - float(np.trim_zeros(shape.present).mean()) if shape.present.any() else 1.0
    if missing > (allowed := raw.settings["missing"]):
        shares = {"missing": in_digits(missing, 2), "allowed": in_digits(allowed, 4)}
        reason = say("much-missing", file=printable(operation.file), **shares)
        return replace(record, reason=reason)
    return replace(record, raw=raw, shape=shape, seen=seen)


def without_copies(records: Iterable[DriveRecord]) -> list[DriveRecord]:
    """Return records; a record with the samples of an earlier one is rejected."""
    changed, first = [], {}
    for record in records:
        if not record.reason:
            key = record.motion, record.raw.left.tobytes()
            rows = first.setdefault(key, record).operation, record.operation
            other, name = (printable(f"{row.file} {row.channel}".strip()) for row in rows)
            if name != other:
                reason = say("copy", name=name, other=other)
                record = DriveRecord(record.operation, record.motion, record.stated, reason)
        changed.append(record)
    return changed
