"""Means of records as networks see them: some operations of a drive in one condition, or hundreds.

Records are normalised in common units, each by its own time and zero, and averaged. Operations
scatter by more than the sensor's noise. That scatter is noise of their means, measured in the
shapes in which drives of the family change; of few records, beside what is usual of drives.
"""

from collections.abc import Sequence
from typing import NamedTuple, TypeVar

import numpy as np

from breaker.family.inputs import Basis, NormalisedRecords, normalise_record, without_onset
from breaker.family.shape import Shape, median_units
from breaker.records.record import Record

SCATTER_DIRECTIONS = 8
"""First components of changes, in which scatter is measured, as noise."""

# Of operations whose parameters scatter by 0.4 %, as noise over the stroke, and how well that is
# known, as from so many records more than one.
_USUAL, _KNOWN = 0.005, 4


V = TypeVar("V", float, np.ndarray)


def beside_usual(squares: V, seen: float, usual: V, known: float) -> V:
    """Return a variance, or a covariance, of what is seen beside what is usual.

    Args:
        squares: Sum of the squares, or products, of what is seen.
        seen, known: Degrees of freedom of what is seen, and of what is usual.
    """
    return (squares + known * usual) / (seen + known)


class Mean(NamedTuple):
    """Mean of records of one motion.

    Attributes:
        units: A shape with the stroke and duration in which it is given.
        seen: The mean, one record, physical units; its noise is that of the sensor alone.
        left: What each record leaves of it, without onset and zero, ``(n, g)``; 0 of a single one.
    """

    units: Shape
    seen: NormalisedRecords
    left: np.ndarray

    def scatter(self, basis: Basis) -> np.ndarray:
        """Return how far each record is from the others, as noise, ``(n,)``; none of one alone."""
        n = len(self.left)
        scores = self.left @ basis.directions[:SCATTER_DIRECTIONS].T
        return np.sqrt(np.square(scores).mean(axis=1) * n / (n - 1.0)) if n > 1 else np.empty(0)


def mean_record(raws: Sequence[Record], like: Shape | None = None) -> Mean:
    """Normalise records of one motion and average them.

    A step of the grid is there where half of the records have samples, whose mean it is.

    Args:
        like: A shape in whose units they are given; the medians of their own if None.

    Raises:
        ValueError: If a record has no motion from one rest to another.
    """
    middle = median_units([normalise_record(raw)[0] for raw in raws])
    units = like or middle
    seen, n = [normalise_record(raw, units)[1] for raw in raws], len(raws)
    way, present = (
        np.concatenate([getattr(each, of) for each in seen]) for of in ("way", "present")
    )
    count = present.sum(axis=0)
    there = 2 * count >= n
    mean = np.where(there, (way * present).sum(axis=0) / np.maximum(count, 1), way.mean(axis=0))
    swing = np.mean([raw.ripple**2 for raw in raws]) / units.stroke**2  # in step in all of them
    noise = np.sqrt((np.mean([each.noise**2 for each in seen]) + (n - 1) * swing) / n)
    colour, step = (np.mean([getattr(each, of) for each in seen]) for of in ("colour", "step"))
    own = middle.stroke, middle.duration
    numbers = (np.array([each]) for each in (*own, noise, colour, step))
    whole = NormalisedRecords(np.array([True]), mean[None], there[None], *numbers)
    both = present & there
    return Mean(units, whole, without_onset(np.tile(mean, (n, 1)), way, both))


def mean_with_scatter(raws: Sequence[Record], basis: Basis) -> Mean:
    """Return the mean of records of one motion, whose noise has the scatter of operations.

    Raises:
        ValueError: If a record has no motion from one rest to another.
    """
    mean = mean_record(raws)
    noise = _noise_of(mean, len(raws), mean.scatter(basis), len(raws) - 1)
    return mean._replace(seen=mean.seen._replace(noise=noise))


def more_scattered(means: Sequence[Mean], usual: float) -> float:
    """Return by what factor the variance of operations exceeds a usual one, at least 1.

    Args:
        means: Of several visits.
        usual: Variance of a record over the stroke, the sum over the grid.
    """
    seen = sum(len(each.left) - 1 for each in means)
    squares = sum(float(np.square(each.left).sum()) for each in means)
    known = np.mean([len(e.left) * e.seen.noise[0] ** 2 * e.left.shape[1] for e in means])
    return max(float(beside_usual(squares - seen * known, seen, usual, _KNOWN)) / usual, 1.0)


def _noise_of(mean: Mean, count: int, apart: np.ndarray, seen: int) -> np.ndarray:
    """Noise of a mean of records, ``(1,)``: the sensor's, or the operations' scatter if larger."""
    single = np.square(mean.seen.noise) * count
    found = np.square(np.median(apart)) if seen else 0.0
    scattered = beside_usual(seen * found, seen, single + _USUAL**2, _KNOWN)
    return np.sqrt(np.maximum(single, scattered) / count)


def mean_and_change(
    before: Sequence[Record], today: Sequence[Record], basis: Basis
) -> tuple[NormalisedRecords, NormalisedRecords]:
    """Return the mean of a reference, and the change from it, as ``ChangeNetwork.draw`` takes them,
    whose noise has the scatter of operations of both visits.
    """
    first = mean_record(before)
    second = mean_record(today, first.units)
    apart = np.concatenate([each.scatter(basis) for each in (first, second)])
    seen = len(before) + len(today) - 2
    noise = [
        _noise_of(each, len(raws), apart, seen) for each, raws in ((first, before), (second, today))
    ]
    there = first.seen.present & second.seen.present
    way = without_onset(first.seen.way, second.seen.way, there)
    change = second.seen._replace(way=way, present=there, noise=np.hypot(*noise))
    return first.seen._replace(noise=noise[0]), change
