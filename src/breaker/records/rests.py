"""Rests before and after a motion, also where the drive hardly rests.

A rest that drifts, creeps, swings or is cut short has a value all the same, with an error as large
as what is seen to move, or may follow.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breaker.records.segments import Segment
from breaker.records.uncertain import Trace, Uncertain

__all__ = ["Rests"]

_BEFORE = (5.0, 0.05)  # times the motion's duration, the rest before it: from, to
_AFTER = 8.0  # times that, farthest rest after it,
_LAST = 1 / 3  # of which this share counts
_TAIL = 0.7  # share of the time after the arrival from which its rest follows if it moves
_SHORT = 6.0  # samples, least length of a rest
_PARTS = 4  # of the rest after a motion, whose means are compared
_STILL = 16.0  # sum of squares of these, in sds, up to which a drive rests
_SEEN = 3.0  # sd, from which a drift is seen
_ONWARD, _CREEPS = 2.8, 2.0  # times the way seen in a rest that drifts or creeps, its error
_BRAKED = 0.4  # strokes: what a drive still goes, at its greatest speed; with the square of this
# Strokes that a drive may still swing by at its arrival; they fade so fast, over its duration.
_FOLLOWS, _FADES = 0.08, 3.0


@dataclass(eq=False)
class Rests:
    """The rests of a motion.

    Attributes:
        trace: The curve, in the direction of the motion.
        segment: The part of the record that is the motion.
        moves, arrival: Times of the first motion and of 90 % of the way, ms.
    """

    trace: Trace
    segment: Segment
    moves: float
    arrival: float

    @cached_property
    def before(self) -> Uncertain:
        """Travel at rest before the motion, mm; a drift that is seen goes on up to the motion."""
        begin, end = (self.moves - share * self.trace.duration for share in _BEFORE)
        first = float(self.trace.known[0])
        end = max(end, min(self.moves, first + _SHORT * self.trace.step))
        mean = self.trace.rest(begin, end, "before")
        late = self.trace.rest(0.5 * (max(begin, first) + end), end, "before") - mean
        seen = abs(late.value) > _SEEN * self.trace.sd(late)
        return mean + self.trace.error(0.0, _ONWARD * abs(late.value) if seen else 0.0)

    @cached_property
    def after(self) -> Uncertain:
        """Travel at rest after the motion, mm: where the drive rests, settles, or is last seen."""
        duration, stroke = self.trace.duration, self.segment.stroke
        end = min(float(self.trace.known[-1]), self.arrival + _AFTER * duration)
        settled = self.trace.settles(end - _TAIL * (end - self.arrival), end)
        found = settled if settled is not None else self._last(end)
        follows = _FOLLOWS * np.exp(-_FADES * max(end - self.arrival, 0.0) / duration)
        braked = 0.0 if self.segment.arrived else _BRAKED * self.segment.speed**2
        return found + self.trace.error(0.0, stroke * float(follows + braked))

    def _last(self, end: float) -> Uncertain:
        """Mean of the last third of the time after the arrival, up to an end."""
        begin = end - max(_LAST * (end - self.arrival), _SHORT * self.trace.step)
        mean = self.trace.rest(begin, end, "after")
        parts = self.trace.parts(begin, end, _PARTS)
        if not parts:
            return mean
        off = [part - mean for part in parts]
        square = sum((each.value / max(self.trace.sd(each), 1e-12)) ** 2 for each in off)
        if square <= _STILL:
            hidden = off[-1].value ** 2 - self.trace.sd(off[-1]) ** 2
            return mean + self.trace.error(0.0, float(np.sqrt(max(hidden, 0.0))))
        values = [part.value for part in parts]
        ways = np.diff(values)
        creeps = (ways > 0.0).all() or (ways < 0.0).all()
        found = parts[-1] if creeps else mean
        return found + self.trace.error(0.0, (_CREEPS if creeps else 1.0) * float(np.ptp(values)))
