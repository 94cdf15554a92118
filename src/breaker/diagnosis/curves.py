"""Curves for figures, at times after the first detected motion, over a reference, and colours."""

from collections.abc import Iterable, Sequence
from itertools import cycle
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.diagnosis.estimate import DriveRecord, Estimate
from breaker.diagnosis.sentences import Sentence, say
from breaker.family.shape import SHAPE_TIMES
from breaker.records.files import printable

TOLERANCE = 0.05
"""Half-width of the tolerance band around a reference, share of its stroke (IEC 62271-100)."""

_OF_PHASES = {
    # red, amber, blue
    **dict.fromkeys(("R Y B", "R S T", "A B C"), ("#C62828", "#E39A00", "#1F5FBF")),
    **dict.fromkeys(("L1 L2 L3", "U V W"), ("#8B4A1C", "#000000", "#808080")),  # IEC 60445
}
_OTHERS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")


def phase_colours(names: Iterable[str]) -> dict[str, str]:
    """Return the colour of each phase: the usual one if all names are of one system, else any.

    >>> phase_colours(["L2", "L1"])
    {'L2': '#000000', 'L1': '#8B4A1C'}
    """
    names = [*dict.fromkeys(names)]
    for system, colours in _OF_PHASES.items():
        known = dict(zip(system.split(), colours, strict=True))
        if {name.upper() for name in names} <= known.keys():
            return {name: known[name.upper()] for name in names}
    return dict(zip(names, cycle(_OTHERS)))


def curve_of(record: DriveRecord, begin: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return times after the first detected motion, ms, and travel, mm; ``begin`` is included."""
    raw, tenth = record.raw, record.tenth - record.raw.moves
    time = raw.time[raw.inside] - raw.moves
    before, after = tenth + record.shape.duration * SHAPE_TIMES[[0, -1]]
    near = (time >= np.fmin(before, begin)) & (time <= after)
    return time[near], raw.left[near]


def speed_zone(estimate: Estimate) -> list[float]:
    """Return the times between which the speed of the motion is measured, ms of the file; empty if
    the speed has no value.
    """
    raw, name = estimate.record.raw, f"{estimate.record.motion}_speed"
    reading = raw.reading.with_contact(estimate.contact, estimate.speeds, raw.currents)
    for speed in estimate.speeds:
        if speed.name == name and not estimate.measured[name].reason:
            return [reading.place(point)[0].value for point in (speed.start, speed.end)]
    return []


class Overlay(NamedTuple):
    """A record over a reference of the same motion.

    Attributes:
        record, reference: Both records.
        time: Times of both, ``(t,)``, ms after the first detected motion.
        way, good: Travel of both from the first rest position, rising with time, ``(t,)``, mm.
        band: Half-width of the tolerance band, mm.
    """

    record: DriveRecord
    reference: DriveRecord
    time: np.ndarray
    way: np.ndarray
    good: np.ndarray
    band: float

    @property
    def difference(self) -> np.ndarray:
        """Record minus reference, ``(t,)``, mm."""
        return self.way - self.good

    @property
    def farthest(self) -> tuple[float, float]:
        """Time and difference where the difference is largest, ms and mm."""
        return self._at(int(np.nanargmax(np.abs(self.difference))))

    @property
    def leaves(self) -> tuple[float, float] | None:
        """First time at which the record leaves the band, and its difference; None if never."""
        outside = np.abs(self.difference) > self.band
        return self._at(int(outside.argmax())) if outside.any() else None

    def _at(self, k: int) -> tuple[float, float]:
        return float(self.time[k]), float(self.difference[k])

    @property
    def words(self) -> str:
        """Whether and where the record leaves the band."""
        share = 100.0 * self.band / self.reference.shape.stroke
        values = {"band": in_digits(self.band, 3), "share": in_digits(share, 4)}
        for name, place in (("farthest", self.farthest), ("leaves", self.leaves)):
            time, off = place or (np.nan, np.nan)
            values |= {f"{name}_at": f"{time:.1f}", f"{name}_by": in_digits(off, 3, sign=True)}
        return say("overlay-leaves" if self.leaves else "overlay-within", **values)


def overlaid(
    records: Sequence[DriveRecord], good: Sequence[DriveRecord]
) -> tuple[list[Overlay], list[Sentence]]:
    """Compare records with references of the same motion, and of the same phase if there is one.

    Returns:
        The overlays, without records that have no reference; and the reasons why records, or their
        references, cannot be compared: the first motion is hidden.
    """
    overlays, hidden = [], []
    for record in records:
        usable = [e for e in good if e.motion == record.motion and not e.reason]
        if record.reason or not usable:
            continue
        phase = record.operation.phase
        best = next((e for e in usable if e.operation.phase == phase), usable[0])
        if reason := record.raw.reading.start_hidden or best.raw.reading.start_hidden:
            file = printable(record.operation.file)
            hidden.append(say("overlay-hidden", file=file, reason=reason))
            continue
        sign = 1.0 if record.motion == "closing" else -1.0
        (time, travel), (times, good_travel) = curve_of(record), curve_of(best)
        both, known = (time >= times[0]) & (time <= times[-1]), np.isfinite(good_travel)
        time, way = time[both], sign * (travel[both] - record.raw.segment.before)
        good_way = np.interp(time, times[known], good_travel[known]) - best.raw.segment.before
        band = TOLERANCE * best.shape.stroke
        overlays.append(Overlay(record, best, time, way, sign * good_way, band))
    return overlays, hidden
