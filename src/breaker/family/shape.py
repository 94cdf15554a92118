"""Shapes: records without their size, as travel over the stroke against time over a duration.

The record itself defines its units: the rest positions before and after, and the time from 10 to
50 % of the travel, before dampers act. So drives with the same shape of motion have equal numbers,
whatever their size, rate and unit of travel. Training and inference both normalise by this code.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from breaker.common.compiling import compiled

SHAPE_STEP = 0.1  # durations
SHAPE_TIMES = SHAPE_STEP * np.arange(-20, 101)
"""Times of the grid, ``(g,)``: after 10 % of the travel, in durations."""

LEVELS = 0.1, 0.5  # shares of the travel, between which the duration is measured
WINDOW = -2.9, 9.7  # durations after 10 % of the travel: the part of a record for networks

_fast = compiled(late=True)

_RESTS = 2.0, 7.0  # durations before and after 10 % of the travel, beyond which a drive rests
_SMOOTH = 0.2  # durations, over which travel is averaged, so that noise crosses no level twice
_GAP = 0.3  # durations between two samples, beyond which samples are missing: 3 steps of the grid
_FEWEST = 3  # samples of a rest position
_ROUNDS = 4  # iterations, as rest positions and duration depend on each other; more change nothing


class Shape(NamedTuple):
    """A normalised record.

    Attributes:
        way: Travel over the stroke, averaged over each step of the grid, ``(g,)``; linear where
            samples are missing.
        present: Whether there are samples, ``(g,)`` of bool.
        rest: Rest position before the motion, in the record's unit of travel.
        stroke: Distance from there to the rest position after the motion.
        origin: Time of 10 % of the travel after the first sample, ms.
        duration: Time from 10 to 50 % of the travel, ms.
    """

    way: np.ndarray
    present: np.ndarray
    rest: float
    stroke: float
    origin: float
    duration: float


def median_units(shapes: Sequence[Shape]) -> Shape:
    """Return the first of the shapes, with the median stroke and duration of all."""
    middle = np.median([(shape.stroke, shape.duration) for shape in shapes], axis=0).tolist()
    return shapes[0]._replace(stroke=middle[0], duration=middle[1])


def shape_of(travel: np.ndarray, step: float, like: Shape | None = None) -> Shape | None:
    """Normalise a record; return None if it has no motion between two rest positions.

    Args:
        travel: Travel in the direction of the motion, ``(n,)``; NaN where a sample is missing.
        step: Time between samples, ms.
        like: Shape whose stroke and duration are the units; those of the record if None.
    """
    way, present = np.empty(SHAPE_TIMES.size), np.empty(SHAPE_TIMES.size, dtype=np.bool_)
    units = (0.0, 0.0) if like is None else (like.stroke, like.duration)
    numbers = normalise(np.asarray(travel, dtype=np.float64), step, units, way, present)
    return Shape(way, present, *numbers) if numbers[3] > 0.0 else None


@_fast
def effective_noise(noise_sd, colour, step):
    """Return the sd of noise after the average over a step of the grid, from the sd of samples, the
    correlation of neighbours, ``colour``, and the step between samples, in durations.
    """
    share = step / SHAPE_STEP * (1.0 + colour) / (1.0 - colour)
    return noise_sd * np.sqrt(min(1.0, share))


@_fast
def normalise(travel, step, like, way, present):
    """Write ``way`` and ``present`` of ``shape_of``; return rest, stroke, origin and duration, 0
    without a motion. ``like`` is stroke and duration of another record, or zeros.
    """
    known = np.flatnonzero(~np.isnan(travel))
    time, value, n = known * step, travel[known], known.size
    if n < 4 * _FEWEST:
        return 0.0, 0.0, 0.0, 0.0
    low, high = _mean(value[:_FEWEST]), _mean(value[n - max(_FEWEST, n // 20) :])
    origin = duration = 0.0
    begin, end = 0, n
    window = max(1, n // 60)
    for _ in range(_ROUNDS):
        before = low, high, window
        origin, duration = _rise(time, value, low, high, window)
        if not duration > 0.0:
            return 0.0, 0.0, 0.0, 0.0
        window = max(1, round(_SMOOTH * duration / step))
        begin = min(np.searchsorted(time, origin + WINDOW[0] * duration), n - _FEWEST)
        end = max(np.searchsorted(time, origin + WINDOW[1] * duration), begin + _FEWEST)
        rests = np.searchsorted(time, origin - _RESTS[0] * duration)
        arrived = np.searchsorted(time, origin + _RESTS[1] * duration)
        low = _mean(value[begin : max(begin + _FEWEST, rests)])
        high = _mean(value[min(arrived, end - max(_FEWEST, (end - begin) // 20)) : end])
        if before == (low, high, window):
            break
    stroke = high - low
    if not stroke > 0.0:
        return 0.0, 0.0, 0.0, 0.0
    length = like[0] if like[0] > 0.0 else stroke
    unit = like[1] if like[1] > 0.0 else duration
    gap = max(_GAP * unit, 2.5 * step)
    _averages(time[begin:end], value[begin:end], origin, unit, gap, way, present)
    for j in range(way.size):
        way[j] = (way[j] - low) / length
    return low, stroke, origin, duration


@_fast
def _mean(values):
    """Return the mean by a sum in order, equal to the last digit if compiled or not."""
    return values.cumsum()[-1] / values.size


@_fast
def _rise(time, value, low, high, window):
    """Return the time at which the averaged record last leaves the lower level, and the time from
    there until it first reaches the upper level; zeros if it does not.
    """
    n, total, half = value.size, 0.0, window // 2
    smooth, begin, end = np.empty(n), 0, 0
    for i in range(n):
        while end < min(n, i + half + 1):
            total, end = total + value[end], end + 1
        while begin < i - half:
            total, begin = total - value[begin], begin + 1
        smooth[i] = total / (end - begin)
    lower, upper = low + LEVELS[0] * (high - low), low + LEVELS[1] * (high - low)
    last = 1
    while last < n and not (smooth[last] >= upper and smooth[last - 1] < upper):
        last += 1
    first = last if last < n else 0
    while first > 0 and not smooth[first - 1] < lower:
        first -= 1
    if first == 0:
        return 0.0, 0.0
    begins, ends = _crossing(time, smooth, first, lower), _crossing(time, smooth, last, upper)
    return begins, ends - begins


@_fast
def _crossing(time, smooth, i, level):
    """Return the time at which travel crosses a level between samples i - 1 and i."""
    rise = smooth[i] - smooth[i - 1]
    share = (level - smooth[i - 1]) / rise if rise > 0.0 else 1.0
    return time[i - 1] + share * (time[i] - time[i - 1])


@_fast
def _averages(time, value, origin, duration, gap, way, present):
    """Write the mean of the line through samples over each step of the grid, and whether the step
    has samples: it is within the record, and between samples within ``gap`` of each other.
    """
    n, i = value.size, 0
    last, area, total = -np.inf, 0.0, 0.0
    for j in range(2 * way.size):
        edge = origin + duration * (SHAPE_TIMES[j // 2] + (0.5 if j % 2 else -0.5) * SHAPE_STEP)
        while i < n - 1 and time[i + 1] <= edge:
            total += 0.5 * (value[i] + value[i + 1]) * (time[i + 1] - time[i])
            i += 1
        if edge <= time[0]:
            area = value[0] * (edge - time[0])
        elif edge >= time[n - 1]:
            area = total + value[n - 1] * (edge - time[n - 1])
        else:
            share = (edge - time[i]) / (time[i + 1] - time[i])
            height = value[i] + share * (value[i + 1] - value[i])
            area = total + 0.5 * (value[i] + height) * (edge - time[i])
        if j % 2:
            way[j // 2] = (area - last) / (SHAPE_STEP * duration)
            middle, k = edge - 0.5 * SHAPE_STEP * duration, min(i, n - 2)
            near = time[k + 1] - time[k] <= gap
            present[j // 2] = time[0] <= middle <= time[n - 1] and near
        last = area
