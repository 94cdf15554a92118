"""Quantities of a motion: names, units and definitions of quantities of a curve or record.

These quantities add to the seven parameters and have the names that analysers print (the paper has
none). ``evaluation`` computes them from exact curves of the model, and ``breaker.records`` reads
them from records. Limits, reports and tables name them. This module only defines quantities, and
loads without numpy.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches

from breaker.model.parameters import MOTIONS, NAMES, PARAMETERS, UNIT, Parameter, Size

SPEED_UNIT = "m/s"  # the same number as mm/ms

EVENTS = {"closing": "touch", "opening": "separation"}
"""Contact event of each motion: contact touch and contact separation."""

# ---- points and speeds -----------------------------------------------------------------------

_TEXT = re.compile(
    r"(?:(?P<time>\d+(?:\.\d+)?) ?ms (?P<when>before|after) )?(?:"
    r"(?:(?P<distance>\d+(?:\.\d+)?) ?mm (?P<side>before|after) )?(?P<event>touch|separation)"
    r"|(?P<amount>\d+(?:\.\d+)?) ?(?P<unit>%|mm(?= from)) (?P<of>of stroke|from open|from closed))"
)
_RESTS = {"closing": ("open", "closed"), "opening": ("closed", "open")}  # before and after
_SPEED_TRAVEL = 6.0  # mm at size 1: catalogues state speeds over the 6 mm next to the contact event
_USUAL_STROKE = 12.5  # mm at size 1: contact gap plus spring compression of 12 kV breakers


@dataclass(frozen=True)
class Point:
    """A point of a motion.

    Attributes:
        amount: Distance from the contact event or from a rest position, negative before it, or
            percent of the stroke from the rest position at which the motion begins.
        unit: "mm" or "%"; "ms" if the amount is the time from the contact event.
        rest: "open" or "closed", the rest position from which a distance counts; "" for the event.
        later: Time from the instant at which the drive is at that travel to the point, ms.

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
            ValueError: If the text has no known form, or names the event of the other motion.
        """
        event = EVENTS[motion]
        match = _TEXT.fullmatch(" ".join(str(text).split()))
        if match is None or match["event"] not in (None, event):
            raise ValueError(
                f"{text!r} is not a point of {motion}. Write {event}, 6 mm before {event}, 10 ms "
                f"after {event}, 10 % of stroke, 20 mm from open, or 10 ms after 50 % of stroke"
            )
        later = float(match["time"] or 0.0) * (-1.0 if match["when"] == "before" else 1.0)
        if match["event"]:
            distance = float(match["distance"] or 0.0) * (-1.0 if match["side"] == "before" else 1)
            return cls(distance, "mm", later=later) if distance or not later else cls(later, "ms")
        rest = match["of"].removeprefix("from ")
        back = rest == _RESTS[motion][1]
        amount = float(match["amount"])
        if match["unit"] == "mm" and amount:
            return cls(-amount if back else amount, "mm", rest, later)
        if not amount <= 100:
            raise ValueError(f"{text!r} is not a point. Write a share from 0 to 100 %")
        return cls(100.0 - amount if back else amount, "%", later=later)  # 0 mm are 0 %

    @property
    def of_event(self) -> bool:
        """Whether the point is known only with the time of the contact event."""
        return self.unit != "%" and not self.rest

    def text(self, motion: str) -> str:
        """Return the text of the point for ``read``."""
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
        same_unit = start.unit == end.unit or (start.of_event and 0 in (start.amount, end.amount))
        comparable = same_unit and start.rest == end.rest and start.of_event == end.of_event
        if comparable and not (start.amount, start.later) < (end.amount, end.later):
            raise ValueError(f"{self.name} goes {self.words}, which is not forward. Swap them")

    @classmethod
    def read(cls, name: str, points: Sequence[str]) -> Speed:
        """Read a speed from its name and the texts of its two points.

        Raises:
            ValueError: If a point is wrong, or the second is not after the first.
        """
        if not points or len(points) != 2:
            raise ValueError(f"{name} needs two points, from and to")
        try:
            return cls(name, *(Point.read(text, name.split("_")[0]) for text in points))
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from error

    @property
    def motion(self) -> str:
        """Motion of the speed."""
        return self.name.split("_")[0]

    @property
    def points(self) -> list[str]:
        """Texts of the points for ``read``."""
        return [point.text(self.motion) for point in (self.start, self.end)]

    @property
    def words(self) -> str:
        """Points in words."""
        shares = (self.start.unit, self.end.unit) == ("%", "%")
        if shares and not (self.start.later or self.end.later):
            return f"from {self.start.amount:g} to {self.end.text(self.motion)}"
        return "from {} to {}".format(*self.points)

    @property
    def of_event(self) -> bool:
        """Whether the speed is known only with the time of the contact event."""
        return self.start.of_event or self.end.of_event

    def sized(self, size: Size) -> Speed:
        """Return the speed for a drive of another size."""
        return replace(self, start=self.start.sized(size), end=self.end.sized(size))


def speeds_of(
    settings: Mapping[str, Sequence[str] | None] | None = None, size: Size = UNIT
) -> tuple[Speed, ...]:
    """Return the speeds that the section ``speeds`` of the configuration defines.

    ``closing_speed`` and ``opening_speed`` are always among them. Their default points are the
    last 6 mm before the contact touch and the first 6 mm after the contact separation. These 6 mm
    are multiplied by the length of ``size`` and rounded to two digits.

    Raises:
        ValueError: If a definition is wrong.

    Example:
        >>> speeds = speeds_of({"closing_speed_mean": ["10 % of stroke", "90 % of stroke"]})
        >>> [speed.name for speed in speeds]
        ['closing_speed', 'opening_speed', 'closing_speed_mean']
        >>> speeds_of(size=Size(lengths=10.7, times=3.9))[0].words
        'from 64 mm before touch to touch'
    """
    distance = float(f"{_SPEED_TRAVEL * size.lengths:.2g}")
    event = Point(0.0, "mm")
    usual = {
        "closing_speed": Speed("closing_speed", Point(-distance, "mm"), event),
        "opening_speed": Speed("opening_speed", event, Point(distance, "mm")),
    }
    for name, points in (settings or {}).items():
        if points is not None or name not in usual:
            usual[name] = Speed.read(name, points)
    return tuple(usual.values())


def speeds_at(settings: Mapping[str, Sequence[str] | None], stroke: float) -> tuple[Speed, ...]:
    """Return the speeds of a drive with a stroke in mm.

    Similar drives have the same default points, because their size is rounded to one digit.
    """
    return speeds_of(settings, Size(float(f"{stroke / _USUAL_STROKE:.1g}")))


OF_STROKE = {
    f"{motion}_speed_{begin}_{end}": [f"{begin} % of stroke", f"{end} % of stroke"]
    for motion in EVENTS
    for begin, end in ((10, 90), (10, 50), (50, 90))
}
"""Points of speeds that need no contact event, by name: over 10 to 90 % of the stroke, and over
both halves of this range, which show where a drive is slow."""


def every_speed(settings: Mapping[str, Sequence[str] | None]) -> tuple[Speed, ...]:
    """Return the speeds that limits may name, of the section ``speeds`` and ``OF_STROKE``."""
    return speeds_of({**OF_STROKE, **settings})


SPEEDS = speeds_of()
"""Default speeds of a drive of size 1."""

# ---- catalogue -------------------------------------------------------------------------------

_MODEL, _RECORD, _BOTH, _ANSWER = ("model",), ("record",), ("model", "record"), ("answer",)
_CLOSING, _OPENING = ("closing",), ("opening",)


@dataclass(frozen=True)
class Quantity(Parameter):
    """A quantity of a motion, with the attributes of a parameter and these.

    Attributes:
        motions: Motions that have the quantity.
        of: Sources of the quantity: "model" and "record", which limits may use, and "answer", the
            inference of a single record.
        zone: Points between which a mean speed is taken, in words; empty for other quantities.
    """

    motions: tuple[str, ...] = MOTIONS
    of: tuple[str, ...] = _BOTH
    zone: str = ""


_TABLE = (  # name, unit, whether more (1) or less (-1) is worse, motions, sources, definition
    ("spring_compression", "mm", 0, MOTIONS, _MODEL, "stroke minus contact gap, at rest"),
    ("stroke", "mm", 0, MOTIONS, _BOTH, "travel of the drive between its rest positions"),
    ("travel_time", "ms", 1, MOTIONS, _BOTH, "drive from 10 to 90 % of its stroke"),
    ("touch_time", "ms", 1, _CLOSING, _BOTH, "first motion to contact touch"),
    ("over_travel", "mm", 1, _CLOSING, _BOTH, "largest travel beyond the closed rest"),
    ("separation_time", "ms", 1, _OPENING, _BOTH, "first motion to contact separation"),
    ("opening_over_travel", "mm", 1, _OPENING, _BOTH, "largest travel beyond the open rest"),
    ("reaction_time", "ms", 1, MOTIONS, _RECORD, "trigger to first detected motion"),
    ("time_to_10", "ms", 1, MOTIONS, _RECORD, "trigger to 10 % of the stroke"),
    ("time_to_50", "ms", 1, MOTIONS, _RECORD, "trigger to 50 % of the stroke"),
    ("time_to_90", "ms", 1, MOTIONS, _RECORD, "trigger to 90 % of the stroke"),
    ("closing_time", "ms", 1, _CLOSING, _RECORD, "trigger to contact touch"),
    ("opening_time", "ms", 1, _OPENING, _RECORD, "trigger to contact separation"),
    ("main_closing_time", "ms", 1, _CLOSING, _RECORD, "trigger to touch of the main contact"),
    ("main_opening_time", "ms", 1, _OPENING, _RECORD, "trigger to separation of the main contact"),
    ("arcing_wipe", "mm", -1, MOTIONS, _RECORD, "travel between the main and the arcing contact"),
    ("static_resistance", "µΩ", 1, MOTIONS, _RECORD, "closed contact at rest"),
    ("arcing_resistance", "µΩ", 1, MOTIONS, _RECORD, "arcing contact while it alone is closed"),
    ("closing_wipe", "mm", -1, _CLOSING, _RECORD, "travel from contact touch to closed rest"),
    ("opening_wipe", "mm", -1, _OPENING, _RECORD, "travel from closed rest to separation"),
    ("bounce_time", "ms", 1, _CLOSING, _RECORD, "first to last contact touch"),
    ("coil_current", "A", 1, MOTIONS, _RECORD, "largest current of the coil"),
    ("coil_dip_time", "ms", 1, MOTIONS, _RECORD, "trigger to the dip of the coil current"),
    ("coil_off_time", "ms", 1, MOTIONS, _RECORD, "trigger to the end of the coil current"),
    ("release_from10", "ms", 0, MOTIONS, _ANSWER, "10 % of the stroke to start of motion"),
    ("touch_after_release", "ms", 1, _CLOSING, _ANSWER, "start of motion to contact touch"),
    ("touch_from10", "ms", 0, _CLOSING, _ANSWER, "10 % of the stroke to contact touch"),
    ("separation_after_release", "ms", 1, _OPENING, _ANSWER, "start of motion to separation"),
    ("separation_from10", "ms", 0, _OPENING, _ANSWER, "10 % of the stroke to contact separation"),
)


def quantities(speeds: Sequence[Speed] = SPEEDS) -> dict[str, Quantity]:
    """Return all quantities by name: the seven parameters first, ``speeds`` last.

    Example:
        >>> quantities()["closing_speed"].meaning
        'mean speed of the drive from 6 mm before touch to touch'
    """
    known = {parameter.name: Quantity(**vars(parameter), of=_MODEL) for parameter in PARAMETERS}
    for name, unit, worse, motions, of, meaning in _TABLE:
        known[name] = Quantity(name, unit, meaning, worse, motions=motions, of=of)
    for speed in speeds:
        meaning, more = f"mean speed of the drive {speed.words}", {"zone": speed.words}
        motions = (speed.motion,)
        known[speed.name] = Quantity(speed.name, SPEED_UNIT, meaning, -1, motions=motions, **more)
    return known


def quantities_of(
    motion: str, speeds: Sequence[Speed] = SPEEDS, of: Collection[str] | None = _MODEL
) -> dict[str, Quantity]:
    """Return the quantities of a motion by name, without the parameters.

    Args:
        of: Allowed sources, of which a quantity needs at least one; None for all.

    Example:
        >>> list(quantities_of("opening"))[:4]
        ['spring_compression', 'stroke', 'travel_time', 'separation_time']
    """
    return {
        name: quantity
        for name, quantity in quantities(speeds).items()
        if motion in quantity.motions
        and name not in NAMES
        and (of is None or set(of) & set(quantity.of))
    }


QUANTITIES = quantities()
"""Quantities with the default speeds, by name."""

AFTER_RELEASE = {motion: f"{event}_after_release" for motion, event in EVENTS.items()}
"""Name of the time from the start of motion to the contact event, by motion."""

SHARES = {f"time_to_{percent}": percent for percent in (10, 50, 90)}
"""Percent of the stroke at which a time from the trigger ends, by name of the time."""

RESISTANCES = ("static_resistance", "arcing_resistance")
"""Names of the quantities measured from the resistance of the contact."""

CURRENTS = ("coil_current", "coil_dip_time", "coil_off_time", *RESISTANCES)
"""Names of the quantities measured from the current of a coil, or the test current."""


_SPOKEN = {parameter.name: parameter.word for parameter in PARAMETERS}


def in_words(name: str) -> str:
    """Return the name of a parameter or quantity in words.

    >>> in_words("closing_speed_10_90"), in_words("time_to_50"), in_words("k_a")
    ('closing speed 10 to 90 %', 'time to 50 %', 'opening spring')
    """
    words = _SPOKEN.get(name) or name.replace("_", " ")
    if name in OF_STROKE:
        words = " to ".join(words.rsplit(" ", 1))
    return f"{words} %" if name in OF_STROKE or name in SHARES else words


ANSWERED = frozenset(name for name, quantity in QUANTITIES.items() if quantity.of == _ANSWER)
"""Names of the quantities that only the inference of a single record gives."""

INFERRED = ANSWERED | {"spring_compression"}
"""Names of the quantities that no instrument measures, without the parameters."""


def check_quantity(
    name: str, motion: str, speeds: Sequence[Speed] = SPEEDS, of: str = "model"
) -> str | None:
    """Return why a motion lacks a quantity from a source, with a remedy; None if it has it.

    Args:
        of: "model", "record", or "change", the change of a parameter.

    Example:
        >>> check_quantity("reaction_time", "closing").split(".")[0]
        'reaction_time is not a quantity of model in closing'
    """
    every = quantities(speeds).values()
    known = [
        quantity.name for quantity in every if motion in quantity.motions and of in quantity.of
    ]
    if of == "change":
        known, motion = list(NAMES), "any motion"
    elif motion not in MOTIONS:
        return f"motion is {motion!r}. Write {' or '.join(MOTIONS)}."
    if name in known:
        return None
    spelt = name.replace(" ", "_").replace("velocity", "speed")
    near = get_close_matches(spelt, known, cutoff=0.5) or known
    return f"{name} is not a quantity of {of} in {motion}. Take one of {', '.join(near)}."


# ---- known values ----------------------------------------------------------------------------

_LARGEST = 1e6  # larger values result from a wrong unit; squares of smaller ones stay finite
_SHARPEST = 1e-3  # smallest sd as a share of the value: no instrument is more exact


def check_fact(value: float, sd: float) -> str | None:
    """Return why a known value or its sd is not plausible, with a remedy; None if both are.

    Example:
        >>> check_fact(-10.0, 0.1)
        'has the value -10. Give a positive one, at most 1e+06.'
    """
    if not 0 <= value <= _LARGEST:
        return f"has the value {value:g}. Give a positive one, at most {_LARGEST:g}."
    least = _SHARPEST * value
    if not (sd and least <= sd <= _LARGEST):
        return f"has the standard deviation {sd:g}. Give one from {least:g} to {_LARGEST:g}."
    return None


# ---- operation metadata ----------------------------------------------------------------------

CONDITIONS = ("temperature", "voltage")
"""Conditions of an operation that can cause a change of the curves."""

ABOUT = ("breaker", "phase", "date", *CONDITIONS, "event")
"""Metadata of an operation in all results, empty where unknown."""


def metadata_names(data: Mapping) -> list[str]:
    """Return the names in ``ABOUT`` that have a value for any operation of a dataset."""
    return [
        name
        for name in ABOUT
        if name in data and any(value == value and value != "" for value in data[name].values)
    ]
