"""A motion located in its record: the samples that are its own, and their noise."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breaker.reading.records.motion_search import Segment, white_noise
from breaker.reading.records.noise import Noise, noise_at_rest
from breaker.reading.records.ripple import Ripple, ripple_of

# Rest that tells the noise, ms before the first motion: its start may be gradual, and far before it
# an earlier motion may still ring.
_REST = (50.0, 1.0)
# Ends of a record, ms and samples at least, whose readings are compared after a motion there and
# back; how far apart these may be, in strokes at most; and from which on they are: sd of the noise
# of a median, quanta, strokes. How long a drive is at rest by then, ms, and what it moves in that.
_ENDS = 8.0, 8
_RETURNS, _APART = 0.1, (6.0, 1.0, 0.003)
_STILL, _CREEPS = 25.0, 0.1
_LOW = 0.03, 0.2  # of the way, a rise by which first motions are told
# Times the time of the low rise, before it, in which a drive creeps; by how much: sd of that by
# noise, strokes; and sd of the noise by which it has left that line.
_LEAD, _CREEPING, _LEAST, _OFF = 1.5, 6.0, 0.003, 3.0


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
        """Standard deviation of the first motion: of its fit, where the reading ripples, and where
        the drive still creeps after the motion before.
        """
        before, after = self.segment.before, self.segment.after
        time, done = self.time[self.inside] - self.moves, (self.left - before) / (after - before)
        moving = time >= 0.0  # before it another motion may end
        low, high = ((moving & (done >= share)).argmax() for share in _LOW)
        slow = (high - low) * self.step / (_LOW[1] - _LOW[0])  # ms/stroke
        rippled = self.ripple.rms / abs(after - before) * slow
        creeps = self._creeps(time, done, float(time[low])) if self.segment.begin else 0.0
        return float(np.hypot(np.hypot(self.moves_sd, rippled), 0.5 * creeps))

    def _creeps(self, time: np.ndarray, done: np.ndarray, low: float) -> float:
        """How long the drive goes on from its first motion as it crept before, ms: where it truly
        begins to move in that time is not seen.

        Args:
            time: From the first motion on, ``(n,)``, ms.
            done: Share of the way, ``(n,)``; NaN where a sample is missing.
            low: Time of the low rise, ms.
        """
        there = ~np.isnan(done)
        lead = there & (time < 0.0) & (time > -_LEAD * low)
        if lead.sum() < _ENDS[1]:
            return 0.0
        creep = np.polyfit(time[lead], done[lead], 1)
        noise = max(white_noise(done), self.quantum / np.sqrt(12.0) / self.segment.stroke)
        least = max(_CREEPING * noise * np.sqrt(12.0 / lead.sum()), _LEAST)
        if creep[0] * _LEAD * low < least:
            return 0.0
        rise = there & (time >= 0.0) & (time <= low)
        along = rise & (done - np.polyval(creep, time) < _OFF * noise)
        return float(time[along].max(initial=0.0))

    @cached_property
    def unreturned(self) -> float:
        """By how much rests of one position differ before and behind another motion of the record,
        mm; 0 where it has no other, the drive does not rest, or they are alike.

        A drive stops where it stopped before: so much a transducer slipped in one of the motions.
        """
        count = max(round(_ENDS[0] / self.step), _ENDS[1])
        parts = self.sure[: self.sure.size // count * count].reshape(-1, count)
        parts = parts[~np.isnan(parts).any(axis=1)] if parts.size else parts
        levels, apart = np.median(parts, axis=1), max(1, round(_STILL / (count * self.step)))
        stroke = abs(self.segment.after - self.segment.before)
        noise = self.process[0] * np.sqrt(np.pi / count)
        least = float(np.dot(_APART, (noise, self.quantum, stroke)))
        if levels.size <= apart:
            return 0.0
        moved = np.ptp(np.lib.stride_tricks.sliding_window_view(levels, apart + 1), axis=1)
        rests = np.flatnonzero(moved < _CREEPS * least + 3.0 * noise)
        off = 0.0
        for rest in (self.segment.before, self.segment.after):
            own = rests[np.abs(levels[rests] - rest) < _RETURNS * stroke]
            stays = np.split(levels[own], np.flatnonzero(np.diff(own) > 2 * apart) + 1)
            ends = [float(np.median(each)) for each in stays if each.size]
            off = max(off, *np.abs(np.diff(ends)), 0.0) if ends else off
        return off if off > least else 0.0

    @property
    def process(self) -> tuple[float, float]:
        """Standard deviation of the noise of a sample, mm, and its correlation with the next.

        Of the rest before the motion; of a record without rest, what is white in it.
        """
        noise = self.noise_at(self.step)
        sd, colour = noise.process if np.isfinite(noise.sd) else (white_noise(self.left), 0.0)
        return max(sd, self.quantum / np.sqrt(12.0)), colour
