"""Measure the quantities of a record that an analyser prints, with their uncertainty.

The quantities come from local fits and means at the record's own rate, without the model of the
drive. They refer to the rest positions of the record, so its zero does not matter. The uncertainty
includes the noise of the record, its colour, the step of the readings, and a drive that may still
move at the end. It does not include a wrong scale of the sensor.

A quantity that the record does not show, such as the contact touch where no contact was measured,
is NaN, with the reason.
"""

import math
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from breaker.model.quantities import CURRENTS, SHARES, SPEEDS, Point, Speed, quantities_of
from breaker.records.checks import doubtful_samples, ends_of_range, leap_at
from breaker.records.contacts import ContactTimes
from breaker.records.conversion import seen_quantum
from breaker.records.currents import Currents
from breaker.records.first_motion import first_motion, start_interval
from breaker.records.motion import LocatedMotion, find_segment
from breaker.records.noisy_trace import FEW, Trace, Uncertain, error_of
from breaker.records.rejections import NotShownError, UnusableError

_SEEN = 3.0  # sd above which a drift, a swing or a distance beyond a rest is not noise
_VAGUE = 0.45  # durations; a wider start interval hides changes of the reaction time
_BEFORE = (5.0, 0.05)  # durations before the first motion between which the rest before it is read
_AFTER = 8.0  # durations after the arrival, end of the rest after the motion
_LATE = 0.6  # share of the time after the arrival, at its end, that counts as rest
_CALMS = 2.0  # durations after the arrival in which a drive may swing
_PARTS = 4  # parts of the rest after a motion whose means are compared
_DRIFTS = 0.8  # sd of the error of an extrapolated drift, as a share of the extrapolation
_TAIL = 0.7  # share of the time after the arrival, at its end, to which settling is fitted
_CERTAIN = 0.01  # strokes, largest sd of a settling position that is used
# Sd of the error of a rest as a share of the travel within it, chosen by the coverage of simulated
# strokes (studies.measuring, studies.exports): of a fitted, a moving, and a seemingly steady rest.
_FITTED, _MOVED, _HIDES = 0.1, 1.5, 0.7
_UNSEEN, _FADES = 0.04, 2.2  # undetected swing at the arrival, strokes, and its decay per duration
# Share of its speed that a drive loses at once where it picks the contact up, and the sd of this
# share: 0 for an elastic contact, 1/3 for a rigid contact of half the mass of the drive.
_PICKED_UP = 0.1, 0.2
_SOON = 0.7  # durations after the arrival, before which no drive rests
_SWITCHED = {
    "time": "no contact timing: the time of touch or separation is not known",
    "main": "no resistance that shows the main contact apart from the arcing contact",
    "arcing": "no resistance that shows the arcing contact",
    "trigger": "no trigger: when the coil was energised is not known",
}
_CLIPPED = "the reading is at the end of the sensor's range"


class Measured(NamedTuple):
    """A quantity of a record."""

    value: float  # in the quantity's unit; NaN if the record does not show it
    sd: float  # standard deviation of its error
    reason: str  # reason why there is no value, "" if there is a value


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
    """Measure the quantities of a curve.

    Args:
        time: Times, ``(n,)``, ms, evenly spaced, some of them before the first motion.
        travel: Travel towards closed, ``(n,)``, mm; NaN where a sample is missing.
        motion: "closing" or "opening".
        contact: Times of contact and trigger.
        speeds: Definitions of the speeds.

    Raises:
        ValueError: If the curve does not contain the motion and its beginning.

    Example:
        >>> time = np.arange(0.0, 100.0, 0.1)
        >>> x = np.clip((time - 20.0) / 10.0, 0.0, 1.0)
        >>> noise = 0.05 * np.random.default_rng(1).standard_normal(time.size)
        >>> measured = measure_curve(time, 14.0 * x**2 * (3.0 - 2.0 * x) + noise, "closing")
        >>> abs(measured["stroke"].value - 14.0) < 3.0 * measured["stroke"].sd < 0.1
        True
        >>> measured["closing_speed"].reason
        'no contact timing: the time of touch or separation is not known'
    """
    quantum, step = seen_quantum(travel), float(time[1] - time[0])
    doubts = doubtful_samples(travel, step, quantum)
    left = np.where(doubts == "", travel, np.nan)
    segment = find_segment(time, left, motion)
    inside = slice(segment.begin, segment.end)
    moves = first_motion(time[inside], left[inside], motion)
    located = LocatedMotion(motion, time, travel, doubts, quantum, segment, *moves)
    return Reading(located, contact, speeds).quantities()


@dataclass(eq=False)
class Reading:
    """Measurement of one motion in a record."""

    located: LocatedMotion  # the motion in its record
    contact: ContactTimes = _UNKNOWN  # times of contact touch or separation, and of the trigger
    speeds: Sequence[Speed] = SPEEDS  # definitions of the speeds
    # current of the coil, and resistance of the contact
    currents: Currents = _NO_CURRENTS

    def __post_init__(self) -> None:
        located, segment, moves = self.located, self.located.segment, self.located.moves
        time, sign = located.time[located.inside], 1.0 if located.motion == "closing" else -1.0
        forward = sign * located.left
        done = located.done >= 0.01 * max(SHARES.values())
        done &= time >= moves  # excludes outliers before the motion
        if not done.any():
            raise UnusableError("the motion does not go on to 90 % of its stroke")
        self.arrival = float(time[int(done.argmax())])
        self.duration = max(self.arrival - moves, 2.0 * located.step)
        ends = moves - _BEFORE[0] * self.duration, self.arrival + _AFTER * self.duration
        near = slice(*np.searchsorted(time, ends))
        kinds = located.doubts[located.inside]
        self.clipped = time[kinds == "clipped"]
        self.ends = ends_of_range(time, located.left, moves)  # nan where the rest is in the range
        slips = near.start + 1 + np.flatnonzero(kinds[near.start + 1 :] == "slip")
        slips = [(k - near.start, leap_at(forward, k)) for k in slips]
        scales = *located.process, located.quantum, self.duration, segment.stroke
        self.trace = Trace(time[near], forward[near], *scales, located.ripple, slips)
        self._end = float(self.trace.known[-1])
        self._events: dict[str, Uncertain] = {}

    def with_contact(
        self, contact: ContactTimes, speeds: Sequence[Speed], currents: Currents = _NO_CURRENTS
    ) -> "Reading":
        """Return the reading with other times of the contact; the rests are kept."""
        other = copy(self)
        other.contact, other.speeds, other.currents, other._events = contact, speeds, currents, {}
        return other

    def quantities(self) -> dict[str, Measured]:
        """Return the quantities of the motion that records show, by name."""
        methods = {
            "stroke": self.stroke,
            **dict.fromkeys(("closing_wipe", "opening_wipe"), self.wipe),
            "travel_time": lambda: self.at_share(90.0) - self.at_share(10.0),
            **dict.fromkeys(("over_travel", "opening_over_travel"), self.beyond),
            **dict.fromkeys(
                ("touch_time", "separation_time"), lambda: self._event("time") - self._first_motion
            ),
            "reaction_time": lambda: (self._event("trigger") - self._first_motion) * -1.0,
            **{name: partial(self.time_to, percent) for name, percent in SHARES.items()},
            **dict.fromkeys(("closing_time", "opening_time"), lambda: self._since_trigger("time")),
            **dict.fromkeys(
                ("main_closing_time", "main_opening_time"), lambda: self._since_trigger("main")
            ),
            "arcing_wipe": self.arcing_wipe,
            "bounce_time": self.bounce_time,
            **{item.name: partial(self.speed, item) for item in self.speeds},
            **{name: partial(self._current, name) for name in CURRENTS},
        }
        names = quantities_of(self.located.motion, self.speeds, ("record",))
        return {name: self._measured(methods[name]) for name in names}

    def _measured(self, method: Callable[[], Uncertain]) -> Measured:
        try:
            result = method()
        except NotShownError as error:
            return Measured(np.nan, np.nan, error.args[0])
        return Measured(result.value, self.trace.sd(result), "")

    # ---- rests -------------------------------------------------------------------------------

    @cached_property
    def before(self) -> Uncertain:
        """Travel at rest before the motion, mm; its error includes a drift up to the motion."""
        if math.isfinite(self.ends[0]) or (
            self.clipped.size and self.clipped[0] < self.trace.known[0]
        ):
            raise NotShownError(f"{_CLIPPED} before the motion")
        first, moves = float(self.trace.known[0]), self.located.moves
        end = moves - _BEFORE[1] * self.duration
        end = max(end, min(moves, first + FEW * self.trace.step))
        return self.trace.rest(first, end) + error_of(0.0, _DRIFTS * self._drift * (end - first))

    @cached_property
    def after(self) -> Uncertain:
        """Travel at rest after the motion, mm: where the drive rests or settles."""
        trace, end = self.trace, self._end
        if math.isfinite(self.ends[1]) or (self.clipped.size and self.clipped[-1] > end):
            raise NotShownError(f"{_CLIPPED} after the motion")
        parts, after = self._parts, (end - self.arrival) / self.duration
        if not parts or after < _SOON:
            raise NotShownError("the record ends before the drive rests")
        error = _DRIFTS * self._drift * (end - self.located.moves)
        error += _UNSEEN * self.located.segment.stroke * math.exp(-_FADES * after)
        means = [part.value for part in parts]
        travel = float(np.ptp(means))
        if travel < _SEEN * trace.sd(parts[-1] - parts[0]):
            rest = trace.rest(self._late, end)
            return rest + error_of(0.0, math.hypot(error, _HIDES * travel))
        rest = trace.settles(end - _TAIL * (end - self.arrival), end)
        if rest is not None and trace.sd(rest) < _CERTAIN * trace.stroke:
            return rest + error_of(0.0, math.hypot(error, _FITTED * travel))
        return parts[-1] + error_of(0.0, math.hypot(error, _MOVED * travel))

    @property
    def _late(self) -> float:
        """Time, ms, from which on the drive counts as at rest, early enough for the parts."""
        samples = (_PARTS * FEW + 2.0) * self.trace.step
        return self._end - max(_LATE * (self._end - self.arrival), samples)

    @cached_property
    def _parts(self) -> list[Uncertain]:
        """Mean travel in each part of the rest after the motion."""
        return self.trace.parts(self._late, self._end, _PARTS)

    @cached_property
    def _drift(self) -> float:
        """Speed of a detected drift of the reading after the motion, mm/ms; 0 if none is."""
        parts = self._parts
        if not parts or self._end - self.arrival < _CALMS * self.duration:
            return 0.0  # a swing that dies out may look like a drift
        steps = np.diff([part.value for part in parts])
        steady = (steps > 0.0).all() or (steps < 0.0).all()
        if not steady or abs(steps.sum()) < _SEEN * self.trace.sd(parts[-1] - parts[0]):
            return 0.0
        return abs(float(steps.sum())) / (self._end - self._late) * _PARTS / (_PARTS - 1)

    def stroke(self) -> Uncertain:
        """Return the distance between the rests, mm."""
        return self.after - self.before

    def beyond(self) -> Uncertain:
        """Return the largest distance beyond the rest after the motion, mm."""
        last = self.arrival + 3.0 * self.duration  # later swings are smaller than the first
        if ((self.clipped > self.arrival) & (self.clipped < last)).any():
            raise NotShownError(f"{_CLIPPED} there")
        distance = self.trace.top(self.arrival, last) - self.after
        if distance.value >= _SEEN * self.trace.sd(distance):
            return distance
        # The maximum of noise exceeds the true distance, which is never negative.
        return distance + error_of(max(-distance.value, 0.0), abs(distance.value))

    # ---- the start ---------------------------------------------------------------------------

    @cached_property
    def start(self) -> tuple[float, float]:
        """Ends of a 95 % interval of the start of motion, ms."""
        located = self.located
        try:
            return start_interval(located.time[located.inside], located.left, located.motion)
        except UnusableError:  # the samples show no rise
            return float(self.trace.time[0]), self.arrival

    @property
    def start_hidden(self) -> str:
        """Reason why the first motion has no value; "" if it has one."""
        early, late = self.start
        if late - early <= _VAGUE * self.duration:
            return ""
        return (
            f"the first motion is not seen: it is between {early:.1f} and {late:.1f} ms, as a slow "
            "start, hum or noise hides it"
        )

    @property
    def start_sd(self) -> float:
        """Standard deviation of the first motion, ms: its 95 % interval contains the start's."""
        (early, late), moves = self.start, self.located.moves
        return max(self.located.moves_sd, (moves - early) / 1.96, (late - moves) / 1.96)

    @cached_property
    def _first_motion(self) -> Uncertain:
        """Time of the first motion, ms."""
        if self.start_hidden:
            raise NotShownError(self.start_hidden)
        return error_of(self.located.moves, self.start_sd)

    # ---- events ------------------------------------------------------------------------------

    def _event(self, kind: str) -> Uncertain:
        """Return the time, ms, of "time" (touch or separation), "main", "arcing" or "trigger"."""
        if not np.isfinite(getattr(self.contact, kind)):
            reason = self.contact.why if kind != "trigger" else ""
            raise NotShownError(reason or _SWITCHED[kind])
        if kind not in self._events:
            sd = getattr(self.contact, "sd" if kind == "time" else f"{kind}_sd")
            self._events[kind] = error_of(getattr(self.contact, kind), sd)
        return self._events[kind]

    def _since_trigger(self, kind: str) -> Uncertain:
        return self._event(kind) - self._event("trigger")

    def time_to(self, percent: float) -> Uncertain:
        """Return the time from the trigger to a percent of the stroke, ms."""
        return self.at_share(percent) - self._event("trigger")

    @property
    def _event_level(self) -> Uncertain:
        """Travel at contact touch or separation, mm; at separation the drive may lose speed."""
        if "level" not in self._events:
            time, opens = self._event("time"), self.located.motion == "opening"
            level = self.trace.at_corner(time, *_PICKED_UP) if opens else self.trace.at(time)
            self._events["level"] = level
        return self._events["level"]

    def wipe(self) -> Uncertain:
        """Return the distance between the touch or separation and the closed rest, mm."""
        level = self._event_level
        return self.after - level if self.located.motion == "closing" else level - self.before

    def arcing_wipe(self) -> Uncertain:
        """Return the travel between the main and the arcing contact, mm."""
        travel = self.trace.at(self._event("main")) - self.trace.at(self._event("arcing"))
        return travel if self.located.motion == "closing" else travel * -1.0

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
        """Return time, ms, and travel of a point, mm, which increases in either motion."""
        if point.later:
            time = self.place(replace(point, later=0.0))[0] + point.later
            return time, self.trace.at(time)
        if point.of_event:
            time = self._event("time")
            if point.unit == "ms":
                time = time + point.amount
                return time, self.trace.at(time)
            level = self._event_level + point.amount
            if point.amount < 0.0:
                return self.trace.reaches(level, before=time.value), level
            return (self.trace.reaches(level, time.value) if point.amount else time), level
        if point.unit == "mm":
            level = (self.after if point.amount < 0.0 else self.before) + point.amount
        elif point.amount == 0.0:
            return self._first_motion, self.before
        else:
            level = self.before + (self.after - self.before) * (point.amount / 100.0)
        return self.trace.reaches(level, self.located.moves), level
