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
from typing import NamedTuple, Self

import numpy as np

from breaker.prognosis.path_fit import Block, Change, Path, PathFit

_LEVEL, _RATE, _LATER = 100.0, 10.0, 30.0  # prior sds, in changes of the family: none is known
_STARTS = 40  # of changes that are weighed, closer together the later they are
_NEAR = 8  # records about the last place of a change, where each is weighed
_AGE = 2  # records that a change needs: one may be an outlier
_MEMORY = 300.0  # records, over which the size of the scatter is followed
_ODD = 9.0  # square of a record's coordinate, in variances, as which a larger one counts in it
_ALIKE = 0.9  # largest correlation of neighbouring records
_FIRST = 100.0  # records that the scatter of the reference counts for in this
_SOUGHT = ("rate", "rate", "step", "rate", "step")
_LARGE = 30.0  # size of a large change, over that of another
_BASE = 3  # columns that any design has; the next is those of conditions
_POWERS = {"rate": (1, 2), "step": (0,), "event": (0, 1, 2)}  # of time, by kind of change


class _Column(NamedTuple):
    """A column of the design: a power of the time since a change, or since the drive was new."""

    power: int
    origin: float
    before: int = 0
    first: int = 0
    size: float = 0.0
    kept: bool = True


class _Life:
    """A life of a drive, followed by a tracker; arguments as of ``Tracker.follow``."""

    def __init__(
        self,
        tracker: "Tracker",
        operations: np.ndarray,
        fit: PathFit,
        new: np.ndarray | None,
        conditions: Sequence[tuple[np.ndarray, float]],
    ) -> None:
        self.tracker, self.fit = tracker, fit
        some = fit.seen.any(axis=1)
        self.new = np.flatnonzero(some)[: tracker.reference] if new is None else new
        where = np.asarray(operations, dtype=float)
        self.span = max(float(np.ptp(where[self.new])), 1.0)
        self.time = (where - where[self.new].mean()) / self.span
        known = [np.nan_to_num(values) for values, _ in conditions]
        self.conditions = np.array(known).T.reshape(len(self.time), len(known))
        self.effects = np.array([effect for _, effect in conditions])
        self.changes: list[Change] = []
        self.counted, self.alike = _FIRST, 0.0
        n = len(self.time)
        self.known = np.full((n, 9, fit.variance.size), np.nan)
        self.evidence, self.weight = np.full((2, n), np.nan)
        self._renew(0, 0)

    def followed(self, events: Mapping[int, bool]) -> Path:
        """Go through all operations, with events as of ``Tracker.follow``."""
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
        bends = self.tracker.bend**2 * along + self.tracker.aside**2 * aside + 1e-12
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
        weight = (self.tracker.tails + count) / (self.tracker.tails + float(left @ left))
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
        if last and last.kind != "event" and i <= last.noticed + self.tracker.settle:
            self._place(i, full)
            return np.nan
        best = self._seek(i, full)
        if best.evidence > self.tracker.threshold and i > full + self.tracker.settle:
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
        after, fit, tails = slice(change.start, i + 1), self.fit, self.tracker.tails
        rows, there = self._rows(np.arange(change.start, i + 1)), fit.there[after, fit.sought]
        square = np.square(fit.off(rows, change.start, fit.sought) * there).sum(axis=1)
        fit.weight[after] = (tails + there.sum(axis=1)) / (tails + square)
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
        first = standing[-1].start + self.tracker.settle if standing else full
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
        other = np.square(self.tracker.size) * self.fit.variance[self.fit.sought]
        along = np.square(self.tracker.faster * np.outer(now - before, speed))
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


@dataclass(frozen=True)
class Tracker:
    """How lives are followed.

    Attributes:
        reference: Records that are "new".
        settle: Records after these, and after a change, in which none is noticed.
        threshold: Evidence from which a change is noticed, nats.
        bend: Prior sd of the curvature over the life so far: along the change, share of it,
        aside: and across it.
        faster: Prior sd of the change of a rate, in rates.
        size: Prior sd of another change, in changes of the family.
        tails: Degrees of freedom of the scatter.
        warmth, voltage: Prior sds of the effect of 10 K, and of 10 % of the control voltage, in
            changes of the family.
    """

    reference: int = 50
    settle: int = 50
    threshold: float = 10.0
    bend: float = 0.2
    aside: float = 0.2
    faster: float = 3.0
    size: float = 0.03
    tails: float = 100.0
    warmth: float = 0.1
    voltage: float = 0.1

    @classmethod
    def from_settings(cls, settings: Mapping) -> Self:
        """Build from the section ``trend`` of the configuration."""
        return cls(settings["reference"], settings["settle"], settings["threshold"])

    def follow(
        self,
        operations: np.ndarray,
        blocks: Sequence[Block],
        *,
        new: np.ndarray | None = None,
        events: Mapping[int, bool] | None = None,
        conditions: Mapping[str, np.ndarray] | None = None,
    ) -> Path:
        """Go through a life.

        Args:
            operations: Their numbers, rising, ``(o,)``.
            blocks: Coordinates.
            new: Indices of the operations that are new; the first that have a record if None.
            events: Indices of operations before which work was done, and whether on the transducer
                alone.
            conditions: "temperature" and "voltage" beside those of the reference, in 10 K and in
                10 % of the voltage, ``(o,)``, as far as they are known.
        """
        found = [
            (values, {"temperature": self.warmth, "voltage": self.voltage}[name])
            for name, values in (conditions or {}).items()
        ]
        return _Life(self, operations, PathFit(blocks), new, found).followed(events or {})
