"""Locate the motion in a record, with its samples and their noise.

A motion crosses from one outer third of the range of the travel to the other: over-travel, rebound,
bounces and a drifting rest stay within a third. All limits are relative to the record's own range,
noise and speed, so unit, stroke and rate do not matter.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from breaker.common.numerals import in_digits
from breaker.records.noise import REST, Noise, noise_at_rest, ripple_of, smoothed, white_noise
from breaker.records.rejections import (
    FEWEST,
    OtherMotionError,
    SeveralMotionsError,
    UnusableError,
)

_WINDOW = 2.0  # ms, window of the running median, which removes bursts of nearly half of it
CLEAR = 12.0  # sd of the noise, smallest range of a reading in which something moves
_BEGUN = 0.1  # share of the stroke from which a motion has begun, and of its top speed at rest
_NEAR = 5  # durations of the motion, length of the rest that is read before and after it
_SLOW = 2 / 3  # share of the top speed below which contact or damper brake: the record is complete


@dataclass(frozen=True)
class Segment:
    """Part of a record that belongs to one motion."""

    begin: int  # first sample: of the record, or after an earlier motion
    end: int  # last sample plus one: end of the record, or before the travel goes back
    before: float  # median travel at rest before the motion, mm
    # median travel after the motion, mm; the farthest travel if the drive does not arrive
    after: float
    speed: float  # speed at the end as a share of the top speed; 0 if the travel goes back
    back: float  # approximate time at which the travel goes back, ms; nan if it does not

    @property
    def arrived(self) -> bool:
        """Whether the drive comes to rest before the end."""
        return self.speed <= _BEGUN

    @property
    def stroke(self) -> float:
        """Distance between the rest positions, mm."""
        return abs(self.after - self.before)


@dataclass(eq=False)
class Course:
    """Reading along a record, its running median, and its motions."""

    time: np.ndarray  # times, (t,), ms, evenly spaced
    reading: np.ndarray  # reading in any unit, (t,); NaN where a sample is missing

    @cached_property
    def noise(self) -> float:
        """Standard deviation of the noise, if samples are independent."""
        return white_noise(self.reading)

    @property
    def half(self) -> int:
        """Samples of half the window of the running median."""
        return max(2, round(0.5 * _WINDOW / (self.time[1] - self.time[0])))

    @cached_property
    def smooth(self) -> np.ndarray:
        """Running median, ``(t,)``."""
        return smoothed(self.reading, self.half)

    @property
    def moves(self) -> bool:
        """Whether the reading changes by more than noise."""
        return bool(np.ptp(self.smooth) > CLEAR * self.noise)

    @cached_property
    def crossings(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Last sample of each motion in the outer third that it leaves, first sample in the other
        outer third, and whether the reading rises, each ``(m,)``.
        """
        thirds = 3.0 * (self.smooth - self.smooth.min()) / np.ptp(self.smooth)
        outer = np.flatnonzero((thirds <= 1.0) | (thirds >= 2.0))
        high = thirds[outer] >= 2.0
        last = np.flatnonzero(high[1:] != high[:-1])
        return outer[last], outer[last + 1], high[last + 1]

    @cached_property
    def middles(self) -> np.ndarray:
        """Sample in the middle of each motion, ``(m,)``."""
        leaves, reaches, _ = self.crossings
        return (leaves + reaches + 1) // 2

    @cached_property
    def motions(self) -> list[Segment]:
        """Segments of all motions, in both directions."""
        return [self.motion(k) for k in range(self.middles.size)]

    def motion(self, k: int) -> Segment:
        """Return the segment of motion k."""
        sign = 1.0 if self.crossings[2][k] else -1.0
        done = sign * self.smooth
        begin, middle, end = _bounds(done, *[0, *self.middles.tolist(), done.size][k : k + 3])
        speed, back = 0.0, float("nan")
        if end < done.size:
            back = float(self.time[end])
        else:
            speed = _end_speed(done[begin : max(begin + 1, end - self.half)])
        before, after = _rests(done[begin:middle], done[middle:end], arrived=speed <= _BEGUN)
        return Segment(begin, end, sign * before, sign * after, speed, back)


def _bounds(done: np.ndarray, start: int, middle: int, stop: int) -> tuple[int, int, int]:
    """Return begin, middle and end of a motion, from the middles of the motions around it.

    The motion begins in the middle of the rest before it. It ends before the next motion begins:
    earlier than a tenth of that motion by twice the time from a tenth to four tenths of it, since
    a force that builds up acts early.
    """
    low, rest = done[start : middle + 1].min(), np.median(done[middle:stop])
    stroke = rest - low
    if start:
        resting = done <= low + _BEGUN * stroke
        start = (_first(resting, start) + _last(resting, middle)) // 2
    if stop < done.size:
        tenth, four = (_last(done >= rest - share * stroke, stop) for share in (_BEGUN, 4 * _BEGUN))
        stop = max(middle + 1, tenth - 2 * (four - tenth))
    return start, middle, stop


def _rests(first: np.ndarray, second: np.ndarray, *, arrived: bool) -> tuple[float, float]:
    """Return the travel at rest shortly before and after a motion, since the rest may drift."""
    low, high = first.min(), second.max()
    begun = _last(first <= low + _BEGUN * (high - low), first.size - 1)
    done = _first(second >= high - _BEGUN * (high - low), 0)
    near = _NEAR * (first.size - begun + done)
    before = np.median(first[max(0, begun - near) : begun + 1])
    there = second[done : done + near]
    return float(before), float(np.median(there[there.size // 2 :]) if arrived else high)


def _end_speed(done: np.ndarray) -> float:
    """Return the speed at the end as a share of the top speed, over a third of the motion."""
    low, stroke = done.min(), np.ptp(done)
    begun, late = (_first(done >= low + share * stroke, 0) for share in (_BEGUN, 1.0 - _BEGUN))
    span = max(1, (late - begun) // 3)
    fastest = (done[span:] - done[:-span]).max(initial=0.0)
    if fastest == 0.0:
        return 1.0  # the drive moves only within the last half window of the running median
    return float((done[-1] - done[-1 - span]) / fastest)


def _first(flags: np.ndarray, start: int) -> int:
    """Return the first sample from ``start`` on at which a flag is set."""
    return start + int(flags[start:].argmax())


def _last(flags: np.ndarray, stop: int) -> int:
    """Return the last sample up to ``stop`` at which a flag is set."""
    return stop - int(flags[stop::-1].argmax())


def find_segment(
    time: np.ndarray,
    travel: np.ndarray,
    motion: str,
    *,
    begin: float = float("nan"),
    end: float = float("nan"),
) -> Segment:
    """Return the segment of a record that is the requested motion.

    Args:
        time: Times of a record, ``(t,)``, ms, evenly spaced.
        travel: Travel towards closed, ``(t,)``, mm; NaN where a sample is missing.
        motion: "closing" or "opening".
        begin, end: Part of the record to search, ms; nan for its beginning and end.

    Raises:
        SeveralMotionsError: If the record contains the motion more than once.
        UnusableError: If nothing moves, the record does not contain the motion, or it ends before
            the drive slows down at the touch or the damper.
    """
    first = int(np.searchsorted(time, np.nan_to_num(begin, nan=-np.inf)))
    last = int(np.searchsorted(time, end, side="right"))  # all for NaN
    time, sign = time[first:last], 1.0 if motion == "closing" else -1.0
    if (count := int((~np.isnan(travel[first:last])).sum())) < 2 * FEWEST:
        raise UnusableError(f"only {count} samples of travel in the part to look in")
    course = Course(time, sign * travel[first:last])
    if not course.moves:
        ranges = in_digits(np.ptp(course.smooth), 3)
        raise UnusableError(f"nothing moves but by {ranges} mm; is it the right column?")
    forward = course.crossings[2]
    if not forward.any():
        raise OtherMotionError(
            f"the travel has the opposite direction of a {motion}; is the motion wrong, or "
            "endurance.format.sign?"
        )
    if forward.sum() > 1:
        middles = time[course.middles]
        marks = [begin, *(0.5 * (middles[1:] + middles[:-1])).tolist(), end]
        raise SeveralMotionsError(
            f"has {forward.sum()} motions of {motion}, at "
            f"{', '.join(f'{ms:.0f}' for ms in middles[forward])} ms; write from and to of the "
            "one that is meant into operations.csv",
            [(marks[k], marks[k + 1]) for k in np.flatnonzero(forward)],
        )
    segment = course.motion(int(forward.argmax()))
    if abs(segment.speed) > _SLOW:
        raise UnusableError(f"ends in the middle of the {motion}; record longer")
    place = {"begin": first + segment.begin, "end": first + segment.end}
    return replace(segment, **place, before=sign * segment.before, after=sign * segment.after)


@dataclass(frozen=True)
class LocatedMotion:
    """A motion in its record."""

    motion: str  # "closing" or "opening"
    time: np.ndarray  # times of the entire record, (n,), ms
    whole: np.ndarray  # travel of the entire record, (n,), mm towards closed, also if doubtful
    doubts: np.ndarray  # kind of each doubtful sample, (n,) of text; "" where nothing is doubtful
    quantum: float  # step of the reading, mm; 0 where the step is below the noise
    segment: Segment  # part of the record that is the motion
    moves: float  # time of the first motion, ms
    moves_sd: float  # standard deviation of its fit, ms

    @property
    def inside(self) -> slice:
        """Samples of the motion."""
        return slice(self.segment.begin, self.segment.end)

    @cached_property
    def sure(self) -> np.ndarray:
        """Travel of the entire record, ``(n,)``, mm; NaN where a sample is missing or doubtful."""
        return np.where(self.doubts == "", self.whole, np.nan)

    @property
    def left(self) -> np.ndarray:
        """Travel of the motion, ``(m,)``, mm; NaN where a sample is missing or doubtful."""
        return self.sure[self.inside]

    @cached_property
    def done(self) -> np.ndarray:
        """Travel as a share of the stroke, ``(m,)``; NaN where one is missing or doubtful."""
        return (self.left - self.segment.before) / (self.segment.after - self.segment.before)

    @property
    def step(self) -> float:
        """Time between two samples, ms."""
        return float(self.time[1] - self.time[0])

    @cached_property
    def noise(self) -> Noise:
        """Noise at rest before the motion."""
        before = self.moves - self.time[self.inside]
        rest = self.left[(before <= REST[0]) & (before >= REST[1])]
        return noise_at_rest(rest, self.quantum)

    @cached_property
    def process(self) -> tuple[float, float]:
        """Standard deviation of the noise of a sample, mm, and its correlation with the next.

        Estimated at rest before the motion; without a rest, the white noise of the motion.
        """
        sd, colour = self.noise.process
        if np.isnan(sd):
            sd, colour = white_noise(self.left), 0.0
        return max(sd, self.quantum / np.sqrt(12.0)), colour

    @cached_property
    def ripple(self) -> float:
        """Root mean square of a ripple of the reading in the motion, mm; 0 if none is clear."""
        return self.segment.stroke * ripple_of(self.done)
