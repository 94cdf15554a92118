"""Records of a life as independent coordinates, in units of the drive's own scatter.

The change of a record from the mean of the new records has components in the directions in which
drives of the family change. Coordinates diagonalise both the covariance of the family's changes and
the covariance of the drive's own operations, the largest ratio first. Each measured quantity adds a
coordinate, its change. It is used to detect changes only if the curve does not show the quantity,
so that nothing counts twice.
"""

from collections.abc import Mapping
from typing import NamedTuple, Self

import numpy as np

from breaker.family import inputs
from breaker.model.quantities import CURRENTS, SHARES
from breaker.prognosis.series import MotionRecords, Series
from breaker.prognosis.trend import Block

_COMPONENTS = 24
_USUAL = 0.1  # usual scatter of a drive, as a share of the family's changes
_KNOWN = 20  # weight of the usual scatter, in records
_MOVES = 30.0  # prior sd of the change of a measured quantity, in its scatter
# Measured quantities that the curve does not show, which are used to detect changes.
_SOUGHT = {
    *("reaction_time", "touch_time", "separation_time", *SHARES),
    *("closing_time", "opening_time", "main_closing_time", "main_opening_time", "bounce_time"),
    *CURRENTS,
}
# A remounted transducer has another linearity error, a share of the stroke, with waves of half the
# stroke. The temperature of the day gives the readings of an inspection a common error as large.
_MOUNTED, _LENGTH = 0.0035, 0.5


class LifeCurve(NamedTuple):
    """Coordinates of one motion.

    Attributes:
        mean, noise: Mean of the new records, travel over stroke, ``(g,)``; its noise for a network.
        basis: Components of the family's changes.
        forward, back: Maps from components to coordinates and back, ``(k, k)`` each.
        variance: Variance of the family's changes, ``(k,)``.
    """

    mean: np.ndarray
    noise: float
    basis: np.ndarray
    forward: np.ndarray
    back: np.ndarray
    variance: np.ndarray

    @classmethod
    def of(cls, records: MotionRecords, new: np.ndarray, basis: inputs.Basis) -> Self:
        """Return the coordinates of a drive, from its new records and changes of the family."""
        way, present = records.way[new], records.present[new]
        noise, count = float(np.median(records.noise[new])), present.sum(axis=0)
        sums = (way * present).sum(axis=0)
        mean = np.where(count > 0, sums / np.maximum(count, 1), way.mean(axis=0))
        family, directions = basis.variances[:_COMPONENTS], basis.directions[:_COMPONENTS]
        steps = np.diff(_changes(mean, way, present, directions), axis=0) / np.sqrt(2.0)
        usual = noise**2 + _USUAL**2 * family
        scatter = inputs.shrunk_variance(steps.T @ steps, len(steps), np.diag(usual), _KNOWN)
        # Inflate the scatter, because its directions are themselves estimated.
        total = len(steps) + _KNOWN
        scatter *= total / max(total - 1.0 - min(len(steps), len(family)), 1.0)
        # After this map, the scatter is 1 and the covariance of the family is diagonal.
        root = np.linalg.inv(np.linalg.cholesky(scatter))
        variance, turned = np.linalg.eigh(root @ np.diag(family) @ root.T)
        forward = (root.T @ turned)[:, ::-1]
        coordinates = cls(mean, 0.0, directions, forward, np.linalg.inv(forward), variance[::-1])
        return coordinates._replace(
            noise=float(coordinates.input_noise(np.ones(len(family)) / len(new)))
        )

    def project(self, way: np.ndarray, present: np.ndarray) -> np.ndarray:
        """Return coordinates of records, ``(o, g) -> (o, k)``; nan without samples."""
        changes = _changes(self.mean, way, present, self.basis)
        # Row by row, because the rounding of a matrix product depends on the number of rows.
        seen = (changes[:, None] @ self.forward)[:, 0]
        return np.where(present.any(axis=1)[:, None], seen, np.nan)

    def shared(self) -> np.ndarray:
        """Return the variance of the common error of the records of an inspection, ``(k,)``: a
        remounted transducer reads a smooth function of the travel, a sum of Fourier components.
        """
        place = self.mean[None, :] / _LENGTH
        waves = np.concatenate([wave(k * place) for k in (1.0, 2.0) for wave in (np.sin, np.cos)])
        readings = self.mean + _MOUNTED * waves / np.sqrt(2.0)
        return np.square(self.project(readings, np.ones(readings.shape, dtype=bool))).sum(axis=0)

    def input_noise(self, variance: np.ndarray) -> np.ndarray:
        """Return the noise of a curve for a network, by variances of coordinates, ``(..., k)``."""
        shares = np.square(self.back[:, : inputs.SCATTER_DIRECTIONS])
        return np.sqrt((variance @ shares).mean(axis=-1))


class CoordinateReading(NamedTuple):
    """A measured quantity as a coordinate, in its unit.

    Attributes:
        mean, scatter: Mean and scatter of the new records.
        common: Standard deviation of the common error of all readings: the usual stated error.
    """

    mean: float
    scatter: float
    common: float


class Coordinates(NamedTuple):
    """Coordinates of a drive, side by side: of its curves, then of measured quantities.

    Attributes:
        curves: Coordinates of curves, by motion.
        readings: Coordinates of followed measured quantities, by motion and name.
    """

    curves: Mapping[str, LifeCurve]
    readings: Mapping[tuple[str, str], CoordinateReading]

    @classmethod
    def of(cls, series: Series, bases: Mapping[str, inputs.Basis]) -> Self:
        """Return the coordinates of a drive, from the new records of its series. A quantity that
        these records do not show has no coordinate.
        """
        curves, readings = {}, {}
        for motion, records in series.motions.items():
            new = series.new[records.there[series.new]]
            curves[motion] = LifeCurve.of(records, new, bases[motion])
            for name, values in records.measured.items():
                if (shown := new[np.isfinite(values[new])]).size:
                    # Few readings do not show their scatter: the usual and stated one counts too.
                    mean, steps = values[shown].mean(), np.diff(values[shown])
                    common = float(np.median(records.stated[name][shown]))
                    usual = np.hypot(common, inputs.USUAL_SCATTER * mean) ** 2 + 1e-12
                    squares = float(steps @ steps) / 2.0
                    scatter = inputs.shrunk_variance(squares, steps.size, usual, _KNOWN) ** 0.5
                    readings[motion, name] = CoordinateReading(mean, scatter, common)
        return cls(curves, readings)

    @property
    def places(self) -> dict[str | tuple[str, str], slice]:
        """Positions of the coordinates of each motion's curve, and of each measured quantity."""
        sizes = {motion: curve.variance.size for motion, curve in self.curves.items()}
        sizes |= dict.fromkeys(self.readings, 1)
        ends = np.cumsum([*sizes.values()]).tolist()
        return {key: slice(end - sizes[key], end) for key, end in zip(sizes, ends, strict=True)}

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return max(place.stop for place in self.places.values())

    def blocks(self, series: Series) -> list[Block]:
        """Return the coordinates to follow: of records, or of means of inspections."""
        blocks = []
        for motion, curve in self.curves.items():
            records = series.motions[motion]
            seen = curve.project(records.way, records.present)
            blocks.append(Block(seen, curve.variance, curve.shared()))
        for (motion, name), given in self.readings.items():
            seen = (series.motions[motion].measured[name][:, None] - given.mean) / given.scatter
            shared = np.square([_MOUNTED * given.mean / given.scatter])
            blocks.append(Block(seen, np.array([_MOVES**2]), shared, name in _SOUGHT))
        for k, block in enumerate(blocks):
            means, count = series.gathered(block.values)
            noise = 1.0 / count + block.noise * (series.inspections is not None)
            blocks[k] = block._replace(values=means, noise=noise)
        return blocks


def _changes(mean: np.ndarray, way: np.ndarray, present: np.ndarray, directions: np.ndarray):
    """Return components of the changes of records from a mean, ``(o, k)``."""
    there = present & np.isfinite(way)
    change = inputs.without_onset(
        np.broadcast_to(mean, way.shape), np.where(there, way, 0.0), there
    )
    return (change[:, None] @ directions.T)[:, 0]
