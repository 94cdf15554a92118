"""Lines of a life: where any number of coordinates are, whither they go, and where that changed.

Each coordinate moves along ``a + b u + c u^2``, and from each change on ``d (u - u0)`` more, where
wear changed its rate, or ``d``, where the drive itself did. Records scatter around the path: each
counts by Student's t. Coordinates are independent and in units of the scatter, so all is linear and
Gaussian, and what a change would explain is the Schur complement of its column. The curvature has a
prior: a share of the change so far. Without it false changes are found; free, true ones are not.

At every operation three kinds of change are weighed over all times at which they may have begun:
wear faster or slower in its own direction, wear in a new one, and a step. From the threshold on a
change becomes part of the path, and is placed anew until enough records have followed it; it is
forgotten if they deny it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

_WIDE = 30.0  # prior sd of what is not known of a path, in changes of the family
_BEND = 0.2  # prior sd of curvature over the life, in the change so far
_FASTER = 3.0  # prior sd of the change of a rate, in rates
_SIZE = 0.03  # prior sd of another change, in changes of the family
_EFFECT = 0.1  # prior sd of 10 K, or of 10 % of the voltage, in changes of the family
_STARTS = 40  # of changes that are weighed, closer together the later they are
_AGE = 2  # records that a change needs: one may be an outlier
_TAILS = 100.0  # degrees of freedom of the scatter
_MEMORY = 300.0  # records, over which the size of the scatter is followed
_ODD = 9.0  # square of a record's coordinate, in variances, as which a larger one counts in it
_LEADING = 12  # coordinates of a block that count for changes, and for how its path bends
_POWERS = {"rate": (1, 2), "step": (0,), "event": (0, 1, 2)}  # of time, by kind of change


class Block(NamedTuple):
    """Coordinates that are seen together, independent, in units of their scatter.

    Attributes:
        values: ``(o, k)``; rows of nan where there is no record.
        variance: Of the changes that drives of the family make, ``(k,)``, the largest first.
        noise: Variance of a record as far as it is known beforehand, ``(k,)``, in that of its
            scatter: 1, or of the mean of an inspection with the error that its records share.
        sought: Whether changes are looked for in them, and records weighed by them.
    """

    values: np.ndarray
    variance: np.ndarray
    noise: np.ndarray
    sought: bool = True


class Change(NamedTuple):
    """A change of the path.

    Attributes:
        noticed: Index of the operation at which it was.
        start: Index of the first operation after it,
        earliest, latest: and within which indices it lies by 90 %.
        kind: ``"rate"`` of the wear, or its direction, ``"step"``, or ``"event"``, known work.
        evidence: Log Bayes factor against none, nats.
        transducer: Whether what it moved is no change of the drive.
    """

    noticed: int
    start: int
    earliest: int
    latest: int
    kind: str
    evidence: float
    transducer: bool = False


@dataclass(frozen=True)
class Path:
    """What is known after each operation, of all blocks' coordinates side by side, ``(o, k)``.

    Attributes:
        change, variance: Change since new, mean and variance; nan before all new records are there.
        since, since_variance: The same since the last known event; nan before one.
        rate, rate_variance: Of the change, per operation.
        covariance: Of change and rate.
        evidence: For a change that is not noticed yet, nats, ``(o,)``; nan where none is sought.
        weight: Of the record beside one that follows the path, ``(o,)``; nan without one.
    """

    change: np.ndarray
    variance: np.ndarray
    since: np.ndarray
    since_variance: np.ndarray
    rate: np.ndarray
    rate_variance: np.ndarray
    covariance: np.ndarray
    evidence: np.ndarray
    weight: np.ndarray
    changes: tuple[Change, ...]


class PathFit:
    """A regression of coordinates on the columns of a design, with a prior of its own each.

    Args:
        blocks: What is followed, side by side.

    Attributes:
        there: Whether there is a record, ``(o, k)``.
        weight: Of each record, ``(o,)``.
        mean: Coefficients, ``(k, p)``.
        cov: Their covariance, ``(k, p, p)``.
        noise: Variance of a record, ``(k,)``,
        memory: times this, where neighbouring records err alike.
        sought: Coordinates in which changes are sought, indices ``(l,)``.
    """

    def __init__(self, blocks: Sequence[Block]) -> None:
        sizes = [block.variance.size for block in blocks]
        self.block = np.repeat(np.arange(len(blocks)), sizes)
        seen = np.stack([np.isfinite(block.values).all(axis=1) for block in blocks], axis=1)
        # Coordinates that are seen together share their sums of squares.
        self.seen, alike = np.unique(seen, axis=1, return_inverse=True)
        self.alike, self.there = alike.ravel()[self.block], seen[:, self.block]
        values = np.concatenate([block.values for block in blocks], axis=1)
        self.values = np.where(self.there, values, 0.0)
        self.variance = np.concatenate([block.variance for block in blocks])
        self.noise = np.concatenate([block.noise for block in blocks])
        self.leading = np.concatenate([np.arange(size) < _LEADING for size in sizes])
        sought = np.repeat([block.sought for block in blocks], sizes)
        self.sought = np.flatnonzero(self.leading & sought)
        self.weight, self.memory = np.ones(len(self.values)), 1.0

    def design(self, rows: np.ndarray, last: int) -> None:
        """Take another design, ``(o, p)``, and add up the records before ``last``."""
        (n, p), (s, k) = rows.shape, (self.seen.shape[1], self.variance.size)
        self.rows = rows
        # Sums over the records before each.
        self.gram, self.moment = np.zeros((n + 1, s, p, p)), np.zeros((n + 1, p, k))
        self.add(0, last)

    def add(self, first: int, last: int) -> None:
        """Add up the records from ``first`` to before ``last``."""
        some, after = slice(first, last), slice(first + 1, last + 1)
        rows, seen = self.rows[some], self.seen[some, :, None, None]
        weighted = self.weight[some, None, None] * rows[:, :, None]
        gram = np.cumsum(seen * (weighted * rows[:, None])[:, None], axis=0)
        moment = np.cumsum(weighted * self.values[some, None], axis=0)
        self.gram[after], self.moment[after] = self.gram[first] + gram, self.moment[first] + moment

    def solve(self, i: int, precision: np.ndarray) -> None:
        """Fit the records up to ``i``, with prior precisions of the coefficients, ``(k, p)``."""
        noise = self.memory * self.noise
        matrix = self.gram[i + 1, self.alike] / noise[:, None, None]
        self.cov = np.linalg.inv(matrix + precision[:, :, None] * np.eye(precision.shape[1]))
        self.mean = (self.cov @ (self.moment[i + 1] / noise).T[:, :, None])[:, :, 0]

    def off(self, i: int) -> np.ndarray:
        """Return how far a record is from the path, in sds, ``(k,)``."""
        row = self.rows[i]
        return (self.values[i] - self.mean @ row) / np.sqrt(self.noise + row @ (self.cov @ row).T)

    def explained(
        self, starts: np.ndarray, i: int, columns: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Say what columns would explain that are 0 before a start, in coordinates that count.

        Args:
            starts: Index of the first record of each, ``(c,)``.
            i: Index of the last record.
            columns: From there on, as sums of those of the design, ``(c, p)``.

        Returns:
            Precision of its coefficient where nothing is known before, and that times what the
            records say, ``(c, l)`` each.
        """
        some = self.sought
        moment = (self.moment[i + 1] - self.moment[starts])[:, :, some]
        noise, alike = self.memory * self.noise[some], self.alike[some]
        cross = ((self.gram[i + 1] - self.gram[starts]) @ columns[:, None, :, None])[..., 0]
        square = (cross * columns[:, None]).sum(axis=-1)[:, alike]
        cross = cross[:, alike].swapaxes(0, 1)
        known = ((cross @ self.cov[some]) * cross).sum(axis=-1).T
        foreseen = (cross @ self.mean[some][:, :, None])[..., 0].T
        product = (columns[:, None] @ moment)[:, 0] - foreseen
        return square / noise - known / np.square(noise), product / noise


def evidence(precision: np.ndarray, product: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """Return log Bayes factors ``(c,)`` of coefficients with prior variances ``(c, l)``, by what
    ``PathFit.explained`` returns.
    """
    grown = 1.0 + precision * variance
    return 0.5 * (np.square(product) * variance / grown - np.log(grown)).sum(axis=1)


class _Column(NamedTuple):
    """A column of the design: ``(o,)`` values."""

    values: np.ndarray
    power: int = 0  # of the time since the record before it begins
    before: int = 0
    size: float = _WIDE  # prior sd, in changes of the family
    kept: bool = True  # whether what it moves is a change of the drive


class Follower:
    """A life, as it is followed.

    Args:
        operations: Their numbers, rising, ``(o,)``.
        blocks: Coordinates.
        new: Indices of the operations that are new.
        settle: Operations after these, and after a change, in which none is noticed.
        threshold: Evidence from which a change is noticed, nats.
        counted: Records for which the scatter counts that is known beforehand.
        conditions: Temperature and voltage relative to those of the new operations, in 10 K and
            in 10 % of the voltage, ``(o,)`` each, 0 where not known.
    """

    def __init__(
        self,
        operations: np.ndarray,
        blocks: Sequence[Block],
        *,
        new: np.ndarray,
        settle: int = 50,
        threshold: float = 10.0,
        counted: float = 100.0,
        conditions: Sequence[np.ndarray] = (),
    ) -> None:
        self.fit, self.new, self.full = PathFit(blocks), new, int(new[-1])
        self.settle, self.threshold, self.counted = settle, threshold, counted
        where = np.asarray(operations, dtype=float)
        self.span = max(float(np.ptp(where[new])), 1.0)
        self.time = (where - where[0]) / self.span
        self.columns = [_Column(self.time**power, power) for power in range(3)]
        self.columns += [_Column(each, size=_EFFECT, kept=False) for each in conditions]
        self.change, self.off = np.zeros((2, self.fit.variance.size))
        self.alike = 0.0  # correlation of neighbouring records
        self.changes: list[Change] = []
        self._design(0)

    def path(self, events: Mapping[int, bool]) -> Path:
        """Go through all operations.

        Args:
            events: Indices of operations before which the drive was maintained, and whether the
                transducer alone was.
        """
        n, k = self.fit.values.shape
        known = np.full((n, len(Path.__annotations__) - 3, k), np.nan)
        evidence, weight = np.full((2, n), np.nan)
        for i in range(n):
            if i in events and i > self.full:
                self._begin(Change(i, i, i, i, "event", np.inf, events[i]), i)
            if self.fit.there[i].any():
                weight[i] = self._weigh(i) if i > self.full else 1.0
            self.fit.add(i, i + 1)
            if i < self.full:
                continue
            self._solve(i)
            if i > self.full:
                evidence[i] = self._watch(i)
            known[i] = self._known(i)
        return Path(*known.swapaxes(0, 1), evidence, weight, tuple(self.changes))

    def _design(self, last: int) -> None:
        """Take the columns, and add up the records before ``last``."""
        values, *about = zip(*self.columns, strict=True)
        self.power, self.before, self.size, self.kept = map(np.array, about)
        self.fit.design(np.stack(values, axis=1), last)
        self.mean_new = self.fit.rows[self.new].mean(axis=0)

    def _begin(self, change: Change, last: int) -> None:
        """Let a change be part of the path, and fit it to the records before ``last``."""
        self.changes.append(change)
        since = self.time - self.time[change.start - 1]
        after = np.arange(since.size) >= change.start
        for power in _POWERS[change.kind]:
            kept = power > 0 or not change.transducer
            self.columns.append(_Column(after * since**power, power, change.start - 1, kept=kept))
        self._design(last)
        self._solve(last - 1)

    def _watch(self, i: int) -> float:
        """Look for a change after operation ``i``, or place the last one anew; its evidence."""
        last = self.changes[-1] if self.changes else None
        if last and last.kind != "event" and i <= last.noticed + self.settle:
            self.changes.pop()
            del self.columns[-len(_POWERS[last.kind]) :]
            self._design(i + 1)
            self._solve(i)
            best = self._seek(i)
            if best.evidence > 0.0:
                self._begin(best._replace(noticed=last.noticed), i + 1)
            return np.nan
        best = self._seek(i)
        if best.evidence > self.threshold and i > self.full + self.settle:
            self.fit.weight[best.start : i + 1] = 1.0  # they were weighed without it
            self._begin(best, i + 1)
        return best.evidence

    def _solve(self, i: int) -> None:
        """Fit the path to the records up to ``i``; it may bend along its change, and aside."""
        fit, since = self.fit, np.maximum(self.time[i] - self.time[self.before], 1e-9)
        square, roots = np.square(self.change), np.sqrt(fit.variance)
        wide = self.size**2 * fit.variance[:, None] + 1.0
        aside, root = (np.bincount(fit.block, e)[fit.block] for e in (square * fit.leading, roots))
        bends = _BEND**2 * (square + aside * roots / root) + 1e-12
        wide[:, self.power == 2] = bends[:, None]
        fit.solve(i, since ** (2 * self.power) / wide)
        self.change = fit.mean @ self._since(i, self.mean_new)

    def _weigh(self, i: int) -> float:
        """Weigh record ``i`` by how far it is from what is expected, and learn the noise by it."""
        fit, there, off = self.fit, self.fit.there[i], self.fit.off(i)
        sought = fit.sought[there[fit.sought]]
        weight = (_TAILS + sought.size) / (_TAILS + float(np.square(off[sought]).sum()))
        self.counted = min(self.counted + 1.0, _MEMORY)
        if sought.size:
            alike = np.clip(weight * (off[sought] @ self.off[sought]) / sought.size, -1.0, 1.0)
            self.alike += (alike - self.alike) / self.counted
            fit.memory = (1.0 + max(self.alike, 0.0)) / (1.0 - max(self.alike, 0.0))
        self.off = np.where(there, np.sqrt(min(weight, 1.0)) * off, self.off)
        grown = (np.minimum(weight * np.square(off), _ODD) - 1.0) / self.counted
        fit.noise = fit.noise * np.where(there, 1.0 + grown, 1.0)
        fit.weight[i] = weight
        return weight

    def _seek(self, i: int) -> Change:
        """Weigh all changes that may have begun since the last one; the evidence is for any."""
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
        ramps, steps = (self.fit.explained(starts, i, each) for each in columns)
        speed = (self.fit.mean @ self._rate(i))[self.fit.sought]
        along = np.square(_FASTER * np.outer(now - before, speed))
        other = _SIZE**2 * self.fit.variance[self.fit.sought]
        kinds = ("rate", "rate", "step")
        total = np.stack(
            [evidence(*ramps, along), evidence(*ramps, other), evidence(*steps, other)]
        )
        gaps = np.gradient(ages.astype(float)) if ages.size > 1 else np.ones(1)
        total += np.log(gaps / (gaps.sum() * len(kinds)))
        every = float(np.logaddexp.reduce(total.ravel()))
        kind, place = np.unravel_index(total.argmax(), total.shape)
        share = np.cumsum(np.exp(total - every).sum(axis=0)[::-1])  # from the earliest on
        ends = np.minimum(np.searchsorted(share, (0.05, 0.95)), share.size - 1)
        earliest, latest = starts[::-1][ends].tolist()
        return Change(i, int(starts[place]), earliest, latest, kinds[kind], every)

    def _rate(self, i: int) -> np.ndarray:
        """Row of the design that gives the rate after operation ``i``."""
        return self.power * (self.time[i] - self.time[self.before]) ** np.maximum(self.power - 1, 0)

    def _since(self, i: int, earlier: np.ndarray) -> np.ndarray:
        """Row of the design for the change since an earlier row, of the drive alone."""
        return self.kept * (self.fit.rows[i] - earlier)

    def _known(self, i: int) -> list[np.ndarray]:
        """What ``Path`` has of operation ``i``, in its order."""
        events = [change.start for change in self.changes if change.kind == "event"]
        event = self.fit.rows[events[-1]] if events else np.nan
        rows = [self._since(i, self.mean_new), self._since(i, event), self._rate(i) / self.span]
        rows = np.stack(rows)
        mean, cov = self.fit.mean @ rows.T, rows @ self.fit.cov @ rows.T
        since_new, since_event, rate = ((mean[:, k], cov[:, k, k]) for k in range(3))
        return [*since_new, *since_event, *rate, cov[:, 0, 2]]
