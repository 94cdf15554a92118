"""A motion located in its record: the samples that are its own, and their noise."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breaker.records.noise import Noise, noise_at_rest
from breaker.records.ripple import Ripple, ripple_of
from breaker.records.segments import Segment, white_noise

# Rest that tells the noise, ms before the first motion: its start may be gradual, and far before it
# an earlier motion may still ring.
_REST = (50.0, 1.0)


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

    @property
    def process(self) -> tuple[float, float]:
        """Standard deviation of the noise of a sample, mm, and its correlation with the next.

        Of the rest before the motion; of a record without rest, what is white in it.
        """
        noise = self.noise_at(self.step)
        sd, colour = noise.process if np.isfinite(noise.sd) else (white_noise(self.left), 0.0)
        return max(sd, self.quantum / np.sqrt(12.0)), colour
