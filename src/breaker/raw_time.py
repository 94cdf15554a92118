"""The raw operating time of a record: what an engineer reads off a travel curve."""

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["raw_time"]

_LEAST_WAY = 2.0  # mm, below which a record has no motion: noise is far below it


def raw_time(
    times: ArrayLike, travel: ArrayLike, *, share: float, first: float = 0.05
) -> np.ndarray:
    """Return the time that each record takes from one share of its way to another, ``(n,)``, ms.

    The way is that between the record's own rest positions, its means before time 0 and over its
    last twelfth. So neither the zero nor the trigger enters, nor the direction.

    Args:
        times: Times of the samples, ``(t,)``, ms around the nominal first motion, increasing.
        travel: Records, ``(n, t)``, mm.
        share: Share of the way at which the time ends.
        first: Share at which it begins: the first motion as such is not seen in noise.

    Returns:
        Times by linear interpolation at the first crossings; NaN where a record has missing
        samples, moves by less than 2 mm or has crossed a share when it begins.
    """
    times, travel = np.asarray(times, float), np.asarray(travel, float)
    if times.ndim != 1 or travel.ndim != 2 or travel.shape[1] != times.size:
        raise ValueError(f"travel must be (n, {times.size}), not {travel.shape}")
    if not (times.size > 1 and np.all(np.diff(times) > 0) and times[0] < 0):
        raise ValueError("times must increase, and begin before 0")
    if not 0 < first < share < 1:
        raise ValueError("shares must be 0 < first < share < 1")
    start = travel[:, times < 0].mean(axis=1)
    way = travel[:, -max(1, times.size // 12) :].mean(axis=1) - start
    moves = np.isfinite(travel).all(axis=1) & (np.abs(way) >= _LEAST_WAY)
    result = np.full(len(travel), np.nan)
    done = (travel[moves] - start[moves, None]) / way[moves, None]
    result[moves] = _crossing(times, done, share) - _crossing(times, done, first)
    return result


def _crossing(times: np.ndarray, done: np.ndarray, share: float) -> np.ndarray:
    """Time at which each row ``(n, t)`` first reaches a share; NaN if it never does, or has."""
    after = (done >= share).argmax(axis=1)  # 0 if never, too
    before, rows = np.maximum(after - 1, 0), np.arange(len(done))
    low, high = done[rows, before], done[rows, after]
    rise = np.where(after > 0, high - low, np.nan)
    return times[before] + (share - low) / rise * (times[after] - times[before])
