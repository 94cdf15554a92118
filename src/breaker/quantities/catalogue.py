"""Quantities to set limits on: functions of the seven parameters, and what a record itself shows.

Names, units and motions alone: ``mechanism.evaluation`` reads them from the model's curves, and
``reading.records.measurements`` from a record.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

from breaker.quantities.parameters import MOTIONS, NAMES, PARAMETERS, Parameter
from breaker.quantities.speeds import EVENTS, SPEED_UNIT, SPEEDS, Speed

_SHARPEST = 1e-3  # of its value, to which a fact can be known
_LARGEST_FACT = 1e6

_MODEL, _RECORD, _ANSWER = ("model",), ("record",), ("answer",)
_CLOSING, _OPENING = ("closing",), ("opening",)


@dataclass(frozen=True)
class Quantity(Parameter):
    """A quantity to set limits on, with the attributes of a parameter and:

    Attributes:
        motions: Motions that have it.
        of: Names of the sources that it can be read from; "answer" of what is inferred of a record
            beside the parameters, which no limit is on.
        zone: Of a speed, between which points it is the mean; else empty.
    """

    motions: tuple[str, ...] = MOTIONS
    of: tuple[str, ...] = (*_MODEL, *_RECORD)
    zone: str = ""

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


def _wipe(event: str, meaning: str, motions: tuple[str, ...]) -> Quantity:
    """A wipe as analysers count it, at an event of the contact; of which less is the worse."""
    name, symbol = f"wipe_at_{event}", rf"$w_\mathrm{{{event}}}$"
    return Quantity(name, symbol, "mm", meaning, worse=-1, motions=motions, of=_RECORD)


def _current(name: str, meaning: str, motions: tuple[str, ...] = MOTIONS) -> Quantity:
    """A current of coil or motor, of which more is the worse."""
    symbol = rf"$I_\mathrm{{{name.removesuffix('_current').replace('_', ' ')}}}$"
    return Quantity(name, symbol, "A", meaning, worse=1, motions=motions, of=_RECORD)


def _since(event: str, motions: tuple[str, ...]) -> tuple[Quantity, ...]:
    """Times of an event that networks infer, by their zero: the release, and 10 % of the way."""
    about = f"{event}_after_release", r"$t$", "ms", f"release to {event}"
    release = Quantity(*about, worse=1)
    tenth = Quantity(f"{event}_from10", r"$t_{10}$", "ms", f"10 % of the way to {event}")
    return tuple(replace(each, motions=motions, of=_ANSWER) for each in (release, tenth))


_FIXED = (
    *(Quantity(**vars(parameter), of=_MODEL) for parameter in PARAMETERS),
    Quantity("wipe", r"$w$", "mm", "stroke less contact gap: spring pressed at rest", of=_MODEL),
    Quantity("stroke", r"$s$", "mm", "way of the drive between its rest positions"),
    _time("travel_time", "drive from 10 to 90 % of its stroke"),
    _time("touch_time", "first motion to contact touch", _CLOSING),
    _past("over_travel", "closed", "closing"),
    _time("part_time", "first motion to contact parting", _OPENING),
    _past("rebound", "open", "opening"),
    _time("latch_time", "from the trigger to the first motion", of=_RECORD),
    _time("closing_time", "from the trigger to contact touch", _CLOSING, of=_RECORD),
    _time("opening_time", "from the trigger to contact parting", _OPENING, of=_RECORD),
    _wipe("touch", "way of the drive from contact touch to its closed rest", _CLOSING),
    _wipe("parting", "way of the drive from its closed rest to contact parting", _OPENING),
    _time("bounce_time", "from the first contact touch to the last", _CLOSING, of=_RECORD),
    _current("coil_current", "largest current of the coil"),
    _time("coil_dip_time", "from the trigger to the dip of the coil's current", of=_RECORD),
    _time("coil_off_time", "from the trigger until the coil's current is broken", of=_RECORD),
    _current("motor_inrush", "largest current of the motor as it starts, rms", _CLOSING),
    _current("motor_current", "current of the running motor, rms", _CLOSING),
    replace(_time("charging_time", "for which the motor runs", _CLOSING, of=_RECORD), unit="s"),
    Quantity("release_from10", r"$t_{10}$", "ms", "10 % of the way to release", of=_ANSWER),
    *_since("touch", _CLOSING),
    *_since("parting", _OPENING),
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
            SPEED_UNIT,
            f"mean speed of the drive {speed.words}",
            worse=-1,
            motions=(speed.motion,),
            zone=speed.words,
        )
        for speed in speeds
    )
    return {quantity.name: quantity for quantity in (*_FIXED, *moving)}


def quantities_of(
    motion: str, speeds: Sequence[Speed] = SPEEDS, of: Collection[str] | None = _MODEL
) -> dict[str, Quantity]:
    """Return the quantities of a motion that are no parameters, by name; of any source if ``of`` is
    None.

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

AFTER_RELEASE = {motion: f"{event}_after_release" for motion, event in EVENTS.items()}
"""Names of the time from the release to touch or parting, by motion."""

CURRENTS = {
    **dict.fromkeys(("coil_current", "coil_dip_time", "coil_off_time"), "trigger"),
    **dict.fromkeys(("motor_inrush", "motor_current", "charging_time"), "motor"),
}
"""Those that a current shows, by name: whose it is, of the coil ("trigger") or the motor."""

ANSWERED = frozenset(name for name, each in QUANTITIES.items() if each.of == _ANSWER)
"""Names of those that only an answer has, and no limit is on."""

INFERRED = ANSWERED | {"wipe"}
"""Names of those beside the parameters that are inferred, as no instrument shows them."""


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

    Example:
        >>> check_quantity("latch_time", "closing")
        'latch_time is not of the model: records alone show it, in limits with of: record.'
    """
    every = quantities(speeds)
    there = [each for each in every.values() if motion in each.motions and of in each.of]
    known = ", ".join(each.name for each in there)
    if name not in every:
        return f"{name} is not a known quantity. Known of {motion}: {known}."
    if every[name].of == _ANSWER:
        return f"{name} is of a single answer, and no limit is on it. Known of {motion}: {known}."
    if of not in every[name].of:
        return _ELSEWHERE[of].format(name=name, motion=motion, known=known)
    if motion not in every[name].motions:
        other = " or ".join(every[name].motions)
        return f"{name} is a quantity of {other}, not of {motion}. Known of {motion}: {known}."
    return None
