"""The cells of a text: its lines split into them, and each as a number, strictly.

Lines of samples that are alike are split together, column by column, in a third of the time. What
is not a plain decimal number is none: Python's ``float`` takes ``1_000``, digits of any script and
``inf``; an instrument writes none of these, but a damaged file may.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence

from breaker.common.lazy_numpy import np
from breaker.records.lexicon import WORDS

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

_STATES = {word: float(state) for state, words in enumerate(WORDS["states"]) for word in words}
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


def columns_of_alike(lines: Sequence[str], width: int, delimiter: str) -> list[list[str]] | None:
    """Return the columns of cells of lines, or None where one has another number of cells, or may
    be a remark.

    >>> columns_of_alike(["1,2", "3,4"], 2, ","), columns_of_alike(["1,2", "3"], 2, ",")
    ([['1', '3'], ['2', '4']], None)
    """
    joined = f"{delimiter}\0{delimiter}".join(lines)  # no text has a zero byte
    if '"' in joined:  # cells that are quoted without need
        joined = _unquoted(f"{delimiter}{joined}{delimiter}", delimiter)[1:-1]
    if any(sign in joined for sign in _NOT_ALIKE):
        return None
    cells, step = joined.split(None if delimiter == " " else delimiter), width + 1
    ends = cells[width::step]
    if len(cells) != step * len(lines) - 1 or ends.count("\0") != len(ends):
        return None
    return [cells[place::step] for place in range(width)]


def _unquoted(text: str, sign: str) -> str:
    """A text without quotation marks, if each pair of them holds a whole cell without a delimiter;
    as it was, if not.
    """
    parts = text.split('"')
    around = set(parts[::2])  # hardly any two differ where all cells are quoted
    whole = all(part.endswith(sign) and part.startswith(sign) for part in around)
    return "".join(parts) if whole and sign not in "\0".join(parts[1::2]) else text


def is_remark(row: Sequence[str]) -> bool:
    """Say whether a row is a remark: it begins with `#`, `!`, `//` or, not for a unit, `%`."""
    cell = row[0].strip() if row else ""
    return cell.startswith(("#", "!", "//")) or (cell.startswith("%") and cell != "%")


def strict_numbers(cells: Sequence[str], decimal: str) -> tuple[np.ndarray, list[int]]:
    """Return cells of a column as numbers, ``(t,)``, NaN where missing, and the places of what is
    no number. A column of words for two states, such as ON and OFF, is one of 1 and 0.

    >>> values, wrong = strict_numbers(["1,5", "", "1_000"], ",")
    >>> values.tolist(), wrong
    ([1.5, nan, nan], [2])
    >>> strict_numbers(["OFF", "on"], ".")[0].tolist()
    [0.0, 1.0]
    """
    joined = "\n".join(cells)
    plain = joined.isascii() and "_" not in joined and (decimal == "." or "." not in joined)
    same = cells if decimal == "." else joined.replace(decimal, ".").split("\n")
    if plain and len(same) == len(cells):
        try:
            values = np.fromiter(map(float, same), float, len(cells))
        except ValueError:
            pass  # a missing sample, a state, or no number
        else:
            if not np.isinf(values).any():
                return values, []
    bare = [cell.strip() for cell in cells]
    if (states := {cell.lower() for cell in {*bare}} - MISSING) and states <= _STATES.keys():
        return np.array([_STATES.get(cell.lower(), np.nan) for cell in bare]), []
    values, wrong = np.full(len(cells), np.nan), []
    for i, cell in enumerate(bare):
        if is_number(cell, decimal):
            values[i] = float(cell.replace(decimal, "."))
        elif cell.lower() not in MISSING:
            wrong.append(i)
    return values, wrong


def why_none(cell: str) -> str:
    """Return why a cell is no number, and what to do about it.

    >>> why_none("1_000")
    'which is not a number: export without separators of thousands'
    """
    cell = cell.strip()[:100]
    hints = (hint for like, hint in _HINTS.items() if re.fullmatch(like, cell, re.IGNORECASE))
    return f"which is not a number: {next(hints, _REMEDY)}"


def is_number(cell: str, decimal: str) -> bool:
    """Say whether a cell is a plain decimal number. A point that is not the decimal sign makes it
    none: it may separate thousands.
    """
    plain = decimal == "." or "." not in cell
    return plain and bool(_NUMBER.fullmatch(cell.strip().replace(decimal, ".")))
