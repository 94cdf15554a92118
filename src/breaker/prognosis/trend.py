"""Lines of a life: where any number of coordinates are, whither they go, and where that changed.

Each coordinate moves along ``a + b u + c u^2``, and from each change on ``d (u - u0)`` more, where
wear changed its rate, or ``d``, where the drive itself did. Records scatter around the path: each
counts by Student's t. Coordinates are independent and in units of the scatter, so all is linear and
Gaussian, and what a change would explain is the Schur complement of its column. The curvature has a
prior: a share of the change so far. Without it false changes are found; free, true ones are not.

At every operation three kinds of change are weighed over all times at which they may have begun:
wear faster or slower in its own direction, wear in a new one, and a step. From the threshold on a
change becomes part of the path, and is placed anew until enough records have followed it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

_LEVEL, _RATE, _LATER = 100.0, 10.0, 30.0  # prior sds, in changes of the family: none is known
_STARTS = 40  # of changes that are weighed, closer together the later they are
_NEAR = 8  # records about the last place of a change, where each is weighed
_AGE = 2  # records that a change needs: one may be an outlier
_MEMORY = 300.0  # records, over which the size of the scatter is followed
_ODD = 9.0  # square of a record's coordinate, in variances, as which a larger one counts in it
_ALIKE = 0.9  # largest correlation of neighbouring records
_BEND, _ASIDE = 0.2, 0.2  # prior sds of curvature over the life: along the change, and across it
_FASTER = 3.0  # prior sd of the change of a rate, in rates
_SIZE = 0.03  # prior sd of another change, in changes of the family
_TAILS = 100.0  # degrees of freedom of the scatter
_EFFECTS = {"temperature": 0.1, "voltage": 0.1}  # prior sds of 10 K, 10 %, in changes of the family
_SOUGHT = ("rate", "rate", "step", "rate", "step")
_LARGE = 30.0  # size of a large change, over that of another
_BASE = 3  # columns that any design has; the next is those of conditions
_POWERS = {"rate": (1, 2), "step": (0,), "event": (0, 1, 2)}  # of time, by kind of change
_LEADING = 12  # coordinates of a block that count for changes, and for how its path bends


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
        evidence: Log Bayes factor against none, nats; below 0 it was taken back.
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
        bend, bend_variance: Of the rate, per operation.
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
    bend: np.ndarray
    bend_variance: np.ndarray
    evidence: np.ndarray
    weight: np.ndarray
    changes: tuple[Change, ...]


class Explained(NamedTuple):
    """What one more column of the design would explain, by candidate.

    Attributes:
        precision, product: Of its coefficient in every coordinate, ``(c, k)`` each: what the
            records say of it where nothing is known before.
    """

    precision: np.ndarray
    product: np.ndarray

    def evidence(self, variance: np.ndarray) -> np.ndarray:
        """Return the log Bayes factors ``(c,)`` of coefficients with prior variances ``(c, k)``."""
        grown = 1.0 + self.precision * variance
        return 0.5 * (np.square(self.product) * variance / grown - np.log(grown)).sum(axis=1)


class PathFit:
    """A regression of coordinates on the columns of a design, with a prior of its own each.

    Args:
        blocks: What is followed, side by side.

    Attributes:
        there: Whether there is a record, ``(o, k)``.
        weight: Of each record, ``(o,)``.
        mean: Coefficients, ``(k, p)``.
        cov: Their covariance, ``(k, p, p)``.
        change: Change so far, ``(k,)``.
        noise: Variance of a record, ``(k,)``, followed from that of its block on,
        memory: times this, where neighbouring records err alike.
        last: How far the last record was from the path, in sds, ``(k,)``.
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
        self.leading = np.concatenate([np.arange(size) < _LEADING for size in sizes])
        sought = np.repeat([block.sought for block in blocks], sizes)
        self.sought = np.flatnonzero(self.leading & sought)
        self.weight = np.ones(len(self.values))
        self.noise = np.concatenate([block.noise for block in blocks])
        self.memory = 1.0
        self.change, self.last = np.zeros((2, self.variance.size))
        # Sums over the records before each; 0 in columns that the design did not have then.
        n, (k, s) = len(self.values) + 1, (self.variance.size, self.seen.shape[1])
        self.gram, self.moment = np.zeros((n, s, 0, 0)), np.zeros((n, 0, k))

    def sum_up(self, rows: np.ndarray, first: int) -> None:
        """Add up records from index ``first`` on, by their rows of a design, ``(r, p)``.

        Columns that are new are 0 before; what had been added from there on is forgotten.
        """
        r, p = rows.shape
        if more := max(p - self.moment.shape[1], 0):
            self.gram = np.pad(self.gram, ((0, 0), (0, 0), (0, more), (0, more)))
            self.moment = np.pad(self.moment, ((0, 0), (0, more), (0, 0)))
        gram, moment = (each[first : first + r + 1] for each in (self.gram, self.moment))
        gram[:, :, p:], gram[:, :, :, p:], moment[:, p:] = 0.0, 0.0, 0.0
        some = slice(first, first + r)
        weighted = self.weight[some, None, None] * rows[:, :, None]
        gram[1:, :, :p, :p] = self.seen[some, :, None, None] * (weighted * rows[:, None])[:, None]
        moment[1:, :p] = weighted * self.values[some, None]
        for each in (gram, moment):
            np.cumsum(each, axis=0, out=each)

    def solve(self, i: int, precision: np.ndarray) -> None:
        """Fit the records up to ``i``, with prior precisions of the coefficients, ``(k, p)``."""
        noise = self.memory * self.noise
        p = precision.shape[1]
        matrix = self.gram[i + 1, self.alike, :p, :p] / noise[:, None, None]
        self.cov = np.linalg.inv(matrix + precision[:, :, None] * np.eye(p))
        self.mean = (self.cov @ (self.moment[i + 1, :p] / noise).T[:, :, None])[:, :, 0]

    def bends(self) -> tuple[np.ndarray, np.ndarray]:
        """Return squares of the change: along it, and as much as its block may bend aside."""
        square, roots = np.square(self.change), np.sqrt(self.variance)
        aside, root = (
            np.bincount(self.block, e)[self.block] for e in (square * self.leading, roots)
        )
        return square, aside * roots / root

    def about(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return linear functions ``(r, p)`` of the coefficients: ``(k, r)``, and covariances."""
        return self.mean @ rows.T, rows @ self.cov @ rows.T

    def off(self, rows: np.ndarray, first: int, some: np.ndarray | slice) -> np.ndarray:
        """Return how far records are from the path in some coordinates, in sds, ``(r, k)``."""
        left = self.values[first : first + len(rows), some] - rows @ self.mean[some].T
        spread = ((rows @ self.cov[some]) * rows).sum(axis=-1).T
        return left / np.sqrt(self.noise[some] + spread)

    def explained(self, starts: np.ndarray, i: int, columns: np.ndarray) -> list[Explained]:
        """Say what columns would explain that are 0 before a start, in coordinates that count.

        Args:
            starts: Index of the first record of each, ``(c,)``.
            i: Index of the last record.
            columns: Kinds of column from there on, as sums of those of the design, ``(v, c, p)``.
        """
        some, p = self.sought, columns.shape[-1]
        gram = self.gram[i + 1, :, :p, :p] - self.gram[starts, :, :p, :p]
        moment = (self.moment[i + 1, :p] - self.moment[starts, :p])[:, :, some]
        noise, alike = self.memory * self.noise[some], self.alike[some]
        cross = (columns[:, :, None, None] @ gram)[:, :, :, 0]
        square = (cross * columns[:, :, None]).sum(axis=-1)[..., alike]
        cross = cross[:, :, alike].swapaxes(1, 2)
        known = ((cross @ self.cov[some]) * cross).sum(axis=-1).swapaxes(1, 2)
        foreseen = (cross @ self.mean[some][:, :, None])[..., 0].swapaxes(1, 2)
        product = (columns[:, :, None] @ moment)[:, :, 0] - foreseen
        precision = square / noise - known / np.square(noise)
        return [Explained(*each) for each in zip(precision, product / noise, strict=True)]


class _Column(NamedTuple):
    """A column of the design: a power of the time since a change, or since the drive was new."""

    power: int
    origin: float
    before: int = 0
    first: int = 0
    size: float = 0.0
    kept: bool = True


class _Life:
    """A life of a drive, as it is followed; arguments as of ``follow``."""

    def __init__(
        self,
        operations: np.ndarray,
        fit: PathFit,
        new: np.ndarray,
        conditions: Sequence[tuple[np.ndarray, float]],
        settle: int,
        threshold: float,
        counted: float,
    ) -> None:
        self.fit, self.new, self.settle, self.threshold = fit, new, settle, threshold
        where = np.asarray(operations, dtype=float)
        self.span = max(float(np.ptp(where[self.new])), 1.0)
        self.time = (where - where[self.new].mean()) / self.span
        self.conditions = np.array([values for values, _ in conditions]).T.reshape(
            len(self.time), len(conditions)
        )
        self.effects = np.array([effect for _, effect in conditions])
        self.changes: list[Change] = []
        self.counted, self.alike = counted, 0.0
        n = len(self.time)
        self.known = np.full((n, 9, fit.variance.size), np.nan)
        self.evidence, self.weight = np.full((2, n), np.nan)
        self._renew(0, 0)

    def followed(self, events: Mapping[int, bool]) -> Path:
        """Go through all operations, with events as of ``follow``."""
        full = int(self.new[-1])
        for i in range(len(self.time)):
            if i in events and i > full:
                self._begin(Change(i, i, i, i, "event", np.inf, events[i]), i - 1)
            self.weight[i] = self._weigh(i, learnt=i > full)
            self.fit.sum_up(self._rows([i]), i)
            if i < full:
                continue
            self._solve(i)
            if i > full:
                self.evidence[i] = self._watch(i, full)
            self.known[i] = self._known(i)
        return Path(*self.known.swapaxes(0, 1), self.evidence, self.weight, tuple(self.changes))

    @property
    def _of_conditions(self) -> slice:
        """Columns of the design that are those of conditions."""
        return slice(_BASE, _BASE + self.effects.size)

    def _standing(self) -> list[Change]:
        """Changes that were not taken back."""
        return [change for change in self.changes if change.evidence >= 0.0]

    def _renew(self, first: int, last: int) -> None:
        """Make the columns anew, and add up the records from ``first`` to before ``last``."""
        columns = [
            _Column(power, 0.0, size=size) for power, size in enumerate((_LEVEL, _RATE, 0.0))
        ]
        columns += [_Column(0, 0.0, kept=False)] * self.effects.size
        for change in self._standing():
            before = max(change.start - 1, 0)
            since = self.time[before], before, change.start, _LATER
            powers = _POWERS[change.kind]
            columns += [_Column(p, *since, p > 0 or not change.transducer) for p in powers]
        self.columns = _Column(*map(np.array, zip(*columns, strict=True)))
        self.mean_new = self._rows(self.new).mean(axis=0)
        self.fit.sum_up(self._rows(np.arange(first, last)), first)

    def _rows(self, where: Sequence[int]) -> np.ndarray:
        """Rows of the design of operations, ``(r, p)``."""
        since = self.time[where][:, None] - self.columns.origin
        after = np.asarray(where)[:, None] >= self.columns.first
        rows = np.where(after, since**self.columns.power, 0.0)
        rows[:, self._of_conditions] = self.conditions[where]
        return rows

    def _precision(self, i: int) -> np.ndarray:
        """Prior precisions of the path, ``(k, p)``."""
        power, family = self.columns.power, self.fit.variance[:, None]
        along, aside = self.fit.bends()
        bends = _BEND**2 * along + _ASIDE**2 * aside + 1e-12
        wide = np.where(power == 2, bends[:, None], self.columns.size**2 * family + 1.0)
        wide[:, self._of_conditions] = np.outer(self.fit.variance, np.square(self.effects))
        since = np.maximum(self.time[i] - self.time[self.columns.before], 1e-9)
        return since ** (2 * power) / wide

    def _solve(self, i: int) -> None:
        """Fit the path to the records up to ``i``."""
        self.fit.solve(i, self._precision(i))
        self.fit.change = self.fit.mean @ self._since(i, self.mean_new)

    def _weigh(self, i: int, *, learnt: bool) -> float:
        """Weigh record ``i`` by how far it is from what is expected; nan without one."""
        fit, there = self.fit, self.fit.there[i]
        if not there.any():
            return np.nan
        if not learnt:
            return 1.0
        off = fit.off(self._rows([i]), i, slice(None))[0]
        sought = fit.sought[there[fit.sought]]
        left, count = off[sought], sought.size
        weight = (_TAILS + count) / (_TAILS + float(left @ left))
        self.counted = min(self.counted + 1.0, _MEMORY)
        if count:
            alike = min(max(weight * (left @ fit.last[sought]) / count, -1.0), 1.0)
            self.alike += (alike - self.alike) / self.counted
            colour = min(max(self.alike, 0.0), _ALIKE)
            fit.memory = (1.0 + colour) / (1.0 - colour)
        grown = (np.minimum(weight * np.square(off), _ODD) - 1.0) / self.counted
        fit.noise = fit.noise * np.where(there, 1.0 + grown, 1.0)
        fit.last = np.where(there, np.sqrt(min(weight, 1.0)) * off, fit.last)
        fit.weight[i] = weight
        return weight

    def _watch(self, i: int, full: int) -> float:
        """Look for a change after operation ``i``, or place the last one anew; its evidence."""
        last = self.changes[-1] if self.changes else None
        if last and last.kind != "event" and i <= last.noticed + self.settle:
            self._place(i, full)
            return np.nan
        best = self._seek(i, full)
        if best.evidence > self.threshold and i > full + self.settle:
            self._begin(best, i)
            self._solve(i)
        return best.evidence

    def _begin(self, change: Change, i: int) -> None:
        """Let a change be part of the path from now on."""
        self.changes.append(change)
        self._renew(change.start, i + 1)
        self._solve(i)
        if change.kind == "event":
            return
        # Records after it are weighed anew, by the path that has it.
        after, fit = slice(change.start, i + 1), self.fit
        rows, there = self._rows(np.arange(change.start, i + 1)), fit.there[after, fit.sought]
        square = np.square(fit.off(rows, change.start, fit.sought) * there).sum(axis=1)
        fit.weight[after] = (_TAILS + there.sum(axis=1)) / (_TAILS + square)
        fit.sum_up(rows, change.start)

    def _place(self, i: int, full: int) -> None:
        """Place the last change by all that is known now; take it back if nothing speaks for it."""
        last = self.changes.pop()
        self._renew(last.start, i + 1)
        self._solve(i)
        best = self._seek(i, full, last.start)
        if best.evidence < 0.0:
            self.changes.append(last._replace(evidence=-1.0))
        else:
            self._begin(best._replace(noticed=last.noticed), i)
        self._solve(i)

    def _seek(self, i: int, full: int, near: int | None = None) -> Change:
        """Weigh all changes that may have begun since the last one; of those near one, each.

        The evidence of the best is that for any.
        """
        standing = self._standing()
        first = standing[-1].start + self.settle if standing else max(full, 1)
        if i + 1 - first < _AGE:
            return Change(i, 0, 0, 0, "", -np.inf)
        ages = np.geomspace(_AGE, i + 1 - first, _STARTS).round().astype(int)
        if near is not None:
            ages = np.append(ages, i + 1 - np.arange(near - _NEAR, near + _NEAR + 1))
        ages = np.unique(np.clip(ages, _AGE, i + 1 - first))
        starts = i + 1 - ages
        now, before = self.time[i], self.time[starts - 1]
        columns = np.zeros((2, starts.size, len(self.mean_new)))  # a ramp, and a step
        columns[:, :, 0] = -before / (now - before), np.ones(starts.size)
        columns[0, :, 1] = 1.0 / (now - before)
        ramps, steps = self.fit.explained(starts, i, columns)
        speed = (self.fit.mean @ self._rate(i))[self.fit.sought]
        other = _SIZE**2 * self.fit.variance[self.fit.sought]
        along = np.square(_FASTER * np.outer(now - before, speed))
        sizes = (other, _LARGE**2 * other)
        others = (each.evidence(size) for size in sizes for each in (ramps, steps))
        total = np.stack([ramps.evidence(along), *others])
        gaps = np.gradient(ages.astype(float)) if ages.size > 1 else np.ones(1)
        total += np.log(gaps / (gaps.sum() * len(_SOUGHT)))
        evidence = float(np.logaddexp.reduce(total.ravel()))
        kind, place = np.unravel_index(total.argmax(), total.shape)
        share = np.cumsum(np.exp(total - evidence).sum(axis=0)[::-1])  # from the earliest on
        ends = np.minimum(np.searchsorted(share, (0.05, 0.95)), share.size - 1)
        earliest, latest = starts[::-1][ends].tolist()
        return Change(i, int(starts[place]), earliest, latest, _SOUGHT[kind], evidence)

    def _rate(self, i: int) -> np.ndarray:
        """Row of the design that gives the rate after operation ``i``."""
        since, power = self.time[i] - self.columns.origin, self.columns.power
        return np.where(power == 2, 2.0 * since, power == 1)

    def _since(self, i: int, earlier: np.ndarray) -> np.ndarray:
        """Row of the design for the change since an earlier row, of the drive alone."""
        return self.columns.kept * (self._rows([i])[0] - earlier)

    def _known(self, i: int) -> list[np.ndarray]:
        """What ``Path`` has of operation ``i``, in its order."""
        events = [change.start for change in self._standing() if change.kind == "event"]
        event = self._rows(events[-1:])[0] if events else np.nan
        rows = (self._since(i, self.mean_new), self._since(i, event), self._rate(i) / self.span)
        bend = np.where(self.columns.power == 2, 2.0, 0.0) / self.span**2
        mean, cov = self.fit.about(np.stack([*rows, bend]))
        since_new, since_event, rate, bent = ((mean[:, k], cov[:, k, k]) for k in range(4))
        return [*since_new, *since_event, *rate, cov[:, 0, 2], *bent]


def follow(
    operations: np.ndarray,
    blocks: Sequence[Block],
    *,
    new: np.ndarray,
    settle: int = 50,
    threshold: float = 10.0,
    counted: float = 100.0,
    events: Mapping[int, bool] | None = None,
    conditions: Mapping[str, np.ndarray] | None = None,
) -> Path:
    """Go through a life.

    Args:
        operations: Their numbers, rising, ``(o,)``.
        blocks: Coordinates.
        new: Indices of the operations that are new.
        settle: Operations after these, and after a change, in which none is noticed.
        threshold: Evidence from which a change is noticed, nats.
        counted: Records for which the scatter counts that is known beforehand.
        events: Indices of operations before which the drive was maintained, and whether the
            transducer alone was.
        conditions: "temperature" and "voltage" relative to those of the new operations, in 10 K and
            in 10 % of the voltage, ``(o,)``, as far as they are known.
    """
    found = [(np.nan_to_num(values), _EFFECTS[name]) for name, values in (conditions or {}).items()]
    life = _Life(operations, PathFit(blocks), new, found, settle, threshold, counted)
    return life.followed(events or {})
