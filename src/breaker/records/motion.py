"""The motion in a record: which part of it that is, the samples that are its own, and their noise.

The breaker has moved where the travel crosses from one third of its range to the opposite one:
overtravel, rebound, bounces and a drifting rest stay within a third. All is relative to the
record's own range, noise and speed, so neither unit nor stroke nor rate matters.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from breaker.common.numerals import in_digits
from breaker.records.noise import (
    REST,
    Noise,
    hum_of,
    noise_at_rest,
    ripple_of,
    smoothed,
    white_noise,
)
from breaker.records.rejections import (
    FEWEST,
    MATTERS,
    OtherMotionError,
    SeveralMotionsError,
    UnusableError,
)

_WINDOW = 2.0  # ms, of the running median: a burst of nearly half of it leaves no trace
CLEAR = 12.0  # sd of the noise, least range of a reading in which something moves
_BEGUN = 0.1  # of the way, from which a motion is under way; of its greatest speed, until it rests
_NEAR = 5  # times as long as the motion, how far the rest before and after it is looked at
_SLOW = 2 / 3  # of the greatest speed: below, touch or damper act, and the force has been seen


@dataclass(frozen=True)
class Segment:
    """The part of a record that belongs to one motion."""

    begin: int  # first sample: that of the record, or the first after an earlier motion
    end: int  # the sample after the last: the end of the record, or before the travel goes back
    before: float  # median travel at rest before the motion, mm
    # median travel after the motion, mm; of a drive that does not arrive, the farthest
    after: float
    speed: float  # at the end, over the greatest one; 0 if the travel goes back
    back: float  # about when the travel goes back, ms; nan if it does not

    @property
    def arrived(self) -> bool:
        """Whether the drive comes to rest before the end."""
        return self.speed <= _BEGUN

    @property
    def stroke(self) -> float:
        """Way between the rest positions, mm."""
        return abs(self.after - self.before)


@dataclass(eq=False)
class Course:
    """A reading along a record: without noise and bursts, and its motions."""

    time: np.ndarray  # times, (t,), ms, evenly spaced
    reading: np.ndarray  # in any unit, (t,); NaN where a sample is missing

    @cached_property
    def noise(self) -> float:
        """Standard deviation of its noise, if samples are independent."""
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
        """Whether it changes by more than noise does."""
        return bool(np.ptp(self.smooth) > CLEAR * self.noise)

    @cached_property
    def crossings(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of each motion the last sample in the third that it leaves, the first in the opposite
        one, and whether it rises, ``(m,)`` each.
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
        """Every motion, either way."""
        return [self.motion(k) for k in range(self.middles.size)]

    def motion(self, k: int) -> Segment:
        """Return one of the motions."""
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
    """Bounds of a motion about its middle, from the middles of those before and after it.

    It begins half way from the arrival of the one before. It ends where the one after has begun,
    and back by twice as long as that takes to four tenths, as a force that builds up begins before.
    """
    low, rest = done[start : middle + 1].min(), np.median(done[middle:stop])
    way = rest - low
    if start:
        still = done <= low + _BEGUN * way
        start = (_first(still, start) + _last(still, middle)) // 2
    if stop < done.size:
        begun, well = (_last(done >= rest - share * way, stop) for share in (_BEGUN, 4 * _BEGUN))
        stop = max(middle + 1, begun - 2 * (well - begun))
    return start, middle, stop


def _rests(first: np.ndarray, second: np.ndarray, *, arrived: bool) -> tuple[float, float]:
    """Travel at rest before and after a motion, close to it, since the rest may drift."""
    low, high = first.min(), second.max()
    begun = _last(first <= low + _BEGUN * (high - low), first.size - 1)
    done = _first(second >= high - _BEGUN * (high - low), 0)
    near = _NEAR * (first.size - begun + done)
    before = np.median(first[max(0, begun - near) : begun + 1])
    there = second[done : done + near]
    return float(before), float(np.median(there[there.size // 2 :]) if arrived else high)


def _end_speed(done: np.ndarray) -> float:
    """Speed at the end of a record over the greatest one, in a third of the time of the motion."""
    low, way = done.min(), np.ptp(done)
    begun, late = (_first(done >= low + share * way, 0) for share in (_BEGUN, 1.0 - _BEGUN))
    span = max(1, (late - begun) // 3)
    fastest = (done[span:] - done[:-span]).max(initial=0.0)
    if fastest == 0.0:
        return 1.0  # what moves is nearer to the end than a running median sees
    return float((done[-1] - done[-1 - span]) / fastest)


def _first(flags: np.ndarray, start: int) -> int:
    """First sample from one on at which a flag is set."""
    return start + int(flags[start:].argmax())


def _last(flags: np.ndarray, stop: int) -> int:
    """Last sample up to one at which a flag is set."""
    return stop - int(flags[stop::-1].argmax())


def find_segment(
    time: np.ndarray,
    travel: np.ndarray,
    motion: str,
    *,
    begin: float = float("nan"),
    end: float = float("nan"),
) -> Segment:
    """Return where in a record the motion asked for is.

    Args:
        time: Times of a record, ``(t,)``, ms, evenly spaced.
        travel: Travel towards closed, ``(t,)``, mm; NaN where a sample is missing.
        motion: "closing" or "opening".
        begin, end: Part of the record to look in, ms; nan for its beginning and end.

    Raises:
        SeveralMotionsError: If the motion is in the record more than once.
        UnusableError: If nothing moves, the motion is not in the record, or the record ends before
            the drive slows down at the touch or the damper.
    """
    first = int(np.searchsorted(time, np.nan_to_num(begin, nan=-np.inf)))
    last = int(np.searchsorted(time, end, side="right"))  # of NaN all
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
            f"the travel goes the other way, which is no {motion}; is the motion wrong, or "
            "endurance.format.sign?"
        )
    if forward.sum() > 1:
        at = time[course.middles]
        marks = [begin, *(0.5 * (at[1:] + at[:-1])).tolist(), end]
        raise SeveralMotionsError(
            f"has {forward.sum()} motions of {motion}, at "
            f"{', '.join(f'{moment:.0f}' for moment in at[forward])} ms; write from and to of the "
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
    time: np.ndarray  # times of the whole record, (n,), ms
    whole: np.ndarray  # its travel, (n,), mm towards closed, doubtful samples among them
    doubts: np.ndarray  # kind of each doubtful sample, (n,) of text; "" where nothing is doubtful
    quantum: float  # step of the reading, mm; 0 where it is fine
    segment: Segment  # the part that is the motion
    moves: float  # time of the first motion, ms
    moves_sd: float  # standard deviation of its fit, ms

    @property
    def inside(self) -> slice:
        """The samples of the motion."""
        return slice(self.segment.begin, self.segment.end)

    @cached_property
    def sure(self) -> np.ndarray:
        """Travel of the whole record, ``(n,)``, mm; NaN where a sample is missing or doubtful."""
        return np.where(self.doubts == "", self.whole, np.nan)

    @property
    def left(self) -> np.ndarray:
        """That of the motion."""
        return self.sure[self.inside]

    @cached_property
    def done(self) -> np.ndarray:
        """Shares of the way that are done, ``(m,)``; NaN where a sample is missing or doubtful."""
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

        Of the rest before the motion; of a record without rest, what is white in it.
        """
        sd, colour = self.noise.process
        if np.isnan(sd):
            sd, colour = white_noise(self.left), 0.0
        return max(sd, self.quantum / np.sqrt(12.0)), colour

    @cached_property
    def hum(self) -> tuple[float, float]:
        """Amplitude, mm, and frequency, kHz, by which the mains swing the reading; 0 if not."""
        amplitude, frequency = hum_of(self.time[self.inside], self.left, self.moves)
        matters = amplitude > MATTERS * self.segment.stroke
        return (amplitude, frequency) if matters else (0.0, 0.0)

    @cached_property
    def ripple(self) -> float:
        """Root mean square of a ripple of the reading during the motion, mm; 0 if none is clear."""
        return max(self.segment.stroke * ripple_of(self.done), self.hum[0] / np.sqrt(2.0))

    @cached_property
    def first_motion_sd(self) -> float:
        """Standard deviation of the first motion, ms: of its fit, and where the reading ripples."""
        there = self.time[self.inside] >= self.moves  # before, another motion may end
        done = np.where(there, self.done, 0.0)
        low, high = ((done >= share).argmax() for share in (0.3 * _BEGUN, 2 * _BEGUN))
        slow = (high - low) * self.step / (1.7 * _BEGUN)  # ms/stroke
        return float(np.hypot(self.moves_sd, self.ripple / self.segment.stroke * slow))
