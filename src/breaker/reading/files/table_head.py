"""Where the samples of a table begin, which columns they are in, and the units that it states.

Preambles differ from file to file, so the line with the names is found by the names, and a table
without names by its numbers. An explicit ``skip_rows`` is taken at its word.
"""

from bisect import bisect_left
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from breaker.common.numerals import in_digits
from breaker.reading.files.column_names import (
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
from breaker.reading.files.guards import RejectedCurveError
from breaker.reading.files.text_cells import MISSING, is_number

Row = Sequence[str]

_LONGEST = 10_000  # rows in which names are looked for
_RUN = 20  # rows of which most are numbers, where a table without names begins


@dataclass(frozen=True)
class SampleTable:
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
class Head:
    """What stands above the samples.

    Attributes:
        table: Where it stands.
        first: Row of the first sample.
        named: Rows of names and of units above it, where names are wanted.
        places: Place of each column in a row, from 0, by its kind: see
            ``column_names.wanted_columns``.
        labels: What messages call these columns.
        amperes: As of ``Columns``.
        width: Cells that a row may have.
        remarks: What is doubtful, in words.
    """

    table: SampleTable
    first: int
    named: Sequence[int]
    places: Mapping[str, int]
    labels: Mapping[str, str]
    amperes: Mapping[str, float]
    width: int
    remarks: tuple[str, ...]


def find_head(table: SampleTable, channel: str) -> Head:
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
    unnamed, skip = len(numbers) == len(wanted), table.settings["skip_rows"]
    names = None if skip is None else _explicit_row(table, skip)
    if unnamed and (names is None or table.numeric(rows[names], numbers)):
        first = _first_run(table, numbers) if names is None else names
        names, units = _above(table, first, numbers)
        places, width = numbers, max(map(len, rows[first : first + _RUN]))
    else:
        names = _names_row(table, wanted) if names is None else names
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
    return Head(table, first, named, places, labels, amperes, width, remarks)


def is_remark(row: Row) -> bool:
    """Say whether a row is a remark: it begins with `#`, `!`, `//` or, not for a unit, `%`."""
    cell = row[0].strip()
    return cell.startswith(("#", "!", "//")) or (cell.startswith("%") and cell != "%")


def _is_timeless(table: SampleTable) -> bool:
    """Whether a rate stands for a column of the time that is in no row."""
    time, rate = table.settings["time_column"], table.settings["rate"]
    if not rate or not isinstance(time, str):
        return False
    return not any(places_of(row, time) for row in table.first_rows)


def _explicit_row(table: SampleTable, skip: int) -> int:
    """The row of the line after those that are skipped."""
    row = bisect_left(table.lines, skip + 1)
    if row == len(table.lines):
        reason = f"ends before line {skip + 1}, where endurance.format.skip_rows puts the names"
        raise RejectedCurveError(table.file, reason)
    if table.lines[row] != skip + 1:
        reason = "is blank, but endurance.format.skip_rows puts the names there"
        raise RejectedCurveError(table.file, reason, line=skip + 1)
    return row


def _names_row(table: SampleTable, wanted: Mapping[str, str | int]) -> int:
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


def _no_names(table: SampleTable, wanted: Mapping[str, str | int]) -> str:
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


def _first_run(table: SampleTable, places: Mapping[str, int], after: int = 0) -> int:
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
    table: SampleTable, first: int, places: Mapping[str, int]
) -> tuple[int | None, int | None]:
    """Rows of names and of units above the first sample, where there are such."""
    if first == 0:
        return None, None
    units = table.settings["units_row"]
    if units is None:
        own = _without_beside(places).values()
        units = all(unit_of(table.cell(first - 1, place)) for place in own)
    return (first - 2 if first > 1 else None, first - 1) if units else (first - 1, None)


def _after_names(
    table: SampleTable, names: int, places: Mapping[str, int]
) -> tuple[int, int | None]:
    """Rows of the first sample and of the units, if there is one, below a row of names."""
    rows, units = table.rows, table.settings["units_row"]
    below = (i for i in range(names + 1, len(rows)) if not is_remark(rows[i]))
    first = next(below, len(rows))
    if units is None and first < len(rows):
        units = _are_units(table, first, places)
    first, units = (next(below, len(rows)), first) if units and first < len(rows) else (first, None)
    if first < len(rows) and _is_text(table, rows[first], len(rows[names])):
        with suppress(RejectedCurveError):  # text stands between the names and the samples
            first = _first_run(table, places, first)
    return first, units


def _is_text(table: SampleTable, row: Row, columns: int) -> bool:
    """Whether a row is a line of text rather than a damaged sample: it has few cells, no number."""
    filled = list(filter(str.strip, row))
    return 2 * len(filled) <= columns and not any(map(table.is_number, filled))


def _are_units(table: SampleTable, row: int, places: Mapping[str, int]) -> bool:
    """Whether a row below the names is none of samples: it has a text, and no number."""
    cells = [table.cell(row, place) for place in places.values()]
    if all(cell.lower() in MISSING for cell in cells):  # the other columns decide
        cells = [cell.strip() for cell in table.rows[row]]
    texts = any(cell.lower() not in MISSING for cell in cells)
    return texts and not any(map(table.is_number, cells))


def _check_units(
    table: SampleTable,
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
        if row is not None and (table.is_number(text) or (settings["units_row"] and not text)):
            reason = f"the unit of {labels[kind]} is {text!r}; see endurance.format.units_row"
            raise RejectedCurveError(file, reason, line=table.lines[row])
        if not text:
            text, row = split_unit(table.cell(names, place))[1] or "", names
        line = None if row is None else table.lines[row]
        remarks += check_unit(file, (kind, labels[kind]), text, settings, line)
    return remarks


def _without_beside(places: Mapping[str, int]) -> dict[str, int]:
    """Those of time and travel, which alone have units and a number in every row."""
    return {kind: place for kind, place in places.items() if kind not in BESIDE}
