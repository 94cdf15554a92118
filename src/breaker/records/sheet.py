"""The table of samples of a record: where it begins, and its columns of time and travel.

Preambles differ from file to file, so the line with the names is found by the names, and a table
without names by its numbers. A format returns a record as ``Columns``, and an unknown file as
``Labelled`` columns or as ``Tables`` of cells.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from breaker.common.lazy_numpy import np
from breaker.common.numerals import in_digits
from breaker.records.cells import (
    LARGEST_NUMBER,
    MISSING,
    Lines,
    is_number,
    strict_numbers,
    why_none,
)
from breaker.records.files import RejectedCurveError, check_size
from breaker.records.header import Preamble, preamble_of
from breaker.records.words import (
    BESIDE,
    amperes_of,
    check_unit,
    label_of,
    listed,
    place_of,
    places_of,
    split_unit,
    unit_of,
    wanted_columns,
)

Row = Sequence[str]

_LONGEST = 10_000  # rows in which names are looked for
_RUN = 20  # rows of which most are numbers, where a table without names begins


@dataclass(frozen=True)
class Columns:
    """A record as it stands in its file.

    Attributes:
        time: Times, ``(t,)``; None where the file has none.
        travel: Readings, ``(t,)``, NaN where one is missing.
        lines: Line of each in the file, ``(t,)``.
        remarks: What is doubtful about the file, in words.
        beside: Those of ``word_meanings.BESIDE`` that are wanted, by kind, ``(t,)``, NaN where
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


class Labelled(NamedTuple):
    """Columns of which a file says names and units.

    Attributes:
        settings: What it tells of ``endurance.format``, by key.
        preamble: Cells of what it states beside, line by line.
        names: Of the columns.
        units: As the settings call them; None where none is known.
        columns: Numbers of each, ``(t,)``.
    """

    settings: dict
    preamble: list[list[str]]
    names: list[str]
    units: list[str | None]
    columns: list[np.ndarray]


class Tables(NamedTuple):
    """Tables of cells, of which it is to be guessed where names and samples are.

    Attributes:
        lines: Of each table, cells with tabs between.
        reason: Why the file is refused where none of them has columns of numbers.
    """

    lines: Iterable[Sequence[str]]
    reason: str


@dataclass(frozen=True)
class _SampleTable:
    """The first rows of a file, and what is said of it.

    Attributes:
        file: Named in messages.
        lines: Line of each row in the file.
        rows: Cells of the rows; blank ones are left out.
        settings: The section ``endurance.format``, complete.
    """

    file: str | Path
    lines: Sequence[int]
    rows: Sequence[Row]
    settings: Mapping

    @property
    def first_rows(self) -> Iterator[Row]:
        """Those in which names are looked for."""
        return islice(self.rows, _LONGEST)

    def cell(self, row: int | None, place: int) -> str:
        """Return a cell; it is empty where there is none."""
        return "" if row is None else "".join(self.rows[row][place : place + 1]).strip()

    def is_number(self, cell: str) -> bool:
        """Say whether a cell is a plain number."""
        return is_number(cell, self.settings["decimal"])

    def numeric(self, row: Row, places: Mapping[str, int]) -> bool:
        """Say whether a row has numbers in those of these places that are time and travel."""
        own = _without_beside(places).values()
        return all(self.is_number("".join(row[place : place + 1])) for place in own)

    def texts(self, row: Row) -> tuple[bool, ...]:
        """Say which cells of a row are neither blank nor numbers."""
        return tuple(cell.strip() != "" and not self.is_number(cell) for cell in row)


@dataclass(frozen=True)
class _Head:
    """What stands above the samples.

    Attributes:
        table: Where it stands.
        first: Row of the first sample.
        named: Rows of names and of units above it, where names are wanted.
        places: Place of each column in a row, from 0, by its kind: see
            ``word_meanings.wanted_columns``.
        labels: What messages call these columns.
        amperes: As of ``Columns``.
        width: Cells that a row may have.
        remarks: What is doubtful, in words.
    """

    table: _SampleTable
    first: int
    named: Sequence[int]
    places: Mapping[str, int]
    labels: Mapping[str, str]
    amperes: Mapping[str, float]
    width: int
    remarks: tuple[str, ...]


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
    head = _find_head(_SampleTable(file, lines, rows, settings), channel)
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
    head: _Head, lines: Sequence[int], rows: Sequence[Row], first: int = 0
) -> dict[str, np.ndarray]:
    """The columns of a block, and its lines, each ``(t,)``, from the row of its first sample."""
    every = rows.columns(first, head.width) if isinstance(rows, Lines) else None
    lines, rows = lines[first:], rows if every else rows[first:]
    # Where a line has its time, what is not there is missing; without, it may be no sample at all.
    least = 0 if "time" in head.places else head.places["travel"] + 1
    if not every:
        kept = [i for i, row in enumerate(rows) if len(row) >= least and not _is_remark(row)]
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


def _check_widths(head: _Head, lines: Sequence[int], rows: Sequence[Row]) -> None:
    """Reject a line with more cells than names, as decimal commas make where commas separate; and
    where blanks do, also one with fewer: nobody knows which cell is blank.
    """
    width, exact = head.width, head.table.settings["delimiter"] == " "
    remedy = "see endurance.format.delimiter and endurance.format.decimal"
    for line, row in zip(lines, rows, strict=True):
        if len(row) != width and (exact or any(map(str.strip, row[width:]))):
            reason = f"{len(row)} cells where there are {width} columns; {remedy}"
            raise RejectedCurveError(head.table.file, reason, line=line)


def _find_head(table: _SampleTable, channel: str) -> _Head:
    """Find the head of a table; a channel is the column of travel if it is not that of settings.

    Raises:
        RejectedCurveError: If a column is not there, or states another unit than the settings.
    """
    rows = table.rows
    if not rows:
        raise RejectedCurveError(table.file, "is empty")
    wanted = wanted_columns(table.first_rows, table.settings, channel)
    timeless = _is_timeless(table)
    if timeless:
        del wanted["time"]
    numbers = {kind: column - 1 for kind, column in wanted.items() if isinstance(column, int)}
    unnamed = len(numbers) == len(wanted)
    if unnamed:
        first = _first_run(table, numbers)
        names, units = _above(table, first, numbers)
        places, width = numbers, max(map(len, rows[first : first + _RUN]))
    else:
        names = _names_row(table, wanted)
        line = table.lines[names]
        places = {k: place_of(table.file, rows[names], c, line=line) for k, c in wanted.items()}
        first, units = _after_names(table, names, places)
        width = max(len(rows[names]), len(rows[units]) if units else 0)
    if first >= len(rows):
        reason = f"ends before its first sample, with line {table.lines[-1]}"
        raise RejectedCurveError(table.file, reason)
    labels = {kind: label_of(column) for kind, column in wanted.items()}
    remarks = _check_units(table, names, units, places, labels)
    if timeless:
        time, rate = table.settings["time_column"], in_digits(table.settings["rate"], 6)
        remarks += (f"there is no column {time!r}: times are those of the rate, {rate} kHz",)
    named = [] if unnamed else [row for row in (names, units) if row is not None]
    amperes = {
        kind: amperes_of(table.cell(names, place), table.cell(units, place))
        for kind, place in places.items()
        if kind in BESIDE
    }
    return _Head(table, first, named, places, labels, amperes, width, remarks)


def _is_remark(row: Row) -> bool:
    """Say whether a row is a remark: it begins with `#`, `!`, `//` or, not for a unit, `%`."""
    cell = row[0].strip()
    return cell.startswith(("#", "!", "//")) or (cell.startswith("%") and cell != "%")


def _is_timeless(table: _SampleTable) -> bool:
    """Whether a rate stands for a column of the time that is in no row."""
    time, rate = table.settings["time_column"], table.settings["rate"]
    if not rate or not isinstance(time, str):
        return False
    return not any(places_of(row, time) for row in table.first_rows)


def _names_row(table: _SampleTable, wanted: Mapping[str, str | int]) -> int:
    """The first row that has the names, if possible with numbers below it."""
    candidates = []
    for i, row in enumerate(table.first_rows):
        found = {kind: places_of(row, column) for kind, column in wanted.items()}
        if all(found.values()):
            places = {kind: where[0] for kind, where in found.items()}
            if any(table.numeric(below, places) for below in table.rows[i + 1 : i + 4]):
                return i
            candidates.append(i)
    if not candidates:
        raise RejectedCurveError(table.file, _no_names(table, wanted))
    return candidates[0]


def _no_names(table: _SampleTable, wanted: Mapping[str, str | int]) -> str:
    """Why no row has the names."""
    rows, delimiter = list(table.first_rows), table.settings["delimiter"]
    lacking = [c for c in wanted.values() if not any(places_of(row, c) for row in rows)]
    columns = " and ".join(map(label_of, lacking or wanted.values()))
    for sign in ",;\t| ":
        split = ([cell.strip('"') for cell in delimiter.join(row).split(sign)] for row in rows)
        if sign != delimiter and any(
            all(places_of(cells, column) for column in wanted.values()) for cells in split
        ):
            return f"no line has {columns}; is endurance.format.delimiter {sign!r}?"
    reason = f"no line has {columns}"
    numeric = (i for i, row in enumerate(rows) if 2 * sum(map(table.is_number, row)) > len(row))
    if first := next(filter(None, numeric), None):
        above = range(first - 1, max(0, first - 2) - 1, -1)
        filled = {i: list(filter(str.strip, rows[i])) for i in above}
        names = max(above, key=lambda i: (not all(map(unit_of, filled[i])), len(filled[i])))
        reason += f"; line {table.lines[names]}, above the numbers, has {listed(rows[names])}"
    return reason + "; see endurance.format, also its encoding, or give numbers of columns"


def _first_run(table: _SampleTable, places: Mapping[str, int], after: int = 0) -> int:
    """The first row, after as many, with numbers in these places, of rows that mostly have them and
    are alike.
    """
    for i, row in enumerate(table.first_rows):
        if i < after or not table.numeric(row, places):
            continue
        run = table.rows[i : i + _RUN]
        usual = Counter(map(table.texts, run)).most_common(1)[0][0]
        numeric = sum(table.numeric(below, places) for below in run)
        if table.texts(row) == usual and numeric >= 0.75 * len(run):
            return i
    columns = " and ".join(str(place + 1) for place in places.values())
    reason = f"has no numbers in column {columns}; see endurance.format, also delimiter and decimal"
    raise RejectedCurveError(table.file, reason)


def _above(
    table: _SampleTable, first: int, places: Mapping[str, int]
) -> tuple[int | None, int | None]:
    """Rows of names and of units above the first sample, where there are such."""
    if first == 0:
        return None, None
    own = _without_beside(places).values()
    units = all(unit_of(table.cell(first - 1, place)) for place in own)
    return (first - 2 if first > 1 else None, first - 1) if units else (first - 1, None)


def _after_names(
    table: _SampleTable, names: int, places: Mapping[str, int]
) -> tuple[int, int | None]:
    """Rows of the first sample and of the units, if there is one, below a row of names."""
    rows, units = table.rows, None
    below = (i for i in range(names + 1, len(rows)) if not _is_remark(rows[i]))
    first = next(below, len(rows))
    if first < len(rows) and _are_units(table, first, places):
        first, units = next(below, len(rows)), first
    if first < len(rows) and _is_text(table, rows[first], len(rows[names])):
        with suppress(RejectedCurveError):  # text stands between the names and the samples
            first = _first_run(table, places, first)
    return first, units


def _is_text(table: _SampleTable, row: Row, columns: int) -> bool:
    """Whether a row is a line of text rather than a damaged sample: it has few cells, no number."""
    filled = list(filter(str.strip, row))
    return 2 * len(filled) <= columns and not any(map(table.is_number, filled))


def _are_units(table: _SampleTable, row: int, places: Mapping[str, int]) -> bool:
    """Whether a row below the names is none of samples: it has a text, and no number."""
    cells = [table.cell(row, place) for place in places.values()]
    if all(cell.lower() in MISSING for cell in cells):  # the other columns decide
        cells = [cell.strip() for cell in table.rows[row]]
    texts = any(cell.lower() not in MISSING for cell in cells)
    return texts and not any(map(table.is_number, cells))


def _check_units(
    table: _SampleTable,
    names: int | None,
    units: int | None,
    places: Mapping[str, int],
    labels: Mapping[str, str],
) -> tuple[str, ...]:
    """Reject a column that states another unit than the settings; remark on an unknown one."""
    file, settings = table.file, table.settings
    remarks: tuple[str, ...] = ()
    for kind, place in _without_beside(places).items():
        text, row = table.cell(units, place), units
        if not text:
            text, row = split_unit(table.cell(names, place))[1] or "", names
        line = None if row is None else table.lines[row]
        remarks += check_unit(file, (kind, labels[kind]), text, settings, line)
    return remarks


def _without_beside(places: Mapping[str, int]) -> dict[str, int]:
    """Those of time and travel, which alone have units and a number in every row."""
    return {kind: place for kind, place in places.items() if kind not in BESIDE}
