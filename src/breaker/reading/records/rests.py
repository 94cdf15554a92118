"""Rests before and after a motion, also where the drive hardly rests.

A rest that drifts, creeps, swings or is cut short has a value all the same, with an error as large
as what is seen to move, or may follow.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breaker.reading.records.error_propagation import Trace, Uncertain
from breaker.reading.records.motion import Segment
from breaker.reading.records.rejections import NotShownError

_BEFORE = (5.0, 0.05)  # times the motion's duration, the rest before it: from, to
_AFTER = 8.0  # times that, farthest rest after it,
_LAST = 1 / 3  # of which this share counts
_TAIL = 0.7  # share of the time after the arrival from which its rest follows if it moves
_SHORT = 6.0  # samples, least length of a rest
_PARTS = 4  # of the rest after a motion, whose means are compared
_STILL = 16.0  # sum of squares of these, in sds, up to which a drive rests
_SEEN = 3.0  # sd, from which a drift is seen
_DRIFTS = 0.6  # times the way that a drift goes until the end, its error
_LATE = 0.6  # share of the time after the arrival in which it is looked for
_CALMS = 2.0  # times the duration, for which a drive may swing
_ONWARD, _CREEPS = 2.8, 2.0  # times the way seen in a rest that drifts or creeps, its error
_SWING, _RESTS = 0.5, 0.08  # durations at the end in which a swing shows; of the stroke, the most
_FITTED = 0.2  # of a swing, the error of the rest about which it does, where that is fitted
_UNSEEN, _FADES = 0.12, 2.2  # strokes of a swing that turns there, and how fast it fades, durations
_SOON = 0.8  # durations after the arrival, before which no drive rests


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
        mean = self.trace.rest(*self._lead, "before")
        return mean + self.trace.error(0.0, _ONWARD / 4.0 * self._drift * float(np.ptp(self._lead)))

    @cached_property
    def _lead(self) -> tuple[float, float]:
        """From when to when the drive rests before the motion, ms."""
        begin, end = (self.moves - share * self.trace.duration for share in _BEFORE)
        first = float(self.trace.known[0])
        return max(begin, first), max(end, min(self.moves, first + _SHORT * self.trace.step))

    @cached_property
    def _drift(self) -> float:
        """How fast the reading is seen to drift, before the motion or late after it, mm/ms."""
        last = self._end
        late, slopes = (last - _LATE * (last - self.arrival), last), [0.0]
        swings = last - self.arrival < _CALMS * self.trace.duration
        for (begin, end), count in ((self._lead, 2), (late, _PARTS))[: 1 if swings else 2]:
            parts = self.trace.parts(begin, end, count)
            ways = np.diff([each.value for each in parts])
            steady = parts and ((ways > 0.0).all() or (ways < 0.0).all())
            if steady and abs(ways.sum()) > _SEEN * self.trace.sd(parts[-1] - parts[0]):
                slopes.append(abs(float(ways.sum())) / (end - begin) * count / (count - 1))
        return max(slopes)

    @cached_property
    def after(self) -> Uncertain:
        """Travel at rest after the motion, mm: where the drive rests or settles."""
        duration, stroke = self.trace.duration, self.segment.stroke
        end = self._end
        after, window = (end - self.arrival) / duration, max(_SWING * duration, self._few)
        late = self.trace.parts(end - window, end, _PARTS)
        swings = self._seen(late) if late else stroke
        if after < _SOON or swings > _RESTS * stroke:
            raise NotShownError("the record ends before the drive rests")
        settled = self._settled
        found = settled if settled is not None else self._last(end)
        follows = _UNSEEN * stroke * float(np.exp(-_FADES * after))
        follows += (_FITTED if settled is not None else 1.0) * swings
        drifts = _DRIFTS * self._drift * (end - self.moves)
        return found + self.trace.error(0.0, follows + drifts)

    def window(self, side: str) -> tuple[float, float]:
        """Return from when to when the rest "before" or "after" the motion is read, ms."""
        if side == "before":
            return self._lead
        end = self._end
        last = max(_LAST * (end - self.arrival), _SHORT * self.trace.step)
        return end - (last if self._settled is None else _TAIL * (end - self.arrival)), end

    @cached_property
    def _end(self) -> float:
        """Until when the rest after the motion is looked at, ms."""
        return min(float(self.trace.known[-1]), self.arrival + _AFTER * self.trace.duration)

    @cached_property
    def _settled(self) -> Uncertain | None:
        """Where the end of the curve settles, mm; None where that is not seen."""
        return self.trace.settles(self._end - _TAIL * (self._end - self.arrival), self._end)

    @property
    def _few(self) -> float:
        """Least time in which parts of a rest have samples enough, ms."""
        return (_PARTS * _SHORT + 2.0) * self.trace.step

    def _seen(self, parts: Sequence[Uncertain]) -> float:
        """Way between parts of a rest that is more than noise, mm."""
        way = float(np.ptp([part.value for part in parts]))
        return max(0.0, way - _SEEN * self.trace.sd(parts[-1] - parts[0]))

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
