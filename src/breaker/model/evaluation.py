"""Quantities of parameter sets, read from their exact curves.

Times, speeds and ways are read from the curve of a parameter set without noise, its motion starting
at 0. A quantity that does not exist for a parameter set is nan:

- all that needs touch or parting, of a contact that does not touch or part within 60 ms, or that
  has no closed state to start from (no wipe, ``f <= k_a L``);
- a speed between points that the drive does not pass;
- what needs a closed rest position where there is none: stroke, travel time, over-travel;
- over-travel or rebound of a drive that is still on its way at 60 ms.

A set of any size is read as one of about the size of the reference drive, with lengths and times
divided by powers of 2, which is exact; the 60 ms are of that size.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from breaker.model.curves import blocks, check, rest_position, travel
from breaker.model.equations import own_time, wipe
from breaker.model.parameters import GAP, MOTIONS, NAMES, Size, split
from breaker.model.quantities import SPEED_UNIT, SPEEDS, Point, Speed, check_quantity

_STEP = 0.25  # ms; cubics between samples are then right to a micrometre, as the tests show
TIMES = np.arange(241) * _STEP
"""Times of the samples, ms."""

_SETTLED = 0.1  # mm from its rest position within which a drive counts as at rest at the end
_HALVINGS = 30  # of a step of the grid, in search of a crossing


@dataclass(eq=False)
class Readings:
    """Curves of ``n`` parameter sets, and what is read from them.

    Attributes:
        theta: Parameters, ``(n, p)``.
        motion: "closing" or "opening".
        pressed: Whether a contact stays pressed in the closed state, ``(n,)``.
    """

    theta: np.ndarray
    motion: str
    pressed: np.ndarray
    _curves: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self._curves, switching, _ = travel(self.theta, TIMES, self.motion)
        self._exists = np.isfinite(switching) & (self.pressed | (self.motion == "closing"))
        self._at = np.where(self._exists, switching, 0.0)

    @property
    def switching(self) -> np.ndarray:
        """Time from the first motion to touch or parting, ``(n,)``, ms."""
        return np.where(self._exists, self._at, np.nan)

    def beyond(self) -> np.ndarray:
        """Largest way beyond the rest position at the end, ``(n,)``, mm."""
        beyond = self._forward - self._forward_rests[1][:, None]
        return np.where(self.pressed & self._exists, _most(beyond), np.nan)

    def duration(self, start: Point, end: Point) -> np.ndarray:
        """Time from one point to another, ``(n,)``, ms; nan where the first is not before."""
        duration = self._place(end)[0] - self._place(start)[0]
        return np.where(duration > 0, duration, np.nan)

    def speed(self, start: Point, end: Point) -> np.ndarray:
        """Mean speed from one point to another, ``(n,)``, mm/ms."""
        (begin, low, before), (stop, high, after) = self._place(start), self._place(end)
        duration = stop - begin
        speed = ((high - low) + (after - before)) / np.where(duration > 0, duration, np.nan)
        return np.abs(speed)

    @cached_property
    def _forward(self) -> np.ndarray:
        """Travel in the direction of the motion, ``(n, t)``, mm."""
        return self._curves if self.motion == "closing" else -self._curves

    @property
    def _forward_rests(self) -> list[np.ndarray]:
        """Rest positions before and after the motion in its direction, ``(n,)`` each, mm."""
        before, after = MOTIONS if self.motion == "closing" else MOTIONS[::-1]
        sign = 1.0 if self.motion == "closing" else -1.0
        return [sign * rest_position(self.theta, each) for each in (before, after)]

    def _place(self, point: Point) -> tuple[np.ndarray, np.ndarray, float]:
        """Time of a point, ``(n,)``, ms, and its travel, as that of a mark ``(n,)`` and the way
        from there, mm; nan where it is not reached.
        """
        if point.later:
            at = self._place(replace(point, later=0.0))[0] + point.later
            return self._time_and_travel(at, np.isfinite(at))
        if not point.of_event:
            start, end = self._forward_rests
            level = start + point.amount / 100.0 * (end - start)
            if point.unit == "mm":
                level = (end if point.amount < 0.0 else start) + point.amount
            level = np.where(self.pressed, level, np.nan)
            at = self._first_after(level, np.zeros(len(level)))
            return np.where(level == start, 0.0, at), level, 0.0
        if point.unit == "ms":
            return self._time_and_travel(self._at + point.amount, self._exists)
        mark = np.where(self._exists, self._travel(self._at), np.nan)
        if point.amount == 0.0:
            return self._at, mark, 0.0
        search = self._last_before if point.amount < 0.0 else self._first_after
        return search(mark + point.amount, self._at), mark, point.amount

    def _time_and_travel(self, at: np.ndarray, exists: np.ndarray) -> tuple:
        """What ``_place`` returns of times ``(n,)``, ms, where they exist and are simulated."""
        there = exists & (at <= TIMES[-1])
        at = np.where(there, at, np.nan)
        return at, self._travel(np.where(there, np.maximum(at, 0.0), 0.0)), 0.0

    def _travel(self, at: np.ndarray) -> np.ndarray:
        """Travel at times ``(n,)``, by cubics, ``(n,)``, mm."""
        first = _around(at)
        return _through(_four(self._forward, first), at / _STEP - first)

    def _last_before(self, level: np.ndarray, end: np.ndarray) -> np.ndarray:
        """Last time before ``end`` (n,) at which a curve passes its level, nan if it does not."""
        below = (self._forward <= level[:, None]) & (end[:, None] > TIMES)
        last = TIMES.size - 1 - np.argmax(below[:, ::-1], axis=1)
        return _crossing(self._forward, level, last, below.any(axis=1))

    def _first_after(self, level: np.ndarray, begin: np.ndarray) -> np.ndarray:
        """First time after ``begin`` (n,) at which a curve reaches its level, nan if never."""
        above = (self._forward >= level[:, None]) & (begin[:, None] < TIMES)
        return _crossing(self._forward, level, np.argmax(above, axis=1) - 1, above.any(axis=1))


# ---- curves (n, t) on the grid ---------------------------------------------------------------


def _around(at: np.ndarray) -> np.ndarray:
    """First of the four samples around each time, ``(n,)``; of the nearest four at the ends."""
    return np.clip(np.floor(at / _STEP).astype(int) - 1, 0, TIMES.size - 4)


def _four(curves: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Four samples of each curve from ``first`` (n,), ``(4, n)``."""
    return np.take_along_axis(curves, first[:, None] + np.arange(4), axis=1).T


def _through(samples: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Values of cubics through samples ``(4, n)``, ``u`` (n,) samples after the first."""
    a, b, c, d = samples
    v, w, x = u - 1, u - 2, u - 3
    return (d * u * v * w - a * v * w * x) / 6 + (b * u * w * x - c * u * v * x) / 2


def _crossing(
    curves: np.ndarray, level: np.ndarray, sample: np.ndarray, found: np.ndarray
) -> np.ndarray:
    """Time between a sample (n,) and the next at which a curve passes its level, by bisection."""
    sample = np.clip(sample, 0, TIMES.size - 2)
    low, width = TIMES[sample], _STEP
    first = _around(low)
    samples = _four(curves, first)
    was_below = np.take_along_axis(curves, sample[:, None], axis=1)[:, 0] <= level
    for _ in range(_HALVINGS):
        width /= 2
        before = (_through(samples, (low + width) / _STEP - first) <= level) == was_below
        low = low + width * before
    return np.where(found, low + width / 2, np.nan)


def _most(beyond: np.ndarray) -> np.ndarray:
    """Largest way beyond rest, ``(n, t) -> (n,)``, between samples by a parabola: 0 if it is not
    passed, nan where it neither has a peak beyond rest nor ends near it.
    """
    peak = np.clip(np.argmax(beyond, axis=1), 1, TIMES.size - 2)
    before, top, after = np.take_along_axis(beyond, peak[:, None] + np.arange(-1, 2), axis=1).T
    bend = 2 * top - before - after
    turns = (top >= before) & (top >= after) & (bend > 0)
    top = top + np.where(turns, (after - before) ** 2 / (8 * np.where(turns, bend, 1.0)), 0.0)
    largest = np.maximum(np.where(turns, top, beyond[:, -1]), 0.0)
    passed = turns & (top > 0)
    return np.where(passed | (np.abs(beyond[:, -1]) <= _SETTLED), largest, np.nan)


# ---- evaluation ----


# Of the reference drive: contact gap, mm, and its own times (``own_time``), ms.
_GAP, _TIMES = 10.0, {"closing": np.sqrt(10.0 / 0.75), "opening": np.sqrt(1.0 / 0.045)}
_NEAR = 0.75  # powers of 2 within which a drive counts as of the reference drive's size
_TRAVEL = Point(10.0, "%"), Point(90.0, "%")  # between which a travel time is taken


def evaluate(
    names: Sequence[str], theta: np.ndarray, motion: str, speeds: Sequence[Speed] = SPEEDS
) -> np.ndarray:
    """Return quantities of parameter sets, ``(n, len(names))``, in the units of ``QUANTITIES``.

    The wipe is that of the formula, ``(f - k_a L) / (k_a + k_b)``: not positive where a contact
    does not stay pressed. Other quantities are nan where they do not exist (see the module).

    Args:
        theta: Parameters, ``(n, p)``, of drives of any size.

    Raises:
        ValueError: If a quantity is unknown or of the other motion, or for parameters that
            ``travel`` refuses.

    Example:
        >>> theta = np.array([[2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0]])
        >>> evaluate(["wipe", "touch_time", "closing_speed"], theta, "closing").round(2)
        array([[ 3.53, 10.09,  1.24]])
    """
    for name in names:
        if complaint := check_quantity(name, motion, speeds):
            raise ValueError(complaint)
    theta, _, _ = check(theta, np.zeros(1), motion, 0.0)
    result = np.empty((len(theta), len(names)))
    for rows in blocks(len(theta)):
        parameters = np.asarray(theta[rows], dtype=np.float64)
        known = dict(zip(NAMES, split(parameters), strict=True)) | _ways(parameters)
        if shown := set(names) - known.keys():
            known |= _read_from_curves(shown, parameters, motion, speeds)
        for column, name in enumerate(names):
            result[rows, column] = known[name]
    return result


def _ways(theta: np.ndarray) -> dict[str, np.ndarray]:
    """Wipe and stroke of parameter sets ``(n, p)``, ``(n,)``."""
    pressed = wipe(theta)
    stroke = theta[..., NAMES.index(GAP.name)] + pressed
    return {"wipe": pressed, "stroke": np.where(pressed > 0, stroke, np.nan)}


def _read_from_curves(
    names: set[str], theta: np.ndarray, motion: str, speeds: Sequence[Speed]
) -> dict[str, np.ndarray]:
    """Simulate parameter sets ``(n, p)`` and return what a curve shows, by name, ``(n,)``."""
    found = {name: np.empty(len(theta)) for name in names}
    for size, rows in _sizes(theta, motion):
        there = theta[rows] / size.factors
        readings = Readings(there, motion, _ways(there)["wipe"] > 0)
        back = Size(1.0 / size.lengths, 1.0 / size.times)
        points = {each.name: (each.sized(back).start, each.sized(back).end) for each in speeds}
        for name in names:
            if name in points:
                found[name][rows] = readings.speed(*points[name]) * size.factor(SPEED_UNIT)
            elif name == "travel_time":
                found[name][rows] = readings.duration(*_TRAVEL) * size.times
            elif name in ("touch_time", "part_time"):
                found[name][rows] = readings.switching * size.times
            else:
                found[name][rows] = readings.beyond() * size.lengths
    return found


def _sizes(theta: np.ndarray, motion: str) -> Iterator[tuple[Size, np.ndarray]]:
    """Yield sizes in powers of 2, and which parameter sets ``(n, p)`` are of about that size."""
    times = own_time(theta, motion) / _TIMES[motion]
    powers = np.log2([theta[..., NAMES.index(GAP.name)] / _GAP, times])
    powers = np.where(np.abs(powers) <= _NEAR, 0.0, np.rint(powers))
    for lengths, duration in np.unique(powers, axis=1).T:
        rows = np.flatnonzero((powers[0] == lengths) & (powers[1] == duration))
        yield Size(2.0**lengths, 2.0**duration), rows
