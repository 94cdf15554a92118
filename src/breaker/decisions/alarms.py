"""Alarms on limits: raised and cleared with hysteresis, and their table.

Shapes: ``o`` operations, ``l`` limits.
"""

import math
from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from breaker.mechanism import Limit

__all__ = ["alarm_table", "first", "raised"]


def raised(probability: ArrayLike, *, raise_at: float, clear_at: float, after: int) -> np.ndarray:
    """Return after which operations the alarm is on, ``(o,)`` of bool.

    It goes on after ``after`` usable operations in a row with a probability of at least
    ``raise_at``, and off after as many with one of at most ``clear_at``. An operation without a
    probability (nan) neither counts nor breaks the row.

    >>> raised([0.9, 0.95, float("nan"), 0.99, 0.2], raise_at=0.95, clear_at=0.5, after=2).tolist()
    [False, False, False, True, True]

    Raises:
        ValueError: If a level cannot be used, or a probability is neither nan nor from 0 to 1.
    """
    if not (0 <= clear_at <= raise_at <= 1 and after >= 1):
        raise ValueError("an alarm needs 0 <= clear <= raise <= 1 and after >= 1")
    on, count, result = False, 0, []
    for each in np.asarray(probability, dtype=np.float64).tolist():
        if not math.isnan(each):
            if not 0 <= each <= 1:
                raise ValueError(f"a probability must be from 0 to 1, not {each}")
            count = count + 1 if (each <= clear_at if on else each >= raise_at) else 0
            if count == after:
                on, count = not on, 0
        result.append(on)
    return np.array(result, dtype=bool)


def first(active: ArrayLike, operations: ArrayLike) -> float:
    """Return the number of the first operation at which ``active (o,)`` holds; nan if none.

    >>> first([False, True, True], [10, 15, 20])
    15.0
    """
    on = np.flatnonzero(active)
    return float(np.asarray(operations)[on[0]]) if on.size else math.nan


def alarm_table(
    limits: Sequence[Limit], operations: ArrayLike, active: ArrayLike, probability: ArrayLike
) -> pd.DataFrame:
    """Return the alarms as a table, one row for each time one was raised.

    Args:
        limits: The limits, ``l`` of them.
        operations: Numbers of the operations, ``(o,)``.
        active: Whether an alarm is on, ``(o, l)``.
        probability: Probability of each limit, ``(o, l)``.

    Returns:
        Columns ``limit``, ``words``, ``motion``, ``from_operation`` and ``to_operation``, the
        first and last operation with the alarm on, the latter empty if it is still on, and
        ``highest_probability`` in between (nan if no operation there is usable).
    """
    operations, active = np.asarray(operations), np.asarray(active, dtype=bool)
    probability = np.asarray(probability, dtype=np.float64)
    shape = (len(operations), len(limits))
    if active.shape != shape or probability.shape != shape:
        raise ValueError(f"active and probability must have the shape (o, l) = {shape}")
    rows = []
    for limit, on, p in zip(limits, active.T, probability.T, strict=True):
        changes = np.flatnonzero(np.diff(on, prepend=False, append=False))
        for begin, end in changes.reshape(-1, 2).tolist():
            last = operations[end - 1] if end < len(on) else pd.NA
            highest = np.fmax.reduce(p[begin:end])
            rows.append((limit.name, limit.words, limit.motion, operations[begin], last, highest))
    columns = {"limit": str, "words": str, "motion": str}
    columns |= {"from_operation": "Int64", "to_operation": "Int64", "highest_probability": float}
    return pd.DataFrame(rows, columns=list(columns)).astype(columns)
