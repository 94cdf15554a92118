"""What a transducer that was mounted again shows between two visits: slack, or another zero.

Slack hides the first way of a motion. Its start is seen late, so the way from there to 10 % takes
less time, in closing and opening alike, while the rest of either motion is as it was. More time
would be a force that builds up later as well as slack that is gone, and is left to the drive. Where
trigger and contact are known, one motion is enough: the start is as much later as the contact event
follows sooner on it. No wear of a drive does either.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from breaker.diagnosis.changes import QuantityChange
from breaker.diagnosis.estimate import SWITCHING, DriveRecord
from breaker.diagnosis.identity import Difference

_SDS = 4.0  # from which a start has changed, in each motion
_STAYS, _LITTLE = 2.0, 0.01  # sds and share, up to which the rest of the motion has not
_SCATTER = 0.03  # of the time to 10 % of the way, from operation to operation
_ZERO = 0.01  # of the stroke, from which a zero has moved, and noise of a sample by this:
_NOISES = 6.0


def slack_between(
    visits: Mapping[str, Sequence[DriveRecord]], rows: Sequence[QuantityChange]
) -> list[Difference]:
    """Return how the starts of motions differ as with another slack of the transducer.

    Args:
        visits: Usable records "before" and "today".
        rows: What ``measured_changes`` returns.

    Returns:
        As of ``stated_differences``; none where starts do not, or where the rest of a motion does,
        too.
    """
    starts = {m: _starts(visits, m) for m in dict.fromkeys(row.motion for row in rows)}
    by = {(row.name, row.motion): row for row in rows}
    apart = {
        m: (today[0] - before[0]) / np.hypot(before[1], today[1])
        for m, (before, today) in starts.items()
    }
    both = len(apart) > 1 and max(apart.values()) < -_SDS
    found = {m: both and _stays(by.get((f"{m}_speed_50_90", m))) for m in starts}
    found = found if all(found.values()) else {}
    found |= {m: True for m in starts if _shifted(by, m)}
    what = "time to 10 % of the way, as of another slack of the transducer,"
    return [
        Difference(what, "ms", motion, *(float(each[0]) for each in starts[motion]))
        for motion in found
    ]


def _starts(visits: Mapping[str, Sequence[DriveRecord]], motion: str) -> list[tuple[float, float]]:
    """Mean time from the first motion to 10 % of the way at each visit, and its sd, ms."""
    found = []
    for records in visits.values():
        own = [each for each in records if each.motion == motion]
        times = np.array([each.tenth - each.raw.moves for each in own])
        squares = [each.raw.first_motion_sd**2 for each in own]
        error = np.mean(squares) + (_SCATTER * times.mean()) ** 2
        scatter = times.var(ddof=1) if len(own) > 1 else 0.0
        found.append((float(times.mean()), float(np.sqrt(max(error, scatter) / len(own)))))
    return found


def _stays(row: QuantityChange | None) -> bool:
    """Whether a measured quantity has not changed."""
    return row is not None and abs(row.difference) < _STAYS * row.sd + _LITTLE * row.before


def _shifted(by: Mapping[tuple[str, str], QuantityChange], motion: str) -> bool:
    """Whether the first motion is seen later or earlier, and trigger to contact lasts as long."""
    names = "reaction_time", SWITCHING[motion], f"{motion}_time"
    latch, after, whole = (by.get((name, motion)) for name in names)
    if not (latch and after and whole):
        return False
    moved = abs(latch.difference) > _SDS * latch.sd
    opposite = abs(latch.difference + after.difference) < 0.5 * abs(latch.difference)
    return moved and opposite and _stays(whole)


def zero_between(visits: Mapping[str, Sequence[DriveRecord]]) -> str:
    """Say that the open breaker is read elsewhere, which is no change of the drive, or nothing."""
    zeros, noises, strokes = [], [], []
    for records in visits.values():
        own = [each.raw for each in records]
        ends = [e.segment.before if e.motion == "closing" else e.segment.after for e in own]
        zeros.append(float(np.median(ends)))
        noises += [each.noise_at(each.step).sd for each in own]
        strokes += [each.segment.stroke for each in own]
    moved = abs(zeros[1] - zeros[0])
    if not moved > _NOISES * np.median(noises) + _ZERO * np.median(strokes):
        return ""
    was, now = (f"{round(each, 1) + 0.0:.1f} mm" for each in zeros)  # no -0
    return (
        f"the open breaker was read at {was} and is at {now}: the transducer is mounted elsewhere, "
        "which is no change of the drive, and of ways, times and speeds none"
    )
