"""The motion in a record: which part of it that is, the samples that are its own, and their noise.

A record may hold a closing and an opening, or more, and go on for seconds. The breaker has moved
where the travel crosses from one third of its range to the opposite one: overtravel, rebound,
bounces and a drifting rest stay within a third. All is relative to the record's own range, noise
and speed, so neither unit nor stroke nor rate matters.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from breaker.common.numerals import in_digits
from breaker.records.fits import smoothed
from breaker.records.noise import Noise, Ripple, noise_at_rest, ripple_of
from breaker.records.rejections import FEWEST, MATTERS, SeveralMotionsError, UnusableError

_WINDOW = 2.0  # ms, of the running median: a burst of nearly half of it leaves no trace
_CLEAR = 12.0  # sd of the noise, least range of a reading in which something moves
_BEGUN = 0.1  # of the way, from which a motion is under way; it is at rest within a tenth of that
_NEAR = 5  # times as long as the motion, how far the rest before and after it is looked at
_SLOW = 2 / 3  # of the greatest speed: below, touch or damper act, and the force has been seen
_STILL = 0.1  # of the greatest speed: below, the drive has arrived
# Rest that shows the noise, ms before the first motion: its start may be gradual, and far before it
# an earlier motion may still ring.
_REST = (50.0, 1.0)
_BLOCK = 8.0  # ms, of which levels are compared; over four of them a drive that rests stays


@dataclass(frozen=True)
class Segment:
    """The part of a record that belongs to one motion.

    Attributes:
        begin: First sample: that of the record, or the first after an earlier motion.
        end: The sample after the last: the end of the record, or before the travel goes back.
        before: Median travel at rest before the motion, mm.
        after: Median travel after the motion, mm; of a drive that does not arrive, the farthest.
        speed: At the end, over the greatest one; 0 if the travel goes back.
        back: About when the travel goes back, ms; nan if it does not.
    """

    begin: int
    end: int
    before: float
    after: float
    speed: float
    back: float

    @property
    def arrived(self) -> bool:
        """Whether the drive comes to rest before the end."""
        return self.speed <= _STILL

    @property
    def stroke(self) -> float:
        """Way between the rest positions, mm."""
        return abs(self.after - self.before)


@dataclass(eq=False)
class Course:
    """A reading along a record: without noise and bursts, and its motions.

    Attributes:
        time: Times, ``(t,)``, ms, evenly spaced.
        reading: In any unit, ``(t,)``; NaN where a sample is missing.

    Example:
        >>> time = np.arange(0.0, 60.0, 0.1)
        >>> course = Course(time, 14.0 * np.clip((time - 20.0) / 10.0, 0.0, 1.0))
        >>> [(found.before, found.after) for found in course.motions]
        [(0.0, 14.0)]
    """

    time: np.ndarray
    reading: np.ndarray

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
        return bool(np.ptp(self.smooth) > _CLEAR * self.noise)

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
        begin, middle, end = _between(
            done, self.noise, *[0, *self.middles.tolist(), done.size][k : k + 3]
        )
        back = float(self.time[end]) if end < done.size else float("nan")
        speed = 0.0
        if end == done.size:
            speed = _end_speed(done[begin : max(begin + 1, end - self.half)])
        before, after = _rests(done[begin:middle], done[middle:end], arrived=speed <= _STILL)
        return Segment(begin, end, sign * before, sign * after, speed, back)


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
            the drive slows down. One that ends later is enough: the forces that drive it have been
            seen up to the touch or the damper.
    """
    first = 0 if np.isnan(begin) else int(np.searchsorted(time, begin))
    last = len(time) if np.isnan(end) else int(np.searchsorted(time, end, side="right"))
    time, sign = time[first:last], 1.0 if motion == "closing" else -1.0
    if (count := int((~np.isnan(travel[first:last])).sum())) < 2 * FEWEST:
        raise UnusableError(f"only {count} samples of travel in the part to look in")
    course = Course(time, sign * travel[first:last])
    if not course.moves:
        raise UnusableError(
            f"nothing moves: the travel ranges over {in_digits(np.ptp(course.smooth), 3)} mm, with "
            f"noise of {in_digits(course.noise, 2)} mm; is it the right column?"
        )
    forward = course.crossings[2]
    if not forward.any():
        raise UnusableError(
            f"the travel goes from {sign * course.smooth[0]:.1f} to {sign * course.smooth[-1]:.1f} "
            f"mm, which is no {motion}; is it in the wrong folder, or endurance.format.sign wrong?"
        )
    if forward.sum() > 1:
        raise _several(time[course.middles], forward, motion, (begin, end))
    found = course.motion(int(forward.argmax()))
    if found.speed > _SLOW:
        moving = f"{time[-1]:.1f} ms and {found.speed:.0%} of the greatest speed"
        raise UnusableError(f"ends in the middle of the {motion}, at {moving}; record longer")
    place = {"begin": first + found.begin, "end": first + found.end}
    return replace(found, **place, before=sign * found.before, after=sign * found.after)


def _several(
    at: np.ndarray, forward: np.ndarray, motion: str, part: tuple[float, float]
) -> SeveralMotionsError:
    """Why a motion is refused that is in the part of a record more than once."""
    between = [part[0], *(0.5 * (at[1:] + at[:-1])).tolist(), part[1]]
    times = ", ".join(f"{each:.0f}" for each in at[forward])
    return SeveralMotionsError(
        f"has {forward.sum()} motions of {motion}, at {times} ms; say which one is meant by from "
        "and to in operations.csv",
        [(between[k], between[k + 1]) for k in np.flatnonzero(forward)],
    )


def white_noise(travel: np.ndarray) -> float:
    """Return the sd of the noise of a record, mm, if its samples are independent.

    Second differences of a motion at even speed are noise alone, of sqrt(6) times its sd.
    """
    second = np.diff(travel[~np.isnan(travel)], n=2)
    return float(np.median(np.abs(second)) / (0.6745 * np.sqrt(6.0))) if second.size else 0.0


def _first(flags: np.ndarray, start: int) -> int:
    """First sample from one on at which a flag is set."""
    return start + int(flags[start:].argmax())


def _last(flags: np.ndarray, stop: int) -> int:
    """Last sample up to one at which a flag is set."""
    return stop - int(flags[stop::-1].argmax())


def _between(
    done: np.ndarray, noise: float, start: int, middle: int, stop: int
) -> tuple[int, int, int]:
    """Bounds of a motion about its middle, from those of the motions before and after it.

    It begins once the one before has arrived, and ends no later than the one after begins: where
    that has begun, and back by twice as long as it takes from there to four tenths of the way, for
    a force that builds up begins before an even one.
    """
    low, rest = done[start : middle + 1].min(), np.median(done[middle:stop])
    way = rest - low
    if start:  # the last time, in the first half of the rest, that it is off the level of the other
        arrived = _first(done <= low + _BEGUN * way, start)
        begun = _last(done <= low + _BEGUN * way, middle)
        half = (arrived + begun) // 2
        off = np.abs(done[arrived:half] - np.median(done[half : begun + 1]))
        near = max(0.1 * _BEGUN * way, _CLEAR * noise)
        last = int(np.flatnonzero(off > near)[-1:].sum())
        start = arrived + (last if last < off.size - 1 else 0)  # it may still settle as it begins
    if stop < done.size:
        begun, well = (_last(done >= rest - share * way, stop) for share in (_BEGUN, 4 * _BEGUN))
        stop = max(middle + 1, begun - 2 * (well - begun))
    return start, middle, stop


def _rests(first: np.ndarray, second: np.ndarray, *, arrived: bool) -> tuple[float, float]:
    """Travel at rest before and after a motion, from what leads to its middle and what follows.

    Close to the motion, since the rest may drift: as far as a few times as long as it lasts.
    """
    low, high = first.min(), second.max()
    begun = _last(first <= low + _BEGUN * (high - low), first.size - 1)
    done = _first(second >= high - _BEGUN * (high - low), 0)
    near = _NEAR * (first.size - begun + done)
    before = np.median(first[max(0, begun - near) : begun + 1])
    there = second[done : done + near]
    return float(before), float(np.median(there[there.size // 2 :]) if arrived else high)


def _end_speed(done: np.ndarray) -> float:
    """Speed at the end of a record, over the greatest one."""
    low, way = done.min(), np.ptp(done)
    if way == 0.0:
        return 1.0  # what moves is nearer to the end than a running median sees
    shares = np.linspace(
        _BEGUN, 1.0 - _BEGUN, 17
    )  # six further on, three tenths of the way are gone
    reached = np.array([_first(done >= low + share * way, 0) for share in shares])
    span = max(1, int((reached[6:] - reached[:-6]).min()))
    return float((done[-1] - done[max(0, done.size - 1 - span)]) / (3 * _BEGUN * way))


@dataclass(frozen=True)
class LocatedMotion:
    """A motion in its record.

    Attributes:
        motion: "closing" or "opening".
        time: Times of the whole record, ``(n,)``, ms.
        whole: Its travel, ``(n,)``, mm towards closed, doubtful samples among them.
        doubts: Kind of each doubtful sample, ``(n,)`` of text; "" where nothing is doubtful.
        quantum: Step of the reading, mm; 0 where it is fine.
        segment: The part that is the motion.
        moves: Time of the first motion, ms.
        moves_sd: Standard deviation of its fit, ms.
    """

    motion: str
    time: np.ndarray
    whole: np.ndarray
    doubts: np.ndarray
    quantum: float
    segment: Segment
    moves: float
    moves_sd: float

    @property
    def inside(self) -> slice:
        """The samples of the motion."""
        return slice(self.segment.begin, self.segment.end)

    @property
    def sure(self) -> np.ndarray:
        """Travel of the whole record, ``(n,)``, mm; NaN where a sample is missing or doubtful."""
        return np.where(self.doubts == "", self.whole, np.nan)

    @property
    def left(self) -> np.ndarray:
        """That of the motion."""
        return self.sure[self.inside]

    @property
    def step(self) -> float:
        """Time between two samples, ms."""
        return float(self.time[1] - self.time[0])

    def noise_at(self, grid_step: float) -> Noise:
        """Return the noise at rest, its colour at the step of a grid, ms."""
        before = self.moves - self.time[self.inside]
        rest = self.left[(before <= _REST[0]) & (before >= _REST[1])]
        return noise_at_rest(rest, self.step, grid_step, self.quantum)

    @cached_property
    def ripple(self) -> Ripple:
        """Ripple of the reading during the motion, of amplitude 0 where none is clear."""
        before, after = self.segment.before, self.segment.after
        way = (self.left - before) * np.sign(after - before)
        return ripple_of(self.time[self.inside], way, abs(after - before))

    @cached_property
    def first_motion_sd(self) -> float:
        """Standard deviation of the first motion, ms: of its fit, and where the reading ripples."""
        before, after = self.segment.before, self.segment.after
        time, done = self.time[self.inside] - self.moves, (self.left - before) / (after - before)
        moving = time >= 0.0  # before it another motion may end
        low, high = ((moving & (done >= share)).argmax() for share in (0.3 * _BEGUN, 2 * _BEGUN))
        slow = (high - low) * self.step / (1.7 * _BEGUN)  # ms/stroke
        return float(np.hypot(self.moves_sd, self.ripple.rms / abs(after - before) * slow))

    @cached_property
    def unreturned(self) -> float:
        """By how much rests of one position differ before and behind another motion of the record,
        mm; 0 where it has no other, the drive does not rest, or they are alike.

        A drive stops where it stopped before: so much a transducer slipped in one of the motions.
        """
        count = max(round(_BLOCK / self.step), FEWEST)
        parts = self.sure[: self.sure.size // count * count].reshape(-1, count)
        levels = np.median(parts[~np.isnan(parts).any(axis=1)], axis=1)
        if levels.size < 4:
            return 0.0
        noise, stroke = self.process[0] * np.sqrt(np.pi / count), self.segment.stroke
        moved = np.ptp(np.lib.stride_tricks.sliding_window_view(levels, 4), axis=1)
        stays = np.flatnonzero(moved < 0.1 * MATTERS * stroke + 3.0 * noise)
        off = 0.0
        for rest in (self.segment.before, self.segment.after):
            own = stays[np.abs(levels[stays] - rest) < _BEGUN * stroke]
            groups = np.split(levels[own], np.flatnonzero(np.diff(own) > 8) + 1)
            off = max(off, float(np.ptp([np.median(each) for each in groups])) if own.size else 0.0)
        return off if off > MATTERS * stroke + 6.0 * noise + self.quantum else 0.0

    @property
    def process(self) -> tuple[float, float]:
        """Standard deviation of the noise of a sample, mm, and its correlation with the next.

        Of the rest before the motion; of a record without rest, what is white in it.
        """
        noise = self.noise_at(self.step)
        sd, colour = noise.process if np.isfinite(noise.sd) else (white_noise(self.left), 0.0)
        return max(sd, self.quantum / np.sqrt(12.0)), colour
