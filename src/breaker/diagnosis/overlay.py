"""A record over a good one: aligned at the first motion, the difference, and where it is too large.

Each is taken from its own rest before the motion, as a transducer's zero says nothing of a drive.
The band is a share of the good record's stroke: by default the 5 % to either side that IEC
62271-100 grants a travel characteristic.
"""

import logging
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.diagnosis.estimate import DriveRecord
from breaker.records.files import printable

TOLERANCE = 0.05
"""Share of the stroke, half of the band about a good record."""

_BEFORE, _AFTER = 0.5, 7.0  # of the durations, before and after the first motion
_NONE = 1e-3  # share of the band, below which a difference is none
_LASTING = 0.3, 3  # ms and samples: for less, the difference is no motion of the drive


class Overlay(NamedTuple):
    """A record over a good one of the same motion.

    Attributes:
        operation, motion, phase, file: What the record is of.
        good_file: Where the good record is from.
        time: Of both, ``(t,)``, ms after the first motion.
        way, good: Ways from the rest before the motion, ``(t,)``, mm, rising with time; nan where
            a sample is missing.
        band: Half of the band, mm.
        share: The same over the good record's stroke.
        leaves: Time and difference where the band is left first; None where it is not.
        farthest: Time and difference where the difference is largest.
    """

    operation: int
    motion: str
    phase: str
    file: str
    good_file: str
    time: np.ndarray
    way: np.ndarray
    good: np.ndarray
    band: float
    share: float
    leaves: tuple[float, float] | None
    farthest: tuple[float, float]

    @property
    def difference(self) -> np.ndarray:
        """The record less the good one, ``(t,)``, mm."""
        return self.way - self.good

    @property
    def title(self) -> str:
        """Which record it is."""
        phase = f", {self.phase}" if self.phase else ""
        return f"{self.motion}{phase} in {printable(self.file).rpartition('/')[2]}"

    @property
    def words(self) -> str:
        """Where the record leaves the band, in words."""
        share = in_digits(100.0 * self.share, 4)
        band = f"±{in_digits(self.band, 3)} mm ({share} % of the stroke)"
        most = f"{in_digits(self.farthest[1], 3, sign=True)} mm at {self.farthest[0]:.1f} ms"
        if self.leaves is None and abs(self.farthest[1]) < _NONE * self.band:
            return "is the same as the reference"
        if self.leaves is None:
            return f"stays within {band} of the reference; farthest {most} after the first motion"
        at, by = self.leaves
        first = f"{at:.1f} ms after the first motion, by {in_digits(by, 3, sign=True)} mm"
        return f"LEAVES the band of {band} {first}; farthest {most}"

    @property
    def values(self) -> dict[str, object]:
        """All but the curves, as plain values."""
        curves = ("time", "way", "good")
        return {name: each for name, each in self._asdict().items() if name not in curves}


def overlaid(
    records: Sequence[DriveRecord], good: Sequence[DriveRecord], share: float = TOLERANCE
) -> list[Overlay]:
    """Lay records over good ones.

    Args:
        records: Those of a visit; what cannot be used is left out.
        good: Good records: of several of a motion that of the same phase, and place among those of
            its motion and phase, counts, or else the first.
        share: Half of the band over the stroke.

    Returns:
        Those of records that have a good one of their motion, where both show a first motion.
    """
    counts: dict[tuple[str, str], int] = {}
    found = []
    for record in records:
        key = record.motion, record.operation.phase
        place = counts[key] = counts.get(key, -1) + 1
        same = [each for each in good if each.motion == record.motion and not each.reason]
        if record.reason or not same:
            continue
        alike = [each for each in same if each.operation.phase == record.operation.phase]
        best = alike[min(place, len(alike) - 1)] if alike else same[0]
        if hidden := record.raw.reading.start_hidden or best.raw.reading.start_hidden:
            file = printable(record.operation.file)
            words = "%s is not laid over the reference, as %s"
            logging.getLogger("breaker").warning(words, file, hidden)
            continue
        found.append(_overlay(record, best, share))
    return found


def _overlay(record: DriveRecord, good: DriveRecord, share: float) -> Overlay:
    (time, way), (good_time, good_way) = map(_from_rest, (record, good))
    duration = max(record.shape.duration, good.shape.duration)
    begin = max(-_BEFORE * duration, time[0], good_time[0])
    end = min(_AFTER * duration, time[-1], good_time[-1])
    near = (time >= begin) & (time <= end)
    time, way = time[near], way[near]
    known = np.isfinite(good_way)
    good_way = np.interp(time, good_time[known], good_way[known])
    difference, band = way - good_way, share * good.shape.stroke
    farthest = int(np.nanargmax(np.abs(difference)))
    step = record.raw.step
    first = _first_outside(np.abs(difference) > band, max(_LASTING[1], round(_LASTING[0] / step)))
    places = [
        None if k is None else (float(time[k]), float(difference[k])) for k in (first, farthest)
    ]
    of = record.operation
    about = of.number, record.motion, of.phase, str(of.file)
    curves = time, way, good_way
    return Overlay(*about, str(good.operation.file), *curves, band, share, *places)


def _from_rest(record: DriveRecord) -> tuple[np.ndarray, np.ndarray]:
    """Times after the first motion, ms, and ways from the rest before it, mm."""
    raw, sign = record.raw, 1.0 if record.motion == "closing" else -1.0
    return raw.time[raw.inside] - raw.moves, sign * (raw.left - raw.segment.before)


def _first_outside(outside: np.ndarray, lasting: int) -> int | None:
    """First sample of a run of so many outside."""
    runs = np.convolve(outside.astype(int), np.ones(lasting, int), "valid") == lasting
    return int(runs.argmax()) if runs.any() else None
