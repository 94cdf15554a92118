"""Numbers in texts: written for people, never with a power of ten, and as they order names."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from breaker.common.lazy_numpy import np


def in_digits(value: float, digits: int, *, sign: bool = False) -> str:
    """Write a number with so many significant digits, as people write it.

    >>> in_digits(134.2, 2, sign=True), in_digits(0.000012345, 2), in_digits(178.0, 4)
    ('+130', '0.000012', '178')
    """
    more = {"unique": False, "fractional": False, "trim": "-", "sign": sign}
    return np.format_float_positional(value, precision=digits, **more)


def first_of(names: Sequence[str], most: int) -> str:
    """List names, at most so many, and count the others, as in "a, b and 1 more"."""
    more = len(names) - most
    return ", ".join(names[:most]) + (f" and {more} more" if more > 0 else "")


def in_p(value: float) -> str:
    """Write a p-value; below 0.0001 its digits say no more."""
    return "p < 0.0001" if value < 1e-4 else f"p = {in_digits(value, 2)}"


def natural(path: str | Path) -> list[tuple[int, str]]:
    """Return a key by which 9 comes before 10."""
    parts = re.split("([0-9]+)", str(path))
    return [(int(part), "") if part.isdecimal() else (0, part) for part in parts]
