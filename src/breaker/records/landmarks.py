"""Landmarks of a record: its first motion, its main motion, and the operating time.

First motion: from rest, under a constant force and friction, travel begins as
``A tau^2 (1 - kappa tau)``, ``tau`` the time since the first motion and ``kappa`` about a third of
the friction. Fitting that to the rest and the first rise, rather than waiting for a threshold,
makes the time nearly free of bias and of the force: a threshold alone is late by milliseconds, and
later for a weak drive.

Main motion: the part of a record that the model describes (paper, Sec. 7). The model does not
describe the rest of the stroke, where stops and dampers act.

Operating time: what an engineer reads off a travel curve.
"""

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["NoMotionError", "first_motion", "main_motion", "raw_time"]

_RISE = 1.5  # mm, rise up to which the start is fitted
_EARLIEST = 5.0  # ms, longest time that the rise may take
_STEP = 0.01  # ms, of the times tried
_KAPPA = 0.12  # 1/ms, the median over the default prior: right to 0.01 ms on average there
_TOGETHER = 5  # samples whose mean has to rise, so that noise does not
_SHARE = {"closing": 0.75, "opening": 0.85}  # of the way between the rest positions
_SEEN = 0.6  # least share of the samples of the first rise
_LEAST_WAY = 2.0  # mm, below which a record has no motion: noise is far below it


class NoMotionError(ValueError):
    """A record in which nothing moves, or the first motion is not seen."""


def first_motion(time: np.ndarray, travel: np.ndarray, direction: float) -> float:
    """Return the time of the first motion, ms.

    Args:
        time: Times of a record, ``(t,)``, ms, evenly spaced.
        travel: Travel, ``(t,)``, mm; NaN where a sample is missing.
        direction: 1 if the travel grows, -1 if it falls.

    Raises:
        NoMotionError: If the travel does not leave its rest position by 1.5 mm, has left it when
            the record begins, or too many samples of this rise are missing.

    Example:
        >>> time = np.arange(0.0, 30.0, 0.1)
        >>> travel = 0.3 * np.maximum(time - 12.0, 0.0) ** 2
        >>> f"{first_motion(time, travel, 1.0):.1f} ms"
        '12.1 ms'
    """
    there = ~np.isnan(travel)
    risen = direction * (travel - np.median(travel[there][:_TOGETHER]))
    filled = risen if there.all() else np.interp(time, time[there], risen[there])
    mean = np.convolve(filled, np.full(_TOGETHER, 1 / _TOGETHER), mode="valid")
    above = np.flatnonzero(mean >= _RISE)
    if above.size == 0:
        raise NoMotionError(f"no motion: the travel rises by no more than {mean.max():.2f} mm")
    last = above[0] + _TOGETHER // 2
    step = (time[-1] - time[0]) / (time.size - 1)
    first = max(0, last - round(2 * _EARLIEST / step))
    seen = np.flatnonzero(there)
    before, after = seen[seen < last][-1:], seen[seen >= last][:1]
    # At least one sample moves after each of them; of none, the misfit would be 0 / 0.
    end = time[last] - 1.5 * step - (time[last - 1] - time[before]).sum()
    candidates = np.arange(max(time[first], time[last] - _EARLIEST), end, _STEP)
    if candidates.size == 0 or not (risen[after] - risen[before] <= _RISE).any():
        raise NoMotionError("the first motion is not seen: its samples are missing")
    known = seen[(seen >= first) & (seen < last)]
    best = candidates[_misfit(time[known], risen[known], candidates).argmin()]
    rise = there[(time >= best) & (time <= time[last])]
    if rise.mean() < _SEEN:
        missing = f"{(~rise).sum()} of the {rise.size} samples of its rise are missing"
        raise NoMotionError(f"the first motion is not seen: {missing}")
    if best <= time[seen[0]]:
        raise NoMotionError("no rest before the motion: the record begins too late")
    return float(best)


def _misfit(time: np.ndarray, risen: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Sum of squares that the best rise from each start leaves, the rest position fitted along."""
    tau = np.maximum(time - starts[:, None], 0.0)
    shape = tau**2 * (1.0 - _KAPPA * tau)
    shape -= shape.mean(axis=1, keepdims=True)
    risen = risen - risen.mean()
    return risen @ risen - (shape @ risen) ** 2 / np.einsum("st,st->s", shape, shape)


def main_motion(travel: np.ndarray, times: np.ndarray, motion: str) -> np.ndarray:
    """Say which samples of a curve belong to the main motion, ``(t,)`` of bool.

    From time 0 to where the drive has done its share of the way between its rest positions: about
    up to the touch when closing, up to the stop when opening.

    Args:
        travel: A curve with little noise, ``(t,)``, mm.
        times: Times, ``(t,)``, ms, 0 at the first motion.
        motion: "closing" or "opening".
    """
    start, end = _rests(times, travel)
    done = (travel - start) / (end - start) >= _SHARE[motion]
    last = int(done.argmax()) if done.any() else len(travel)
    return (times >= 0) & (np.arange(len(travel)) < last)


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
    start, end = _rests(times, travel)
    way = end - start
    moves = np.isfinite(travel).all(axis=1) & (np.abs(way) >= _LEAST_WAY)
    result = np.full(len(travel), np.nan)
    done = (travel[moves] - start[moves, None]) / way[moves, None]
    result[moves] = _crossing(times, done, share) - _crossing(times, done, first)
    return result


def _rests(times: np.ndarray, travel: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rest positions before and after the motion, ``(..., t) -> (...)``: the mean travel before
    time 0, or where that is not recorded its first sample, and that over the last twelfth.
    """
    before, last = max(1, np.searchsorted(times, 0.0)), max(1, times.size // 12)
    return travel[..., :before].mean(axis=-1), travel[..., -last:].mean(axis=-1)


def _crossing(times: np.ndarray, done: np.ndarray, share: float) -> np.ndarray:
    """Time at which each row ``(n, t)`` first reaches a share; NaN if it never does, or has."""
    after = (done >= share).argmax(axis=1)  # 0 if never, too
    before, rows = np.maximum(after - 1, 0), np.arange(len(done))
    low, high = done[rows, before], done[rows, after]
    rise = np.where(after > 0, high - low, np.nan)
    return times[before] + (share - low) / rise * (times[after] - times[before])
