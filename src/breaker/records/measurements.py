"""Quantities read from a record itself, with their uncertainty: what an instrument would print.

Local fits and means at the record's own rate give them, without the model of the drive. Rest
positions are the record's own, so its zero does not enter. The uncertainty follows from the noise
of the record, its colour, the step of the readings, and a drive that may still move at the end. A
wrong scale of the sensor remains unseen.

A quantity that the record does not show, such as touch where no contact was measured, is NaN, with
the reason.
"""

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.model.quantities import CURRENTS, SHARES, SPEEDS, Point, Speed, quantities_of
from breaker.records.axes import seen_quantum
from breaker.records.checks import doubtful_samples, leap_at
from breaker.records.contacts import ContactTimes
from breaker.records.currents import Currents
from breaker.records.first_motion import StartInterval, first_motion, start_interval
from breaker.records.motion import LocatedMotion, find_segment
from breaker.records.propagation import SEEN, TAILS, Trace, Uncertain, error_of
from breaker.records.rejections import MATTERS, NotShownError, UnusableError

_NEAR = 5.0, 8.0  # durations of the motion before and after it in which it is at rest
_VAGUE = 0.4  # durations, uncertainty of the first motion that hides a change of a latch
_SOON = 0.8  # durations after the arrival, before which no drive rests
# Durations after the arrival, until which a swing or creep looks like a drift. With an error for
# drifts, intervals of 80 strokes with one contain the truth for 73 %, not 56 %.
_LONG = 2.0
_UNREST = 0.08  # strokes, change late in the rest from which the drive does not rest
_FOLLOWS = 0.3  # of such a change, error of the rest: other swings than those that are fitted
_SWING = 0.12, 2.2  # strokes of a swing that turns at the end, and how it fades per duration
_SWITCHED = {
    "time": "no contact timing: the time of touch or parting is not known",
    "main": "no resistance that shows the main contact apart from the arcing contact",
    "arcing": "no resistance that shows the arcing contact",
    "trigger": "no trigger: when the coil was energised is not known",
}


class Measured(NamedTuple):
    """A quantity of a record.

    Attributes:
        value: In the quantity's unit; NaN if the record does not show it.
        sd: Standard deviation of its error.
        reason: Why there is no value, "" if there is one.
    """

    value: float
    sd: float
    reason: str


_UNKNOWN = ContactTimes()
_NO_CURRENTS = Currents(np.zeros(0))


def measure_curve(
    time: np.ndarray,
    travel: np.ndarray,
    motion: str,
    *,
    contact: ContactTimes = _UNKNOWN,
    speeds: Sequence[Speed] = SPEEDS,
) -> dict[str, Measured]:
    """Read the quantities of a curve.

    Args:
        time: Times, ``(n,)``, ms, evenly spaced, some of them before the first motion.
        travel: Travel towards closed, ``(n,)``, mm; NaN where a sample is missing.
        motion: "closing" or "opening".
        contact: Times of contact and trigger.
        speeds: Definitions of the speeds.

    Raises:
        ValueError: If the motion is not in the curve, or its beginning is not.

    Example:
        >>> time = np.arange(0.0, 100.0, 0.1)
        >>> way = 14.0 * np.sin(0.5 * np.pi * np.clip((time - 20.0) / 10.0, 0.0, 1.0)) ** 2
        >>> stroke = measure_curve(time, way, "closing")["stroke"]
        >>> abs(stroke.value - 14.0) < 0.01
        True
    """
    quantum, step = seen_quantum(travel), float(time[-1] - time[0]) / (time.size - 1)
    doubts = doubtful_samples(travel, step, quantum)
    left = np.where(doubts == "", travel, np.nan)
    segment = find_segment(time, left, motion)
    inside = slice(segment.begin, segment.end)
    moves = first_motion(time[inside], left[inside], motion)
    located = LocatedMotion(motion, time, travel, doubts, quantum, segment, *moves)
    return Reading(located, contact, speeds).quantities()


@dataclass(eq=False)
class Reading:
    """What is read of the part of a record that is one motion.

    Attributes:
        located: That motion.
        contact: When the contact touched or parted, and the trigger came.
        speeds: Definitions of the speeds.
        currents: Currents of coil and motor.
    """

    located: LocatedMotion
    contact: ContactTimes = _UNKNOWN
    speeds: Sequence[Speed] = SPEEDS
    currents: Currents = _NO_CURRENTS

    def __post_init__(self) -> None:
        located, segment, moves = self.located, self.located.segment, self.located.moves
        time, sign = located.time[located.inside], 1.0 if located.motion == "closing" else -1.0
        forward = sign * located.left
        done = (forward - sign * segment.before) / segment.stroke >= 0.01 * max(SHARES.values())
        done &= time >= moves  # an outlier may lie before
        if not done.any():
            raise UnusableError("the motion does not go on to 90 % of its stroke")
        self.arrival = float(time[int(done.argmax())])
        self.duration = max(self.arrival - moves, 2.0 * located.step)
        first, last = moves - _NEAR[0] * self.duration, self.arrival + _NEAR[1] * self.duration
        near = slice(*np.searchsorted(time, [first, last]))
        kinds = located.doubts[located.inside]
        self.clipped = time[kinds == "clipped"]
        slips = 1 + np.flatnonzero(kinds[near.start + 1 :] == "slip")
        leaps = [(int(k), leap_at(forward[near.start :], k)) for k in slips]
        about = *located.process, located.quantum, self.duration, segment.stroke
        self.trace = Trace(time[near], forward[near], *about, located.ripple, leaps)

    def with_contact(
        self, contact: ContactTimes, speeds: Sequence[Speed], currents: Currents = _NO_CURRENTS
    ) -> "Reading":
        """Return the reading with other times of the contact; the rests are not read again."""
        other = copy(self)
        other.contact, other.speeds, other.currents = contact, speeds, currents
        return other

    def quantities(self) -> dict[str, Measured]:
        """Return the quantities of the motion that records show, by name."""
        ways = {
            "stroke": self.stroke,
            **dict.fromkeys(("wipe_at_touch", "wipe_at_parting"), self.wipe),
            "travel_time": lambda: self.at_share(90.0) - self.at_share(10.0),
            **dict.fromkeys(("over_travel", "rebound"), self.beyond),
            **dict.fromkeys(
                ("touch_time", "part_time"), lambda: self._event("time") - self._first_motion
            ),
            "latch_time": lambda: self._first_motion - self._event("trigger"),
            **{name: partial(self._time_to, percent) for name, percent in SHARES.items()},
            **dict.fromkeys(("closing_time", "opening_time"), partial(self._since_trigger, "time")),
            **dict.fromkeys(
                ("main_closing_time", "main_opening_time"), partial(self._since_trigger, "main")
            ),
            "arcing_wipe": self.arcing_wipe,
            "bounce_time": self.bounce_time,
            **{each.name: partial(self.speed, each) for each in self.speeds},
            **{name: partial(self._current, name) for name in CURRENTS},
        }
        names = quantities_of(self.located.motion, self.speeds, ("record",))
        return {name: self._measured(ways[name]) for name in names}

    def _measured(self, way: Callable[[], Uncertain]) -> Measured:
        try:
            result = way()
        except NotShownError as error:
            return Measured(np.nan, np.nan, str(error))
        return Measured(result.value, self.trace.sd(result), "")

    # ---- rests -------------------------------------------------------------------------------

    def _unclipped(self, begin: float, end: float, where: str) -> None:
        """Raise NotShownError where the reading is at the end of the sensor's range."""
        if ((self.clipped >= begin) & (self.clipped <= end)).any():
            raise NotShownError(f"the reading is at the end of the sensor's range {where}")

    @cached_property
    def before(self) -> Uncertain:
        """Rest before the motion."""
        self._unclipped(-np.inf, self.trace.known[0], "before the motion")
        span = float(self.trace.known[0]), self.located.moves
        return self.trace.rest(*span) + error_of(0.0, self.trace.unrest(*span))

    @cached_property
    def after(self) -> Uncertain:
        """Rest after the motion, where the drive rests or will rest."""
        end, stroke = float(self.trace.known[-1]), self.located.segment.stroke
        self._unclipped(end, np.inf, "after the motion")
        rests = end - self.arrival
        unrest = self.trace.unrest(end - rests / 3.0, end)
        if rests < _SOON * self.duration or unrest > _UNREST * stroke:
            raise NotShownError("the record ends before the drive rests")
        begin, moves = end - TAILS[0] * rests, self.located.moves
        found = self.trace.settled(self.arrival, moves)
        drifted = self.trace.drift(begin, end) * (0.5 * (begin + end) - moves)
        if drifted > MATTERS * stroke and rests > _LONG * self.duration:
            found = found + error_of(0.0, drifted)
        later = _SWING[0] * stroke * float(np.exp(-_SWING[1] * rests / self.duration))
        return found + error_of(0.0, later + _FOLLOWS * unrest)

    def stroke(self) -> Uncertain:
        """Return the distance between the rests, mm."""
        return self.after - self.before

    def beyond(self) -> Uncertain:
        """Return the largest distance beyond the rest after the motion, mm."""
        last = self.arrival + 3.0 * self.duration  # later, a swing is smaller than the first
        least = in_digits(float(np.nanmax(self.trace.travel)) - self.after.value, 3)
        self._unclipped(self.arrival, last, f"there: at least {least} mm")
        way = self.trace.top(self.arrival, last) - self.after
        if way.value >= SEEN * self.trace.sd(way):
            return way
        # The top of noise is above what it hides, and no distance is negative.
        return way + max(-way.value, 0.0) + error_of(0.0, abs(way.value))

    # ---- the start ---------------------------------------------------------------------------

    @cached_property
    def start(self) -> StartInterval:
        """From when to when the drive may begin to move: anywhere, where samples show no rise."""
        located = self.located
        try:
            return start_interval(located.time[located.inside], located.left, located.motion)
        except UnusableError:
            ends = float(self.trace.time[0]), self.arrival
            return StartInterval(located.moves, *ends, self.duration)

    @property
    def start_hidden(self) -> str:
        """Reason why the first motion has no value; "" if it has one."""
        start = self.start
        if start.late - start.early <= _VAGUE * start.duration:
            return ""
        return (
            f"the first motion is not seen: it is between {start.early:.1f} and {start.late:.1f} "
            "ms, as a slow start, hum or noise hides it"
        )

    @property
    def start_sd(self) -> float:
        """Standard deviation of the time that aligns records, ms: 95 % contain the interval."""
        return max(self.located.first_motion_sd, self.start.sd_of(self.located.moves))

    @property
    def _first_motion(self) -> Uncertain:
        """Time of the first motion, ms: that of the rise, if the drive may begin to move then."""
        if self.start_hidden:
            raise NotShownError(self.start_hidden)
        start, moves = self.start, self.located.moves
        time = moves if start.early <= moves <= start.late else start.time
        return error_of(time, max(self.located.first_motion_sd, start.sd_of(time)), "start")

    # ---- events ------------------------------------------------------------------------------

    def _event(self, kind: str) -> Uncertain:
        """Time of touch or parting ("time"), of "main", "arcing" or "trigger", ms."""
        if not np.isfinite(getattr(self.contact, kind)):
            why = self.contact.why if kind != "trigger" else ""
            raise NotShownError(why or _SWITCHED[kind])
        sd = getattr(self.contact, "sd" if kind == "time" else f"{kind}_sd")
        return error_of(getattr(self.contact, kind), sd, kind)

    def _since_trigger(self, kind: str) -> Uncertain:
        return self._event(kind) - self._event("trigger")

    def _time_to(self, percent: float) -> Uncertain:
        return self.at_share(percent) - self._event("trigger")

    def wipe(self) -> Uncertain:
        """Return the distance between the touch or parting and the closed rest, mm."""
        level = self.trace.at(self._event("time"))
        return self.after - level if self.located.motion == "closing" else level - self.before

    def arcing_wipe(self) -> Uncertain:
        """Return the travel between the main and the arcing contact, mm."""
        way = self.trace.at(self._event("main")) - self.trace.at(self._event("arcing"))
        return way if self.located.motion == "closing" else way * -1.0

    def bounce_time(self) -> Uncertain:
        """Return the time from the first touch to the last, ms."""
        if not np.isfinite(bounce := self.contact.bounce_time):
            reason = "no signal of the contact or test current shows whether it bounces"
            raise NotShownError(self.contact.why or reason)
        return error_of(bounce, self.located.step / np.sqrt(6.0))  # of two edges

    def _current(self, name: str) -> Uncertain:
        return error_of(*getattr(self.currents, name)())

    # ---- points ------------------------------------------------------------------------------

    def speed(self, speed: Speed) -> Uncertain:
        """Return the mean speed between two points, mm/ms."""
        (begin, low), (end, high) = self.place(speed.start), self.place(speed.end)
        if not end.value > begin.value:
            raise NotShownError(f"{speed.points[1]} is not after {speed.points[0]}")
        return (high - low) / (end - begin)

    def at_share(self, percent: float) -> Uncertain:
        """Return the time of a percent of the stroke, ms."""
        return self.place(Point(percent, "%"))[0]

    def place(self, point: Point) -> tuple[Uncertain, Uncertain]:
        """Return time and travel of a point, ms and mm; the travel rises in any motion."""
        if point.later:
            at = self.place(replace(point, later=0.0))[0] + point.later
            return at, self.trace.at(at)
        if not point.of_event:
            return self._between_rests(point)
        at = self._event("time")
        if point.unit == "ms":
            at = at + point.amount
            return at, self.trace.at(at)
        level = self.trace.at(at) + point.amount
        if point.amount < 0.0:
            return self.trace.left(level, at.value), level
        if point.amount > 0.0:
            return self.trace.reaches(level, at.value), level
        return at, level

    def _between_rests(self, point: Point) -> tuple[Uncertain, Uncertain]:
        """Time and travel of a point that is defined by rests."""
        if point.unit == "mm":
            level = (self.after if point.amount < 0.0 else self.before) + point.amount
        elif point.amount == 0.0:
            return self._first_motion, self.before
        else:
            level = self.before + (self.after - self.before) * (point.amount / 100.0)
        return self.trace.reaches(level, self.located.moves), level
