"""Split lines of a text into cells, and read columns of cells as numbers, strictly.

Only plain decimal numbers are accepted: Python's ``float`` also accepts ``1_000``, digits of any
script and ``inf``, which no instrument writes, but a damaged file may contain.
"""

import csv
import re
from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from breaker.records.words import BESIDE, WORDS

LARGEST_NUMBER = {"time": 1e16, "travel": 1e9, **dict.fromkeys(BESIDE, 1e40)}
"""Largest time (since 1970 it is 2e15 microseconds) and largest readings. Some instruments write
9.9e37 for the resistance of an open contact."""

NOT_A_NUMBER = (
    "which is not a number: export plain decimal numbers without separators of thousands, empty "
    "cells for missing samples, and nothing below; see endurance.format.decimal"
)
"""Reason to reject a cell, and the remedy."""

MISSING = frozenset(["", "nan", "na", "n/a", "#n/a", "-", "--", "---"])
"""Contents of the cell of a missing sample, in lower case."""

_COMMENT = re.compile(r"^([#%!]|//)\s+")  # the sign is not a cell in a line of names
_BEFORE_UNIT = re.compile(r"(?<=[^\s\])])\s+(?=[\[(])")  # the blank in `Travel (mm)`
_SPECIAL = '"([#!%/'  # signs that give a line a special meaning
_STATES = {word: float(state) for state, words in enumerate(WORDS["states"]) for word in words}
# Possessive quantifiers avoid a time that grows with the square of the number of digits.
_NUMBER = re.compile(r"[-+]?(?:[0-9]++\.?[0-9]*+|\.[0-9]++)(?:[eE][-+]?[0-9]++)?")


def cells_of(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line; with the delimiter " ", several blanks count as one.

    Lines are split one by one: an unpaired quotation mark, such as an inch, must not join lines.
    """
    line = line.strip() if delimiter == " " else line.rstrip("\n")
    if delimiter == " ":
        line = _BEFORE_UNIT.sub("", _COMMENT.sub(r"\1", line))
    if '"' in line and line.count('"') % 2 == 0:
        cells = next(
            csv.reader([line.replace("\r", " ")], delimiter=delimiter, skipinitialspace=True), []
        )
    else:
        cells = line.split(None if delimiter == " " else delimiter)
    return [cell.strip() for cell in cells]


def columns_of_alike(lines: Sequence[str], width: int, delimiter: str) -> list[list[str]] | None:
    """Return columns of cells of plain lines, split in one step; None if a line is not plain."""
    joined = f"{delimiter}\0{delimiter}".join(lines)  # no text has a zero byte
    if any(sign in joined for sign in _SPECIAL):
        return None
    cells, step = joined.split(None if delimiter == " " else delimiter), width + 1
    ends = cells[width::step]
    if len(cells) != step * len(lines) - 1 or ends.count("\0") != len(ends):
        return None
    return [cells[place::step] for place in range(width)]


def is_remark(row: Sequence[str]) -> bool:
    """Return whether a row begins with `#`, `!`, `//` or, unless it is a unit, `%`."""
    cell = row[0].strip() if row else ""
    return cell.startswith(("#", "!", "//")) or (cell.startswith("%") and cell != "%")


def strict_numbers(cells: Sequence[str], decimal: str) -> tuple[np.ndarray, list[int]]:
    """Return cells of a column as numbers, ``(t,)``, NaN where missing, and the places of other
    cells. Words for two states, such as ON and OFF, become 1 and 0.
    """
    joined = "\n".join(cells)
    if joined.isascii() and "_" not in joined and (decimal == "." or "." not in joined):
        same = cells if decimal == "." else joined.replace(decimal, ".").split("\n")
        with suppress(ValueError):  # a missing sample, a state, or another text
            values = np.fromiter(map(float, same), float, len(cells))
            if np.isfinite(values).all():
                return values, []
    bare = [cell.strip() for cell in cells]
    if (states := {cell.lower() for cell in {*bare}} - MISSING) and states <= _STATES.keys():
        return np.array([_STATES.get(cell.lower(), np.nan) for cell in bare]), []
    numbers = {cell: float(cell.replace(decimal, ".")) for cell in bare if is_number(cell, decimal)}
    wrong = [i for i, c in enumerate(bare) if c not in numbers and c.lower() not in MISSING]
    return np.array([numbers.get(cell, np.nan) for cell in bare]), wrong


def is_number(cell: str, decimal: str) -> bool:
    """Return whether a cell is a plain decimal number; with a decimal comma, a cell with a point is
    not, since the point may separate thousands.
    """
    plain = decimal == "." or "." not in cell
    return plain and bool(_NUMBER.fullmatch(cell.strip().replace(decimal, ".")))
