"""Inputs of the networks of a family: records of drives, and means of records.

Inputs are principal components of the shape, each divided by the root of its variance and of the
noise's; shares of samples in parts of the record; noise, colour and rate; and stroke and duration
if the size of the drive is known.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Self

import numpy as np

from breaker.family.shape import (
    SHAPE_STEP,
    SHAPE_TIMES,
    WINDOW,
    Shape,
    effective_noise,
    median_units,
    shape_of,
)
from breaker.model.parameters import MOTIONS
from breaker.records.record import Record

SCATTER_DIRECTIONS = 8  # first components of changes, in which scatter is measured, as noise
_PARTS = 12  # of the grid; the share of samples in each part is an input
_RIDGE = 1e-9  # keeps the fit of onset and zero regular without a sample
_FARTHEST = 8.0  # sds at which components are cut: no drive of a family is farther out
_MIDDLE = np.log([4e-3, 0.05])  # noise and step in the middle of their ranges in training
_LEAST_NOISE = 5e-5  # share of the stroke: no network was trained with less

# Scatter of operations whose parameters scatter by 0.4 %, as noise over the stroke or share of a
# measured quantity; and the degrees of freedom as which it counts.
USUAL_SCATTER, _KNOWN = 0.005, 4


class Sensors(NamedTuple):
    """Ranges of sensors, in strokes and durations; each training record has a sensor drawn from it.

    Attributes:
        noise: Noise of a sample, log-uniform; negligible by default.
        step: Time between samples, log-uniform. Finer samples are averaged for networks.
        quantum: Resolution of a rounded travel over the noise, log-uniform.
        begins, ends: Ends of the record after 10 % of the travel.
        entire, white, smooth, gapless: Shares of records with the latest end, white noise, no
            rounding, and no gap.
        colour: Largest correlation of neighbouring samples.
        gap: Time without samples.
        error: Sd of the logarithm of estimated noise, and of its estimated colour.
    """

    noise: tuple[float, float] = (1e-6, 1.1e-6)
    step: tuple[float, float] = (0.025, 0.15)
    quantum: tuple[float, float] = (0.1, 4.0)
    begins: tuple[float, float] = (WINDOW[0], -0.5)
    ends: tuple[float, float] = (2.5, WINDOW[1])
    entire: float = 0.5
    white: float = 0.6
    smooth: float = 0.5
    gapless: float = 0.9
    colour: float = 0.8
    gap: tuple[float, float] = (0.1, 1.5)
    error: float = 0.1


_SENSORS = Sensors()


class NormalisedRecords(NamedTuple):
    """Normalised records of one motion, from which inputs of networks are computed.

    Attributes:
        there: Whether there is a record, ``(n,)`` of bool; other numbers of an absent one are free.
        way, present: Normalised shapes, ``(n, g)``, and whether there are samples.
        stroke, duration: Stroke, mm, and time from 10 to 50 % of the travel, ms, ``(n,)``.
        noise: Standard deviation over the stroke, after the average over a step of the grid.
        colour: Correlation of neighbouring samples.
        step: Time between samples, in durations.
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
    def one(cls, way: np.ndarray, present: np.ndarray, *numbers: float) -> Self:
        """Return one record; ``numbers`` are ``stroke`` to ``step``."""
        return cls(*(np.array([value]) for value in (True, way, present, *numbers)))

    @classmethod
    def nothing(cls, n: int) -> Self:
        """Return n absent records."""
        shape, number = np.zeros((n, SHAPE_TIMES.size)), np.ones((5, n))
        number[3] = 0.0  # the colour
        return cls(number[3] > 0.0, shape, shape > 0.0, *number)


class Basis(NamedTuple):
    """Principal components of shapes, or of their changes: their mean ``(g,)``, orthonormal
    directions ``(k, g)`` and variances ``(k,)``.
    """

    mean: np.ndarray
    directions: np.ndarray
    variances: np.ndarray

    @classmethod
    def of(cls, shapes: np.ndarray, count: int) -> Self:
        """Return the first components of shapes ``(n, g)`` without noise."""
        mean = shapes.mean(axis=0)
        _, sizes, directions = np.linalg.svd(shapes - mean, full_matrices=False)
        return cls(mean, directions[:count], np.square(sizes[:count]) / len(shapes))

    def amplitudes(self, shapes: np.ndarray) -> np.ndarray:
        """Return components ``(n, k)`` of shapes ``(n, g)``."""
        return (shapes - self.mean) @ self.directions.T

    def scores(self, shapes: np.ndarray, noise: np.ndarray) -> np.ndarray:
        """Return components of shapes ``(n, g)`` with noise ``(n,)``, each of order 1."""
        scaled = self.amplitudes(shapes) / np.sqrt(self.variances + np.square(noise)[:, None])
        return np.clip(scaled, -_FARTHEST, _FARTHEST)


def state_inputs(
    records: Mapping[str, NormalisedRecords],
    known_size: np.ndarray,
    bases: Mapping[str, Basis],
    usual: Sequence,
) -> np.ndarray:
    """Return the inputs of a state network, ``(n, i)`` of float32.

    Args:
        records, bases: Records in units of a drive of size 1, and components, by motion.
        known_size: Whether the size of the drive is known, ``(n,)`` of bool.
        usual: Mean and sd of the logarithms of stroke and duration in the family, ``(2, 2)``.
    """
    records = _of_both_motions(records)
    sizes = zip(units_of(records), usual, strict=True)
    columns = [records[m].there for m in MOTIONS] + [known_size]
    columns += [known_size * (np.log(unit) - mean) / sd for unit, (mean, sd) in sizes]
    columns += _opening_over_closing(records, usual)
    for motion, seen in records.items():
        parts = [_order_one(seen.noise), seen.colour, np.log(seen.step) - _MIDDLE[1]]
        parts += [_shares(seen.present), bases[motion].scores(seen.way, seen.noise)]
        columns.append(seen.there[:, None] * np.column_stack(parts))
    return np.column_stack(columns).astype(np.float32)


def change_inputs(
    records: Mapping[str, NormalisedRecords],
    changes: Mapping[str, NormalisedRecords],
    bases: Mapping[str, Basis],
    change_bases: Mapping[str, Basis],
    usual: Sequence,
) -> np.ndarray:
    """Return the inputs of a change network, ``(n, i)`` of float32, from references, differences
    from these after ``without_onset``, components of both, and ``usual`` as of ``state_inputs``.
    """
    records, changes = _of_both_motions(records), _of_both_motions(changes)
    columns = [records[m].there for m in MOTIONS] + _opening_over_closing(records, usual)
    for motion, seen in records.items():
        change, basis = changes[motion], change_bases[motion]
        parts = [_order_one(seen.noise), _order_one(change.noise), _shares(change.present)]
        parts += [bases[motion].scores(seen.way, seen.noise)]
        parts += [basis.scores(change.way, change.noise)]
        parts += [np.arcsinh(basis.amplitudes(change.way) / change.noise[:, None])]
        columns.append(seen.there[:, None] * np.column_stack(parts))
    return np.column_stack(columns).astype(np.float32)


def _of_both_motions(records: Mapping[str, NormalisedRecords]) -> dict[str, NormalisedRecords]:
    nothing = NormalisedRecords.nothing(len(next(iter(records.values())).way))
    return {motion: records.get(motion, nothing) for motion in MOTIONS}


def units_of(records: Mapping[str, NormalisedRecords]) -> np.ndarray:
    """Return stroke and duration of the first recorded motion, ``(2, n)``."""
    first, second = (np.array([seen.stroke, seen.duration]) for seen in records.values())
    return np.where(records[MOTIONS[0]].there, first, second)


def _opening_over_closing(
    records: Mapping[str, NormalisedRecords], usual: Sequence
) -> list[np.ndarray]:
    """Return log ratios of stroke and duration, in sds of the family; 0 without both motions."""
    first, second = records.values()
    both = first.there & second.there
    ratios = second.stroke / first.stroke, second.duration / first.duration
    return [both * np.log(ratio) / sd for ratio, (_, sd) in zip(ratios, usual, strict=True)]


def _order_one(noise: np.ndarray) -> np.ndarray:
    return (np.log(noise) - _MIDDLE[0]) / 2.0


def _shares(present: np.ndarray) -> np.ndarray:
    """Return the share of samples in each part of the grid, ``(n, g) -> (n, parts)``."""
    even = present[:, : SHAPE_TIMES.size // _PARTS * _PARTS]
    return even.reshape(len(even), _PARTS, -1).mean(axis=2)


def without_onset(reference: np.ndarray, present: np.ndarray, there: np.ndarray) -> np.ndarray:
    """Return the change of shapes from references without the part that a shift of time or zero
    explains; all ``(n, g)``, in units of the references, and 0 where not ``there``.
    """
    slope = np.gradient(reference, SHAPE_STEP, axis=1)
    rows = np.stack([np.ones_like(slope), slope], axis=1) * there[:, None]
    change = (present - reference) * there
    square = rows @ rows.swapaxes(1, 2) + _RIDGE * np.eye(2)
    amounts = np.linalg.solve(square, rows @ change[:, :, None])
    return change - (amounts.swapaxes(1, 2) @ rows)[:, 0]


def normalise_record(raw: Record, like: Shape | None = None) -> tuple[Shape, NormalisedRecords]:
    """Normalise a measured record, in its own units or those of the shape ``like``; return its
    shape, and the record for networks, physical units.

    Raises:
        ValueError: If the record has no motion between rest positions, or does not show these.
    """
    forward = raw.left if raw.motion == "closing" else -raw.left
    if (shape := shape_of(forward, raw.step, like)) is None:
        raise ValueError("the record has no motion from one rest to another")
    known = np.flatnonzero(~np.isnan(forward))
    first, last = raw.step * known[0] - shape.origin, raw.step * known[-1] - shape.origin
    begins, ends = _SENSORS.begins[1] + SHAPE_STEP, _SENSORS.ends[0] - SHAPE_STEP
    if (late := first > begins * shape.duration) or last < ends * shape.duration:
        cut = f"begins {-first:.1f} ms before" if late else f"ends {last:.1f} ms after"
        raise ValueError(f"{cut} 10 % of the way, where the drive need not rest; record longer")
    seen = network_record(shape, *raw.process, raw.step, like)
    swing = raw.ripple / (like or shape).stroke
    return shape, seen._replace(noise=np.hypot(seen.noise, swing))


def network_record(
    shape: Shape, sd: float, colour: float, step: float, like: Shape | None = None
) -> NormalisedRecords:
    """Return a normalised record for networks, physical units; ``like`` is a shape with its units.

    Args:
        sd, colour: Noise of a sample, mm, and the correlation of neighbouring ones.
        step: Time between samples, ms.
    """
    units = like or shape
    noise = effective_noise(sd / units.stroke, colour, step / units.duration)
    share = step / shape.duration
    finest = _SENSORS.step[0]
    if share < finest:  # the same noise at the finest step in training
        share, colour = finest, colour ** (finest / share)
    numbers = shape.stroke, shape.duration, max(noise, _LEAST_NOISE), colour, share
    return NormalisedRecords.one(shape.way, shape.present, *numbers)


class Mean(NamedTuple):
    """Mean of records of one motion, normalised in common units, each with its own time and zero.

    Attributes:
        units: Shape whose stroke and duration are the units.
        seen: The mean, physical units; its noise is that of the sensor alone.
        left: Deviations of records from it, without onset and zero, ``(n, g)``; 0 for one record.
    """

    units: Shape
    seen: NormalisedRecords
    left: np.ndarray


def mean_record(raws: Sequence[Record], like: Shape | None = None) -> Mean:
    """Normalise records of one motion and average them, where half of them have samples, in units
    of ``like`` or of their own medians. Raise as ``normalise_record``.
    """
    middle = median_units([normalise_record(raw)[0] for raw in raws])
    units, n = like or middle, len(raws)
    records = [normalise_record(raw, units)[1] for raw in raws]
    seen = NormalisedRecords(*map(np.concatenate, zip(*records, strict=True)))
    count = seen.present.sum(axis=0)
    there, total = 2 * count >= n, (seen.way * seen.present).sum(axis=0)
    mean = np.where(there, total / np.maximum(count, 1), seen.way.mean(axis=0))
    swing = np.mean([raw.ripple**2 for raw in raws]) / units.stroke**2  # in phase in all records
    noise = np.sqrt((np.mean(seen.noise**2) + (n - 1) * swing) / n)
    numbers = middle.stroke, middle.duration, noise, np.mean(seen.colour), np.mean(seen.step)
    left = without_onset(np.tile(mean, (n, 1)), seen.way, seen.present & there)
    return Mean(units, NormalisedRecords.one(mean, there, *numbers), left)


def mean_and_change(
    first: Mean, second: Mean, basis: Basis
) -> tuple[NormalisedRecords, NormalisedRecords]:
    """Return a reference, and the change from it in its units, for ``ChangeNetwork.draw``. Their
    noise includes the scatter of operations of both means.
    """
    noise = _noise_of_means([first, second], basis)
    there = first.seen.present & second.seen.present
    way = without_onset(first.seen.way, second.seen.way, there)
    change = second.seen._replace(way=way, present=there, noise=np.hypot(*noise))
    return first.seen._replace(noise=noise[0]), change


def _noise_of_means(means: Sequence[Mean], basis: Basis) -> list[np.ndarray]:
    """Return the noise of each mean, ``(1,)``: that of the sensor, or the scatter of operations in
    directions in which drives of the family change, if larger; for few records the usual scatter.
    """
    scatter, seen = [], sum(len(mean.left) - 1 for mean in means)
    for left in (mean.left for mean in means if len(mean.left) > 1):
        scores, n = left @ basis.directions[:SCATTER_DIRECTIONS].T, len(left)
        scatter += np.sqrt(np.square(scores).mean(axis=1) * n / (n - 1.0)).tolist()
    square, noise = np.square(np.median(scatter)) if seen else 0.0, []
    for mean in means:
        single = np.square(mean.seen.noise) * len(mean.left)
        scattered = shrunk_variance(seen * square, seen, single + USUAL_SCATTER**2)
        noise.append(np.sqrt(np.maximum(single, scattered) / len(mean.left)))
    return noise


def shrunk_variance(squares, seen, usual, known=_KNOWN):
    """Return a variance or covariance, shrunk to the usual one: ``squares`` are sums of squares or
    products of observations; ``seen`` and ``known`` are degrees of freedom of these and the usual.
    """
    return (squares + known * usual) / (seen + known)
