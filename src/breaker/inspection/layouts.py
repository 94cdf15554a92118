"""The layout of a text file of unknown origin, guessed: encoding, delimiter, head and columns.

Guessing belongs here, to propose settings that are then shown and confirmed by reading. Records are
read with explicit settings only.
"""

import csv
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path

import numpy as np
from charset_normalizer import from_bytes

from breaker.files import (
    LARGEST_NUMBER,
    MISSING,
    is_number,
    read_bytes,
    split_unit,
    strict_numbers,
    unit_of,
)

__all__ = ["Layout", "LayoutError", "guess_layout", "layout_of_rows"]

_CODES = ("gb18030", "cp1252", "shift_jis", "euc_kr", "cp1251", "cp1250")
_WORDS = re.compile("行程|位移|时间|時間|电流|速度|采样|変位|время|ход|путь")
_DELIMITERS = (";", "\t", "|", ",", " ")  # in case of doubt, the first that fits
_LOOKED_AT = 200  # lines from which the delimiter is guessed
_TOGETHER = 5  # lines in a row that look like samples: there samples begin
_LONGEST_NAME = 60  # signs
_VALUE = re.compile(r"[-+]?\d+(?:[.,]\d+)?\s*\S{0,5}|.*[:=]")  # "10 kHz", "Rate:": of no column


class LayoutError(ValueError):
    """A file in which no columns of numbers are found."""


@dataclass(frozen=True)
class Layout:
    """What is in a file.

    Attributes:
        settings: What was guessed of ``endurance.format``, by key.
        preamble: Lines before the samples, but for names and units.
        names: Name of each column, empty where it has none.
        units: Unit of each column as the settings call it; None where none is known.
        columns: Numbers of each column, ``(t,)``, NaN where a cell is empty or no number.
        texts: All cells of columns without any number, by place.
        kind: What kind of file it is.
    """

    settings: dict
    preamble: list[str]
    names: list[str]
    units: list[str | None]
    columns: list[np.ndarray]
    texts: dict[int, list[str]] = field(default_factory=dict)
    kind: str = "a text"

    def column(self, place: int) -> str | int:
        """Return how settings name a column: without its unit if possible, or by its number."""
        bare = [split_unit(name)[0] for name in self.names]
        for names in (bare, self.names):
            if names[place] and names.count(names[place]) == 1:
                return names[place]
        return place + 1


def guess_layout(file: str | Path) -> Layout:
    """Guess the layout of a text file.

    Raises:
        LayoutError: If there are no columns of numbers.
        RejectedCurveError: If the file cannot be read.

    Example:
        >>> import tempfile
        >>> rows = [f"{i / 10:.1f};{i / 7:.3f}".replace(".", ",") for i in range(50)]
        >>> with tempfile.NamedTemporaryFile("w") as file:
        ...     print("Rig 3", "Zeit;Weg", "[msec];mm", *rows, sep="\\n", file=file, flush=True)
        ...     layout = guess_layout(file.name)
        >>> layout.settings
        {'encoding': 'utf-8', 'delimiter': ';', 'decimal': ','}
        >>> layout.preamble, layout.names, layout.units
        (['Rig 3'], ['Zeit', 'Weg'], ['ms', 'mm'])
    """
    content = read_bytes(file)
    encoding = _encoding(content)
    # Damaged signs do not hide the rest; reading says where they are.
    lines = re.split(
        r"\r\n|\n|\r", content.decode(encoding, errors="replace").removeprefix("\ufeff")
    )
    delimiter, decimal = _signs(lines)
    settings = {"encoding": encoding, "delimiter": delimiter, "decimal": decimal}
    return layout_of_rows([_cells(line, delimiter) for line in lines], settings)


def layout_of_rows(rows: Sequence[Sequence[str]], settings: Mapping) -> Layout:
    """Guess the head and the columns of a table.

    Args:
        rows: Cells of each line.
        settings: ``decimal``, and what else of the settings is known.

    Raises:
        LayoutError: If there are no columns of numbers.
    """
    decimal = settings["decimal"]
    first = _first_sample(rows, decimal)
    cells = list(zip_longest(*filter(any, rows[first:]), fillvalue=""))
    columns = [strict_numbers(column, decimal, LARGEST_NUMBER["time"])[0] for column in cells]
    named, units_at = _head(rows[:first], columns)
    names = [] if named is None else rows[named]
    units = [split_unit(name)[1] for name in names]
    if units_at is not None:
        units = [unit_of(cell) for cell in rows[units_at]]
    head = {named, units_at}
    return Layout(
        settings=dict(settings),
        preamble=["; ".join(filter(None, rows[i])) for i in range(first) if i not in head],
        names=[*names, *[""] * len(columns)][: len(columns)],
        units=[*units, *[None] * len(columns)][: len(columns)],
        columns=columns,
        texts={i: list(cells[i]) for i in range(len(cells)) if np.isnan(columns[i]).all()},
    )


def _encoding(content: bytes) -> str:
    """Encoding of a text: by its mark, UTF-8 where it is that, else by what it would say."""
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "utf-16"
    try:
        content.decode("utf-8")
    except UnicodeDecodeError:
        pass
    else:
        return "utf-8"
    if (zeros := content[:2000].count(0)) > len(content[:2000]) / 4:
        return "utf-16-le" if content[1:2000:2].count(0) > zeros / 2 else "utf-16-be"
    # Lines of numbers tell nothing.
    telling = b"\n".join(line for line in content.split(b"\n") if not line.isascii())
    for code in _CODES:  # so few signs leave doubts, but words do not
        if _WORDS.search(telling.decode(code, errors="ignore")):
            return code
    best = from_bytes(telling, cp_isolation=_CODES).best()
    alike = best.could_be_from_charset if best else []
    return next((code for code in _CODES if code in alike), "latin-1")


def _signs(lines: Sequence[str]) -> tuple[str, str]:
    """Delimiter and decimal sign with which most cells, and the fewest others, are numbers."""
    filled = [line for line in lines[len(lines) // 5 :] if line.strip()]
    some = filled[:: max(1, len(filled) // _LOOKED_AT)]
    quoted = any('"' in line for line in some)
    pairs = [(d, sign) for d in _DELIMITERS for sign in ".," if d != sign or quoted]

    def fit(pair: tuple[str, str]) -> tuple[bool, int]:
        rows = [_cells(line, pair[0]) for line in some]
        # 12,045 is one number: no column has zeros before whole numbers, but perhaps the first.
        padded = any(re.fullmatch(r"0\d+", cell) for row in rows for cell in row[1:])
        cells = [cell for row in rows for cell in row if cell.lower() not in MISSING]
        return not padded, sum(1 if is_number(cell, pair[1]) else -1 for cell in cells)

    return max(pairs, key=fit)


def _cells(line: str, delimiter: str) -> list[str]:
    """Cells of a line; where " " is the delimiter, any blanks are one."""
    if delimiter == " ":
        return line.split()
    if '"' in line:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter), [])]
    return [cell.strip() for cell in line.split(delimiter)]


def _first_sample(rows: Sequence[Sequence[str]], decimal: str) -> int:
    """Line, from 0, of the first sample.

    Raises:
        LayoutError: If no column has numbers.
    """
    kinds = [[_kind(cell, decimal) for cell in row] for row in rows]
    body = [row for row in kinds[len(rows) // 5 :] if any(row)]
    columns = list(zip_longest(*body, fillvalue=0))
    numeric = [i for i, kind in enumerate(columns) if kind.count(1) > 3 * kind.count(-1)]
    usual = np.median([row.count(1) for row in body]) if body else 0
    fits = np.array(
        [
            0 < 2 * row.count(1) >= usual and not any(row[i] < 0 for i in numeric if i < len(row))
            for row in kinds
            if any(row)
        ],
        dtype=int,
    )
    filled = np.flatnonzero([any(row) for row in kinds])
    runs = np.convolve(np.append(fits, [0] * _TOGETHER), np.ones(_TOGETHER), "valid")
    starts = np.flatnonzero((runs[: fits.size] >= _TOGETHER - 1) & (fits == 1))
    if not numeric or starts.size == 0:
        raise LayoutError("no columns of numbers are found; is it a text file of measurements?")
    return int(filled[starts[0]])


def _kind(cell: str, decimal: str) -> int:
    """1 for a number, 0 for a missing sample, -1 for anything else."""
    if cell.lower() in MISSING:
        return 0
    return 1 if is_number(cell, decimal) else -1


def _head(
    above: Sequence[Sequence[str]], columns: Sequence[np.ndarray]
) -> tuple[int | None, int | None]:
    """Lines, from 0, of names and of units among those above the samples; None where none is."""
    filled = [i for i, row in enumerate(above) if any(row)]
    units = filled[-1] if filled and _are_units(above[filled[-1]]) else None
    candidates = filled[:-1] if units is not None else filled
    if candidates and _are_names(above[candidates[-1]], len(columns)):
        return candidates[-1], units
    # A line of short names, such as "t;s", may look like one of units.
    return (units, None) if units is not None else (None, None)


def _are_units(row: Iterable[str]) -> bool:
    cells = [cell for cell in row if cell.strip("[]()-1")]
    return bool(cells) and sum(unit_of(cell) is not None for cell in cells) >= 2 / 3 * len(cells)


def _are_names(row: Sequence[str], columns: int) -> bool:
    cells = list(filter(None, row))
    short = all(len(cell) <= _LONGEST_NAME and not _VALUE.fullmatch(cell) for cell in cells)
    return short and columns / 2 <= len(cells) <= columns
