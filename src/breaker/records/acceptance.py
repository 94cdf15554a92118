"""What will be accepted of a folder of records, and why the rest will not, before any training."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.documents.parts import Document, Remark, Section, Table
from breaker.model.quantities import SPEEDS
from breaker.records.curves import ReadRecord, read_records
from breaker.records.files import printable
from breaker.records.folder import list_operations
from breaker.records.grid import Grid
from breaker.records.operations import MANIFEST, Operation, read_manifest
from breaker.records.preparation import Prepared
from breaker.records.proposal_text import ITEM, alike

_PART = 50  # files that one process reads at a time


class CheckedRecord(NamedTuple):
    """What is shown of a record.

    Attributes:
        file: Its name.
        reason: Why it was rejected; empty of one that is accepted.
        remarks: What is doubtful about one that is, in words.
        noise: Standard deviation at rest, mm; NaN of one that is rejected.
        stroke: mm; the same.
    """

    file: str
    reason: str = ""
    remarks: str = ""
    noise: float = np.nan
    stroke: float = np.nan


@dataclass(frozen=True)
class Checked:
    """The records of one motion, of one breaker and phase where a table names them.

    Attributes:
        motion: "closing" or "opening".
        breaker, phase: Names; empty where there are none.
        records: As read; None if the operations could not be listed.
        trouble: Why they could not.
    """

    motion: str
    breaker: str = ""
    phase: str = ""
    records: Sequence[CheckedRecord] | None = None
    trouble: str = ""

    @property
    def accepted(self) -> int:
        """Number of accepted records."""
        return sum(not each.reason for each in self.records or ())


def check_folder(
    folder: str | Path, endurance: Mapping, sensor: Mapping, motions: Iterable[str]
) -> list[Checked]:
    """Read all records of a folder.

    Args:
        folder: As for ``endurance.curves``.
        endurance: The section of the configuration: ``format``, ``events``, and ``breaker`` and
            ``phase`` where one of several is meant.
        sensor: The section of the configuration: the model's grid, and the noise.
        motions: "closing", "opening" or both.
    """
    times = np.linspace(sensor["start"], sensor["stop"], sensor["samples"])
    grid = Grid(times, sensor["noise_sd"], sensor["zero_sd"], sensor["onset_sd"])
    read = partial(_read, settings=endurance["format"], grid=grid)
    checked = []
    for motion in motions:
        for breaker, phase in _groups(folder, endurance):
            of = motion, breaker or "", phase or ""
            try:
                operations = list_operations(
                    folder, motion, breaker=breaker, phase=phase, events=endurance["events"]
                )
            except (ValueError, OSError) as error:
                checked.append(Checked(*of, trouble=str(error)))
            else:
                checked.append(Checked(*of, _in_parts(partial(read, motion=motion), operations)))
    return checked


def _read(
    operations: Sequence[Operation], settings: Mapping, **about: object
) -> list[CheckedRecord]:
    """Read some operations as the workflow reads them, and keep what is shown."""
    found, how = [], Prepared(settings)
    records = read_records(operations, settings, preparation=how, **about)
    for operation, record in zip(operations, records, strict=True):
        file = printable(operation.file)
        if isinstance(record, ReadRecord):
            stroke = record.measured(SPEEDS)["stroke"].value
            remarks = "; ".join(record.remarks)
            found.append(CheckedRecord(file, "", remarks, record.noise.sd, stroke))
        else:
            found.append(CheckedRecord(file, str(record)))
    return found


def _in_parts(read: Callable, operations: Sequence[Operation]) -> list[CheckedRecord]:
    """What is read of operations, on all cores where there are many of them."""
    if len(operations) < 2 * _PART:
        return read(operations)
    parts = [operations[i : i + _PART] for i in range(0, len(operations), _PART)]
    with ProcessPoolExecutor() as pool:
        return [each for part in pool.map(read, parts) for each in part]


def _groups(folder: str | Path, endurance: Mapping) -> list[tuple[str | None, str | None]]:
    """Breakers and phases of a folder, or those that are chosen."""
    chosen = breaker, phase = endurance.get("breaker"), endurance.get("phase")
    try:
        rows = read_manifest(Path(folder, MANIFEST))
    except ValueError:
        return [chosen]  # there is no table, or listing says what is wrong with it
    there = sorted({(each.breaker, each.phase) for _, each in rows})
    fit = [(b, p) for b, p in there if breaker in (None, b) and phase in (None, p)]
    return fit or [chosen]


# ---- in words -----------------------------------------------------------------------------------


def words_of_checked(checked: Sequence[Checked]) -> Document:
    """Return a table of what was accepted, and the reasons and remarks, each once."""
    parts: list = [_table(checked)]
    for trouble in dict.fromkeys(each.trouble for each in checked if each.trouble):
        of = ", ".join(_name(each) for each in checked if each.trouble == trouble)
        parts.append(Section(f"{of}: {trouble}"))
    sections = {"Rejected:": "reason", "Remarks on what was accepted:": "remarks"}
    read = [(_name(each), each.records) for each in checked if each.records is not None]
    for title, kind in sections.items():
        if found := [(name, *pair) for name, records in read for pair in _texts(records, kind)]:
            parts.append(Section(title, _grouped(found)))
    return Document(parts=parts)


def _name(checked: Checked) -> str:
    return " ".join(filter(None, [checked.breaker, checked.phase, checked.motion]))


def _texts(records: Sequence[CheckedRecord], kind: str) -> list[tuple[str, str]]:
    """File and text of each record that has one of a kind."""
    return [(each.file, text) for each in records if (text := getattr(each, kind))]


def _table(checked: Sequence[Checked]) -> Table:
    rows = []
    for each in checked:
        if each.records is None:
            rows.append([_name(each), "none", "0", "", "", "", ""])
            continue
        count, remarked = len(each.records), sum(bool(one.remarks) for one in each.records)
        numbers = [count, each.accepted, remarked, count - each.accepted]
        ends = ([getattr(one, name) for one in each.records] for name in ("stroke", "noise"))
        ranges = (_range(np.array(values)) for values in ends)
        rows.append([_name(each), *map(str, numbers), *ranges])
    head = ("", "records", "accepted", "with remarks", "rejected", "stroke (mm)", "noise (mm)")
    return Table(head, rows)


def _range(values: np.ndarray) -> str:
    values = values[np.isfinite(values)]
    ends = (values.min(), values.max()) if values.size else ()
    return " to ".join(in_digits(end, 3) for end in ends)


def _grouped(found: Sequence[tuple[str, str, str]]) -> list[Remark]:
    """Items with each text once, where texts are alike: how many, and the first of them."""
    lines = []
    for members in sorted(alike(found), key=len, reverse=True):
        name, file, text = members[0]
        text = text if text.startswith(file) else f"{file}: {text}"
        count = f"{len(members)} of {name}, first " if len(members) > 1 else f"{name}, "
        lines.append(Remark(count + text, ITEM))
    return lines
