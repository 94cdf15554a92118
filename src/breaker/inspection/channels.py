"""Which columns of an unknown record are travels: they move between rests as a drive does.

Guessing, to propose settings: see ``layouts``.
"""

import re
from dataclasses import dataclass

import numpy as np

from breaker.files import TO_MM
from breaker.inspection.layouts import Layout
from breaker.inspection.timing import Clock
from breaker.records import running_median, white_noise

__all__ = ["Travel", "find_travels"]

_OTHER_NAMES = re.compile(
    r"(?i)curr|strom|courant|corrient|coil|spule|bobin|speed|veloc|geschw|vitesse|accel|vibrat"
    r"|press|druck|temp|aux|contact|kontakt|status|digital|trigger|\bI\d|\bI_?L\d|电流|速度|電流"
)
_TRAVEL_NAMES = re.compile(
    r"(?i)travel|stroke|\bweg|hub|posit|displac|course|carrera|transduc|angle|winkel|motion|行程|位移"
)
_TRAVEL_UNITS = frozenset([*TO_MM, "deg", "rad", "V", "counts", "%"])

_STILL = 12.0  # sd of the noise, below which nothing moves
# Of the way: the first of these takes longer than one of the others where a mass is set in motion.
# Than the next one even where a drive is fastest early, as in an opening with strong springs.
_BEGINS = (0.03, 0.12)
_LATER = ((0.12, 0.21), (0.4, 0.49))
_GENTLE = 1.2  # times
_FASTEST = 100  # kHz, of recorders
_LEAST = 0.2  # of the range of a record, between two rests
_MOST = 6  # motions in a record; more are an oscillation


@dataclass(frozen=True)
class Travel:
    """A column that moves between rests.

    Attributes:
        place: Column.
        unit: As the settings call it; None where it is not stated.
        smooth: Readings without noise, bursts and gaps, ``(t,)``.
        at: Sample in the middle of each motion, ``(m,)``.
        rises: Whether the reading rises in it, ``(m,)``.
        levels: Readings at rest before, between and after the motions, ``(m + 1,)``.
    """

    place: int
    unit: str | None
    smooth: np.ndarray
    at: np.ndarray
    rises: np.ndarray
    levels: np.ndarray

    @property
    def strokes(self) -> np.ndarray:
        """Way of each motion between the rests, ``(m,)``, in the unit of the reading."""
        return np.abs(np.diff(self.levels))

    def part(self, motion: int) -> tuple[int, int]:
        """First sample, and the one after the last, of the part with one motion alone."""
        ends = [0, *((self.at[1:] + self.at[:-1]) // 2).tolist(), self.smooth.size]
        return ends[motion], ends[motion + 1]

    def begins(self, motion: int) -> int:
        """Sample at which a motion has begun: a fiftieth of its way."""
        first, middle = self.part(motion)[0], self.at[motion]
        level, way = self.levels[motion], self.strokes[motion]
        resting = np.abs(self.smooth[first : middle + 1] - level) <= 0.02 * way
        return int(first + np.flatnonzero(resting)[-1]) if resting.any() else first

    def arrives(self, motion: int, still: int) -> int:
        """Sample from which on the travel stays at rest, within a twentieth of its way, for as
        many samples as given, or to the end.
        """
        last = self.at[motion + 1] if motion + 1 < self.at.size else self.smooth.size
        level, way = self.levels[motion + 1], self.strokes[motion]
        moving = np.abs(self.smooth[self.at[motion] : last] - level) > 0.05 * way
        begins = np.flatnonzero(~moving & np.append(True, moving[:-1]))
        ends = np.flatnonzero(~moving & np.append(moving[1:], True)) + 1
        long = (ends - begins >= still) | (ends == moving.size)
        return int(self.at[motion] + (begins[long][0] if long.any() else moving.size))


def find_travels(layout: Layout, clock: Clock) -> list[Travel]:
    """Find the columns that move between rests as a drive does; currents do not."""
    half = 5 if np.isnan(clock.rate) else round(np.clip(clock.rate, 2, _FASTEST))
    named, shaped = [], []
    for place, values in enumerate(layout.columns):
        unit, name = layout.units[place], layout.names[place]
        if place == clock.place or (unit and unit not in _TRAVEL_UNITS):
            continue
        says = unit in TO_MM or unit in ("deg", "rad") or _TRAVEL_NAMES.search(name) is not None
        if _OTHER_NAMES.search(name) and not says:
            continue
        smooth = _smooth(values, half)
        travel = None if smooth is None else _travel(place, unit, smooth, half)
        if travel and (says or _is_gentle(travel)):
            (named if says else shaped).append(travel)
    return named or shaped


def _smooth(values: np.ndarray, half: int) -> np.ndarray | None:
    """A column without noise and bursts, its ends cut where empty; None if nothing moves."""
    there = np.flatnonzero(np.isfinite(values))
    if there.size < 40:
        return None
    filled = np.interp(np.arange(values.size), there, values[there])
    smooth = running_median(filled, 2 * half + 1)
    return smooth if np.ptp(smooth) > _STILL * white_noise(values) else None


def _travel(place: int, unit: str | None, smooth: np.ndarray, half: int) -> Travel | None:
    """Motions of a column, as crossings from one third of its range to the opposite one."""
    thirds = 3.0 * (smooth - smooth.min()) / np.ptp(smooth)
    outer = np.flatnonzero((thirds <= 1.0) | (thirds >= 2.0))
    high = thirds[outer] >= 2.0
    last = np.flatnonzero(high[1:] != high[:-1])
    at = (outer[last] + outer[last + 1] + 1) // 2
    # A running median keeps a jump, as of a contact, sharp.
    if not 0 < at.size <= _MOST or (np.diff(outer)[last] < max(2, half // 2)).any():
        return None
    rises, parts = high[last + 1], np.split(smooth, at)
    thirds = np.split(thirds, at)
    rests = [parts[0][: max(1, parts[0].size // 2)]]
    for part, third, up in zip(parts[1:-1], thirds[1:], rises, strict=False):
        rests.append(part[third >= 2.0 if up else third <= 1.0])
    rests.append(parts[-1][-max(1, parts[-1].size // 4) :])
    levels = np.array([float(np.median(rest)) for rest in rests])
    travel = Travel(place, unit, smooth, at, rises, levels)
    return travel if travel.strokes.min() > _LEAST * np.ptp(smooth) else None


def _is_gentle(travel: Travel) -> bool:
    """Whether a motion begins as that of a mass, slowly; a current rises fastest at first.

    One is enough: before another, the drive may still creep to its rest.
    """
    for k, at in enumerate(travel.at.tolist()):
        before, after = travel.levels[k : k + 2]
        done = (travel.smooth[travel.part(k)[0] : at + 1] - before) / (after - before)
        back = done[::-1]
        times = [
            int((back <= start).argmax()) - int((back <= end).argmax())
            for start, end in (_BEGINS, *_LATER)
        ]
        if times[0] >= _GENTLE * min(times[1:]):
            return True
    return False
