"""What pictures of answers show: a record of each motion, posteriors, and curves with marks."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_p
from breaker.common.randomness import generator
from breaker.diagnosis.estimate import Estimate, Given
from breaker.diagnosis.overlay import Overlay
from breaker.family.membership import PARTS
from breaker.family.shape import SHAPE_TIMES
from breaker.model.parameters import NAMES
from breaker.records.files import printable
from breaker.records.measurements import Reading
from breaker.records.record import Record

_PRIOR = 1000  # draws
_MOST = 30  # operations of which posteriors are shown
_LEAD = 0.1  # of the time from the trigger to the first motion, shown before it
_BEFORE, _AFTER = 1.0, 8.0  # of the durations about the first motion, what a panel shows


class PictureCurve(NamedTuple):
    """A record, beside the nearest shape of the family.

    Attributes:
        file: Where it is from.
        words: How it fits; ``good`` whether it does.
        time, travel: The record, ms after the first motion, and mm.
        grid, nearest: The same of the nearest shape, ``(g,)``.
        left: What it leaves of the record, ``(g,)``, mm; nan without a sample.
        usual: Root mean square of that by part, of 99 % of the family's drives, ``(g,)``, mm.
        switching: Draws of touch or separation, ms after the first motion; none out of the family.
    """

    file: str
    words: str
    good: bool
    time: np.ndarray
    travel: np.ndarray
    grid: np.ndarray
    nearest: np.ndarray
    left: np.ndarray
    usual: np.ndarray
    switching: np.ndarray


class Shown(NamedTuple):
    """What is shown of a drive.

    Attributes:
        title: Of the picture.
        curves: First record of each motion.
        posteriors: Draws ``(d, p)`` of some operations, by the motions that they are of; nan of a
            parameter that is withheld.
        prior: Draws ``(d, p)`` of the prior.
        switching: By motion, draws of the time from the release to touch or separation, ms.
    """

    title: str
    curves: Mapping[str, PictureCurve]
    posteriors: Mapping[str, Sequence[np.ndarray]]
    prior: np.ndarray
    switching: Mapping[str, Sequence[np.ndarray]]


def shown(answers: Sequence[Estimate], given: Given, *, seed: int) -> Shown:
    """Return what is drawn of answers, of which one at least is of a record that can be used."""
    there = [answer for answer in answers if not answer.record.reason]
    counts = Counter(answer.record.motion for answer in there)
    first = {m: next(each for each in there if each.record.motion == m) for m in counts}
    source = " and ".join(f"{n} {motion}{'s' * (n > 1)}" for motion, n in counts.items())
    if len({printable(each.record.operation.file) for each in there}) == 1:
        source = _name(there[0])
    drawn = [answer for answer in there if answer.draws is not None][:_MOST]
    posteriors: dict[str, list[np.ndarray]] = {}
    switching: dict[str, list[np.ndarray]] = {}
    for answer in drawn:
        if not answer.contact_unknown:
            switching.setdefault(answer.record.motion, []).append(answer.after_release)
        if answer.record.motion == answer.motions[0]:
            theta = answer.draws.theta.copy()
            theta[:, [bool(answer.why_not(name)) for name in NAMES]] = np.nan
            posteriors.setdefault(" and ".join(answer.motions), []).append(theta)
    return Shown(
        f"Drive as inferred from {source}",
        {motion: _curve(each) for motion, each in first.items()},
        posteriors,
        given.sample_prior(there[0], _PRIOR, generator(seed, "prior draws")),
        switching,
    )


def _name(answer: Estimate) -> str:
    """Name of the file, without its folder."""
    return printable(answer.record.operation.file).rpartition("/")[2]


def _curve(answer: Estimate) -> PictureCurve:
    """The record of an answer, towards closed."""
    record, match = answer.record, answer.match
    raw, shape = record.raw, record.shape
    sign = 1.0 if record.motion == "closing" else -1.0
    after = record.tenth - raw.moves
    grid = after + shape.duration * SHAPE_TIMES
    time = raw.time[raw.inside] - raw.moves
    near = (time >= grid[0]) & (time <= grid[-1])
    left = np.where(shape.present, sign * shape.stroke * (shape.way - match.nearest), np.nan)
    usual = np.full(SHAPE_TIMES.size, np.nan)
    for (begin, end), ratio in zip(PARTS.values(), match.parts.values(), strict=True):
        part = (begin <= SHAPE_TIMES) & (end > SHAPE_TIMES)
        if np.isfinite(ratio):
            usual[part] = np.sqrt(np.nanmean(np.square(left[part]))) / ratio
    words = f"{'outside' if answer.misfit else 'inside'} the family, {in_p(match.p_value)}"
    none, untold = np.empty(0), answer.draws is None or answer.contact_unknown
    return PictureCurve(
        file=_name(answer),
        words=words,
        good=not answer.misfit,
        time=time[near],
        travel=raw.left[near],
        grid=grid,
        nearest=sign * (shape.rest + shape.stroke * match.nearest),
        left=left,
        usual=usual,
        switching=none if untold else after + answer.draws.switching[record.motion],
    )


# ---- panels of a report --------------------------------------------------------------------------


class Marked(NamedTuple):
    """A channel's curve with its marks.

    Attributes:
        phase: Name of the channel.
        time, travel: The record, ms of the file and mm.
        moves: Time of the first motion, ms, and travel there, mm.
        switching: The same of touch or separation, nan if not known.
        timed: Whether that was measured.
        rests: Travel before and after the motion, mm.
        points: Times and travels of the points of speeds.
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
    beside: Mapping[str, np.ndarray] = MappingProxyType({})


class Panel(NamedTuple):
    """One motion of all channels, and these over a good record, if there is one."""

    title: str
    motion: str
    curves: list[Marked]
    overlays: list[Overlay]


def panel_of(answers: Sequence[Estimate], overlays: Iterable[Overlay], title: str) -> Panel:
    """Return the panel of one motion of an operation.

    Args:
        answers: Of its channels.
        overlays: Of all motions.
    """
    motion, operations = answers[0].record.motion, [each.record.operation for each in answers]
    keys = {(str(each.file), each.number, motion) for each in operations}
    own = [each for each in overlays if (each.file, each.operation, each.motion) in keys]
    return Panel(title, motion, [_marked(answer) for answer in answers], own)


def _marked(answer: Estimate) -> Marked:
    """The curve of a record, and its marks."""
    record, raw = answer.record, answer.record.raw
    time, left = raw.time[raw.inside], raw.left
    known = np.isfinite(left)

    def place(at: float) -> tuple[float, float]:
        return at, float(np.interp(at, time[known], left[known])) if np.isfinite(at) else np.nan

    sign = 1.0 if record.motion == "closing" else -1.0
    reading = Reading(raw, answer.contact)
    own = [each for each in answer.speeds if each.motion == record.motion]
    own = [each for each in own if not answer.measured[each.name].reason]
    ends = [each for speed in own for each in (speed.start, speed.end)]
    points = [reading.place(e) for e in ends if not e.of_event or e.amount or e.later]
    duration, trigger = record.shape.duration, answer.contact.trigger
    first = np.fmin(raw.moves - _BEFORE * duration, trigger - _LEAD * (raw.moves - trigger))
    span = first, raw.moves + _AFTER * duration
    near = (time >= span[0]) & (time <= span[1])
    return Marked(
        record.operation.phase,
        time[near],
        left[near],
        place(np.nan if raw.reading.start_hidden else raw.moves),
        place(answer.contact.time),
        record.timed,
        (raw.segment.before, raw.segment.after),
        [(at.value, sign * level.value) for at, level in points],
        _beside(raw, near),
    )


def _beside(raw: Record, near: np.ndarray) -> dict[str, np.ndarray]:
    """Contact and coil of a record at some samples of its motion, as shares of their ranges."""
    found = {}
    for kind in ("trigger", "contact"):
        if kind in raw.currents.channels:
            values = raw.currents.channels[kind][raw.inside][near]
            there = values[np.isfinite(values)]
            if there.size and np.ptp(there) > 0.0:
                found[kind] = (values - there.min()) / np.ptp(there)
    return found
