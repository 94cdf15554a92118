"""Which part of a record is the motion asked for.

A record may hold a closing and an opening, or more, and go on for seconds: see ``course``.
"""

from dataclasses import dataclass

import numpy as np

from breaker.records.course import Course
from breaker.records.errors import UnusableError

__all__ = ["Segment", "find_segment"]

_FEWEST = 20  # samples of a record
_SLOW = 2 / 3  # of the greatest speed: below, touch or damper act, and the force has been seen


@dataclass(frozen=True)
class Segment:
    """The part of a record that belongs to one motion.

    Attributes:
        begin: First sample: that of the record, or the first after an earlier motion.
        end: The sample after the last: the end of the record, or before the travel goes back.
        before: Median travel at rest before the motion, mm.
        after: Median travel after the motion, mm; of a drive that does not arrive, the farthest.
        arrived: Whether the drive comes to rest before the end.
        back: About when the travel goes back, ms; nan if it does not.
    """

    begin: int
    end: int
    before: float
    after: float
    arrived: bool
    back: float

    @property
    def stroke(self) -> float:
        """Way between the rest positions, mm."""
        return abs(self.after - self.before)


def find_segment(
    time: np.ndarray,
    travel: np.ndarray,
    motion: str,
    *,
    begin: float = float("nan"),
    end: float = float("nan"),
) -> Segment:
    """Return where in a record the motion asked for is.

    Args:
        time: Times of a record, ``(t,)``, ms, evenly spaced.
        travel: Travel towards closed, ``(t,)``, mm; NaN where a sample is missing.
        motion: "closing" or "opening".
        begin, end: Part of the record to look in, ms; nan for its beginning and end.

    Raises:
        UnusableError: If nothing moves, the motion is not in the record or more than once, or the
            record ends before the drive slows down. One that ends later is enough: the forces that
            drive it have been seen up to the touch or the damper.
    """
    first = 0 if np.isnan(begin) else int(np.searchsorted(time, begin))
    last = len(time) if np.isnan(end) else int(np.searchsorted(time, end, side="right"))
    time, sign = time[first:last], 1.0 if motion == "closing" else -1.0
    if (count := int((~np.isnan(travel[first:last])).sum())) < _FEWEST:
        raise UnusableError(f"only {count} samples of travel in the part to look in")
    course = Course(time[1] - time[0], sign * travel[first:last])
    if not course.moves:
        raise UnusableError(
            f"nothing moves: the travel ranges over {np.ptp(course.smooth):.3g} mm, with noise of "
            f"{course.noise:.2g} mm; is it the right column?"
        )
    forward = course.crossings[2]
    if forward.sum() != 1:
        smooth = sign * course.smooth
        raise UnusableError(_none_or_several(time[course.middles], forward, smooth, motion))
    found = course.motion(int(forward.argmax()))
    if found.speed > _SLOW:
        moving = f"{time[-1]:.1f} ms and {found.speed:.0%} of the greatest speed"
        raise UnusableError(f"ends in the middle of the {motion}, at {moving}; record longer")
    return Segment(
        begin=first + found.begin,
        end=first + found.end,
        before=sign * found.before,
        after=sign * found.after,
        arrived=found.arrived,
        back=float(time[found.end]) if found.end < time.size else float("nan"),
    )


def _none_or_several(at: np.ndarray, forward: np.ndarray, travel: np.ndarray, motion: str) -> str:
    """Why a motion is refused that is not in the record, or more than once."""
    if not forward.any():
        return (
            f"the travel goes from {travel[0]:.1f} to {travel[-1]:.1f} mm, which is no {motion}; "
            "is it in the wrong folder, or endurance.format.sign wrong?"
        )
    times = ", ".join(f"{each:.0f}" for each in at[forward])
    return (
        f"has {forward.sum()} motions of {motion}, at {times} ms; say which one is meant by from "
        "and to in operations.csv"
    )
