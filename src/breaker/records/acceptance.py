"""Read a folder of records before training; report accepted records and reasons of rejection."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from breaker.common.document import Document, Remark, Table
from breaker.common.numerals import in_digits
from breaker.records.curves import Grid, GriddedRecord, read_records
from breaker.records.files import RejectedCurveError, printable
from breaker.records.folder import list_operations, table_rows
from breaker.records.proposal import ITEM, grouped


class CheckedGroup(NamedTuple):
    """Records of one motion, of one breaker and phase if a table names them, or the error in
    listing them.
    """

    name: str
    motion: str
    accepted: Sequence[GriddedRecord] = ()
    rejected: Sequence[RejectedCurveError] = ()
    error: str = ""


def check_folder(
    folder: str | Path, endurance: Mapping, sensor: Mapping, motions: Iterable[str]
) -> list[CheckedGroup]:
    """Read all records of a folder, ``endurance.curves``, of some motions.

    Args:
        folder, motions: The folder; "closing", "opening" or both.
        endurance, sensor: Sections of the configuration.

    Raises:
        ValueError: If the table of the folder is wrong.
    """
    times = np.linspace(sensor["start"], sensor["stop"], sensor["samples"])
    grid = Grid(times, sensor["noise_sd"], sensor["zero_sd"], sensor["onset_sd"])
    breaker, phase = endurance["breaker"], endurance["phase"]
    rows = {(operation.breaker, operation.phase) for _, operation in table_rows(folder)}
    poles = [(b, p) for b, p in sorted(rows) if breaker in (None, b) and phase in (None, p)]
    groups = []
    for motion in motions:
        for pole in poles or [(breaker, phase)]:
            name = " ".join(filter(None, [*pole, motion]))
            try:
                operations = list_operations(folder, motion, breaker=pole[0], phase=pole[1])
            except (ValueError, OSError) as error:
                groups.append(CheckedGroup(name, motion, error=str(error)))
                continue
            results = read_records(operations, endurance["format"], grid, motion)
            accepted = [result for result in results if isinstance(result, GriddedRecord)]
            rejected = [result for result in results if isinstance(result, RejectedCurveError)]
            groups.append(CheckedGroup(name, motion, accepted, rejected))
    return groups


def document_of(groups: Sequence[CheckedGroup]) -> Document:
    """Return a table of the numbers of accepted records, and the reasons and remarks, each once."""
    head = ("", "records", "accepted", "with remarks", "rejected", "stroke (mm)", "noise (mm)")
    rows, texts = [], {"Rejected:": [], "Remarks on accepted records:": []}
    for name, _, accepted, rejected, _ in groups:
        remarked = [result for result in accepted if result.remarks]
        counts = len(accepted) + len(rejected), len(accepted), len(remarked), len(rejected)
        strokes = _range([result.record.segment.stroke for result in accepted])
        noises = _range([result.record.noise.sd for result in accepted])
        rows.append([name, *map(str, counts), strokes, noises])
        texts["Rejected:"] += [(name, error.file, str(error)) for error in rejected]
        texts["Remarks on accepted records:"] += [
            (name, printable(result.record.operation.file), "; ".join(result.remarks))
            for result in remarked
        ]
    errors = [Table(title=f"{group.name}: {group.error}") for group in groups if group.error]
    lists = [Table(title=title, rows=_grouped(lines)) for title, lines in texts.items() if lines]
    return Document(parts=[Table(head, rows), *errors, *lists])


def _range(values: Sequence[float]) -> str:
    finite = [value for value in values if np.isfinite(value)]
    return f"{in_digits(min(finite), 3)} to {in_digits(max(finite), 3)}" if finite else ""


def _grouped(texts: Sequence[tuple[str, str, str]]) -> list[Remark]:
    """Return one line for texts that differ only in numbers: their count, and the first text."""
    lines = []
    for members in sorted(grouped(texts), key=len, reverse=True):
        name, file, text = members[0]
        text = text if text.startswith(file) else f"{file}: {text}"
        count = f"{len(members)} of {name}, first " if len(members) > 1 else f"{name}, "
        lines.append(Remark(count + text, ITEM))
    return lines
