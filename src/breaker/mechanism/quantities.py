"""Quantities to set limits on, as functions of the seven parameters.

Times, speeds and ways are read from the exact curve of a parameter set, without noise, its motion
starting at 0. A quantity that does not exist for a parameter set is nan:

- of a closing whose contact does not touch within 60 ms, all that is read from the curve;
- of an opening whose contact does not part within 60 ms, or that has no closed state to start from
  (no wipe, ``f <= k_a L``), the same;
- a speed over 6 mm, where the drive does not travel as far before the touch or after the parting;
- the over-travel without a closed rest position (no wipe), and over-travel or rebound of a drive
  that is still on its way at 60 ms.

A contact whose force falls to zero again after the touch counts as closed, as in ``mechanism``.
Compiled code is imported where it is called: to check a configuration, with which every job of the
workflow begins, takes the names alone.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from breaker.mechanism.parameters import MOTIONS, NAMES, PARAMETERS, Parameter, split

__all__ = ["QUANTITIES", "Quantity", "check_quantity", "evaluate"]

_STEP = 0.25  # ms; cubics between samples are then right to a micrometre, as the tests show
_TIMES = np.arange(241) * _STEP
_WAY = 6.0  # mm, over which a speed is taken
_SETTLED = 0.1  # mm from its rest position within which a drive counts as at rest at the end
_HALVINGS = 30  # of a step of the grid, in search of a crossing


@dataclass(frozen=True)
class Quantity(Parameter):
    """A quantity to set limits on, with the attributes of a parameter and:

    Attributes:
        motions: Motions that have it.
    """

    motions: tuple[str, ...]


QUANTITIES = {
    quantity.name: quantity
    for quantity in (
        *(Quantity(**asdict(parameter), motions=MOTIONS) for parameter in PARAMETERS),
        Quantity("wipe", r"$w$", "mm", "way of the drive past the contact gap, closed", MOTIONS),
        Quantity(
            "touch_time", r"$t_\mathrm{touch}$", "ms", "first motion to contact touch", ("closing",)
        ),
        Quantity(
            *("closing_speed", r"$v_\mathrm{close}$", "mm/ms"),
            *("mean speed of the drive over the last 6 mm before the touch", ("closing",)),
        ),
        Quantity(
            *("over_travel", r"$\Delta_\mathrm{close}$", "mm"),
            *("largest travel beyond the closed rest position", ("closing",)),
        ),
        Quantity(
            "part_time", r"$t_\mathrm{part}$", "ms", "first motion to contact parting", ("opening",)
        ),
        Quantity(
            *("opening_speed", r"$v_\mathrm{open}$", "mm/ms"),
            *("mean speed of the drive over the first 6 mm after the parting", ("opening",)),
        ),
        Quantity(
            *("rebound", r"$\Delta_\mathrm{open}$", "mm"),
            *("largest travel beyond the open rest position", ("opening",)),
        ),
    )
}
"""The seven parameters and what follows from them, by name."""


def check_quantity(name: str, motion: str) -> str | None:
    """Return why a motion does not have a quantity, with a remedy; None if it has it."""
    known = ", ".join(each.name for each in QUANTITIES.values() if motion in each.motions)
    if name not in QUANTITIES:
        return f"{name} is not a known quantity. Known of {motion}: {known}."
    if motion not in QUANTITIES[name].motions:
        other = " or ".join(QUANTITIES[name].motions)
        return f"{name} is a quantity of {other}, not of {motion}. Known of {motion}: {known}."
    return None


def evaluate(names: Sequence[str], theta: np.ndarray, motion: str) -> np.ndarray:
    """Return quantities of parameter sets, ``(n, len(names))``, in the units of ``QUANTITIES``.

    Each set is simulated once, and not at all if no quantity needs its curve. The wipe is that of
    the formula, ``(f - k_a L) / (k_a + k_b)``: not positive where a contact does not stay pressed.

    Args:
        names: Names of quantities.
        theta: Parameters, ``(n, p)``.
        motion: "closing" or "opening".

    Returns:
        float64; nan where a quantity does not exist (see the module).

    Raises:
        ValueError: If a quantity is unknown or of the other motion, or for parameters that
            ``travel`` refuses.

    Example:
        >>> theta = np.array([[2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0]])
        >>> evaluate(["wipe", "touch_time", "closing_speed"], theta, "closing").round(2)
        array([[ 3.53, 10.09,  1.24]])
    """
    from breaker.mechanism.curves import blocks, check

    for name in names:
        if complaint := check_quantity(name, motion):
            raise ValueError(complaint)
    theta, _, _ = check(theta, _TIMES, motion, 0.0)
    result = np.empty((len(theta), len(names)))
    for rows in blocks(len(theta)):
        parameters = np.asarray(theta[rows], dtype=np.float64)
        known = dict(zip(NAMES, split(parameters), strict=True)) | {"wipe": _wipe(parameters)}
        if not known.keys() >= set(names):
            known |= _read_from_curves(parameters, motion)
        for column, name in enumerate(names):
            result[rows, column] = known[name]
    return result


def _wipe(theta: np.ndarray) -> np.ndarray:
    _, k_a, k_b, _, _, f, gap = split(theta)
    return (f - k_a * gap) / (k_a + k_b)


def _read_from_curves(theta: np.ndarray, motion: str) -> dict[str, np.ndarray]:
    """Simulate parameter sets ``(n, p)`` and return what a curve shows, by name, ``(n,)``."""
    from breaker.mechanism.curves import rest_position, travel

    curves, switching, _ = travel(theta, _TIMES, motion)
    pressed = _wipe(theta) > 0
    exists = np.isfinite(switching) & (pressed | (motion == "closing"))
    at = np.where(exists, switching, 0.0)
    level = _cubic(curves, _around(at), at) - _WAY
    if motion == "closing":
        names = "touch_time", "closing_speed", "over_travel"
        crossing = _last_rise(curves, level, at)
        beyond = curves - rest_position(theta, "opening")[:, None]
    else:
        names = "part_time", "opening_speed", "rebound"
        crossing, beyond = _first_fall(curves, level, at), -curves
    speed = _WAY / np.abs(at - crossing)
    values = switching, speed, np.where(pressed, _most(beyond), np.nan)
    return {
        name: np.where(exists, value, np.nan) for name, value in zip(names, values, strict=True)
    }


# ---- curves (n, t) on the grid ---------------------------------------------------------------


def _around(at: np.ndarray) -> np.ndarray:
    """First of the four samples around each time, ``(n,)``; of the nearest four at the ends."""
    return np.clip(np.floor(at / _STEP).astype(int) - 1, 0, _TIMES.size - 4)


def _cubic(curves: np.ndarray, first: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Values ``(n,)`` at times ``(n,)`` of the cubics through four samples from ``first``."""
    a, b, c, d = np.take_along_axis(curves, first[:, None] + np.arange(4), axis=1).T
    u = at / _STEP - first
    v, w, x = u - 1, u - 2, u - 3
    return (d * u * v * w - a * v * w * x) / 6 + (b * u * w * x - c * u * v * x) / 2


def _last_rise(curves: np.ndarray, level: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Last time before ``end`` (n,) at which a curve rises past its level, nan if it does not."""
    below = (curves <= level[:, None]) & (end[:, None] > _TIMES)
    last = _TIMES.size - 1 - np.argmax(below[:, ::-1], axis=1)
    return _crossing(curves, level, last, below.any(axis=1))


def _first_fall(curves: np.ndarray, level: np.ndarray, begin: np.ndarray) -> np.ndarray:
    """First time after ``begin`` (n,) at which a curve falls to its level, nan if it does not."""
    below = (curves <= level[:, None]) & (begin[:, None] < _TIMES)
    return _crossing(curves, level, np.argmax(below, axis=1) - 1, below.any(axis=1))


def _crossing(
    curves: np.ndarray, level: np.ndarray, sample: np.ndarray, found: np.ndarray
) -> np.ndarray:
    """Time between a sample (n,) and the next at which a curve passes its level, by bisection."""
    sample = np.clip(sample, 0, _TIMES.size - 2)
    low, high = _TIMES[sample], _TIMES[sample + 1]
    first = _around(low)
    was_below = np.take_along_axis(curves, sample[:, None], axis=1)[:, 0] <= level
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        before = (_cubic(curves, first, middle) <= level) == was_below
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return np.where(found, (low + high) / 2, np.nan)


def _most(beyond: np.ndarray) -> np.ndarray:
    """Largest way beyond rest, ``(n, t) -> (n,)``: 0 if it is not passed, nan if still open.

    Between samples by a parabola. It is open where the way neither has a peak beyond rest nor
    ends near it.
    """
    peak = np.clip(np.argmax(beyond, axis=1), 1, _TIMES.size - 2)
    before, top, after = np.take_along_axis(beyond, peak[:, None] + np.arange(-1, 2), axis=1).T
    bend = 2 * top - before - after
    turns = (top >= before) & (top >= after) & (bend > 0)
    top = top + np.where(turns, (after - before) ** 2 / (8 * np.where(turns, bend, 1.0)), 0.0)
    largest = np.maximum(np.where(turns, top, beyond[:, -1]), 0.0)
    passed = turns & (top > 0)
    return np.where(passed | (np.abs(beyond[:, -1]) <= _SETTLED), largest, np.nan)
