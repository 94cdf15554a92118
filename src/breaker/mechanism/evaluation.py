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

import numpy as np

from breaker.mechanism.curves import blocks, check
from breaker.mechanism.readings import Readings
from breaker.quantities.catalogue import check_quantity
from breaker.quantities.drive_conditions import own_time, wipe
from breaker.quantities.parameters import GAP, NAMES, split
from breaker.quantities.size import Size
from breaker.quantities.speeds import SPEED_UNIT, SPEEDS, Point, Speed

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
