"""The layout of a table of unknown origin, guessed: its head and its columns.

Guessing belongs here, to propose settings that are then shown and confirmed by reading. Records are
read with explicit settings only. The size of a table is bounded before its cells are built, and the
head is guessed from the first lines and some of the others: a file may hold anything.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from itertools import pairwise, zip_longest
from pathlib import Path

import numpy as np

from breaker.reading.files.guards import MOST_COLUMNS, check_size
from breaker.reading.files.preamble import Preamble, preamble_of
from breaker.reading.files.text_cells import (
    LARGEST_NUMBER,
    MISSING,
    Lines,
    cells_of,
    is_number,
    strict_numbers,
)
from breaker.reading.files.word_meanings import places_of, split_unit, unit_of

_SAMPLE = 1_000  # lines from which the kinds of columns are guessed
_ABOVE = (10_000, 2**20)  # first lines, and signs, among which samples begin; reading looks there
_FIRST = 200  # lines, among which samples begin in most files
_BLOCK = 2_000  # lines, of which cells are built at a time
_TOGETHER = 5  # lines in a row that look like samples: there samples begin
_LONGEST_NAME = 60  # signs; no number is longer either
_VALUE = re.compile(r"[-+]?\d+(?:[.,]\d+)?\s*\S{0,5}|.*[:=]")  # "10 kHz", "Rate:": of no column


class LayoutError(ValueError):
    """A file in which no columns of numbers are found."""


@dataclass(frozen=True)
class Layout:
    """What is in a file.

    Attributes:
        settings: What was guessed of ``endurance.format``, by key.
        preamble: Cells of the lines before the samples, but for names and units.
        names: Name of each column, empty where it has none.
        units: Unit of each column as the settings call it; None where none is known.
        columns: Numbers of each column, ``(t,)``, NaN where a cell is empty or no number.
        texts: Cells of columns without any number, by place, of some of the samples.
        every: How many samples lie from one of these cells to the next.
        kind: What kind of file it is.
        file: The file.
    """

    settings: dict
    preamble: list[list[str]]
    names: list[str]
    units: list[str | None]
    columns: list[np.ndarray]
    texts: dict[int, list[str]] = field(default_factory=dict)
    every: int = 1
    kind: str = "a text"
    file: Path = Path()

    @property
    def nbytes(self) -> int:
        """Bytes of its columns."""
        return sum(each.nbytes for each in self.columns)

    @cached_property
    def stated(self) -> Preamble:
        """What the lines before the samples say."""
        decimal = self.settings.get("decimal", ".")
        return preamble_of(self.preamble, decimal, self.columns[0].size)

    @cached_property
    def _bare(self) -> list[str]:
        return [split_unit(name)[0] for name in self.names]

    def column(self, place: int) -> str | int:
        """Return how settings name a column: without its unit if possible, or by its number."""
        for names in (self._bare, self.names):
            if names[place] and names.count(names[place]) == 1:
                return names[place]
        return place + 1

    def place_of(self, column: str | int) -> int | None:
        """Return the place of a column that settings name; None where it is not one."""
        words = (column, split_unit(column)[0]) if isinstance(column, str) else (column,)
        found = (places for each in words if (places := places_of(self.names, each)))
        number = [int(column) - 1] if str(column).isdecimal() else []
        return next((places[0] for places in (*found, number) if len(places) == 1), None)


def layout_of_lines(
    file: str | Path, lines: Sequence[str], settings: Mapping, delimiter: str
) -> Layout:
    """Guess the head and the columns of a table from its lines, the sign between their cells, and
    settings: ``decimal``, and what else of them is known.

    Raises:
        LayoutError: If there are no columns of numbers.
        RejectedCurveError: If there are more columns or samples than a record has.
    """
    for number, line in enumerate(lines, start=1):
        if line.count(delimiter) >= MOST_COLUMNS:
            check_size(file, 1, len(cells_of(line, delimiter)), line=number)
    first, numeric = _first_sample(file, lines, delimiter, settings["decimal"])
    width = len(numeric)
    above = [cells_of(line, delimiter) for line in lines[:first]]
    samples = _filled(lines[first:], delimiter)
    check_size(file, len(samples), width)
    columns = _numbers(samples, delimiter, settings["decimal"], numeric)
    every = max(1, len(samples) // _SAMPLE)
    some = (cells_of(line, delimiter) for line in samples[::every])
    cells = dict(enumerate(zip_longest(*some, fillvalue="")))
    named, units_at = _head(above, width)
    names = [] if named is None else [above[named][0].lstrip("#%! "), *above[named][1:]]
    units = [split_unit(name)[1] for name in names]
    if units_at is not None:
        units = list(map(unit_of, above[units_at]))
    # Blanks that separate columns are those between the words of a text, too.
    texts = [[line.strip()] for line in lines[:first]] if delimiter == " " else above
    rest = [row for i, row in enumerate(texts) if i not in (named, units_at)]
    return Layout(
        settings=dict(settings),
        preamble=rest,
        names=[*names, *[""] * width][:width],
        units=[*units, *[None] * width][:width],
        columns=columns,
        texts={i: list(cells.get(i, ())) for i in range(width) if np.isnan(columns[i]).all()},
        every=every,
        file=Path(file),
    )


def _numbers(
    lines: Sequence[str], delimiter: str, decimal: str, numeric: Sequence[bool]
) -> list[np.ndarray]:
    """Numbers of each column, ``(t,)``, NaN where a cell is empty or no number, and in all of a
    column that is not numeric.
    """
    columns = np.full((len(numeric), len(lines)), np.nan)
    for begin in range(0, len(lines), _BLOCK):
        block = lines[begin : begin + _BLOCK]
        rows = Lines(block, range(len(block)), delimiter)
        alike = rows.columns(0, len(numeric))  # in a third of the time, where lines are
        cells_in = rows[:] if alike is None else []
        for place in np.flatnonzero(numeric):
            odd = (row[place] if place < len(row) else "" for row in cells_in)
            cells = list(odd) if alike is None else alike[place]
            values, _ = strict_numbers(cells, decimal, LARGEST_NUMBER["time"])
            columns[place, begin : begin + len(block)] = values
    return list(columns)


def _filled(lines: Iterable[str], delimiter: str) -> list[str]:
    """Lines with a cell that is not empty."""
    blank = f'{delimiter}" \t\v\f\n'
    return [line for line in lines if line.strip(blank)]


def _first_sample(
    file: str | Path, lines: Sequence[str], delimiter: str, decimal: str
) -> tuple[int, list[bool]]:
    """Line, from 0, of the first sample, and for each column whether it has numbers.

    Raises:
        LayoutError: If no column has numbers.
    """

    kinds = Kinds(decimal)

    @cache  # of a short file, all lines are looked at twice
    def kinds_in(line: str) -> list[int]:
        return [kinds[cell] for cell in cells_of(line, delimiter)]

    body = _filled(lines[len(lines) // 5 :], delimiter)
    body = list(filter(any, map(kinds_in, body[:: max(1, len(body) // _SAMPLE)])))
    columns = list(zip_longest(*body, fillvalue=0))
    numeric = [i for i, kind in enumerate(columns) if kind.count(1) > 3 * kind.count(-1)]
    usual = np.median([row.count(1) for row in body]) if body else 0
    top = lines[: _ABOVE[0]]
    most = 1 + int(np.searchsorted(np.cumsum(list(map(len, top))), _ABOVE[1]))
    for count in (min(_FIRST, most), most):  # most files have few lines above their samples
        rows = list(map(kinds_in, top[:count]))
        filled = [i for i, row in enumerate(rows) if any(row)]
        fits = [
            0 < 2 * rows[i].count(1) >= usual
            and not (-1 in rows[i] and any(rows[i][k] < 0 for k in numeric if k < len(rows[i])))
            for i in filled
        ]
        runs = np.convolve([*fits, *[False] * _TOGETHER], np.ones(_TOGETHER), "valid")
        starts = np.flatnonzero((runs[: len(fits)] >= _TOGETHER - 1) & np.array(fits, bool))
        if numeric and starts.size and starts[0] + _TOGETHER <= len(fits):
            break
    if not numeric or starts.size == 0:
        place = "" if len(rows) == len(lines) else f" in the first {len(rows):,} lines"
        reason = f"no columns of numbers are found{place}; is it a text file of measurements?"
        raise LayoutError(f"{file}: {reason}")
    return filled[starts[0]], [1 in kind for kind in columns]


class Kinds(dict):
    """What cells are by a decimal sign: 1 a number, 0 a missing sample, -1 anything else. Each cell
    is looked at once: samples of an instrument repeat themselves.

    >>> kinds = Kinds(",")
    >>> [kinds[cell] for cell in ("1,5", "nan", "1.5")]
    [1, 0, -1]
    """

    def __init__(self, decimal: str) -> None:
        super().__init__()
        self._decimal = decimal

    def __missing__(self, cell: str) -> int:
        """Look at a cell for the first time."""
        kind = 1 if len(cell) <= _LONGEST_NAME and is_number(cell, self._decimal) else -1
        self[cell] = found = 0 if cell.lower() in MISSING else kind
        return found


def _head(above: Sequence[Sequence[str]], width: int) -> tuple[int | None, int | None]:
    """Lines, from 0, of names and of units among those above the samples; None where none is."""
    filled = [i for i, row in enumerate(above) if any(row)]
    units = filled[-1] if filled and _are_units(above[filled[-1]]) else None
    candidates = filled[:-1] if units is not None else filled
    if candidates and _are_names(above[candidates[-1]], width):
        return candidates[-1], units
    for names, below in pairwise(filled) if units is None else ():  # other text is in between
        if _are_names(above[names], width) and _are_units(above[below]):
            return names, below
    return units, None  # a line of short names, such as "t;s", may look like one of units


def _are_units(row: Iterable[str]) -> bool:
    cells = [cell for cell in row if cell.strip("[]()-1")]
    return bool(cells) and sum(unit_of(cell) is not None for cell in cells) >= 2 / 3 * len(cells)


def _are_names(row: Sequence[str], columns: int) -> bool:
    cells = list(filter(None, row))
    short = all(len(cell) <= _LONGEST_NAME and not _VALUE.fullmatch(cell) for cell in cells)
    return short and columns / 2 <= len(cells) <= columns
