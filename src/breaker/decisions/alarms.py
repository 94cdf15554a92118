"""Hysteresis, and the table of alarms: the spells in which a limit was exceeded.

Shapes: ``o`` operations, ``l`` limits.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike

__all__ = ["alarm_table", "first", "latched", "latest", "spell_table"]


def latest(there: ArrayLike) -> np.ndarray:
    """Index of the last operation at which something is there, by then, ``(o, ...)``; -1: none.

    >>> latest([False, True, False, True]).tolist()
    [-1, 1, 1, 3]
    """
    there = np.asarray(there, dtype=bool)
    at = np.arange(len(there)).reshape(-1, *[1] * (there.ndim - 1))
    return np.maximum.accumulate(np.where(there, at, -1), axis=0)


def latched(on: ArrayLike, off: ArrayLike) -> np.ndarray:
    """Return what is on after each operation, ``(o, ...)``: from ``on`` until ``off``.

    Where neither holds, nothing changes; where both do, it is on.

    >>> latched([0, 1, 0, 0, 0], [0, 0, 0, 1, 0]).tolist()
    [False, True, True, False, False]
    """
    on = np.asarray(on, dtype=bool)
    last = latest(on | np.asarray(off, dtype=bool))
    if not len(on):
        return on
    return np.take_along_axis(on, np.maximum(last, 0), axis=0) & (last >= 0)


def first(active: ArrayLike, operations: ArrayLike) -> float:
    """Return the number of the first operation at which ``active (o,)`` holds; nan if none.

    >>> first([False, True, True], [10, 15, 20])
    15.0
    """
    on = np.flatnonzero(active)
    return float(np.asarray(operations)[on[0]]) if on.size else math.nan


def alarm_table(judged: xr.Dataset, motions: Mapping[str, str]) -> pd.DataFrame:
    """Return one row for each spell in which a limit was exceeded.

    Args:
        judged: What ``judge`` returns.
        motions: Motion of each limit, by its name.

    Returns:
        Columns ``limit``, ``words``, ``motion``, ``from_operation`` and ``to_operation``, the
        first and last operation of the spell, the latter empty if it lasts, and
        ``highest_probability`` that the level is beyond the limit in between.
    """
    operations, rows = judged.operation.values, []
    for name in judged.limit.values:
        one = judged.sel(limit=name)
        changes = np.flatnonzero(np.diff(one.exceeded.values, prepend=False, append=False))
        for begin, end in changes.reshape(-1, 2).tolist():
            last = operations[end - 1] if end < len(operations) else pd.NA
            highest = one.level_probability.values[begin:end].max()
            words = one.words.item(), motions[str(name)]
            rows.append((str(name), *words, operations[begin], last, highest))
    return spell_table(rows)


def spell_table(rows: Sequence[tuple]) -> pd.DataFrame:
    """Return a table of rows with the columns of ``alarm_table``."""
    columns = {"limit": str, "words": str, "motion": str}
    columns |= {"from_operation": "Int64", "to_operation": "Int64", "highest_probability": float}
    return pd.DataFrame(rows, columns=list(columns)).astype(columns)
