"""Read a folder of records before any training; report what is accepted, and why not the rest."""

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from breaker.common.document import Document, Remark, Section, Table
from breaker.common.numerals import in_digits
from breaker.records.curves import Grid, GriddedRecord, read_records
from breaker.records.files import printable
from breaker.records.folder import list_operations
from breaker.records.operations import MANIFEST, Operation, read_manifest
from breaker.records.proposal import ITEM, alike

_FEWEST, _PARTS = 50, 8  # files that one process reads at a time, some seconds of work; most parts


class CheckedRecord(NamedTuple):
    """A record: its file, why it was rejected, remarks, and noise at rest and stroke, mm."""

    file: str
    reason: str = ""
    remarks: str = ""
    noise: float = np.nan
    stroke: float = np.nan


class CheckedGroup(NamedTuple):
    """Records of one motion, of one breaker and phase where a table names them, or why they could
    not be listed.
    """

    name: str
    motion: str
    records: Sequence[CheckedRecord] = ()
    error: str = ""

    @property
    def accepted(self) -> int:
        """Number of accepted records."""
        return sum(not record.reason for record in self.records)


def check_folder(
    folder: str | Path, endurance: Mapping, sensor: Mapping, motions: Iterable[str]
) -> list[CheckedGroup]:
    """Read all records of a folder, ``endurance.curves``, of some motions.

    Args:
        folder, motions: The folder; "closing", "opening" or both.
        endurance, sensor: Sections of the configuration.
    """
    times = np.linspace(sensor["start"], sensor["stop"], sensor["samples"])
    grid = Grid(times, sensor["noise_sd"], sensor["zero_sd"], sensor["onset_sd"])
    chosen = breaker, phase = endurance.get("breaker"), endurance.get("phase")
    try:
        rows = {(each.breaker, each.phase) for _, each in read_manifest(Path(folder, MANIFEST))}
    except ValueError:
        rows = set()  # no table, or listing the operations reports what is wrong with it
    of = [(b, p) for b, p in sorted(rows) if breaker in (None, b) and phase in (None, p)]
    groups = []
    for motion in motions:
        read = partial(_read, settings=endurance["format"], grid=grid, motion=motion)
        for breaker, phase in of or [chosen]:
            name = " ".join(filter(None, [breaker, phase, motion]))
            which = {"breaker": breaker, "phase": phase, "events": endurance["events"]}
            try:
                operations = list_operations(folder, motion, **which)
            except (ValueError, OSError) as error:
                groups.append(CheckedGroup(name, motion, error=str(error)))
                continue
            size = max(_FEWEST, -(-len(operations) // _PARTS))  # all may be lines of one file
            parts = [operations[i : i + size] for i in range(0, len(operations), size)]
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
            about = result.noise.sd, result.record.segment.stroke
            checked.append(CheckedRecord(file, "", "; ".join(result.remarks), *about))
        else:
            checked.append(CheckedRecord(file, str(result)))
    return checked


def document_of(groups: Sequence[CheckedGroup]) -> Document:
    """Return a table of what was accepted, and the reasons and remarks, each once."""
    head = ("", "records", "accepted", "with remarks", "rejected", "stroke (mm)", "noise (mm)")
    rows, texts = [], {"Rejected:": [], "Remarks on accepted records:": []}
    for group in groups:
        records = group.records
        rejected = [(group.name, each.file, each.reason) for each in records if each.reason]
        remarked = [(group.name, each.file, each.remarks) for each in records if each.remarks]
        counts = len(records), group.accepted, len(remarked), len(rejected)
        ranges = (_range([getattr(each, name) for each in records]) for name in ("stroke", "noise"))
        rows.append([group.name, *map(str, counts), *ranges])
        texts["Rejected:"] += rejected
        texts["Remarks on accepted records:"] += remarked
    errors = [Section(f"{group.name}: {group.error}") for group in groups if group.error]
    lists = [Section(title, _grouped(lines)) for title, lines in texts.items() if lines]
    return Document(parts=[Table(head, rows), *errors, *lists])


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
