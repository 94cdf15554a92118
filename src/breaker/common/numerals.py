"""Numbers in texts, without powers of ten, and the natural order of names with numbers."""

import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np


def in_digits(value: float, digits: int, *, sign: bool = False) -> str:
    """Return a number with ``digits`` significant digits, without an exponent.

    >>> in_digits(134.2, 2, sign=True), in_digits(0.000012345, 2), in_digits(178.0, 4)
    ('+130', '0.000012', '178')
    """
    more = {"unique": False, "fractional": False, "trim": "-", "sign": sign}
    return np.format_float_positional(value, precision=digits, **more)


def distinct(values: Sequence[float], digits: int, *, sign: bool = False) -> list[str]:
    """Return rising numbers with enough digits to distinguish the ends, at least ``digits``.

    >>> distinct([178.21, 178.24], 4), distinct([2.0, 3.0], 4)
    (['178.21', '178.24'], ['2', '3'])
    """
    write = lambda more: [in_digits(value, more, sign=sign) for value in values]  # noqa: E731
    texts = map(write, range(digits, 8))
    return next((ends for ends in texts if ends[0] != ends[-1]), write(digits))


def first_of(names: Sequence[str], most: int) -> str:
    """List at most ``most`` names, and count the others, as in "a, b and 1 more"."""
    more = len(names) - most
    return ", ".join(names[:most]) + (f" and {more} more" if more > 0 else "")


def in_p(value: float) -> str:
    """Return a p-value in words, without digits below 0.0001."""
    return "p < 0.0001" if value < 1e-4 else f"p = {in_digits(value, 2)}"


def in_percent(probability: float) -> str:
    """Return a probability as a percentage, never 0 or 100 %.

    >>> in_percent(0.233), in_percent(0.9996), in_percent(0.001)
    ('23 %', '> 99 %', '< 1 %')
    """
    if probability < 0.01:
        return "< 1 %"
    return "> 99 %" if probability > 0.99 else f"{100 * probability:.0f} %"


def about(value: float) -> str:
    """Return an estimated number of operations to three digits.

    >>> about(1878.3), about(42.4), about(float("inf"))
    ('1,880', '42', 'beyond the horizon')
    """
    if not math.isfinite(value):
        return "unknown" if math.isnan(value) else "beyond the horizon"
    digits = max(0, math.floor(math.log10(max(value, 1.0))) - 2)
    return f"{round(value, -digits):,.0f}"


def span(low: float, high: float) -> str:
    """Return an interval of estimated numbers of operations."""
    return f"{about(low)} to {about(high)}"


def natural(path: str | Path) -> list[tuple[int, str]]:
    """Return a key that sorts 9 before 10."""
    parts = re.split("([0-9]+)", str(path))
    return [(int(part), "") if part.isdecimal() else (0, part) for part in parts]
