"""Speeds of the drive: each its mean between two points of a motion, as configured.

A point is written as engineers say it:

- ``touch`` (of the contact, in a closing) or ``parting`` (in an opening);
- a way or a time from there: ``6 mm before touch``, ``10 ms after parting``;
- a share of the way between the rest positions, of which 0 % is the first motion:
  ``10 % of stroke`` from where the motion begins, or ``10 % from closed`` in either motion;
- a way from a rest position: ``20 mm from open``, ``15 mm from closed``;
- a time before or after any of these: ``10 ms after 50 % of stroke``.

The name of a speed begins with ``closing_speed`` or ``opening_speed``, and so says its motion.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from breaker.quantities.size import UNIT, Size

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
    def read(cls, text: str, motion: str) -> "Point":
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

    def sized(self, size: Size) -> "Point":
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
    def read(cls, name: str, points: Sequence[str]) -> "Speed":
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

    def sized(self, size: Size) -> "Speed":
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
