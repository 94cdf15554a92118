"""Where in a record what is measured of it is read: times, readings, and from what to what.

With these an engineer can check each number against the analyser's own cursor.
"""

from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from breaker.common.plain_values import Plain
from breaker.model.quantities import EVENTS, Point, Speed
from breaker.reading.records.measurements import Reading
from breaker.reading.records.rejections import NotShownError


@dataclass(frozen=True)
class Place(Plain):
    """A place in a record: what is there, and when; None where there is none of a value."""

    what: str
    time: float  # of the file, ms; the begin of a rest
    until: float | None  # the end of a rest, ms
    sample: int  # the nearest one, counted from 1
    travel: float | None  # mm towards closed; the mean of a rest


def places_of(reading: Reading, name: str) -> list[Place]:
    """Return the places that a quantity is read from, in their order; none of one that is not
    shown.

    Args:
        reading: Of the record.
        name: As ``Reading.quantities`` has it.
    """
    try:
        return [*_places(reading, name)]
    except NotShownError:
        return []


def _places(reading: Reading, name: str):
    motion = reading.located.motion
    before, after = _Rest(reading, "before"), _Rest(reading, "after")
    first = _Point(reading, Point(0.0, "%"), "first motion")
    contact = _Point(reading, Point(0.0, "mm"), EVENTS[motion])
    trigger = partial(_place, reading, "trigger", reading.contact.trigger)
    speed = next((each for each in reading.speeds if each.name == name), None)
    known = {
        "stroke": (before, after),
        "wipe_at_touch": (contact, after),
        "wipe_at_parting": (before, contact),
        "travel_time": tuple(_Point(reading, Point(p, "%"), f"{p:.0f} %") for p in (10.0, 90.0)),
        **dict.fromkeys(("over_travel", "rebound"), (_Top(reading), after)),
        **dict.fromkeys(("touch_time", "part_time"), (first, contact)),
        "latch_time": (trigger, first),
        **dict.fromkeys(("closing_time", "opening_time"), (trigger, contact)),
    }
    if name == "bounce_time":
        times = reading.contact.time, reading.contact.settles
        for what, at in zip(("first change", "last change"), times, strict=True):
            yield _place(reading, f"{what} of the contact", at)
        return
    if speed is not None:
        yield from _ends(reading, speed)
        return
    for each in known.get(name, ()):
        yield each()


def _ends(reading: Reading, speed: Speed):
    """The points of a speed."""
    for point, words in zip((speed.start, speed.end), speed.points, strict=True):
        yield _Point(reading, point, words)()


class _Rest(NamedTuple):
    """A rest of a motion, "before" or "after" it."""

    reading: Reading
    side: str

    def __call__(self) -> Place:
        begin, end = self.reading.rests.window(self.side)
        level = getattr(self.reading, self.side).value
        return _place(self.reading, f"rest {self.side}", begin, level, end)


class _Point(NamedTuple):
    """A point of a motion, and what it is called."""

    reading: Reading
    point: Point
    what: str

    def __call__(self) -> Place:
        at, level = self.reading.place(self.point)
        return _place(self.reading, self.what, at.value, level.value)


class _Top(NamedTuple):
    """The farthest place behind a motion."""

    reading: Reading

    def __call__(self) -> Place:
        trace, arrival = self.reading.trace, self.reading.arrival
        level = self.reading.beyond().value + self.reading.after.value
        later = trace.time > arrival
        at = float(trace.time[later][int(trace.smooth[later].argmax())])
        return _place(self.reading, "farthest", at, level)


def _place(
    reading: Reading, what: str, at: float, forward: float = np.nan, until: float | None = None
) -> Place:
    """A place, by the travel from open or from closed on that is read there."""
    record = reading.located
    sample = round((at - float(record.time[0])) / record.step) + 1
    travel = forward if record.motion == "closing" else -forward
    until = None if until == at else until
    return Place(what, at, until, sample, travel if np.isfinite(travel) else None)
