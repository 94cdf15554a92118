"""Quantities to set limits on: functions of the seven parameters, and what a record itself shows.

Names, units and motions alone: ``mechanism.evaluation`` reads them from the model's curves, and
``reading.records.measurements`` from a record.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from breaker.common.lazy_numpy import np
from breaker.model.parameters import (
    FORCE,
    MOTIONS,
    NAMES,
    OPENING_SPRING,
    PARAMETERS,
    UNIT,
    Parameter,
    Size,
)

if TYPE_CHECKING:
    import xarray as xr

SPEED_UNIT = "m/s"
"""Unit of speeds wherever one is told: as a number the same as mm/ms."""

EVENTS = {"closing": "touch", "opening": "parting"}
_TEXT = re.compile(
    r"(?:(?P<time>\d+(?:\.\d+)?) ?ms (?P<when>before|after) )?(?:"
    r"(?:(?P<way>\d+(?:\.\d+)?) ?mm (?P<side>before|after) )?(?P<event>touch|parting)"
    r"|(?P<amount>\d+(?:\.\d+)?) ?(?P<unit>%|mm(?= from)) (?P<of>of stroke|from open|from closed))"
)
_RESTS = {"closing": ("open", "closed"), "opening": ("closed", "open")}  # before and after
_WAY = 6.0  # mm at size 1, over which a speed is taken that is not configured
_STROKE = 12.5  # mm, the stroke of most drives of size 1


@dataclass(frozen=True)
class Point:
    """A point of a motion.

    Attributes:
        amount: Way or time from touch or parting or way from a rest, negative before it, or percent
            of the stroke from where the motion begins.
        unit: "mm", "ms" or "%".
        rest: "open" or "closed", from which a way counts; "" is touch or parting.
        later: Time from where the travel is there to the point, ms; negative before it.

    Example:
        >>> Point.read("6 mm before touch", "closing")
        Point(amount=-6.0, unit='mm', rest='', later=0.0)
        >>> Point.read("10 ms after 30 % from open", "opening").text("opening")
        '10 ms after 70 % of stroke'
    """

    amount: float
    unit: str
    rest: str = ""
    later: float = 0.0

    @classmethod
    def read(cls, text: str, motion: str) -> Point:
        """Read a point of a motion from its text.

        Raises:
            ValueError: If the text is not of a known form, or of the other motion.
        """
        event = EVENTS[motion]
        found = _TEXT.fullmatch(" ".join(str(text).split()))
        if found is None or found["event"] not in (None, event):
            raise ValueError(
                f"{text!r} is no point of {motion}; write {event}, such as 6 mm before {event}, "
                f"10 ms after {event}, 10 % of stroke, 20 % from closed, 20 mm from open, or 10 ms "
                "after 50 % of stroke"
            )
        later = float(found["time"] or 0.0) * (-1.0 if found["when"] == "before" else 1.0)
        if found["event"]:
            way = float(found["way"] or 0.0) * (-1.0 if found["side"] == "before" else 1.0)
            return cls(way, "mm", later=later) if way or not later else cls(later, "ms")
        rest = found["of"].removeprefix("from ")
        back = rest == _RESTS[motion][1]
        amount = float(found["amount"])
        if found["unit"] == "mm" and amount:
            return cls(-amount if back else amount, "mm", rest, later)
        if not amount <= 100:
            raise ValueError(f"{text!r} is no point: shares are from 0 to 100 %")
        return cls(100.0 - amount if back else amount, "%", later=later)  # 0 mm are 0 %

    @property
    def of_event(self) -> bool:
        """Whether it is known only where touch or parting is."""
        return self.unit != "%" and not self.rest

    def text(self, motion: str) -> str:
        """Write the point as ``read`` takes it."""
        event = EVENTS[motion]
        side = "before" if self.amount < 0 else "after"
        place = f"{abs(self.amount):g} {self.unit} {side} {event}" if self.amount else event
        if self.unit == "%":
            place = f"{self.amount:g} % of stroke"
        elif self.rest:
            place = f"{abs(self.amount):g} mm from {self.rest}"
        when = "before" if self.later < 0 else "after"
        return f"{abs(self.later):g} ms {when} {place}" if self.later else place

    def sized(self, size: Size) -> Point:
        """Return the point for a drive of another size."""
        amount = self.amount * (1.0 if self.unit == "%" else size.factor(self.unit))
        return replace(self, amount=amount, later=self.later * size.times)


@dataclass(frozen=True)
class Speed:
    """Mean speed of the drive between two points.

    Attributes:
        name: Name of the speed, which begins with the name of its motion.
        start, end: The points.

    Example:
        >>> speed = Speed.read("closing_speed", ["10 ms before touch", "touch"])
        >>> speed.motion, speed.words
        ('closing', 'from 10 ms before touch to touch')
    """

    name: str
    start: Point
    end: Point

    def __post_init__(self) -> None:
        start, end = self.start, self.end
        alike = start.unit == end.unit or (start.of_event and 0 in (start.amount, end.amount))
        comparable = alike and start.rest == end.rest and start.of_event == end.of_event
        if comparable and not (start.amount, start.later) < (end.amount, end.later):
            raise ValueError(f"{self.name} goes {self.words}, which is not forward; swap them")

    @classmethod
    def read(cls, name: str, points: Sequence[str]) -> Speed:
        """Read a speed from its name and the texts of its two points.

        Raises:
            ValueError: If a point is wrong, or the second is not after the first.
        """
        if len(points) != 2:
            raise ValueError(f"{name} needs two points, from and to, not {len(points)}")
        try:
            return cls(name, *(Point.read(text, name.split("_")[0]) for text in points))
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from error

    @property
    def motion(self) -> str:
        """Its motion."""
        return self.name.split("_")[0]

    @property
    def points(self) -> list[str]:
        """Points of the speed as ``read`` takes them."""
        return [each.text(self.motion) for each in (self.start, self.end)]

    @property
    def words(self) -> str:
        """Between which points, in words: those of a configuration, or in short of shares."""
        shares = (self.start.unit, self.end.unit) == ("%", "%")
        if shares and not (self.start.later or self.end.later):
            return f"from {self.start.amount:g} to {self.end.text(self.motion)}"
        return "from {} to {}".format(*self.points)

    @property
    def of_event(self) -> bool:
        """Whether it is known only where touch or parting is."""
        return self.start.of_event or self.end.of_event

    def sized(self, size: Size) -> Speed:
        """Return the speed for a drive of another size."""
        return replace(self, start=self.start.sized(size), end=self.end.sized(size))


def speeds_of(
    settings: Mapping[str, Sequence[str] | None] | None = None, size: Size = UNIT
) -> tuple[Speed, ...]:
    """Return the speeds that the section ``speeds`` of the configuration defines.

    ``closing_speed`` and ``opening_speed`` are always there: unless given, over the last 6 mm
    before the touch, and the first 6 mm after the parting, times the length of the size, to two
    digits.

    Raises:
        ValueError: If a definition is wrong.

    Example:
        >>> speeds = speeds_of({"closing_speed_mean": ["10 % of stroke", "90 % of stroke"]})
        >>> [speed.name for speed in speeds]
        ['closing_speed', 'opening_speed', 'closing_speed_mean']
        >>> speeds_of(size=Size(lengths=10.7, times=3.9))[0].words
        'from 64 mm before touch to touch'
    """
    way = float(f"{_WAY * size.lengths:.2g}")
    touch = Point(0.0, "mm")
    usual = {
        "closing_speed": Speed("closing_speed", Point(-way, "mm"), touch),
        "opening_speed": Speed("opening_speed", touch, Point(way, "mm")),
    }
    given = {name: points for name, points in (settings or {}).items() if points is not None}
    if unknown := (settings or {}).keys() - given.keys() - usual.keys():
        raise ValueError(f"{min(unknown)} needs two points, from and to")
    return tuple((usual | {name: Speed.read(name, given[name]) for name in given}).values())


def speeds_at(settings: Mapping[str, Sequence[str] | None], stroke: float) -> tuple[Speed, ...]:
    """Return the speeds of a drive with a stroke, mm: where none is configured, over a way that is
    the same for drives alike, as its size is rounded to one digit. Raises as ``speeds_of``.
    """
    return speeds_of(settings, Size(float(f"{stroke / _STROKE:.1g}")))


OF_STROKE = {
    f"{motion}_speed_{begin}_{end}": [f"{begin} % of stroke", f"{end} % of stroke"]
    for motion in EVENTS
    for begin, end in ((10, 90), (10, 50), (50, 90))
}
"""Points of speeds that any record shows, also one without a contact, by name: over most of the
way, and over either half of that, which shows where a drive is slow."""


def every_speed(settings: Mapping[str, Sequence[str] | None]) -> tuple[Speed, ...]:
    """Return the speeds that the section ``speeds`` defines, and those that any record shows: what
    limits may name. Raises as ``speeds_of``.
    """
    return speeds_of({**OF_STROKE, **settings})


def with_named(
    settings: Mapping[str, Sequence[str] | None], limits: Sequence[Mapping[str, object]]
) -> dict[str, Sequence[str] | None]:
    """Return the section ``speeds`` with those speeds that any record shows and limits name.

    Example:
        >>> with_named({}, [{"name": "slow", "lower": {"closing_speed_10_50": 1.2}}])
        {'closing_speed_10_50': ['10 % of stroke', '50 % of stroke']}
    """
    text = str(limits)
    return {n: points for n, points in OF_STROKE.items() if n in text} | dict(settings)


SPEEDS = speeds_of()
"""Speeds of a drive of size 1 where none is configured."""


# ---- catalogue ----


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


# ---- moving mass ----


_LARGEST = 1e5  # kg
_WIDEST = 1.0 / 3.0  # of the mass, that its standard deviation may be


@dataclass(frozen=True)
class MassQuantity:
    """A quantity that needs the moving mass: a parameter, of name ``of``, times mass and factor.

    Attributes:
        factor: From the parameter's unit times kg and mm to the power ``ways`` to the unit.
        ways: Power of the stroke.
    """

    name: str
    unit: str
    meaning: str
    of: str
    factor: float
    ways: int = 0


# By unit of a parameter: the unit with the mass, and the factor to it. mm/ms^2 are 1e3 m/s^2,
# 1/ms^2 are 1e6 1/s^2, 1/ms are 1e3 1/s, and mm are 1e-3 m.
_UNITS = {"mm/ms²": ("N", 1e3), "1/ms²": ("N/m", 1e6), "1/ms": ("N s/m", 1e3)}
_OTHERS = tuple(each for each in PARAMETERS if each.unit in _UNITS and each is not FORCE)
_WORK, _ENERGY = "work of the closing force over the stroke", "energy of the opening spring, closed"

MASS_QUANTITIES = (
    *(
        MassQuantity(
            each.word.replace(" ", "_"),
            _UNITS[each.unit][0],
            each.word,
            each.name,
            _UNITS[each.unit][1],
        )
        for each in (FORCE, *_OTHERS)
    ),
    MassQuantity("closing_work", "J", _WORK, FORCE.name, 1.0, 1),
    MassQuantity("opening_energy", "J", _ENERGY, OPENING_SPRING.name, 0.5e6 * 1e-6, 2),
)
"""All of them, in the order in which they are told."""


def check_mass(mass: float, sd: float) -> str | None:
    """Return why nothing moves with such a mass, kg, with a remedy; None if it may.

    Example:
        >>> check_mass(0.0, 0.5)
        'has the value 0, but a moving mass is above 0 and at most 100000 kg.'
    """
    if not 0.0 < mass <= _LARGEST:
        return f"has the value {mass:g}, but a moving mass is above 0 and at most {_LARGEST:g} kg."
    if not 0.0 <= sd <= _WIDEST * mass:
        return (
            f"has the standard deviation {sd:g}, but must have one from 0 to a third of the mass: "
            "weigh the moving parts, or leave it out."
        )
    return None


def mass_draws(mass: float, sd: float, n: int, rng: np.random.Generator) -> np.ndarray:
    """Return draws of a mass, ``(n,)``, kg: normal, and above 0."""
    return np.abs(mass + sd * rng.standard_normal(n))


def with_mass(theta: np.ndarray, stroke: float, mass: np.ndarray) -> dict[str, np.ndarray]:
    """Return draws of all quantities by name, ``(d,)``.

    Args:
        theta: Draws of the parameters, ``(d, p)``.
        stroke: Of the drive, mm.
        mass: Of the drive, kg, ``(d,)``.
    """
    return {
        each.name: each.factor * theta[:, NAMES.index(each.of)] * mass * stroke**each.ways
        for each in MASS_QUANTITIES
    }


# ---- advice ----


LOOK = "Where to look first (no diagnosis)"
"""What stands before such words."""


def advice_on(names: Iterable[str], advice: Mapping[str, str]) -> list[str]:
    """Say where to look first for quantities, parameters or mechanisms, the same words once.

    Args:
        names: Of what has become worse. A speed that has no entry has that of its motion.

    Example:
        >>> advice_on(["f", "mu", "closing_speed_10_90"], {"f": "spring", "closing_speed": "latch"})
        ['f: spring', 'closing_speed_10_90: latch']
    """
    found: dict[str, dict[str, None]] = {}
    for name in names:
        motion = name.partition("_speed_")[0]
        key = f"{motion}_speed" if name not in advice and motion in MOTIONS else name
        if words := advice.get(key):
            found.setdefault(words, {})[name] = None
    return [f"{', '.join(these)}: {words}" for words, these in found.items()]


# ---- operation metadata ----


CONDITIONS = ("temperature", "voltage")
"""What an operation depends on beside the drive."""

ABOUT = ("breaker", "phase", "date", *CONDITIONS, "event")
"""What is known of an operation and kept through to all results; empty where it is not."""


def metadata_names(data: xr.Dataset) -> list[str]:
    """Return which of ``ABOUT`` a dataset of operations has a value of, for any operation."""
    return [
        name
        for name in ABOUT
        if name in data and any(value == value and value != "" for value in data[name].values)
    ]
