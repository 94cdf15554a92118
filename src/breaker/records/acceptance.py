"""Read a folder of records before any training; report what is accepted, and why not the rest."""

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.documents.parts import Document, Remark, Section, Table
from breaker.model.quantities import SPEEDS
from breaker.records.curves import GriddedRecord, read_records
from breaker.records.files import printable
from breaker.records.folder import list_operations
from breaker.records.grid import Grid
from breaker.records.operations import MANIFEST, Operation, read_manifest
from breaker.records.proposal_text import ITEM, alike

_PART = 50  # files that one process reads at a time: some seconds of work


class CheckedRecord(NamedTuple):
    """Result of one record.

    Attributes:
        file: Name of the file.
        reason: Why the record was rejected; "" if it was accepted.
        remarks: Remarks on an accepted record.
        noise: Standard deviation at rest, mm; NaN if rejected.
        stroke: Stroke, mm; NaN if rejected.
    """

    file: str
    reason: str = ""
    remarks: str = ""
    noise: float = np.nan
    stroke: float = np.nan


@dataclass(frozen=True)
class CheckedGroup:
    """Records of one motion, of one breaker and phase where a table names them.

    Attributes:
        name: Breaker, phase and motion.
        motion: "closing" or "opening".
        records: Results of the records; None if the operations could not be listed.
        error: Why the operations could not be listed.
    """

    name: str
    motion: str
    records: Sequence[CheckedRecord] | None = None
    error: str = ""

    @property
    def accepted(self) -> int:
        """Number of accepted records."""
        return sum(not record.reason for record in self.records or ())


def check_folder(
    folder: str | Path, endurance: Mapping, sensor: Mapping, motions: Iterable[str]
) -> list[CheckedGroup]:
    """Read all records of a folder.

    Args:
        folder: Folder as for ``endurance.curves``.
        endurance: The section of the configuration: ``format``, ``events``, and ``breaker`` and
            ``phase`` where one of several is meant.
        sensor: The section of the configuration: grid of the model, and noise.
        motions: "closing", "opening" or both.
    """
    times = np.linspace(sensor["start"], sensor["stop"], sensor["samples"])
    grid = Grid(times, sensor["noise_sd"], sensor["zero_sd"], sensor["onset_sd"])
    groups = []
    for motion in motions:
        for breaker, phase in _groups(folder, endurance):
            name = " ".join(filter(None, [breaker, phase, motion]))
            of = {"breaker": breaker, "phase": phase, "events": endurance["events"]}
            try:
                operations = list_operations(folder, motion, **of)
            except (ValueError, OSError) as error:
                groups.append(CheckedGroup(name, motion, error=str(error)))
                continue
            read = partial(_read, settings=endurance["format"], grid=grid, motion=motion)
            parts = [operations[i : i + _PART] for i in range(0, len(operations), _PART)]
            if len(parts) > 1:
                with ProcessPoolExecutor() as pool:
                    results = [*pool.map(read, parts)]
            else:
                results = map(read, parts)
            groups.append(CheckedGroup(name, motion, [one for part in results for one in part]))
    return groups


def _read(operations: Sequence[Operation], **about: object) -> list[CheckedRecord]:
    """Read some operations as the workflow reads them."""
    checked = []
    for operation, result in zip(operations, read_records(operations, **about), strict=True):
        file = printable(operation.file)
        if isinstance(result, GriddedRecord):
            stroke = result.record.measured(SPEEDS)["stroke"].value
            remarks = "; ".join(result.remarks)
            checked.append(CheckedRecord(file, "", remarks, result.noise.sd, stroke))
        else:
            checked.append(CheckedRecord(file, str(result)))
    return checked


def _groups(folder: str | Path, endurance: Mapping) -> list[tuple[str | None, str | None]]:
    """Return breakers and phases of a folder, or those that are chosen."""
    chosen = breaker, phase = endurance.get("breaker"), endurance.get("phase")
    try:
        rows = read_manifest(Path(folder, MANIFEST))
    except ValueError:
        return [chosen]  # no table, or listing the operations reports what is wrong with it
    there = sorted({(operation.breaker, operation.phase) for _, operation in rows})
    fit = [(b, p) for b, p in there if breaker in (None, b) and phase in (None, p)]
    return fit or [chosen]


def document_of(groups: Sequence[CheckedGroup]) -> Document:
    """Return a table of what was accepted, and the reasons and remarks, each once."""
    parts: list = [_table(groups)]
    for error in dict.fromkeys(group.error for group in groups if group.error):
        names = ", ".join(group.name for group in groups if group.error == error)
        parts.append(Section(f"{names}: {error}"))
    for title, kind in {"Rejected:": "reason", "Remarks on accepted records:": "remarks"}.items():
        texts = [
            (group.name, record.file, text)
            for group in groups
            for record in group.records or ()
            if (text := getattr(record, kind))
        ]
        if texts:
            parts.append(Section(title, _grouped(texts)))
    return Document(parts=parts)


def _table(groups: Sequence[CheckedGroup]) -> Table:
    rows = []
    for group in groups:
        records = group.records or ()
        remarked = sum(bool(record.remarks) for record in records)
        counts = len(records), group.accepted, remarked, len(records) - group.accepted
        values = ([getattr(record, name) for record in records] for name in ("stroke", "noise"))
        rows.append([group.name, *map(str, counts), *map(_range, values)])
    head = ("", "records", "accepted", "with remarks", "rejected", "stroke (mm)", "noise (mm)")
    return Table(head, rows)


def _range(values: Sequence[float]) -> str:
    finite = [value for value in values if np.isfinite(value)]
    return f"{in_digits(min(finite), 3)} to {in_digits(max(finite), 3)}" if finite else ""


def _grouped(texts: Sequence[tuple[str, str, str]]) -> list[Remark]:
    """Return texts that differ in numbers alone once: how many they are, and the first."""
    lines = []
    for members in sorted(alike(texts), key=len, reverse=True):
        name, file, text = members[0]
        text = text if text.startswith(file) else f"{file}: {text}"
        count = f"{len(members)} of {name}, first " if len(members) > 1 else f"{name}, "
        lines.append(Remark(count + text, ITEM))
    return lines
