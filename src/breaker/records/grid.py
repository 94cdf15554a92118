"""A record on the model's grid of time, around its first motion.

Where the record's step divides the grid's, the grid takes whole samples. At any other rate, a time
of the grid takes the nearest sample, moved to that time by the cubic through four samples, which
never makes white noise larger. No sample serves two times of the grid. High rates are not averaged,
for that would change the noise unnoticed.
"""

from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.records.rejections import Remark, UnusableError

_ON = 1e-3  # samples, by which a place, or a step of the grid, may be off whole ones
_FEWEST = 16  # samples of a motion, which is two for each parameter


class Grid(NamedTuple):
    """The model's grid, and the errors that the model takes for granted on it.

    Attributes:
        times: Times, ``(t,)``, ms around the first motion.
        noise_sd, zero_sd, onset_sd: Standard deviations of the noise and the zero, mm, and of the
            first motion, ms; a record whose own is another has a remark. None compares nothing.
    """

    times: np.ndarray
    noise_sd: float | None = None
    zero_sd: float | None = None
    onset_sd: float | None = None


class Gridded(NamedTuple):
    """A record on the grid: travel, ``(t,)``, mm, NaN where a sample is missing; its time that is 0
    on the grid, ms; for which times its rate gives a sample, ``(t,)`` of bool; and the longest time
    by which a sample is moved, ms, 0 where all are whole.
    """

    travel: np.ndarray
    start: float
    sampled: np.ndarray
    moved: float


def on_grid(time: np.ndarray, travel: np.ndarray, times: np.ndarray, moves: float) -> Gridded:
    """Put a record on the grid; samples before it begins and after it ends are missing.

    Args:
        time, travel: Times, ``(n,)``, ms, evenly spaced; travel, mm, NaN where one is missing.
        times: The model's grid, ``(t,)``, ms around the first motion.
        moves: Time of the first motion, ms.
    """
    step = float(time[-1] - time[0]) / (len(time) - 1)
    every = float(times[1] - times[0]) / step
    first = round((moves + times[0] - time[0]) / step)
    start = float(time[first] if 0 <= first < len(time) else time[0] + first * step)
    start -= float(times[0])
    if every > 0.5 and abs(every - round(every)) <= _ON:
        every = round(every)
    place = first + every * np.arange(len(times))
    nearest = np.rint(place)
    place = np.where(np.abs(place - nearest) < _ON, nearest, place)
    # Of the times that have the same nearest sample, the one that is nearest to it has it.
    sampled = np.abs(place - nearest) <= 0.5 * min(every, 1.0) + _ON
    sampled[1:] &= ~(sampled[:-1] & (nearest[1:] == nearest[:-1]))
    record = np.full(len(times), np.nan)
    record[sampled] = _cubic(travel, place[sampled])
    return Gridded(record, start, sampled, float(np.abs(place - nearest)[sampled].max() * step))


def _cubic(travel: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Values of the cubic through the four samples about each place; NaN where one is missing."""
    before = np.floor(place).astype(int)
    x = (place - before)[:, None]
    nodes = np.arange(-1, 3)
    others = np.array([nodes[nodes != node] for node in nodes])  # (4, 3)
    weights = np.prod((x[:, :, None] - others) / (nodes[:, None] - others), axis=2)
    indices = before[:, None] + nodes
    there = (indices >= 0) & (indices < len(travel))
    samples = np.where(there, travel[np.where(there, indices, 0)], np.nan)
    # A weight of 0 needs no sample; any other makes NaN of NaN.
    return np.where(weights == 0.0, 0.0, weights * samples).sum(axis=1)


def check_missing(gridded: Gridded, allowed: float) -> None:
    """Raise UnusableError where more samples are missing than a share of those of the rate."""
    count = int(gridded.sampled.sum())
    if count < min(_FEWEST, gridded.sampled.size):
        raise UnusableError(
            f"only {count} of the {gridded.sampled.size} times of the model's grid have a sample: "
            "check the rate, size.times and the section sensor"
        )
    missing = int(np.isnan(gridded.travel[gridded.sampled]).sum())
    if missing > allowed * count:
        raise UnusableError(
            f"{missing} of the {count} samples of the model's grid are missing, more than the "
            f"share of {allowed:g} that endurance.format.missing allows"
        )


def grid_remarks(gridded: Gridded, time: np.ndarray, times: np.ndarray) -> list[str]:
    """Return remarks where a record does not cover the grid, ``times``, or its rate does not fit;
    ``time`` are those of the record's part, ``(n,)``, ms.
    """
    step = float(time[-1] - time[0]) / (len(time) - 1)
    late = time[0] - gridded.start - times[0]
    early = gridded.start + times[-1] - time[-1]
    remarks = [Remark("begins-late", late=f"{late:.1f}")] if late > step else []
    if early > step:
        remarks.append(Remark("ends-early", early=f"{early:.1f}", at=f"{time[-1]:.1f}"))
    if gridded.moved > 0.0 or not gridded.sampled.all():
        none, moved = int((~gridded.sampled).sum()), in_digits(gridded.moved, 2)
        remarks.append(Remark("rate-moved", step=in_digits(step, 4), moved=moved, none=none))
    return remarks
