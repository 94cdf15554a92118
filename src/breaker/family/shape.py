"""Shapes: records without their size, as travel over the stroke against time over a duration.

The record itself defines its units: the rest positions before and after, and the time from 10 to
50 % of the travel, before dampers act. So drives with the same shape of motion have equal numbers,
whatever their size, rate and unit of travel. Training and inference both normalise by this code.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

SHAPE_STEP = 0.1  # durations
SHAPE_TIMES = SHAPE_STEP * np.arange(-20, 101)
"""Times of the grid, ``(g,)``: after 10 % of the travel, in durations."""

LEVELS = 0.1, 0.5  # shares of the travel, between which the duration is measured
WINDOW = -2.9, 9.7  # durations after 10 % of the travel: the part of a record for networks

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
    travel = np.asarray(travel, dtype=np.float64)
    motion = motion_of(travel, step)
    if not motion[1] > 0.0:
        return None
    way, present = np.empty(SHAPE_TIMES.size), np.empty(SHAPE_TIMES.size, dtype=np.bool_)
    units = (motion[1], motion[3]) if like is None else (like.stroke, like.duration)
    average(travel, step, motion, units, way, present)
    return Shape(way, present, *motion[:4])


# ---- functions that training compiles, and inference runs as they are ---------------------------


def effective_noise(noise_sd, colour, step):
    """Return the sd of noise after the average over a step of the grid, from the sd of samples, the
    correlation of neighbours, ``colour``, and the step between samples, in durations.
    """
    share = step / SHAPE_STEP * (1.0 + colour) / (1.0 - colour)
    return noise_sd * np.sqrt(min(1.0, share))


def motion_of(travel, step):
    """Return rest, stroke, origin and duration as in ``Shape``, and the first and the next after
    the last known sample for the networks; zeros without a motion.
    """
    known = np.flatnonzero(~np.isnan(travel))
    time, value, n = known * step, travel[known], known.size
    begin, end, origin, duration = 0, n, 0.0, 0.0
    if n < 4 * _FEWEST:
        return 0.0, 0.0, 0.0, 0.0, 0, 0
    low, high = value[:_FEWEST].mean(), value[n - max(_FEWEST, n // 20) :].mean()
    window = max(1, n // 60)
    sums = np.concatenate((np.zeros(1), value.cumsum()))
    for _ in range(_ROUNDS):
        before, half = (low, high, window), min(window // 2, n // 2 - 1)
        smooth = (sums[2 * half + 1 :] - sums[: n - 2 * half]) / (2 * half + 1)
        middle = time[half:]  # of the windows
        lower, upper = low + LEVELS[0] * (high - low), low + LEVELS[1] * (high - low)
        rises = np.flatnonzero((smooth[1:] >= upper) & (smooth[:-1] < upper)) + 1
        leaves = np.flatnonzero(smooth[: rises[0] if rises.size else 0] < lower) + 1
        if high <= low or not leaves.size:
            return 0.0, 0.0, 0.0, 0.0, 0, 0
        i, j = leaves[-1], rises[0]  # samples after the last departure, and after the arrival
        share = (lower - smooth[i - 1]) / (smooth[i] - smooth[i - 1])
        origin = middle[i - 1] + share * (middle[i] - middle[i - 1])
        share = (upper - smooth[j - 1]) / (smooth[j] - smooth[j - 1])
        duration = middle[j - 1] + share * (middle[j] - middle[j - 1]) - origin
        window = max(1, round(_SMOOTH * duration / step))
        begin = min(np.searchsorted(time, origin + WINDOW[0] * duration), n - _FEWEST)
        end = max(np.searchsorted(time, origin + WINDOW[1] * duration), begin + _FEWEST)
        rests = np.searchsorted(time, origin - _RESTS[0] * duration)
        arrived = np.searchsorted(time, origin + _RESTS[1] * duration)
        low = value[begin : max(begin + _FEWEST, rests)].mean()
        high = value[min(arrived, end - max(_FEWEST, (end - begin) // 20)) : end].mean()
        if before == (low, high, window):
            break
    return low, max(high - low, 0.0), origin, duration, begin, end


def average(travel, step, motion, like, way, present):
    """Write ``way`` and ``present`` of ``Shape``: means of the line through samples over steps of
    the grid; present is a step within the record, and between samples that are near each other.

    Args:
        travel, step: As in ``shape_of``.
        motion: Result of ``motion_of`` with a stroke above 0.
        like: Stroke and duration that are the units.
    """
    low, _, origin, _, begin, end = motion
    known = np.flatnonzero(~np.isnan(travel))[begin:end]
    time, value, unit = known * step, travel[known], like[1]
    gaps, rises = np.diff(time), np.diff(value)
    edges = origin + unit * (SHAPE_TIMES[0] + SHAPE_STEP * (np.arange(way.size + 1) - 0.5))
    i = np.searchsorted(time, edges, side="right") - 1
    i = np.minimum(np.maximum(i, 0), gaps.size - 1)
    inside = np.minimum(np.maximum(edges, time[0]), time[-1])
    height = value[i] + (inside - time[i]) / gaps[i] * rises[i]
    areas = np.concatenate((np.zeros(1), ((value[:-1] + 0.5 * rises) * gaps).cumsum()))
    area = areas[i] + 0.5 * (value[i] + height) * (inside - time[i]) + height * (edges - inside)
    way[:] = (np.diff(area) / (SHAPE_STEP * unit) - low) / like[0]
    middle = edges[1:] - 0.5 * SHAPE_STEP * unit
    near = gaps[i[1:]] <= max(_GAP * unit, 2.5 * step)
    present[:] = (time[0] <= middle) & (middle <= time[-1]) & near
