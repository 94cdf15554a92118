"""Records of a life as coordinates: independent, in units of the drive's own scatter.

The change of a record from the mean of the new ones has a component in each direction in which
drives of the family change. The coordinates are the directions in which both the covariance of the
family's changes and that of the drive's own operations are diagonal, the largest ratio first.
A measured quantity adds one coordinate, its change in units of its scatter. Changes are sought in
it only if the curve says nothing of it, so nothing counts twice.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Self

import numpy as np

from breaker.family.inputs import SCATTER_DIRECTIONS, Basis, shrunk_variance, without_onset
from breaker.model.quantities import CURRENTS, SHARES
from breaker.prognosis.series import Series
from breaker.prognosis.trend import Block

_COMPONENTS = 24
_USUAL = 0.1  # scatter that is usual of drives, in changes of the family,
_KNOWN = 20  # and how well it is known, as from so many records more
_MOVES = 30.0  # what wear may do to a measured quantity, in its scatter
# Of which the curve says nothing.
_APART = {
    *("reaction_time", "touch_time", "separation_time", *SHARES),
    *("closing_time", "opening_time", "main_closing_time", "main_opening_time", "bounce_time"),
    *CURRENTS,
}
_SCATTERS = 0.005  # share by which what is measured of operations usually scatters
# A transducer that is mounted again reads another linearity, a share of the stroke, with waves of
# half the stroke. Readings of one inspection share as much, by the temperature of the day, too.
_MOUNTED, _LENGTH = 0.0035, 0.5


class LifeCurve(NamedTuple):
    """Coordinates of one motion.

    Attributes:
        mean: The mean of the new records, way over stroke, ``(g,)``.
        noise: Noise of that mean, as a network of changes is told it.
        basis: Components of the family's changes.
        forward, back: From components to coordinates and back, ``(k, k)`` each.
        variance: Of the family's changes, ``(k,)``.
    """

    mean: np.ndarray
    noise: float
    basis: np.ndarray
    forward: np.ndarray
    back: np.ndarray
    variance: np.ndarray

    @classmethod
    def of(
        cls, way: np.ndarray, present: np.ndarray, noise: float, basis: Basis, new: np.ndarray
    ) -> Self:
        """Return the coordinates of a drive.

        Args:
            way, present: Records of the motion, ``(o, g)``.
            noise: Of a record, share of the stroke.
            basis: Of the family's changes.
            new: Which records are new, indices ``(n,)``.
        """
        count = present[new].sum(axis=0)
        sums = (way[new] * present[new]).sum(axis=0)
        mean = np.where(count > 0, sums / np.maximum(count, 1), way[new].mean(axis=0))
        family, directions = basis.variances[:_COMPONENTS], basis.directions[:_COMPONENTS]
        changes = _changes(mean, way[new], present[new], directions)
        apart, usual = np.diff(changes, axis=0) / np.sqrt(2.0), noise**2 + _USUAL**2 * family
        scatter = shrunk_variance(apart.T @ apart, len(apart), np.diag(usual), _KNOWN)
        # Inflated, as its directions are themselves estimated.
        total = len(apart) + _KNOWN
        scatter *= total / max(total - 1.0 - min(len(apart), len(family)), 1.0)
        # After this map the scatter is 1, and the family diagonal.
        root = np.linalg.inv(np.linalg.cholesky(scatter))
        variance, turned = np.linalg.eigh(root @ np.diag(family) @ root.T)
        forward = (root.T @ turned)[:, ::-1]
        found = cls(mean, 0.0, directions, forward, np.linalg.inv(forward), variance[::-1])
        return found._replace(noise=float(found.input_noise(np.ones(len(family)) / len(new))))

    def project(self, way: np.ndarray, present: np.ndarray) -> np.ndarray:
        """Return coordinates of records, ``(o, g) -> (o, k)``; nan without a sample."""
        changes = _changes(self.mean, way, present, self.basis)
        # One by one, as a product of many rows rounds each by how many they are.
        seen = (changes[:, None] @ self.forward)[:, 0]
        return np.where(present.any(axis=1)[:, None], seen, np.nan)

    def change(self, coordinates: np.ndarray) -> np.ndarray:
        """Return changes of the curve, ``(..., k) -> (..., g)``, way over stroke."""
        return coordinates @ self.back @ self.basis

    def shared(self) -> np.ndarray:
        """Return the variance of the error that all records of an inspection share, ``(k,)``.

        A transducer mounted again reads a smooth function of the travel, with Fourier components.
        """
        place = self.mean[None, :] / _LENGTH
        waves = np.concatenate([wave(k * place) for k in (1.0, 2.0) for wave in (np.sin, np.cos)])
        ways = self.mean + _MOUNTED * waves / np.sqrt(2.0)
        return np.square(self.project(ways, np.ones(ways.shape, dtype=bool))).sum(axis=0)

    def input_noise(self, variance: np.ndarray) -> np.ndarray:
        """Return the noise that a network is told of coordinates' variances, ``(..., k)``."""
        shares = np.square(self.back[:, :SCATTER_DIRECTIONS])
        return np.sqrt((variance @ shares).mean(axis=-1))


class CoordinateReading(NamedTuple):
    """A measured quantity as a coordinate.

    Attributes:
        motion, name: What it is.
        mean: While the drive was new, in its unit.
        scatter: In its unit.
        common: Standard deviation of the error that all readings share, in its unit: what is
            usually stated with the new ones.
    """

    motion: str
    name: str
    mean: float
    scatter: float
    common: float


class Coordinates(NamedTuple):
    """Coordinates of a drive, side by side: of its curves, then of what is measured.

    Attributes:
        curves: By motion.
        readings: Of the measured quantities that are followed.
    """

    curves: Mapping[str, LifeCurve]
    readings: Sequence[CoordinateReading]

    @classmethod
    def of(cls, series: Series, bases: Mapping[str, Basis]) -> Self:
        """Return the coordinates of a drive, by the new records of its series; none of a quantity
        that these do not show.
        """
        curves, readings = {}, []
        for motion, each in series.motions.items():
            new = series.new[each.there[series.new]]
            noise = float(np.median(each.noise[new]))
            curves[motion] = LifeCurve.of(each.way, each.present, noise, bases[motion], new)
            for name, values in each.measured.items():
                if (shown := new[np.isfinite(values[new])]).size:
                    # They scatter as is usual and stated, as far as few do not tell.
                    mean, common = values[shown].mean(), float(np.median(each.stated[name][shown]))
                    apart, usual = np.diff(values[shown]), np.hypot(common, _SCATTERS * mean)
                    squares = float(apart @ apart) / 2.0
                    scatter = shrunk_variance(squares, apart.size, usual**2 + 1e-12, _KNOWN) ** 0.5
                    readings.append(CoordinateReading(motion, name, mean, scatter, common))
        return cls(curves, tuple(readings))

    @property
    def sizes(self) -> list[int]:
        """How many coordinates the curve of each motion has."""
        return [curve.variance.size for curve in self.curves.values()]

    def blocks(self, series: Series) -> list[Block]:
        """Return what is followed: records, or means of inspections."""
        found = []
        for motion, curve in self.curves.items():
            seen = curve.project(series.motions[motion].way, series.motions[motion].present)
            found.append((seen, curve.variance, curve.shared(), True))
        for each in self.readings:
            values = series.motions[each.motion].measured[each.name]
            seen, shared = (values - each.mean) / each.scatter, _MOUNTED * each.mean / each.scatter
            about = seen[:, None], np.array([_MOVES**2]), np.array([shared**2])
            found.append((*about, each.name in _APART))
        blocks = []
        for values, variance, shared, sought in found:
            means, count = series.gathered(values)
            noise = 1.0 / count + shared * (series.inspections is not None)
            blocks.append(Block(means, variance, noise, sought))
        return blocks

    def places(self, motion: str) -> slice:
        """Where the coordinates of a motion's curve stand."""
        k = list(self.curves).index(motion)
        return slice(sum(self.sizes[:k]), sum(self.sizes[: k + 1]))

    def reading(self, motion: str, name: str) -> tuple[CoordinateReading, int] | None:
        """Return a quantity, and where its coordinate stands; None where it is not followed."""
        for k, each in enumerate(self.readings):
            if (each.motion, each.name) == (motion, name):
                return each, sum(self.sizes) + k
        return None


def _changes(mean: np.ndarray, way: np.ndarray, present: np.ndarray, directions: np.ndarray):
    """Components of the changes of records from a mean, ``(o, k)``."""
    there = present & np.isfinite(way)
    change = without_onset(np.broadcast_to(mean, way.shape), np.where(there, way, 0.0), there)
    return (change[:, None] @ directions.T)[:, 0]
