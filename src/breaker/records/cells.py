"""The cells of a text: its lines split into them, and each as a number, strictly.

A line is split where it is looked at; lines of samples that are alike are split together, column by
column. What is not a plain decimal number is none, and is said to be none: Python's ``float`` takes
``1_000``, digits of any script and ``inf``; an instrument writes none of these, but a damaged file
may.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence

from breaker.common.lazy_numpy import np

_COMMENT = re.compile(r"^([#%!]|//)\s+")  # its sign is no cell of a line of names
# The blank before a unit in brackets that follows a name, where blanks separate.
_BEFORE_UNIT = re.compile(r"(?<=[^\s\])])\s+(?=[\[(])")
_NOT_ALIKE = '"([#!%/'  # signs of which a line has its own meaning

LARGEST_NUMBER = {"time": 1e16, "travel": 1e9}
LARGEST_NUMBER |= dict.fromkeys(("contact", "current", "trigger", "motor"), 1e40)
"""Beyond it is no time (those since 1970 are 2e15 microseconds), and no reading of a sensor. Some
instruments write 9.9e37 for the resistance of an open contact."""

MISSING = frozenset(["", "nan", "na", "n/a", "#n/a", "-", "--", "---"])
"""What stands in the cell of a missing sample, in lower case."""

# Never tries fewer digits than there are: that would take the square of their number.
_NUMBER = re.compile(r"[-+]?(?:[0-9]++\.?[0-9]*+|\.[0-9]++)(?:[eE][-+]?[0-9]++)?")
_HINTS = {
    r"[-+]?0[xX].*": "export decimal numbers, not hexadecimal ones",
    r"[-+]?[0-9][0-9.,]*(?:[_'’\s][0-9.,]+)+": "export without separators of thousands",
    r"[-+]?[0-9.,]*[.,][0-9.,]*(?:[eE].*)?": (
        "see endurance.format.decimal, and export without separators of thousands"
    ),
    r"[-+]?inf(?:inity)?": "leave the cell empty where the instrument overflowed",
    r"(?s).*[0-9]:[0-9]{2}.*": (
        "export seconds, or set endurance.format.time_column: null and the rate"
    ),
    r"[-+−﹣－]?[\d.,٫]+": "write it with the digits 0 to 9 and the sign -",
}
_REMEDY = (
    "leave the cell empty where a sample is missing; a line of remarks begins with #, and what "
    "stands below the samples is to be deleted"
)


class Lines(Sequence):
    """Rows of cells: the lines of a text that are not blank.

    Args:
        every: All lines of the text, or of a part of it.
        kept: Places of those that are not blank.
        delimiter: The sign between cells; where it is " ", any blanks are one.
    """

    def __init__(self, every: Sequence[str], kept: Sequence[int], delimiter: str) -> None:
        self._every, self._delimiter = every, delimiter
        self._kept = every if len(kept) == len(every) else [every[i] for i in kept]
        self._columns: dict[tuple[int, int], list[list[str]] | None] = {}

    def __len__(self) -> int:
        return len(self._kept)

    def __getitem__(self, place: int | slice) -> list:
        if isinstance(place, slice):
            return [cells_of(line, self._delimiter) for line in self._kept[place]]
        return cells_of(self._kept[place], self._delimiter)

    def above(self, line: int, others: Sequence[int]) -> list[list[str]]:
        """Return the cells of what stands above a line, counted from 1, but for other lines; where
        blanks separate, each is one cell, as blanks are between words, too.
        """
        some = (text for i, text in enumerate(self._every[: line - 1], 1) if i not in others)
        if self._delimiter == " ":
            return [[text.strip()] for text in some]
        return [cells_of(text, self._delimiter) for text in some]

    def columns(self, first: int, width: int) -> list[list[str]] | None:
        """Return the columns of cells of the rows from the first on, or None where one has another
        number of cells, or may be a remark.
        """
        if (first, width) not in self._columns:
            self._columns[first, width] = self._split(self._kept[first:], width)
        return self._columns[first, width]

    def _split(self, lines: Sequence[str], width: int) -> list[list[str]] | None:
        sign = self._delimiter
        joined = f"{sign}\0{sign}".join(lines)  # no text has a zero byte
        if '"' in joined:  # cells that are quoted without need
            joined = _unquoted(f"{sign}{joined}{sign}", sign)[1:-1]
        if any(each in joined for each in _NOT_ALIKE):
            return None
        cells, step = joined.split(None if sign == " " else sign), width + 1
        ends = cells[width::step]
        if len(cells) != step * len(lines) - 1 or ends.count("\0") != len(ends):
            return None
        return [cells[place::step] for place in range(width)]


def _unquoted(text: str, sign: str) -> str:
    """A text without quotation marks, if each pair of them holds a whole cell without a delimiter;
    as it was, if not.
    """
    parts = text.split('"')
    beside = set(parts[::2])  # hardly any two differ where all cells are quoted
    whole = all(each.endswith(sign) and each.removeprefix("\n").startswith(sign) for each in beside)
    return "".join(parts) if whole and sign not in "\0".join(parts[1::2]) else text


def cells_of(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line; where " " is the delimiter, any blanks are one.

    Each line is split for itself: an odd quotation mark, such as that of an inch, must not join
    lines, or their numbers shift.

    >>> cells_of('"1,5", 2', ","), cells_of("Travel (mm)  Time", " ")
    (['1,5', '2'], ['Travel(mm)', 'Time'])
    """
    line = line.strip() if delimiter == " " else line.rstrip("\n")
    if delimiter == " ":
        line = _COMMENT.sub(r"\1", line)
        line = _BEFORE_UNIT.sub("", line) if "(" in line or "[" in line else line
    cells = line.split(None if delimiter == " " else delimiter)
    if '"' in line and line.count('"') % 2 == 0:
        reader = csv.reader([line], delimiter=delimiter, skipinitialspace=True)
        cells = next(reader, [])
    if " " not in line and line.isascii() and line.isprintable():
        return cells  # no blank is in it, as in most lines of samples
    return [cell.strip() for cell in cells]


def strict_numbers(
    cells: Sequence[str], decimal: str, largest: float
) -> tuple[np.ndarray, list[int]]:
    """Return cells of a column as numbers, ``(t,)``, NaN where missing, and the places of what is
    no number, or one beyond the largest of a reading.

    Example:
        >>> values, wrong = strict_numbers(["1,5", "", "1_000"], ",", 1e9)
        >>> values.tolist(), wrong
        ([1.5, nan, nan], [2])
    """
    joined = "\n".join(cells)
    plain = joined.isascii() and "_" not in joined and (decimal == "." or "." not in joined)
    same = cells if decimal == "." else joined.replace(decimal, ".").split("\n")
    if plain and len(same) == len(cells):
        try:
            values = np.fromiter(map(float, same), float, len(cells))
        except ValueError:
            pass  # a missing sample, or no number
        else:
            if not (np.abs(values) > largest).any():
                return values, []
    values, wrong = np.full(len(cells), np.nan), []
    for i, cell in enumerate(map(str.strip, cells)):
        if cell.lower() in MISSING:
            continue
        number = float(cell.replace(decimal, ".")) if is_number(cell, decimal) else np.nan
        if abs(number) <= largest:
            values[i] = number
        else:
            wrong.append(i)
    return values, wrong


def are_readings(values: np.ndarray, kind: str) -> bool:
    """Say whether values ``(t,)``, NaN where missing, are none beyond the largest of a kind."""
    return bool((np.isnan(values) | (np.abs(values) <= LARGEST_NUMBER[kind])).all())


def why_none(cell: str, decimal: str, largest: float) -> str:
    """Return why a cell is no number, and what to do about it.

    >>> why_none("1_000", ".", 1e9)
    'which is not a number: export without separators of thousands'
    """
    if is_number(cell, decimal):
        return f"which is no reading: it is beyond {largest:.0e}"
    cell = cell.strip()[:100]
    hints = (hint for like, hint in _HINTS.items() if re.fullmatch(like, cell, re.IGNORECASE))
    return f"which is not a number: {next(hints, _REMEDY)}"


def is_number(cell: str, decimal: str) -> bool:
    """Say whether a cell is a plain decimal number. A point that is not the decimal sign makes it
    none: it may separate thousands.
    """
    plain = decimal == "." or "." not in cell
    return plain and bool(_NUMBER.fullmatch(cell.strip().replace(decimal, ".")))
