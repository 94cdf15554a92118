"""From operations to days: how many a drive makes in a day, and on what date it makes which."""

from collections.abc import Sequence
from datetime import datetime, timedelta

import numpy as np

_YEAR = 365.0  # days over which operations are counted, where the records go back as far,
_LEAST = 30.0  # and over which they must have been
_FARTHEST = 36525.0  # days ahead that are told


def days_per_operation(operations: np.ndarray, dates: Sequence[str]) -> np.ndarray:
    """Return the recent mean number of days between operations, ``(o,)``, nan if not known.

    Counted from the last dated operation that is a year back or more, else from the first one, and
    not at all within a month.

    Args:
        operations: Numbers of the operations, rising, ``(o,)``.
        dates: Date of each as ISO 8601, empty where not known.

    >>> dates = ["2020-01-01", "2020-01-01", "2024-01-01", "2024-01-01"]
    >>> days_per_operation(np.array([1, 5, 100, 104]), dates).round(1).tolist()
    [nan, nan, 15.4, 14.8]
    """
    numbers, days = _dated(operations, dates)
    result = np.full(len(operations), np.nan)
    for i, last in enumerate(np.searchsorted(numbers, operations, "right") - 1):
        if last < 0:
            continue
        past = np.flatnonzero(days[: last + 1] <= days[last] - _YEAR)
        since = past[-1] if past.size else 0
        made, passed = numbers[last] - numbers[since], days[last] - days[since]
        if made > 0 and passed >= _LEAST:
            result[i] = passed / made
    return result


def _dated(operations: np.ndarray, dates: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """Numbers and days, since year 1, of the operations that have a date."""
    there = [i for i, date in enumerate(dates) if date]
    found = [datetime.fromisoformat(dates[i]).replace(tzinfo=None) for i in there]
    days = [(date - datetime.min) / timedelta(days=1) for date in found]
    return np.asarray(operations)[there], np.array(days, dtype=float)


def on_date(
    wanted: np.ndarray, operations: np.ndarray, dates: Sequence[str], per_operation: np.ndarray
) -> list[str]:
    """Return the date at which an operation is expected, as known at each operation, ``(o,)``.

    Empty where rate or number are not known, or more than a century away. The other arguments are
    those of ``days_per_operation``, and what it returns.

    Args:
        wanted: Number of an operation, ``(o,)``.
    """
    numbers, days = _dated(operations, dates)
    found = []
    lasts = np.searchsorted(numbers, operations, "right") - 1
    for number, last, each in zip(wanted, lasts, per_operation, strict=True):
        ahead = (number - numbers[last]) * each if last >= 0 else np.nan
        day = days[last] + ahead if abs(ahead) < _FARTHEST else np.nan
        there = 0 <= day < (datetime.max - datetime.min).days
        date = datetime.min + timedelta(days=float(day)) if there else None
        found.append(date.date().isoformat() if date else "")
    return found
