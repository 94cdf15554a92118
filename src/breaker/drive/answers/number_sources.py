"""Where in its file each measured number of a document is read."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from breaker.drive.answers.evidence import Answer
from breaker.quantities.speeds import EVENTS, Point, Speed
from breaker.reading.records.measurements import Reading
from breaker.reading.records.rejections import NotShownError

_LINE = "  {:<50} {:<22} {:>8} {:>11}"


class Place(NamedTuple):
    """A place in a record.

    Attributes:
        what: What is there, in words.
        time: In the time of the file, ms; the begin of a rest.
        until: The end of a rest, ms; the same as ``time`` of a point.
        travel: Reading there, mm towards closed; the mean of a rest.
    """

    what: str
    time: float
    until: float
    travel: float


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
    trigger = Place("trigger", *[reading.contact.trigger] * 2, float("nan"))
    speed = next((each for each in reading.speeds if each.name == name), None)
    known = {
        "stroke": (before, after),
        "wipe": (contact, after) if motion == "closing" else (before, contact),
        "travel_time": tuple(_Point(reading, Point(p, "%"), f"{p:.0f} %") for p in (10.0, 90.0)),
        **dict.fromkeys(("over_travel", "rebound"), (_Top(reading), after)),
        **dict.fromkeys(("touch_time", "part_time"), (first, contact)),
        "latch_time": (trigger, first),
        **dict.fromkeys(("closing_time", "opening_time"), (trigger, contact)),
    }
    if name == "bounce_time":
        times = reading.contact.time, reading.contact.settles
        for what, at in zip(("first change", "last change"), times, strict=True):
            yield Place(f"{what} of the contact", at, at, float("nan"))
        return
    if speed is not None:
        yield from _ends(reading, speed)
        return
    for each in known.get(name, ()):
        yield each if isinstance(each, Place) else each()


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
        return Place(f"rest {self.side}", begin, end, _towards_closed(self.reading, level))


class _Point(NamedTuple):
    """A point of a motion, and what it is called."""

    reading: Reading
    point: Point
    what: str

    def __call__(self) -> Place:
        at, level = self.reading.place(self.point)
        travel = _towards_closed(self.reading, level.value)
        return Place(self.what, at.value, at.value, travel)


class _Top(NamedTuple):
    """The farthest place behind a motion."""

    reading: Reading

    def __call__(self) -> Place:
        trace, arrival = self.reading.trace, self.reading.arrival
        level = self.reading.beyond().value + self.reading.after.value
        later = trace.time > arrival
        at = float(trace.time[later][int(trace.smooth[later].argmax())])
        return Place("farthest", at, at, _towards_closed(self.reading, level))


def _towards_closed(reading: Reading, forward: float) -> float:
    return forward if reading.located.motion == "closing" else -forward


def explained(document: Mapping, answers: Sequence[Answer]) -> dict:
    """Return a document with the places of what is measured.

    Args:
        document: What ``document`` returns.
        answers: Those that it is of.

    Returns:
        The same; each accepted record has ``places``, by the names of its quantities a list of
        ``what`` is there, its ``time`` and, of a rest, ``until``, ms of the file; ``sample``, the
        number of the nearest one from 1; and ``travel``, mm towards closed; None where there is
        none.
    """
    records = []
    for entry, answer in zip(document["records"], answers, strict=True):
        more = {"places": _places_in(entry, answer)} if entry["accepted"] else {}
        records.append({**entry, **more})
    return {**document, "records": records}


def place_lines(record: Mapping) -> list[str]:
    """Return the places of a record as lines of a terminal; none where the document has none."""
    rows = record.get("places", {})
    lines = [_LINE.format("where it is read", "time of the file, ms", "sample", "travel, mm")]
    for name, places in rows.items():
        for each in places:
            until = "" if each["until"] is None else f" to {each['until']:.2f}"
            way = "" if each["travel"] is None else f"{each['travel']:.3f}"
            what, at = f"{name}: {each['what']}", f"{each['time']:.2f}{until}"
            lines.append(_LINE.format(what, at, each["sample"], way).rstrip())
    return lines if rows else []


def _places_in(entry: Mapping, answer: Answer) -> dict[str, list[dict]]:
    raw, found = answer.record.raw, {}
    reading = Reading(raw, answer.contact, answer.speeds)
    for name, each in entry["quantities"].items():
        if each["median"] is None or each["source"] == "inferred":
            continue
        found[name] = [
            {
                "what": place.what,
                "time": place.time,
                "until": None if place.until == place.time else place.until,
                "sample": round((place.time - float(raw.time[0])) / raw.step) + 1,
                "travel": place.travel if np.isfinite(place.travel) else None,
            }
            for place in places_of(reading, name)
        ]
    return {name: places for name, places in found.items() if places}
