"""Quantities of parameter sets, computed from their exact curves (definitions: ``quantities``).

Times, speeds and distances are read from the curve of a parameter set, whose motion starts at 0. A
quantity that does not exist for a parameter set is nan:

- quantities of the contact event, if it does not occur within 60 ms;
- quantities of the closed rest position, if it does not exist (``f <= k_a L``);
- a speed between points that the drive does not pass;
- over-travel of a drive that is still moving at 60 ms.

A drive of any size is first scaled to about the size of the reference drive: lengths and times are
divided by powers of 2, which is exact. The 60 ms apply to the scaled drive.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from breaker.model.curves import blocks, check, travel
from breaker.model.equations import closed_rest, own_time, spring_compression
from breaker.model.parameters import GAP, NAMES, Size, split
from breaker.model.quantities import SPEED_UNIT, SPEEDS, Point, Speed, check_quantity

_STEP = 0.25  # ms; keeps the error of cubics between samples below a micrometre (see tests)
TIMES = np.arange(241) * _STEP
"""Times of the samples, ms."""

_SETTLED = 0.1  # mm; a drive this near its rest position, the noise of a sensor, is at rest
_NEAR = 0.75  # powers of 2 from the reference drive's size for which 60 ms and the step suffice
_REFERENCE = np.array([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0])  # medians of the default prior


def evaluate(
    names: Sequence[str], theta: np.ndarray, motion: str, speeds: Sequence[Speed] = SPEEDS
) -> np.ndarray:
    """Return quantities of parameter sets, ``(n, len(names))``, in the units of ``QUANTITIES``.

    The spring compression is zero or negative where a contact is not pressed. Other quantities are
    nan where they do not exist (see the module).

    Args:
        theta: Parameters, ``(n, p)``, of drives of any size.

    Raises:
        ValueError: If the motion has no such quantity, or ``travel`` refuses the parameters.

    Example:
        >>> theta = np.array([[2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0]])
        >>> names = ["spring_compression", "touch_time", "closing_speed"]
        >>> evaluate(names, theta, "closing").round(2)
        array([[ 3.53, 10.09,  1.24]])
    """
    for name in names:
        if complaint := check_quantity(name, motion, speeds):
            raise ValueError(complaint)
    theta, _, _ = check(theta, np.zeros(1), motion, 0.0)
    result = np.empty((len(theta), len(names)))
    for rows in blocks(len(theta)):
        parameters = np.asarray(theta[rows], dtype=np.float64)
        known = dict(zip(NAMES, split(parameters), strict=True))
        known["spring_compression"] = pressed = spring_compression(parameters)
        known["stroke"] = np.where(pressed > 0, known[GAP.name] + pressed, np.nan)
        if shown := set(names) - known.keys():
            known |= _read_from_curves(shown, parameters, motion, speeds)
        for column, name in enumerate(names):
            result[rows, column] = known[name]
    return result


def _read_from_curves(
    names: set[str], theta: np.ndarray, motion: str, speeds: Sequence[Speed]
) -> dict[str, np.ndarray]:
    """Simulate parameter sets ``(n, p)`` and return quantities of their curves, ``(n,)`` each."""
    values = {name: np.empty(len(theta)) for name in names}
    for size, rows in _sizes(theta, motion):
        curves = _Curves(theta[rows] / size.factors, motion)
        back = Size(1.0 / size.lengths, 1.0 / size.times)
        points = {given.name: (given.sized(back).start, given.sized(back).end) for given in speeds}
        for name in names:
            if name in points:
                values[name][rows] = curves.speed(*points[name]) * size.factor(SPEED_UNIT)
            elif name == "travel_time":
                values[name][rows] = curves.travel_time() * size.times
            elif name in ("touch_time", "separation_time"):
                values[name][rows] = np.where(curves.exists, curves.event_time, np.nan) * size.times
            else:
                values[name][rows] = curves.over_travel() * size.lengths
    return values


def _sizes(theta: np.ndarray, motion: str) -> Iterator[tuple[Size, np.ndarray]]:
    """Yield sizes in powers of 2, with the rows of parameter sets ``(n, p)`` near each size."""
    gap = NAMES.index(GAP.name)
    times = own_time(theta, motion) / own_time(_REFERENCE, motion)
    powers = np.log2([theta[..., gap] / _REFERENCE[gap], times])
    powers = np.where(np.abs(powers) <= _NEAR, 0.0, np.rint(powers))
    for lengths, duration in np.unique(powers, axis=1).T:
        rows = np.flatnonzero((powers[0] == lengths) & (powers[1] == duration))
        yield Size(2.0**lengths, 2.0**duration), rows


class _Curves:
    """Exact curves of parameter sets ``(n, p)``, and quantities of the curves, ``(n,)`` each."""

    def __init__(self, theta: np.ndarray, motion: str) -> None:
        closing = motion == "closing"
        curves, switching = travel(theta, TIMES, motion)
        self.pressed = spring_compression(theta) > 0
        # Whether there is a contact event, and its time from the start of motion, ms.
        self.exists = np.isfinite(switching) & (self.pressed | closing)
        self.event_time = np.where(self.exists, switching, 0.0)
        # Travel in the direction of the motion, (n, t), and the rest positions before and after.
        self.forward = curves if closing else -curves
        closed, opened = closed_rest(theta), np.zeros(len(theta))
        self.start, self.end = (opened, closed) if closing else (-closed, opened)

    def over_travel(self) -> np.ndarray:
        """Largest travel beyond the final rest position, mm, by a parabola through samples: 0 if
        the drive does not pass it, nan if the curve has no peak beyond it and does not end near it.
        """
        beyond = self.forward - self.end[:, None]
        peak = np.clip(np.argmax(beyond, axis=1), 1, TIMES.size - 2)
        before, top, after = np.take_along_axis(beyond, peak[:, None] + np.arange(-1, 2), axis=1).T
        bend = 2 * top - before - after
        turns = (top >= before) & (top >= after) & (bend > 0)
        top = top + np.where(turns, (after - before) ** 2 / (8 * np.where(turns, bend, 1.0)), 0.0)
        largest = np.maximum(np.where(turns, top, beyond[:, -1]), 0.0)
        known = (turns & (top > 0)) | (np.abs(beyond[:, -1]) <= _SETTLED)
        return np.where(self.pressed & self.exists & known, largest, np.nan)

    def travel_time(self) -> np.ndarray:
        """Time from 10 to 90 % of the stroke, ms."""
        duration = self._place(Point(90.0, "%"))[0] - self._place(Point(10.0, "%"))[0]
        return np.where(duration > 0, duration, np.nan)

    def speed(self, start: Point, end: Point) -> np.ndarray:
        """Mean speed from one point to another, mm/ms."""
        (begin, low, before), (stop, high, after) = self._place(start), self._place(end)
        duration = stop - begin
        return np.abs(((high - low) + (after - before)) / np.where(duration > 0, duration, np.nan))

    def _place(self, point: Point) -> tuple[np.ndarray, np.ndarray, float]:
        """Time of a point, ms, the travel of a mark, and the distance from the mark to the point,
        mm; nan where the drive does not reach the point.
        """
        if point.later:
            time = self._place(replace(point, later=0.0))[0] + point.later
            return self._time_and_travel(time, np.isfinite(time))
        if not point.of_event:
            level = self.start + point.amount / 100.0 * (self.end - self.start)
            if point.unit == "mm":
                level = (self.end if point.amount < 0.0 else self.start) + point.amount
            level = np.where(self.pressed, level, np.nan)
            time = self._first_after(level, np.zeros(len(level)))
            return np.where(level == self.start, 0.0, time), level, 0.0
        if point.unit == "ms":
            return self._time_and_travel(self.event_time + point.amount, self.exists)
        mark = np.where(self.exists, self._travel(self.event_time), np.nan)
        if point.amount == 0.0:
            return self.event_time, mark, 0.0
        search = self._last_before if point.amount < 0.0 else self._first_after
        return search(mark + point.amount, self.event_time), mark, point.amount

    def _time_and_travel(self, time: np.ndarray, exists: np.ndarray) -> tuple:
        """Result of ``_place`` for times, ms; nan where they do not exist or are not simulated."""
        there = exists & (time <= TIMES[-1])
        time = np.where(there, time, np.nan)
        return time, self._travel(np.where(there, np.maximum(time, 0.0), 0.0)), 0.0

    def _last_before(self, level: np.ndarray, end: np.ndarray) -> np.ndarray:
        """Last time before ``end`` at which a curve passes its level, nan if it does not."""
        below = (self.forward <= level[:, None]) & (end[:, None] > TIMES)
        return self._crossing(level, TIMES.size - 1 - np.argmax(below[:, ::-1], axis=1), below)

    def _first_after(self, level: np.ndarray, begin: np.ndarray) -> np.ndarray:
        """First time after ``begin`` at which a curve reaches its level, nan if never."""
        above = (self.forward >= level[:, None]) & (begin[:, None] < TIMES)
        return self._crossing(level, np.argmax(above, axis=1) - 1, above)

    def _crossing(self, level: np.ndarray, sample: np.ndarray, crosses: np.ndarray) -> np.ndarray:
        """Time between a sample and the next at which a curve passes its level, by bisection; nan
        where no sample of ``crosses`` (n, t) is true.
        """
        sample = np.clip(sample, 0, TIMES.size - 2)
        low, width = TIMES[sample], _STEP
        first = _around(low)
        samples = self._four(first)
        was_below = np.take_along_axis(self.forward, sample[:, None], axis=1)[:, 0] <= level
        for _ in range(30):  # halvings to 2e-10 ms
            width /= 2
            before = (_cubic(samples, (low + width) / _STEP - first) <= level) == was_below
            low = low + width * before
        return np.where(crosses.any(axis=1), low + width / 2, np.nan)

    def _travel(self, time: np.ndarray) -> np.ndarray:
        """Travel at times, by cubics, mm."""
        first = _around(time)
        return _cubic(self._four(first), time / _STEP - first)

    def _four(self, first: np.ndarray) -> np.ndarray:
        """Four samples of each curve from ``first`` on, ``(4, n)``."""
        return np.take_along_axis(self.forward, first[:, None] + np.arange(4), axis=1).T


def _around(time: np.ndarray) -> np.ndarray:
    """First of the four samples around each time, ``(n,)``; the nearest four at the ends."""
    return np.clip(np.floor(time / _STEP).astype(int) - 1, 0, TIMES.size - 4)


def _cubic(samples: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Values of cubics through samples ``(4, n)``, ``u`` (n,) samples after the first."""
    a, b, c, d = samples
    v, w, x = u - 1, u - 2, u - 3
    return (d * u * v * w - a * v * w * x) / 6 + (b * u * w * x - c * u * v * x) / 2
