"""Cells as numbers, strictly: what is not a plain decimal number is none, and is said to be none.

Python's ``float`` takes ``1_000``, digits of any script and ``inf``; an instrument writes none of
these, but a damaged file may.
"""

import re
from collections.abc import Sequence

import numpy as np

LARGEST_NUMBER = {"time": 1e16, "travel": 1e9, "contact": 1e40, "trigger": 1e40, "motor": 1e40}
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
