"""Inputs of a family's networks: the shape of each record in a few components, and its scales.

Each principal component is divided by the root of its variance and of the noise's, so that it is of
order 1 whatever the noise. Beside them stand which parts of the record are there, its noise, colour
and rate, and where the size of the drive is given, stroke and duration.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Self, TypeVar

import numpy as np

from breaker.family.shape import (
    SHAPE_STEP,
    SHAPE_TIMES,
    Shape,
    effective_noise,
    median_units,
    shape_of,
)
from breaker.model.parameters import MOTIONS
from breaker.records.record import Record

_PARTS = 12  # of the grid, of each of which the share that is there is told
_RIDGE = 1e-9
_FARTHEST = 8.0  # sd of a component, beyond which it counts as that
_USUAL_NOISE, _USUAL_STEP = np.log(4e-3), np.log(0.05)  # in the middle of what is drawn


class NormalisedRecords(NamedTuple):
    """Records of one motion, as networks see them.

    Attributes:
        there: Whether there is a record, ``(n,)`` of bool; what it lacks may be any number.
        way: Normalised shapes, ``(n, g)``.
        present: Where there are samples, ``(n, g)`` of bool.
        stroke: mm, ``(n,)``.
        duration: From 10 to 50 % of the way, ms, ``(n,)``.
        noise: Standard deviation over the stroke, after the average over a step of the grid.
        colour: Correlation of neighbouring samples.
        step: Between samples, in durations.
    """

    there: np.ndarray
    way: np.ndarray
    present: np.ndarray
    stroke: np.ndarray
    duration: np.ndarray
    noise: np.ndarray
    colour: np.ndarray
    step: np.ndarray

    @classmethod
    def nothing(cls, n: int) -> Self:
        """Return n records that are not there."""
        one = np.ones(n)
        shape = np.zeros((n, SHAPE_TIMES.size))
        return cls(one == 0.0, shape, shape > 0.0, one, one, one, 0.0 * one, one)


class Basis(NamedTuple):
    """Principal components of shapes, or of their changes.

    Attributes:
        mean: ``(g,)``.
        directions: Orthonormal, ``(k, g)``.
        variances: Of the components, ``(k,)``.
    """

    mean: np.ndarray
    directions: np.ndarray
    variances: np.ndarray

    @classmethod
    def of(cls, shapes: np.ndarray, count: int) -> Self:
        """Return the basis of shapes ``(n, g)`` without noise."""
        mean = shapes.mean(axis=0)
        _, sizes, directions = np.linalg.svd(shapes - mean, full_matrices=False)
        return cls(mean, directions[:count], np.square(sizes[:count]) / len(shapes))

    def amplitudes(self, shapes: np.ndarray) -> np.ndarray:
        """Return components of shapes ``(n, g)``, ``(n, k)``."""
        return (shapes - self.mean) @ self.directions.T

    def scores(self, shapes: np.ndarray, noise: np.ndarray) -> np.ndarray:
        """Return components of shapes ``(n, g)`` with noise ``(n,)``, each of order 1."""
        scaled = self.amplitudes(shapes) / np.sqrt(self.variances + np.square(noise)[:, None])
        return np.clip(scaled, -_FARTHEST, _FARTHEST)


def state_inputs(
    records: Mapping[str, NormalisedRecords],
    told: np.ndarray,
    bases: Mapping[str, Basis],
    usual: Sequence,
) -> np.ndarray:
    """Return what a network of levels sees, ``(n, i)`` of float32.

    Args:
        records: Of each motion; stroke and duration in the units of a drive of size 1.
        told: Whether the size of the drive is given, ``(n,)`` of bool.
        bases: Of each motion.
        usual: Mean and sd of the logarithms of stroke and duration in the family, ``(2, 2)``.
    """
    (stroke, stroke_sd), (duration, duration_sd) = usual
    one, time = units_of(records)
    columns = [
        *(records[motion].there for motion in MOTIONS),
        told,
        told * (np.log(one) - stroke) / stroke_sd,
        told * (np.log(time) - duration) / duration_sd,
        *_between(records, usual),
    ]
    for motion, seen in records.items():
        columns += [seen.there * each for each in _about(seen)]
        parts = [_shares(seen.present), bases[motion].scores(seen.way, seen.noise)]
        columns += [*(seen.there[:, None] * np.hstack(parts)).T]
    return np.column_stack(columns).astype(np.float32)


def units_of(records: Mapping[str, NormalisedRecords]) -> tuple[np.ndarray, np.ndarray]:
    """Return stroke and duration of the first motion that is there, ``(n,)`` each."""
    first, second = (records[motion] for motion in MOTIONS)
    return (
        np.where(first.there, first.stroke, second.stroke),
        np.where(first.there, first.duration, second.duration),
    )


def change_inputs(
    records: Mapping[str, NormalisedRecords],
    changes: Mapping[str, NormalisedRecords],
    bases: Mapping[str, Basis],
    change_bases: Mapping[str, Basis],
    usual: Sequence,
) -> np.ndarray:
    """Return what a network of changes sees, ``(n, i)`` of float32.

    Args:
        records: Reference of each motion, such as a mean of records of the drive as new.
        changes: What ``without_onset`` leaves of the difference to it, and its noise.
        bases, change_bases: Components of both.
        usual: As of ``state_inputs``.
    """
    columns = [*(records[motion].there for motion in MOTIONS), *_between(records, usual)]
    for motion, seen in records.items():
        change = changes[motion]
        columns += [seen.there * each for each in (_about(seen)[0], _about(change)[0])]
        scores = change_bases[motion].scores(change.way, change.noise)
        size = np.arcsinh(change_bases[motion].amplitudes(change.way) / change.noise[:, None])
        parts = [_shares(change.present), bases[motion].scores(seen.way, seen.noise), scores, size]
        columns += [*(seen.there[:, None] * np.hstack(parts)).T]
    return np.column_stack(columns).astype(np.float32)


def without_onset(reference: np.ndarray, present: np.ndarray, there: np.ndarray) -> np.ndarray:
    """Return a change without what a shift in time or of the zero would explain, ``(n, g)``.

    Args:
        reference, present: Shapes in the units of the reference, ``(n, g)``.
        there: Where both have samples, ``(n, g)`` of bool; the result is 0 elsewhere.
    """
    slope = np.gradient(reference, SHAPE_STEP, axis=1)
    rows = np.stack([np.ones_like(slope), slope], axis=1) * there[:, None]
    change = (present - reference) * there
    square = rows @ rows.swapaxes(1, 2) + _RIDGE * np.eye(2)  # regular without a sample, too
    amounts = np.linalg.solve(square, rows @ change[:, :, None])
    return change - (amounts.swapaxes(1, 2) @ rows)[:, 0]


def _between(
    records: Mapping[str, NormalisedRecords], usual: Sequence
) -> tuple[np.ndarray, np.ndarray]:
    """Logarithms of stroke and duration of opening over those of closing, 0 without both."""
    first, second = (records[motion] for motion in MOTIONS)
    (_, stroke_sd), (_, duration_sd) = usual
    both = first.there & second.there
    return (
        both * np.log(second.stroke / first.stroke) / stroke_sd,
        both * np.log(second.duration / first.duration) / duration_sd,
    )


def _shares(present: np.ndarray) -> np.ndarray:
    """Shares of the parts of the grid that are there, ``(n, g) -> (n, parts)``."""
    whole = present[:, : SHAPE_TIMES.size // _PARTS * _PARTS]
    return whole.reshape(len(whole), _PARTS, -1).mean(axis=2)


def _about(seen: NormalisedRecords) -> tuple[np.ndarray, ...]:
    """Noise, colour and rate of records, each of order 1."""
    noise = (np.log(seen.noise) - _USUAL_NOISE) / 2.0
    return noise, seen.colour, np.log(seen.step) - _USUAL_STEP


_LEAST_NOISE = 5e-5  # noise over the stroke, below which no network was trained
_REQUIRED = -0.4, 2.4  # durations after 10 % of the way, in which trained records have samples
_FINEST_STEP = 0.025  # durations between samples, below which none was: finer ones are averaged


def normalise_record(raw: Record, like: Shape | None = None) -> tuple[Shape, NormalisedRecords]:
    """Normalise a measured record: return its shape, and the same for networks, physical units.

    Args:
        like: Another record of the drive, in whose units this one is given; its own if None.

    Raises:
        ValueError: If the record has no motion from one rest to another, or does not show them.
    """
    forward = raw.left if raw.motion == "closing" else -raw.left
    shape = shape_of(forward, raw.step, like)
    known = np.flatnonzero(~np.isnan(forward))
    first, last = raw.step * known[0] - shape.origin, raw.step * known[-1] - shape.origin
    for late, seen in (
        (first > _REQUIRED[0] * shape.duration, f"begins {-first:.1f} ms before"),
        (last < _REQUIRED[1] * shape.duration, f"ends {last:.1f} ms after"),
    ):
        if late:
            raise ValueError(
                f"{seen} 10 % of the way, where the drive need not rest; record longer"
            )
    seen = network_record(shape, *raw.process, raw.step, like)
    swing = raw.ripple / (shape if like is None else like).stroke
    return shape, seen._replace(noise=np.hypot(seen.noise, swing))


def stored_shape(record: np.ndarray, step: float, like: Shape | None = None) -> Shape | None:
    """Normalise a record of a store; None if it shows no motion.

    Args:
        record: Travel towards the end of the motion, mm, ``(s,)``, padded with nan.
        step: Between samples, ms.
        like: As of ``normalise_record``.
    """
    there = np.flatnonzero(np.isfinite(record))
    try:
        return shape_of(record[: there[-1] + 1] if there.size else record, step, like)
    except ValueError:
        return None


def network_record(
    shape: Shape, sd: float, colour: float, step: float, like: Shape | None = None
) -> NormalisedRecords:
    """Return a normalised record as networks see it, one record, physical units.

    Args:
        sd, colour: Noise of a sample, mm, and the correlation of neighbouring ones.
        step: Between samples, ms.
        like: As of ``normalise_record``.
    """
    length, unit = (shape.stroke, shape.duration) if like is None else (like.stroke, like.duration)
    told = max(effective_noise(sd / length, colour, step / unit), _LEAST_NOISE)
    share = step / shape.duration
    if share < _FINEST_STEP:  # the same noise, as samples that far apart have it
        share, colour = _FINEST_STEP, colour ** (_FINEST_STEP / share)
    numbers = shape.stroke, shape.duration, told, colour, share
    there = np.array([True]), shape.way[None], shape.present[None]
    return NormalisedRecords(*there, *(np.array([each]) for each in numbers))


SCATTER_DIRECTIONS = 8
"""First components of changes, in which scatter is measured, as noise."""

# Of operations whose parameters scatter by 0.4 %, as noise over the stroke, and how well that is
# known, as from so many records more than one.
_USUAL_SCATTER, _KNOWN = 0.005, 4


V = TypeVar("V", float, np.ndarray)


def shrunk_variance(squares: V, seen: float, usual: V, known: float) -> V:
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
    return max(float(shrunk_variance(squares - seen * known, seen, usual, _KNOWN)) / usual, 1.0)


def _noise_of(mean: Mean, count: int, apart: np.ndarray, seen: int) -> np.ndarray:
    """Noise of a mean of records, ``(1,)``: the sensor's, or the operations' scatter if larger."""
    single = np.square(mean.seen.noise) * count
    found = np.square(np.median(apart)) if seen else 0.0
    scattered = shrunk_variance(seen * found, seen, single + _USUAL_SCATTER**2, _KNOWN)
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
