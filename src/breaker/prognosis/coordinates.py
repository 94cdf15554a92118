"""Records of a life as coordinates: independent, in units of the drive's own scatter.

The change of a record from the mean of the new ones has a component in each direction in which
drives of the family change. The coordinates are the directions in which both the covariance of the
family's changes and that of the drive's own operations are diagonal, the largest ratio first.
A measured quantity adds one coordinate: what the curve's coordinates do not explain of it, in units
of its scatter. So nothing counts twice, and a motion or a quantity may be missing.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Self

import numpy as np

from breaker.family.inputs import SCATTER_DIRECTIONS, Basis, shrunk_variance, without_onset
from breaker.model.quantities import CURRENTS, SHARES
from breaker.prognosis.series import Series
from breaker.prognosis.trend import Block

_COMPONENTS = 24
_ROWS = 1000  # records that are projected at once
_USUAL = 0.1  # scatter that is usual of drives, in changes of the family,
_KNOWN = 20  # and how well it is known, as from so many records more
_OUTLIER = 5.0  # times the median of squared distances
_EXPLAINS = 12  # coordinates of a curve that say something of what is measured
_RIDGE = 2.0
_MOVES = 30.0  # what wear may do to the rest of a measured quantity, in its scatter
# Of which the curve says nothing.
_APART = {
    *("reaction_time", "touch_time", "separation_time", *SHARES),
    *("closing_time", "opening_time", "main_closing_time", "main_opening_time", "bounce_time"),
    *CURRENTS,
}
_SCATTERS = 0.005  # share by which what is measured of operations usually scatters
_FEWEST = 10  # readings from which on a curve says something of a quantity, and its scatter is seen
_LATELY = 50  # readings, over which what is stated with them is averaged
_LEAST = 1e-12
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
        scatter = _covariance(changes, np.diag(noise**2 + _USUAL**2 * family))
        variance, forward = _both_diagonal(family, scatter)
        back = np.linalg.inv(forward)
        told = float(np.sqrt(_told(back, np.ones(len(family))) / max(len(new), 1)))
        return cls(mean, told, directions, forward, back, variance)

    def project(self, way: np.ndarray, present: np.ndarray) -> np.ndarray:
        """Return coordinates of records, ``(o, g) -> (o, k)``; nan without a sample."""
        some = [slice(begin, begin + _ROWS) for begin in range(0, len(way), _ROWS)]
        changes = (_changes(self.mean, way[each], present[each], self.basis) for each in some)
        # One by one, as a product of many rows rounds each by how many they are.
        seen = np.concatenate([(each[:, None] @ self.forward)[:, 0] for each in changes])
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
        return np.sqrt(_told(self.back, variance))


class CoordinateReading(NamedTuple):
    """A measured quantity, as a linear function of its motion's coordinates and one of its own.

    Attributes:
        motion, name: What it is.
        mean: While the drive was new, in its unit.
        slopes: What a coordinate says of it, ``(k,)``.
        scatter: Of what is left, in its unit.
        common: Standard deviation of the error that all recent readings share, in its unit,
            ``(o,)``: the geometric mean of the stated ones.
    """

    motion: str
    name: str
    mean: float
    slopes: np.ndarray
    scatter: float
    common: np.ndarray

    @classmethod
    def of(
        cls,
        motion: str,
        name: str,
        values: np.ndarray,
        stated: np.ndarray,
        curve: np.ndarray,
        new: np.ndarray,
    ) -> Self | None:
        """Return the reading of values ``(o,)`` by coordinates ``(o, k)``; None without a new one.

        Few readings scatter as is usual of drives and stated with them, as far as they do not tell.

        Args:
            stated: Standard deviations that are stated with the values, ``(o,)``.
        """
        there = new[np.isfinite(values[new]) & np.isfinite(curve[new]).all(axis=1)]
        if not there.size:
            return None
        seen, read = (np.diff(each[there], axis=0) / np.sqrt(2.0) for each in (curve, values))
        slopes = np.zeros(curve.shape[1])
        if there.size < _FEWEST:
            usual = np.median(stated[there]) ** 2 + (_SCATTERS * values[there].mean()) ** 2
            middle = shrunk_variance(float(read @ read), read.size, usual, _FEWEST) ** 0.5
        else:
            some = seen[:, :_EXPLAINS]
            square = some.T @ some + _RIDGE * np.eye(some.shape[1])
            slopes[: some.shape[1]] = np.linalg.solve(square, some.T @ read)
            left = read - seen @ slopes
            free = max(left.size - some.shape[1], left.size / 2.0)
            middle = _spread(left) * np.sqrt(left.size / free)
        mean = float((values[there] - curve[there] @ slopes).mean())
        scatter = max(float(middle), _LEAST + 1e-9 * abs(mean))
        logs = _of_late(np.log(np.where(np.isfinite(values), np.maximum(stated, _LEAST), np.nan)))
        common = np.where(np.isfinite(logs), np.exp(logs), 0.0)
        return cls(motion, name, mean, slopes, scatter, common)

    def project(self, values: np.ndarray, curve: np.ndarray) -> np.ndarray:
        """Return the coordinate that the quantity adds to its motion's, ``(o, 1)``."""
        explained = (curve * self.slopes).sum(axis=1)
        return ((values - self.mean - explained) / self.scatter)[:, None]


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
        """Return the coordinates of a drive, by the new records of its series."""
        curves, readings = {}, []
        for motion, each in series.motions.items():
            new = series.new[each.there[series.new]]
            noise = float(np.median(each.noise[new]))
            curve = LifeCurve.of(each.way, each.present, noise, bases[motion], new)
            curves[motion], seen = curve, curve.project(each.way, each.present)
            found = (
                CoordinateReading.of(motion, q, v, each.stated[q], seen, new)
                for q, v in each.measured.items()
            )
            readings += [reading for reading in found if reading is not None]
        return cls(curves, tuple(readings))

    def blocks(self, series: Series) -> list[Block]:
        """Return what is followed: records, or means of inspections."""
        seen = {
            motion: curve.project(series.motions[motion].way, series.motions[motion].present)
            for motion, curve in self.curves.items()
        }
        found = [_block(series, seen[m], e.variance, e.shared()) for m, e in self.curves.items()]
        for each in self.readings:
            values = series.motions[each.motion].measured[each.name]
            own = each.project(values, seen[each.motion]), np.array([_MOVES**2])
            shared = np.array([(_MOUNTED * each.mean / each.scatter) ** 2])
            found.append(_block(series, *own, shared, sought=each.name in _APART))
        return found

    def places(self, motion: str) -> slice:
        """Where the coordinates of a motion's curve stand."""
        sizes = {name: curve.variance.size for name, curve in self.curves.items()}
        names = list(sizes)
        begin = sum(sizes[name] for name in names[: names.index(motion)])
        return slice(begin, begin + sizes[motion])

    def row(self, motion: str, name: str) -> tuple[CoordinateReading, np.ndarray] | None:
        """Return the reading of a quantity and its change as a row of coordinates, ``(k,)``, in its
        unit; None where it is not followed.
        """
        begin = sum(curve.variance.size for curve in self.curves.values())
        for k, each in enumerate(self.readings):
            if (each.motion, each.name) == (motion, name):
                row = np.zeros(begin + len(self.readings))
                row[self.places(motion)] = each.slopes
                row[begin + k] = each.scatter
                return each, row
        return None


def _block(
    series: Series, values: np.ndarray, variance: np.ndarray, shared: np.ndarray, *, sought=True
) -> Block:
    """Coordinates as they are followed, with what is known of their scatter beforehand."""
    means, count = series.gathered(values)
    noise = np.ones_like(variance)
    if series.inspections is not None:
        noise = 1.0 / count + shared
    return Block(means, variance, noise, sought)


def _changes(
    mean: np.ndarray, way: np.ndarray, present: np.ndarray, directions: np.ndarray
) -> np.ndarray:
    """Components of the changes of records from a mean, ``(o, k)``."""
    there = present & np.isfinite(way)
    change = without_onset(np.broadcast_to(mean, way.shape), np.where(there, way, 0.0), there)
    return (change[:, None] @ directions.T)[:, 0]


def _spread(values: np.ndarray) -> float:
    """Standard deviation of values about 0, by their median size."""
    return float(np.median(np.abs(values))) / 0.6745


def _of_late(values: np.ndarray) -> np.ndarray:
    """Mean of the last values that are known at each operation, ``(o,)``; nan before the first."""
    known = np.isfinite(values)
    count, total = np.cumsum(known), np.append(0.0, np.cumsum(values[known]))
    before = np.maximum(count - _LATELY, 0)
    with np.errstate(invalid="ignore"):
        return (total[count] - total[before]) / (count - before)


def _covariance(changes: np.ndarray, usual: np.ndarray) -> np.ndarray:
    """Covariance of the scatter of records ``(n, k)``, without outliers, beside what is usual,
    inflated for directions that are themselves estimated.
    """
    apart = np.diff(changes, axis=0) / np.sqrt(2.0)
    found = usual
    for _ in range(2):
        if not len(apart):
            break
        found = shrunk_variance(apart.T @ apart, len(apart), usual, _KNOWN)
        squares = np.einsum("nk,nk->n", apart, np.linalg.solve(found, apart.T).T)
        apart = apart[squares <= _OUTLIER * np.median(squares)]
    total = len(apart) + _KNOWN
    return found * total / max(total - 1.0 - min(len(apart), usual.shape[0]), 1.0)


def _both_diagonal(family: np.ndarray, scatter: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Variances, and the map ``(k, k)`` after which the scatter is 1 and the family diagonal."""
    root = np.linalg.inv(np.linalg.cholesky(scatter))
    variance, turned = np.linalg.eigh(root @ np.diag(family) @ root.T)
    return variance[::-1], (root.T @ turned)[:, ::-1]


def _told(back: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """Mean variance of the first components of coordinates' variances, ``(..., k)``."""
    return (variance @ np.square(back[:, :SCATTER_DIRECTIONS])).mean(axis=-1)
