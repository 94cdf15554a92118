"""Quantities to set limits on: functions of the seven parameters, and what a record itself shows.

Of the model, times, speeds and ways are read from the exact curve of a parameter set, without
noise, its motion starting at 0. A quantity that does not exist for a parameter set is nan:

- of a closing whose contact does not touch within 60 ms, all that needs the touch;
- of an opening whose contact does not part within 60 ms, or that has no closed state to start from
  (no wipe, ``f <= k_a L``), the same;
- a speed between points that the drive does not pass, such as 6 mm before the touch of one that
  does not travel as far;
- what needs a closed rest position where there is none (no wipe): stroke, travel time, over-travel;
- over-travel or rebound of a drive that is still on its way at 60 ms.

A contact whose force falls to zero again after the touch counts as closed, as in ``mechanism``.

Any size of drive: a parameter set is read as one of about the size of the reference drive, with
lengths and times divided by powers of 2, which is exact; the 60 ms are of that size. The powers
follow from the set alone, and are 0 within 5 prior standard deviations of the reference drive.

Compiled code is imported where it is called: to check a configuration, with which every job of the
workflow begins, takes the names alone.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from breaker.mechanism.parameters import MOTIONS, NAMES, PARAMETERS, Parameter, split
from breaker.mechanism.size import Size
from breaker.mechanism.speeds import SPEEDS, Point, Speed

# Of the reference drive: contact gap, mm, and the times in which force and opening spring move it,
# sqrt(L / f) and sqrt(1 / k_a), ms.
_GAP, _TIMES = 10.0, {"closing": np.sqrt(10.0 / 0.75), "opening": np.sqrt(1.0 / 0.045)}
_NEAR = 0.75  # powers of 2 within which a drive counts as of the reference drive's size
_TRAVEL = Point(10.0, "%"), Point(90.0, "%")  # between which a travel time is taken
_SHARPEST = 1e-3  # of its value, to which a fact can be known
_LARGEST_FACT = 1e6

_MODEL, _RECORD = ("model",), ("record",)
_CLOSING, _OPENING = ("closing",), ("opening",)


@dataclass(frozen=True)
class Quantity(Parameter):
    """A quantity to set limits on, with the attributes of a parameter and:

    Attributes:
        motions: Motions that have it.
        of: Names of the sources that it can be read from (``sources``).
    """

    motions: tuple[str, ...] = MOTIONS
    of: tuple[str, ...] = (*_MODEL, *_RECORD)

    @property
    def modelled(self) -> bool:
        """Whether the model has it."""
        return "model" in self.of


def _time(name: str, meaning: str, motions: tuple[str, ...] = MOTIONS, **more) -> Quantity:
    """A time, of which more is the worse."""
    symbol = rf"$t_\mathrm{{{name.removesuffix('_time')}}}$"
    return Quantity(name, symbol, "ms", meaning, worse=1, motions=motions, **more)


def _past(name: str, rest: str, motion: str) -> Quantity:
    """A way past a rest position, of which more is the worse."""
    meaning = f"largest travel beyond the {rest} rest position"
    symbol = {"closing": r"$\Delta_\mathrm{close}$", "opening": r"$\Delta_\mathrm{open}$"}[motion]
    return Quantity(name, symbol, "mm", meaning, worse=1, motions=(motion,))


_FIXED = (
    *(Quantity(**vars(parameter), of=_MODEL) for parameter in PARAMETERS),
    Quantity("wipe", r"$w$", "mm", "way of the drive past the contact gap, closed", of=_MODEL),
    Quantity("stroke", r"$s$", "mm", "way of the drive between its rest positions"),
    _time("travel_time", "time in which the drive goes from 10 to 90 % of its stroke"),
    _time("touch_time", "first motion to contact touch", _CLOSING),
    _past("over_travel", "closed", "closing"),
    _time("part_time", "first motion to contact parting", _OPENING),
    _past("rebound", "open", "opening"),
    _time("latch_time", "from the trigger to the first motion", of=_RECORD),
    _time("closing_time", "from the trigger to contact touch", _CLOSING, of=_RECORD),
    _time("opening_time", "from the trigger to contact parting", _OPENING, of=_RECORD),
    _time("bounce_time", "from the first contact touch to the last", _CLOSING, of=_RECORD),
)
_ELSEWHERE = {  # where a quantity is, by where it is not
    "model": "{name} is not of the model: records alone show it, in limits with of: record.",
    "record": "{name} is a quantity of the model, which no record shows. Take of: model, or one "
    "that records show of {motion}: {known}.",
}
_SYMBOLS = {"closing_speed": r"$v_\mathrm{close}$", "opening_speed": r"$v_\mathrm{open}$"}


def quantities(speeds: Sequence[Speed] = SPEEDS) -> dict[str, Quantity]:
    """Return all quantities by name: the seven parameters and what follows from them.

    Example:
        >>> quantities()["closing_speed"].meaning
        'mean speed of the drive from 6 mm before touch to touch'
    """
    moving = (
        Quantity(
            speed.name,
            _SYMBOLS.get(speed.name, speed.name),
            "mm/ms",
            f"mean speed of the drive {speed.words}",
            worse=-1,
            motions=(speed.motion,),
        )
        for speed in speeds
    )
    return {quantity.name: quantity for quantity in (*_FIXED, *moving)}


def quantities_of(
    motion: str, speeds: Sequence[Speed] = SPEEDS, of: Collection[str] | None = _MODEL
) -> dict[str, Quantity]:
    """Return the quantities of a motion that are no parameters, by name.

    Args:
        motion: "closing" or "opening".
        of: Names of sources, any of which they can be read from; None for any at all.

    Example:
        >>> list(quantities_of("opening"))
        ['wipe', 'stroke', 'travel_time', 'part_time', 'rebound', 'opening_speed']
    """
    return {
        name: each
        for name, each in quantities(speeds).items()
        if motion in each.motions and name not in NAMES and (of is None or set(of) & set(each.of))
    }


QUANTITIES = quantities()
"""Quantities of a drive whose speeds are defined as usual, by name."""


def check_fact(value: float, sd: float) -> str | None:
    """Return why nobody knows a quantity so, with a remedy; None if that may be.

    Example:
        >>> check_fact(-10.0, 0.1)
        'has the value -10, but must have one from 0 to 1e+06.'
    """
    if not 0 <= value <= _LARGEST_FACT:
        return f"has the value {value:g}, but must have one from 0 to {_LARGEST_FACT:g}."
    if not (sd > 0 and _SHARPEST * value <= sd <= _LARGEST_FACT):
        return (
            f"has the standard deviation {sd:g}, but must have one above 0, and at least a "
            "thousandth of the value: nothing in a drive is known better."
        )
    return None


def check_quantity(
    name: str, motion: str, speeds: Sequence[Speed] = SPEEDS, of: str = "model"
) -> str | None:
    """Return why a motion does not have a quantity, with a remedy; None if it has it.

    Args:
        motion: "closing" or "opening".
        of: What it is to be read from, "model" or "record".

    Example:
        >>> check_quantity("latch_time", "closing")
        'latch_time is not of the model: records alone show it, in limits with of: record.'
    """
    every = quantities(speeds)
    there = [each for each in every.values() if motion in each.motions and of in each.of]
    known = ", ".join(each.name for each in there)
    if name not in every:
        return f"{name} is not a known quantity. Known of {motion}: {known}."
    if of not in every[name].of:
        return _ELSEWHERE[of].format(name=name, motion=motion, known=known)
    if motion not in every[name].motions:
        other = " or ".join(every[name].motions)
        return f"{name} is a quantity of {other}, not of {motion}. Known of {motion}: {known}."
    return None


def evaluate(
    names: Sequence[str], theta: np.ndarray, motion: str, speeds: Sequence[Speed] = SPEEDS
) -> np.ndarray:
    """Return quantities of parameter sets, ``(n, len(names))``, in the units of ``QUANTITIES``.

    Each set is simulated once, and not at all if no quantity needs its curve. The wipe is that of
    the formula, ``(f - k_a L) / (k_a + k_b)``: not positive where a contact does not stay pressed.

    Args:
        theta: Parameters, ``(n, p)``, of drives of any size.
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
    _, k_a, k_b, _, _, f, gap = split(theta)
    wipe = (f - k_a * gap) / (k_a + k_b)
    return {"wipe": wipe, "stroke": np.where(wipe > 0, gap + wipe, np.nan)}


def _read_from_curves(
    names: set[str], theta: np.ndarray, motion: str, speeds: Sequence[Speed]
) -> dict[str, np.ndarray]:
    """Simulate parameter sets ``(n, p)`` and return what a curve shows, by name, ``(n,)``."""
    from breaker.mechanism.readings import Readings

    found = {name: np.empty(len(theta)) for name in names}
    for size, rows in _sizes(theta, motion):
        there = theta[rows] / size.factors
        readings = Readings(there, motion, _ways(there)["wipe"] > 0)
        back = Size(1.0 / size.lengths, 1.0 / size.times)
        points = {each.name: (each.sized(back).start, each.sized(back).end) for each in speeds}
        for name in names:
            if name in points:
                found[name][rows] = readings.speed(*points[name]) * size.factor("mm/ms")
            elif name == "travel_time":
                found[name][rows] = readings.duration(*_TRAVEL) * size.times
            elif name in ("touch_time", "part_time"):
                found[name][rows] = readings.switching * size.times
            else:
                found[name][rows] = readings.beyond() * size.lengths
    return found


def _sizes(theta: np.ndarray, motion: str) -> Iterator[tuple[Size, np.ndarray]]:
    """Yield sizes in powers of 2, and which parameter sets ``(n, p)`` are of about that size."""
    _, k_a, _, _, _, f, gap = split(theta)
    times = np.sqrt(gap / f if motion == "closing" else 1.0 / k_a) / _TIMES[motion]
    powers = np.log2([gap / _GAP, times])
    powers = np.where(np.abs(powers) <= _NEAR, 0.0, np.rint(powers))
    for lengths, duration in np.unique(powers, axis=1).T:
        rows = np.flatnonzero((powers[0] == lengths) & (powers[1] == duration))
        yield Size(2.0**lengths, 2.0**duration), rows
