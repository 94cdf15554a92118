"""Curves for figures: records over a reference, with their events, and next to the family's shape.

Times count from the first detected motion. All curves of a motion show the same share of its
duration before and after this instant.
"""

import logging
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits, in_p
from breaker.common.randomness import generator
from breaker.diagnosis.estimate import DriveRecord, Estimate, Given
from breaker.diagnosis.words import say
from breaker.family.shape import SHAPE_TIMES
from breaker.model.parameters import NAMES
from breaker.records.files import printable
from breaker.records.measurements import Reading

TOLERANCE = 0.05
"""Half of the band around a reference, share of its stroke: IEC 62271-100 grants 5 %."""

_WINDOW = -1.0, 8.0  # durations around the first motion: rest before, over-travel and rest after
_SIGN = {"closing": 1.0, "opening": -1.0}
_PRIOR, _MOST = 1000, 30  # prior draws and operations that a figure can show


def _window(record: DriveRecord, begin: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return times after the first motion, ms, and travel, mm, from ``begin`` or earlier on."""
    raw, (before, after) = record.raw, record.shape.duration * np.array(_WINDOW)
    time = raw.time[raw.inside] - raw.moves
    near = (time >= np.fmin(before, begin)) & (time <= after)
    return time[near], raw.left[near]


# ---- over a reference ----------------------------------------------------------------------------


class Overlay(NamedTuple):
    """A record over a reference of the same motion.

    Attributes:
        operation, motion, phase, file: Record.
        good_file: File of the reference.
        time: Times of both, ``(t,)``, ms after the first motion.
        way, good: Travel of both from the rest before, rising with time, ``(t,)``, mm.
        band: Half of the tolerance band, mm.
        share: The same, share of the reference's stroke.
        leaves: First time at which the record leaves the band, and its difference; None if never.
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
        """Record minus reference, ``(t,)``, mm."""
        return self.way - self.good

    @property
    def title(self) -> str:
        """Motion, phase and file of the record."""
        which = ", ".join(filter(None, (self.motion, self.phase)))
        return f"{which} in {printable(self.file).rpartition('/')[2]}"

    @property
    def words(self) -> str:
        """Whether and where the record leaves the band."""
        values = {"band": in_digits(self.band, 3), "share": in_digits(100.0 * self.share, 4)}
        for name, place in (("farthest", self.farthest), ("leaves", self.leaves)):
            at, by = place or (np.nan, np.nan)
            values |= {f"{name}_at": f"{at:.1f}", f"{name}_by": in_digits(by, 3, sign=True)}
        return say("overlay-leaves" if self.leaves else "overlay-within", **values)

    @property
    def values(self) -> dict[str, object]:
        """All but the curves, as plain values."""
        curves = ("time", "way", "good")
        return {name: value for name, value in self._asdict().items() if name not in curves}


def overlaid(
    records: Sequence[DriveRecord], good: Sequence[DriveRecord], share: float = TOLERANCE
) -> list[Overlay]:
    """Compare records with references of the same motion, and of the same phase where there is one.

    A record without a reference is left out; one whose first motion is hidden is logged.

    Args:
        share: Half of the tolerance band, share of the reference's stroke.
    """
    overlays = []
    for record in records:
        usable = [e for e in good if e.motion == record.motion and not e.reason]
        same = [e for e in usable if e.operation.phase == record.operation.phase]
        if record.reason or not usable:
            continue
        best = (same or usable)[0]
        if hidden := record.raw.reading.start_hidden or best.raw.reading.start_hidden:
            about = {"file": printable(record.operation.file), "reason": hidden}
            logging.getLogger("breaker").warning(say("overlay-hidden", **about))
            continue
        overlays.append(_overlay(record, best, share))
    return overlays


def _overlay(record: DriveRecord, good: DriveRecord, share: float) -> Overlay:
    """Compare a record with its reference."""
    sign, of = _SIGN[record.motion], record.operation
    (time, travel), (good_time, good_travel) = map(_window, (record, good))
    both = (time >= good_time[0]) & (time <= good_time[-1])
    time, way = time[both], sign * (travel[both] - record.raw.segment.before)
    known = np.isfinite(good_travel)
    good_travel = np.interp(time, good_time[known], good_travel[known])
    good_way = sign * (good_travel - good.raw.segment.before)
    difference, band = way - good_way, share * good.shape.stroke
    outside = np.abs(difference) > band
    first, farthest = int(outside.argmax()), int(np.nanargmax(np.abs(difference)))
    places = [(float(time[k]), float(difference[k])) for k in (first, farthest)]
    places = places if outside.any() else [None, places[1]]
    about = of.number, record.motion, of.phase, str(of.file), str(good.operation.file)
    return Overlay(*about, time, way, good_way, band, share, *places)


# ---- panels of a report --------------------------------------------------------------------------


class Marked(NamedTuple):
    """Curve of a channel with its events.

    Attributes:
        phase: Name of the channel.
        time, travel: Curve, ms of the file and mm.
        moves: Time and travel of the first detected motion; nan if hidden.
        switching: Time and travel of contact touch or separation; nan if not known.
        timed: Whether the contact was measured.
        rests: Travel before and after the motion, mm.
        points: Times and travels of the points between which speeds are measured.
        beside: Contact ("contact") and coil ("trigger") at the times, as shares of their ranges.
    """

    phase: str
    time: np.ndarray
    travel: np.ndarray
    moves: tuple[float, float]
    switching: tuple[float, float]
    timed: bool
    rests: tuple[float, float]
    points: list[tuple[float, float]]
    beside: Mapping[str, np.ndarray]


class Panel(NamedTuple):
    """One motion of all channels, and their overlays."""

    title: str
    motion: str
    curves: list[Marked]
    overlays: list[Overlay]


def panel_of(estimates: Sequence[Estimate], overlays: Iterable[Overlay], title: str) -> Panel:
    """Return the panel of one motion of an operation.

    Args:
        estimates: Estimates of its channels.
        overlays: Overlays of all motions.
    """
    motion, operations = estimates[0].record.motion, [e.record.operation for e in estimates]
    keys = {(str(operation.file), operation.number, motion) for operation in operations}
    own = [e for e in overlays if (e.file, e.operation, e.motion) in keys]
    return Panel(title, motion, [_marked(e) for e in estimates], own)


def _marked(estimate: Estimate) -> Marked:
    """Return the curve of a record with its events."""
    record, raw, contact = estimate.record, estimate.record.raw, estimate.contact
    lead = 1.1 * (contact.trigger - raw.moves)  # from the trigger on, with some of the rest before
    time, travel = _window(record, lead)
    time = time + raw.moves
    known = np.isfinite(travel)
    reading, points = Reading(raw, contact), []
    for speed in estimate.speeds:
        if speed.motion == record.motion and not estimate.measured[speed.name].reason:
            ends = [p for p in (speed.start, speed.end) if not p.of_event or p.amount or p.later]
            for at, level in map(reading.place, ends):  # the event itself has its own mark
                points.append((at.value, _SIGN[record.motion] * level.value))
    beside = {}
    for kind in raw.currents.channels.keys() & {"trigger", "contact"}:
        values = np.interp(time, raw.time, raw.currents.channels[kind])
        seen = values[np.isfinite(values)]  # none of a column that is empty here
        if seen.size and np.ptp(seen) > 0.0:
            beside[kind] = (values - seen.min()) / np.ptp(seen)
    moves = np.nan if raw.reading.start_hidden else raw.moves
    marks = [
        (at, float(np.interp(at, time[known], travel[known])) if np.isfinite(at) else np.nan)
        for at in (moves, contact.time)
    ]
    rests = raw.segment.before, raw.segment.after
    phase = record.operation.phase
    return Marked(phase, time, travel, *marks, record.timed, rests, points, beside)


# ---- next to the family --------------------------------------------------------------------------


class PictureCurve(NamedTuple):
    """A record next to the nearest shape of the family.

    Attributes:
        file: Its file.
        words: How the record fits the family; ``good`` whether it does.
        time, travel: Record, ms after the first motion, and mm.
        grid, nearest: Nearest shape, ``(g,)``, in the same units.
        left: Record minus nearest shape, ``(g,)``, mm; nan without a sample.
        switching: Draws of contact touch or separation, ms after the first motion; may be empty.
    """

    file: str
    words: str
    good: bool
    time: np.ndarray
    travel: np.ndarray
    grid: np.ndarray
    nearest: np.ndarray
    left: np.ndarray
    switching: np.ndarray


class Shown(NamedTuple):
    """Data of the figure of a drive.

    Attributes:
        curves: First record of each motion.
        posteriors: Draws ``(d, p)`` of operations, by their motions; nan of a withheld parameter.
        prior: Prior draws ``(d, p)``.
    """

    curves: Mapping[str, PictureCurve]
    posteriors: Mapping[str, Sequence[np.ndarray]]
    prior: np.ndarray


def shown(estimates: Sequence[Estimate], given: Given, *, seed: int) -> Shown:
    """Return the data of a figure; at least one record is usable."""
    usable = [e for e in estimates if not e.record.reason]
    first = {e.record.motion: e for e in reversed(usable)}
    posteriors = defaultdict(list)
    for e in [e for e in usable if e.draws is not None][:_MOST]:
        if e.record.motion == e.motions[0]:
            withheld = [bool(e.why_not(name)) for name in NAMES]
            theta = np.where(withheld, np.nan, e.draws.theta)
            posteriors[" and ".join(e.motions)].append(theta)
    curves = {motion: _picture_curve(first[motion]) for motion in sorted(first)}
    prior = given.sample_prior(usable[0], _PRIOR, generator(seed, "prior draws"))
    return Shown(curves, posteriors, prior)


def _picture_curve(estimate: Estimate) -> PictureCurve:
    """Return the record of an estimate next to the nearest shape."""
    record, match, shape = estimate.record, estimate.match, estimate.record.shape
    sign, after = _SIGN[record.motion], record.tenth - record.raw.moves
    left = np.where(shape.present, sign * shape.stroke * (shape.way - match.nearest), np.nan)
    drawn = estimate.draws is not None and not estimate.contact_unknown
    switching = after + estimate.draws.switching[record.motion] if drawn else np.empty(0)
    grid = after + shape.duration * SHAPE_TIMES
    nearest = sign * (shape.rest + shape.stroke * match.nearest)
    words = say("picture-outside" if estimate.misfit else "picture-inside", p=in_p(match.p_value))
    file, curve = printable(record.operation.file), _window(record)
    about = file.rpartition("/")[2], words, not estimate.misfit
    return PictureCurve(*about, *curve, grid, nearest, left, switching)
