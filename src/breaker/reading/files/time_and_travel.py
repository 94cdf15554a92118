"""The columns of time and travel of one record, as numbers in the file's own units."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from breaker.reading.files.column_names import BESIDE
from breaker.reading.files.file_look import check_size
from breaker.reading.files.guards import RejectedCurveError
from breaker.reading.files.preamble import Preamble, preamble_of
from breaker.reading.files.table_head import Head, Row, SampleTable, find_head, is_remark
from breaker.reading.files.text_cells import LARGEST_NUMBER, Lines, strict_numbers, why_none


@dataclass(frozen=True)
class Columns:
    """A record as it stands in its file.

    Attributes:
        time: Times, ``(t,)``; None where the file has none.
        travel: Readings, ``(t,)``, NaN where one is missing.
        lines: Line of each in the file, ``(t,)``.
        remarks: What is doubtful about the file, in words.
        beside: Those of ``column_names.BESIDE`` that are wanted, by kind, ``(t,)``, NaN where
            missing.
        amperes: That one of the unit of these is; nan where it is no current.
        above: Cells of the lines above the samples, but for names and units.
        decimal: Sign of numbers in these.
        width: How many columns the table has; 0 where they are not counted.
        names: Names of its columns; None where these are not looked for.
    """

    time: np.ndarray | None
    travel: np.ndarray
    lines: np.ndarray
    remarks: tuple[str, ...] = ()
    beside: Mapping[str, np.ndarray] = field(default_factory=dict)
    amperes: Mapping[str, float] = field(default_factory=dict)
    above: Sequence[Row] = ()
    decimal: str = "."
    width: int = 0
    names: Sequence[str] | None = None

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""
        arrays = (self.time, self.travel, self.lines, *self.beside.values())
        return sum(each.nbytes for each in arrays if each is not None)

    @property
    def stated(self) -> Preamble:
        """What the lines above the samples say."""
        return preamble_of(self.above, self.decimal, self.travel.size)


def columns_of(
    file: str | Path,
    blocks: Iterable[tuple[Sequence[int], Sequence[Row]]],
    settings: Mapping,
    channel: str = "",
) -> Columns:
    """Return the columns of a table of cells; settings and channel are as of ``read_columns``.

    Args:
        file: Named in messages.
        blocks: Lines and rows of cells, block after block, without blank rows; the first one has
            all that stands above the samples.

    Raises:
        RejectedCurveError: If a column is not there, states another unit, or has a cell that is no
            number; without a time column also if a line between its samples is blank.
    """
    blocks = iter(blocks)
    lines, rows = next(blocks, ([], []))
    head = find_head(SampleTable(file, lines, rows, settings), channel)
    parts = [_part(head, lines, rows, head.first), *(_part(head, *each) for each in blocks)]
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    travel, numbers = columns["travel"], columns["lines"]
    check_size(file, travel.size, len(head.places))
    there = np.flatnonzero(~np.isnan(travel))
    if there.size == 0:
        raise RejectedCurveError(file, f"{head.labels['travel']} has no samples")
    # Channels may differ in length: blanks at the end are its end, no missing samples.
    kept = slice(0, there[-1] + 1)
    if "time" in columns:
        kept = np.flatnonzero(~np.isnan(columns["time"][kept]))
    elif (gaps := np.flatnonzero(np.diff(numbers[kept]) > 1)).size:
        reason = (
            "stands before a line that is blank, a remark or too short; without a time column "
            "nobody knows whether it stands for a sample: delete or mend it"
        )
        raise RejectedCurveError(file, reason, line=int(numbers[gaps[0]]))
    time = columns["time"][kept] if "time" in columns else None
    beside = {kind: columns[kind][kept] for kind in BESIDE if kind in columns}
    named = {lines[row] for row in head.named}
    above = [row for i, row in enumerate(rows[: head.first]) if i not in head.named]
    if isinstance(rows, Lines):
        above = rows.above(lines[head.first], named)
    found = travel[kept], numbers[kept], head.remarks, beside, head.amperes
    names = rows[head.named[0]] if head.named else None
    return Columns(time, *found, above, settings["decimal"], head.width, names)


def _part(
    head: Head, lines: Sequence[int], rows: Sequence[Row], first: int = 0
) -> dict[str, np.ndarray]:
    """The columns of a block, and its lines, each ``(t,)``, from the row of its first sample."""
    every = rows.columns(first, head.width) if isinstance(rows, Lines) else None
    lines, rows = lines[first:], rows if every else rows[first:]
    # Where a line has its time, what is not there is missing; without, it may be no sample at all.
    least = 0 if "time" in head.places else head.places["travel"] + 1
    if not every:
        kept = [i for i, row in enumerate(rows) if len(row) >= least and not is_remark(row)]
        lines, rows = [lines[i] for i in kept], [rows[i] for i in kept]
        _check_widths(head, lines, rows)
    columns, wrong = {"lines": np.array(lines, dtype=int)}, {}
    for kind, place in head.places.items():
        cells = every[place] if every else ["".join(row[place : place + 1]) for row in rows]
        form = head.table.settings["decimal"], LARGEST_NUMBER[kind]
        columns[kind], odd = strict_numbers(cells, *form)
        if odd:
            cell, more = cells[odd[0]], f" ({len(odd)} such samples)" if len(odd) > 1 else ""
            text = f"{head.labels[kind]} is {cell.strip()[:40]!r}, {why_none(cell, *form)}{more}"
            wrong.setdefault(odd[0], text)
    if wrong:
        first = min(wrong)
        raise RejectedCurveError(head.table.file, wrong[first], line=lines[first])
    return columns


def _check_widths(head: Head, lines: Sequence[int], rows: Sequence[Row]) -> None:
    """Reject a line with more cells than names, as decimal commas make where commas separate; and
    where blanks do, also one with fewer: nobody knows which cell is blank.
    """
    width, exact = head.width, head.table.settings["delimiter"] == " "
    remedy = "see endurance.format.delimiter and endurance.format.decimal"
    for line, row in zip(lines, rows, strict=True):
        if len(row) != width and (exact or any(map(str.strip, row[width:]))):
            reason = f"{len(row)} cells where there are {width} columns; {remedy}"
            raise RejectedCurveError(head.table.file, reason, line=line)
