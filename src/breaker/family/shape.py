"""Records without their size: the way over the stroke, in units of the motion's own duration.

A record is normalised by what it shows itself: the rest before and after, and the time from 10 to
50 % of the way, before dampers act. So records of drives that move alike are the same numbers,
whatever their size, rate and units. Samples long before and after the motion are cut off, so that
a long record and a short one have the same rests. What networks see, in training and after, is
made here.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from breaker.common.compiling import compiled

SHAPE_STEP = 0.1
"""Between times of the grid, in durations."""

SHAPE_TIMES = SHAPE_STEP * np.arange(-20, 101)
"""Times of the grid, ``(g,)``: after 10 % of the way, in durations."""

_fast = compiled(late=True)

_LEVELS = (0.1, 0.5)  # of the way, whose times make the duration
_REST, _END = 2.0, 7.0  # durations before and after 10 % of the way, beyond which a drive rests
_SMOOTH = 0.2  # durations, over which a record is averaged before levels are looked for
_FROM, _TO = -2.9, 9.7  # durations after 10 % of the way: networks see no sample outside of these
_GAP = 0.3  # durations between two samples, beyond which what lies between is missing
_FEWEST = 3  # samples of a rest
_ROUNDS = 4


class Shape(NamedTuple):
    """A normalised record.

    Attributes:
        way: Way over the stroke, averaged over each step of the grid, ``(g,)``; where there is no
            sample, the line between those that are next to it.
        present: Whether there are samples, ``(g,)`` of bool.
        rest: Rest before the motion, in the record's unit of travel.
        stroke: From there to the rest after it.
        origin: Time of 10 % of the way after the first sample, ms.
        duration: Time from 10 to 50 % of the way, ms.
    """

    way: np.ndarray
    present: np.ndarray
    rest: float
    stroke: float
    origin: float
    duration: float


def median_units(shapes: Sequence[Shape]) -> Shape:
    """Return the first of a drive's shapes with the median stroke and duration of all."""
    middle = np.median([(each.stroke, each.duration) for each in shapes], axis=0).tolist()
    return shapes[0]._replace(stroke=middle[0], duration=middle[1])


def shape_of(travel: np.ndarray, step: float, like: Shape | None = None) -> Shape:
    """Normalise a record.

    Args:
        travel: Travel in the direction of the motion, ``(n,)``; NaN where a sample is missing.
        step: Between samples, ms.
        like: Another record of the same drive, in whose stroke and duration it is measured; its
            own if None.

    Raises:
        ValueError: If it has no motion from one rest to another.

    Example:
        >>> time = np.arange(0.0, 60.0, 0.1)
        >>> way = np.clip((time - 20.0) / 10.0, 0.0, 1.0)
        >>> found = shape_of(150.0 * way**2 * (3.0 - 2.0 * way) + 7.0, 0.1)
        >>> f"{found.rest:.2f} mm, {found.stroke:.2f} mm, {found.origin:.2f} ms"
        '7.00 mm, 150.00 mm, 21.95 ms'
    """
    way, present = np.empty(SHAPE_TIMES.size), np.empty(SHAPE_TIMES.size, dtype=np.bool_)
    units = (0.0, 0.0) if like is None else (like.stroke, like.duration)
    found = normalise(np.asarray(travel, dtype=np.float64), step, units, way, present)
    if not found[3] > 0.0:
        raise ValueError("the record has no motion from one rest to another")
    return Shape(way, present, *found)


@_fast
def effective_noise(noise_sd, colour, step):
    """Return the standard deviation of noise after the average over a step of the grid.

    Args:
        noise_sd: Of a sample.
        colour: Correlation of neighbouring samples.
        step: Between samples, in durations.
    """
    share = step / SHAPE_STEP * (1.0 + colour) / (1.0 - colour)
    return noise_sd * np.sqrt(min(1.0, share))


@_fast
def normalise(travel, step, like, way, present):
    """Compute ``shape_of`` into ``way`` and ``present``; rest, stroke, origin and duration.

    Stroke and duration of another record, ``like``, are 0 where there is none. The record's own
    duration is 0 where there is no motion.
    """
    time, value = np.empty(travel.size), np.empty(travel.size)
    n = 0
    for i in range(travel.size):
        if not np.isnan(travel[i]):
            time[n], value[n] = i * step, travel[i]
            n += 1
    if n < 4 * _FEWEST:
        return 0.0, 0.0, 0.0, 0.0
    low, high = _mean(value[:_FEWEST]), _mean(value[n - max(_FEWEST, n // 20) : n])
    origin = duration = 0.0
    begin, end = 0, n
    window = max(1, n // 60)
    for _ in range(_ROUNDS):
        before = low, high, window
        origin, duration = _rise(time[:n], value[:n], low, high, window)
        if not duration > 0.0:
            return 0.0, 0.0, 0.0, 0.0
        window = max(1, round(_SMOOTH * duration / step))
        begin = min(np.searchsorted(time[:n], origin + _FROM * duration), n - _FEWEST)
        end = max(np.searchsorted(time[:n], origin + _TO * duration), begin + _FEWEST)
        rests = np.searchsorted(time[:n], origin - _REST * duration)
        arrived = np.searchsorted(time[:n], origin + _END * duration)
        low = _mean(value[begin : max(begin + _FEWEST, rests)])
        high = _mean(value[min(arrived, end - max(_FEWEST, (end - begin) // 20)) : end])
        if before == (low, high, window):
            break  # further rounds would find the same
    stroke = high - low
    if not stroke > 0.0:
        return 0.0, 0.0, 0.0, 0.0
    length = like[0] if like[0] > 0.0 else stroke
    unit = like[1] if like[1] > 0.0 else duration
    _averages(time[begin:end], value[begin:end], origin, unit, way)
    _presence(time[begin:end], origin, unit, max(_GAP * unit, 2.5 * step), present)
    for j in range(way.size):
        way[j] = (way[j] - low) / length
    return low, stroke, origin, duration


@_fast
def _mean(values):
    """Mean by a sum in order, the same to the last digit whether it is compiled or not."""
    return values.cumsum()[-1] / values.size


@_fast
def _rise(time, value, low, high, window):
    """Time of the lower level, and time from there to the upper one, 0 if they are not reached.

    The upper one is where the averaged record first reaches it, the lower one where it last leaves
    it before.
    """
    n, total = value.size, 0.0
    smooth = np.empty(n)
    half = window // 2
    begin = end = 0
    for i in range(n):
        while end < min(n, i + half + 1):
            total += value[end]
            end += 1
        while begin < i - half:
            total -= value[begin]
            begin += 1
        smooth[i] = total / (end - begin)
    lower, upper = low + _LEVELS[0] * (high - low), low + _LEVELS[1] * (high - low)
    last = 1
    while last < n and not (smooth[last] >= upper and smooth[last - 1] < upper):
        last += 1
    if last == n:
        return 0.0, 0.0
    first = last
    while first > 0 and not smooth[first - 1] < lower:
        first -= 1
    if first == 0:
        return 0.0, 0.0
    begins, ends = _crossing(time, smooth, first, lower), _crossing(time, smooth, last, upper)
    return begins, ends - begins


@_fast
def _crossing(time, smooth, i, level):
    """Time at which a level is passed between samples i - 1 and i."""
    rise = smooth[i] - smooth[i - 1]
    share = (level - smooth[i - 1]) / rise if rise > 0.0 else 1.0
    return time[i - 1] + share * (time[i] - time[i - 1])


@_fast
def _averages(time, value, origin, duration, way):
    """Mean of the line through samples over each step of the grid."""
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
            there = value[i] + share * (value[i + 1] - value[i])
            area = total + 0.5 * (value[i] + there) * (edge - time[i])
        if j % 2:
            way[j // 2] = (area - last) / (SHAPE_STEP * duration)
        last = area


@_fast
def _presence(time, origin, duration, gap, present):
    """Whether each step of the grid has samples: none where two of them are a gap apart."""
    n, i = time.size, 0
    for j in range(present.size):
        edge = origin + duration * (SHAPE_TIMES[j] + 0.5 * SHAPE_STEP)
        while i < n - 2 and time[i + 1] <= edge:
            i += 1
        middle = edge - 0.5 * SHAPE_STEP * duration
        present[j] = time[0] <= middle <= time[n - 1] and time[i + 1] - time[i] <= gap
