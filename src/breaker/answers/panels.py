"""The curves of one motion of an operation, all channels with their marks."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from breaker.answers.answer import Answer
from breaker.answers.overlays import Overlay
from breaker.mechanism import Point

__all__ = ["Marked", "Panel", "panel_of"]

_BEFORE, _AFTER = 1.0, 8.0  # of the durations about the first motion, what a panel shows


class Marked(NamedTuple):
    """A channel's curve with its marks.

    Attributes:
        phase: Name of the channel.
        time, travel: The record, ms of the file and mm.
        moves: Time of the first motion, ms, and travel there, mm.
        switching: The same of touch or parting, nan if not known.
        timed: Whether that was measured.
        rests: Travel before and after the motion, mm.
        points: Times and travels of the points of speeds.
    """

    phase: str
    time: np.ndarray
    travel: np.ndarray
    moves: tuple[float, float]
    switching: tuple[float, float]
    timed: bool
    rests: tuple[float, float]
    points: list[tuple[float, float]]


class Panel(NamedTuple):
    """One motion of all channels, and these over a good record, if there is one."""

    title: str
    motion: str
    curves: list[Marked]
    overlays: list[Overlay]


def panel_of(answers: Sequence[Answer], overlays: Iterable[Overlay], title: str) -> Panel:
    """Return the panel of one motion of an operation.

    Args:
        answers: Of its channels.
        overlays: Of all motions.
    """
    operation, motion = answers[0].record.operation, answers[0].record.motion
    key = str(operation.file), operation.number, motion
    own = [each for each in overlays if (each.file, each.operation, each.motion) == key]
    return Panel(title, motion, [_marked(answer) for answer in answers], own)


def _marked(answer: Answer) -> Marked:
    """The curve of a record, and its marks."""
    record, raw = answer.record, answer.record.raw
    time, left = raw.time[raw.inside], raw.left
    switching, timed = raw.contact.time, record.timed
    if not timed and answer.draws is not None:
        switching = record.tenth + float(np.median(answer.draws.switching[record.motion]))
    known = np.isfinite(left)

    def place(at: float) -> tuple[float, float]:
        return at, float(np.interp(at, time[known], left[known])) if np.isfinite(at) else np.nan

    sign = 1.0 if record.motion == "closing" else -1.0
    way = np.where(known, sign * (left - raw.segment.before), -np.inf)
    level = sign * (place(switching)[1] - raw.segment.before)

    def point(each: Point) -> float:
        """Time of a point of a speed."""
        if each.unit == "ms":
            return switching + each.amount + each.later
        stroke = raw.segment.stroke
        goal = each.amount / 100.0 * stroke if each.unit == "%" else level + each.amount
        if each.rest:
            goal = each.amount if each.amount > 0.0 else stroke + each.amount
        passed = (way >= goal) & (time >= raw.moves)
        return float(time[passed.argmax()]) + each.later if passed.any() else np.nan

    shown = [each for each in answer.speeds if each.motion == record.motion]
    shown = [each for each in shown if not answer.measured[each.name].reason]
    ends = [each for speed in shown for each in (speed.start, speed.end)]
    times = [point(each) for each in ends if not each.of_event or each.amount or each.later]
    span = raw.moves - _BEFORE * record.shape.duration, raw.moves + _AFTER * record.shape.duration
    near = (time >= span[0]) & (time <= span[1])
    return Marked(
        record.operation.phase,
        time[near],
        left[near],
        place(raw.moves),
        place(switching),
        timed,
        (raw.segment.before, raw.segment.after),
        [place(at) for at in times if np.isfinite(at)],
    )
