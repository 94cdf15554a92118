"""Trend of a life: values and rates of its coordinates, and changes of these.

Each coordinate follows ``a + b u + c u^2``. From each change on ``d (u - u0)`` is added, if wear
changed its rate, or ``d``, if the drive itself changed. Records scatter around the path by
Student's t. Coordinates are independent, so a change explains the Schur complement of its column.
Curvature has a prior: without it, false changes are detected; if it is free, true ones are missed.

At every operation three kinds of change are compared over all times at which they may have begun:
wear faster or slower in its direction, wear in a new direction, and a step. A change with evidence
above the threshold joins the path. It is moved or removed until enough records follow.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from breaker.prognosis.series import Series

_WIDE = 30.0  # prior sd of unknown coefficients of a path, in changes of the family
_BEND = 0.2  # prior sd of curvature over the life, in the change so far
_FASTER = 3.0  # prior sd of the change of a rate, in rates
_SIZE = 0.03  # prior sd of another change, in changes of the family
_EFFECT = 0.1  # prior sd of the effect of 10 K, or 10 % of the voltage, in changes of the family
_STARTS = 40  # starts of changes that are compared, geometric in their age
_AGE = 2  # fewest records after a change: a single one may be an outlier
_TAILS = 100.0  # degrees of freedom of the scatter
_MEMORY = 300.0  # records over which the scatter is averaged
_LARGEST = 9.0  # squared deviation, in variances, at which the effect of a record on noise is cut
_LEADING = 12  # coordinates of a block that count for changes, and for the bend of its path


class Block(NamedTuple):
    """Independent coordinates that are recorded together, in units of their scatter.

    Attributes:
        values: Coordinates of records, ``(o, k)``; rows of nan without a record.
        variance: Variance of the changes of drives of the family, ``(k,)``, the largest first.
        noise: Prior variance of a record, ``(k,)``, with the common error of an inspection.
        sought: Whether these coordinates are used to detect changes and to weight records.
    """

    values: np.ndarray
    variance: np.ndarray
    noise: np.ndarray
    sought: bool = True


class Change(NamedTuple):
    """A change of the path.

    Attributes:
        noticed: Index of the operation at which the change was detected.
        start, earliest, latest: Index of the first operation after it, and its 90 % interval.
        kind: ``"rate"`` or direction of wear, ``"step"``, or ``"event"``, a maintenance event.
        evidence: Log Bayes factor against no change, nats.
        maintenance: Whether it is work on the drive, not on its transducer alone.
    """

    noticed: int
    start: int
    earliest: int
    latest: int
    kind: str
    evidence: float
    maintenance: bool = False


@dataclass(frozen=True)
class Path:
    """State after each operation, of the coordinates of all blocks side by side, ``(o, k)``.

    Attributes:
        change, variance: Mean and variance of the change since new; nan before the last new record.
        rate, rate_variance, covariance: Mean and variance per operation; covariance with change.
        evidence: Evidence for a further change, nats, ``(o,)``; nan where none is sought.
        weight: Weight of the record, 1 on the path, ``(o,)``; nan without a record.
        changes: Changes of the path, in their order.
    """

    change: np.ndarray
    variance: np.ndarray
    rate: np.ndarray
    rate_variance: np.ndarray
    covariance: np.ndarray
    evidence: np.ndarray
    weight: np.ndarray
    changes: tuple[Change, ...]


class PathFit:
    """A regression of coordinates on the columns of a design, each coordinate with its own prior.

    Attributes:
        weight: Weight of each record, ``(o,)``.
        mean, cov: Coefficients, ``(k, p)``, and their covariance, ``(k, p, p)``.
        noise: Variance of a record, ``(k,)``; ``memory`` increases it if neighbours correlate.
        sought: Indices of coordinates in which changes are sought, ``(l,)``.
    """

    def __init__(self, blocks: Sequence[Block]) -> None:
        values, variance, noise, sought = zip(*blocks, strict=True)
        sizes = [array.size for array in variance]
        self.block = np.repeat(np.arange(len(blocks)), sizes)
        self.seen = np.stack([np.isfinite(array).all(axis=1) for array in values], axis=1)
        self.there = self.seen[:, self.block]
        self.values = np.where(self.there, np.concatenate(values, axis=1), 0.0)
        self.variance, self.noise = np.concatenate(variance), np.concatenate(noise)
        self.leading = np.concatenate([np.arange(size) < _LEADING for size in sizes])
        self.sought = np.flatnonzero(self.leading & np.repeat(sought, sizes))
        self.weight, self.memory = np.ones(len(self.values)), 1.0

    def design(self, rows: np.ndarray, last: int) -> None:
        """Set the design, ``(o, p)``, and sum the records before ``last``."""
        (n, p), blocks = rows.shape, self.seen.shape[1]
        self.rows = rows
        # Sums over the records before each.
        self.gram = np.zeros((n + 1, blocks, p, p))
        self.moment = np.zeros((n + 1, p, self.variance.size))
        self.add(0, last)

    def add(self, first: int, last: int) -> None:
        """Sum the records from ``first`` to before ``last``."""
        part, after = slice(first, last), slice(first + 1, last + 1)
        rows, seen = self.rows[part], self.seen[part, :, None, None]
        weighted = self.weight[part, None, None] * rows[:, :, None]
        gram = np.cumsum(seen * (weighted * rows[:, None])[:, None], axis=0)
        moment = np.cumsum(weighted * self.values[part, None], axis=0)
        self.gram[after], self.moment[after] = self.gram[first] + gram, self.moment[first] + moment

    def solve(self, i: int, precision: np.ndarray) -> None:
        """Fit the records up to ``i``, with prior precisions of the coefficients, ``(k, p)``."""
        noise = self.memory * self.noise
        matrix = self.gram[i + 1, self.block] / noise[:, None, None]
        self.cov = np.linalg.inv(matrix + precision[:, :, None] * np.eye(precision.shape[1]))
        self.mean = (self.cov @ (self.moment[i + 1] / noise).T[:, :, None])[:, :, 0]

    def explained(
        self, starts: np.ndarray, i: int, columns: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return how further columns explain the records up to ``i``: precisions of their
        coefficients without a prior, and products of these and the estimates, ``(c, l)`` each. A
        column is 0 before ``starts (c,)``, then a sum of columns of the design, ``(c, p)``.
        """
        sought = self.sought
        moment = (self.moment[i + 1] - self.moment[starts])[:, :, sought]
        noise, block = self.memory * self.noise[sought], self.block[sought]
        cross = ((self.gram[i + 1] - self.gram[starts]) @ columns[:, None, :, None])[..., 0]
        square = (cross * columns[:, None]).sum(axis=-1)[:, block]
        cross = cross[:, block].swapaxes(0, 1)
        known = ((cross @ self.cov[sought]) * cross).sum(axis=-1).T
        predicted = (cross @ self.mean[sought][:, :, None])[..., 0].T
        product = (columns[:, None] @ moment)[:, 0] - predicted
        return square / noise - known / np.square(noise), product / noise


def evidence(precision: np.ndarray, product: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """Return log Bayes factors ``(c,)`` by ``PathFit.explained`` and prior variances ``(c, l)``."""
    grown = 1.0 + precision * variance
    return 0.5 * (np.square(product) * variance / grown - np.log(grown)).sum(axis=1)


class _Column(NamedTuple):
    """A column of the design: ``(o,)`` values."""

    values: np.ndarray
    power: int = 0  # of the time since the record ``before``
    before: int = 0
    size: float = _WIDE  # prior sd, in changes of the family
    kept: bool = True  # whether it is a change of the drive


class Follower:
    """Filter that follows a life, and detects changes with evidence above the threshold, nats."""

    def __init__(self, series: Series, blocks: Sequence[Block], threshold: float) -> None:
        self.series, self.threshold = series, threshold
        self.fit, self.full = PathFit(blocks), int(series.new[-1])
        self.settle, self.counted = series.settle, series.counted
        where = series.operations.astype(float)
        self.span = max(float(np.ptp(where[series.new])), 1.0)
        self.time = (where - where[0]) / self.span
        self.columns = [_Column(self.time**power, power) for power in range(3)]
        self.columns += [_Column(name, size=_EFFECT, kept=False) for name in series.conditions]
        self.change, self.off = np.zeros((2, self.fit.variance.size))
        self.correlation = 0.0  # of neighbouring records
        self.changes: list[Change] = []
        self.settled = len(self.columns)  # without columns of the last change
        self._design(0)

    def path(self) -> Path:
        """Return the path over all operations."""
        known = np.full((5, *self.fit.values.shape), np.nan)
        evidence, weight = np.full((2, self.time.size), np.nan)
        for i, there in enumerate(self.fit.there):
            if i > self.full and i in self.series.events:
                self._begin(Change(i, i, i, i, "event", np.inf, self.series.events[i]), i)
            if there.any():
                weight[i] = self._weigh(i) if i > self.full else 1.0
            self.fit.add(i, i + 1)
            if i < self.full:
                continue
            self._solve(i)
            evidence[i] = self._watch(i)
            since, rate = self._rows(i)
            rows = np.stack([since, rate / self.span])
            mean, cov = self.fit.mean @ rows.T, rows @ self.fit.cov @ rows.T
            known[:, i] = mean[:, 0], cov[:, 0, 0], mean[:, 1], cov[:, 1, 1], cov[:, 0, 1]
        return Path(*known, evidence, weight, tuple(self.changes))

    def _design(self, last: int) -> None:
        """Set the design from the columns, and fit the records before ``last``."""
        values, *fields = zip(*self.columns, strict=True)
        self.power, self.before, self.size, self.kept = map(np.array, fields)
        self.fit.design(np.stack(values, axis=1), last)
        self.mean_new = self.fit.rows[self.series.new].mean(axis=0)
        if last:
            self._solve(last - 1)

    def _begin(self, change: Change, last: int) -> None:
        """Add a change to the path, and fit the path to the records before ``last``."""
        self.changes.append(change)
        self.settled = len(self.columns)
        since = self.time - self.time[change.start - 1]
        after = np.arange(since.size) >= change.start
        for power in range(3):  # a step, and a new rate with curvature; an event has both
            if change.kind != ("step" if power else "rate"):
                kept = power > 0 or change.kind != "event" or change.maintenance
                column = _Column(after * since**power, power, change.start - 1, kept=kept)
                self.columns.append(column)
        self._design(last)

    def _watch(self, i: int) -> float:
        """Seek a change after operation ``i``, or move the last one; return the evidence."""
        last = self.changes[-1] if self.changes else None
        young = last and last.kind != "event" and i <= last.noticed + self.settle
        if young:
            self.changes.pop()
            del self.columns[self.settled :]
            self._design(i + 1)
        best = self._seek(i)
        if young and best.evidence > 0.0:
            self._begin(best._replace(noticed=last.noticed), i + 1)
        elif not young and best.evidence > self.threshold and i > self.full + self.settle:
            self.fit.weight[best.start : i + 1] = 1.0  # old weights do not include the change
            self._begin(best, i + 1)
        return np.nan if young else best.evidence

    def _solve(self, i: int) -> None:
        """Fit the path to the records up to ``i``; it may bend along its change, and across."""
        fit, since = self.fit, np.maximum(self.time[i] - self.time[self.before], 1e-9)
        square, roots = np.square(self.change), np.sqrt(fit.variance)
        wide = self.size**2 * fit.variance[:, None] + 1.0
        sums, root = (np.bincount(fit.block, e)[fit.block] for e in (square * fit.leading, roots))
        bends = _BEND**2 * (square + sums * roots / root) + 1e-12
        wide[:, self.power == 2] = bends[:, None]
        fit.solve(i, since ** (2 * self.power) / wide)
        self.change = fit.mean @ self._rows(i)[0]

    def _weigh(self, i: int) -> float:
        """Weight record ``i`` by its deviation from the prediction, and update the noise by it."""
        fit, there, row = self.fit, self.fit.there[i], self.fit.rows[i]
        off = (fit.values[i] - fit.mean @ row) / np.sqrt(fit.noise + row @ (fit.cov @ row).T)  # sds
        sought = fit.sought[there[fit.sought]]
        weight = (_TAILS + sought.size) / (_TAILS + float(np.square(off[sought]).sum()))
        self.counted = min(self.counted + 1.0, _MEMORY)
        if sought.size:
            product = np.clip(weight * (off[sought] @ self.off[sought]) / sought.size, -1.0, 1.0)
            self.correlation += (product - self.correlation) / self.counted
            fit.memory = (1.0 + max(self.correlation, 0.0)) / (1.0 - max(self.correlation, 0.0))
        self.off = np.where(there, np.sqrt(min(weight, 1.0)) * off, self.off)
        grown = (np.minimum(weight * np.square(off), _LARGEST) - 1.0) / self.counted
        fit.noise = fit.noise * np.where(there, 1.0 + grown, 1.0)
        fit.weight[i] = weight
        return weight

    def _seek(self, i: int) -> Change:
        """Return the most probable change since the last one, with the evidence for any change."""
        last = self.changes[-1].noticed + self.settle if self.changes else self.full
        first = max(last, 1)
        if i + 1 - first < _AGE:
            return Change(i, 0, 0, 0, "", np.nan)
        ages = np.unique(np.geomspace(_AGE, i + 1 - first, _STARTS).round().astype(int))
        starts = i + 1 - ages
        now, before = self.time[i], self.time[starts - 1]
        columns = np.zeros((2, starts.size, self.power.size))  # a ramp, and a step
        columns[:, :, 0] = -before / (now - before), np.ones(starts.size)
        columns[0, :, 1] = 1.0 / (now - before)
        ramps, steps = (self.fit.explained(starts, i, column) for column in columns)
        speed = (self.fit.mean @ self._rows(i)[1])[self.fit.sought]
        along = np.square(_FASTER * np.outer(now - before, speed))
        free = _SIZE**2 * self.fit.variance[self.fit.sought]
        kinds = ("rate", "rate", "step")
        total = np.stack([evidence(*ramps, along), evidence(*ramps, free), evidence(*steps, free)])
        gaps = np.gradient(ages.astype(float)) if ages.size > 1 else np.ones(1)
        total += np.log(gaps / (gaps.sum() * len(kinds)))
        combined = float(np.logaddexp.reduce(total.ravel()))
        kind, place = np.unravel_index(total.argmax(), total.shape)
        share = np.cumsum(np.exp(total - combined).sum(axis=0)[::-1])  # from the earliest start
        ends = np.minimum(np.searchsorted(share, (0.05, 0.95)), share.size - 1)
        earliest, latest = starts[::-1][ends].tolist()
        return Change(i, int(starts[place]), earliest, latest, kinds[kind], combined)

    def _rows(self, i: int) -> tuple[np.ndarray, np.ndarray]:
        """Return rows of the design for the change of the drive since new, and for its rate."""
        since = self.time[i] - self.time[self.before]
        rate = self.power * since ** np.maximum(self.power - 1, 0)
        return self.kept * (self.fit.rows[i] - self.mean_new), rate
