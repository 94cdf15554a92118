"""A life on the way: records come, the path is fitted, changes are noticed and placed."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from breaker.wear.fit import Fit
from breaker.wear.path import Change, Path

if TYPE_CHECKING:
    from breaker.wear.tracker import Tracker

__all__ = ["Life"]

_LEVEL, _RATE, _LATER = 100.0, 10.0, 30.0  # prior sds, in changes of the family: none is known
_STARTS = 40  # of changes that are weighed, closer together the later they are
_NEAR = 8  # records about the last place of a change, where each is weighed
_AGE = 2  # records that a change needs: one may be an outlier
_MEMORY = 300.0  # records, over which the size of the scatter is followed
_ODD = 9.0  # square of a record's coordinate, in variances, as which a larger one counts in it
_ALIKE = 0.9  # largest correlation of neighbouring records
_FIRST = 100.0  # records that the scatter of the reference counts for in this
_BASE = 3  # columns of the design: level, rate, curvature
_SOUGHT = ("rate", "rate", "step", "rate", "step")
_LARGE = 30.0  # size of a large change, over that of another


class _Best(NamedTuple):
    """The best of the changes that are sought, and how sure it is that there is one."""

    evidence: float
    start: int = 0
    earliest: int = 0
    latest: int = 0
    kind: str = ""


class Life:
    """A life of a drive, followed by a tracker; arguments as of ``Tracker.follow``."""

    def __init__(
        self,
        tracker: "Tracker",
        operations: np.ndarray,
        fit: Fit,
        new: np.ndarray | None,
        temperature: np.ndarray | None,
    ) -> None:
        self.tracker, self.fit = tracker, fit
        some = fit.seen.any(axis=1)
        self.new = np.flatnonzero(some)[: tracker.reference] if new is None else new
        where = np.asarray(operations, dtype=float)
        self.span = max(float(np.ptp(where[self.new])), 1.0)
        self.time = (where - where[self.new].mean()) / self.span
        self.warm = None if temperature is None else np.nan_to_num(temperature)
        self.changes: list[Change] = []
        self.counted, self.alike = _FIRST, 0.0
        self._renew(0)

    def followed(self, events: Mapping[int, bool]) -> Path:
        """Go through all operations, with events as of ``Tracker.follow``."""
        n, full = len(self.time), int(self.new[-1])
        known = np.full((n, 7, self.fit.variance.size), np.nan)
        evidence, weight = np.full((2, n), np.nan)
        for i in range(n):
            if i in events and i > full:
                self._begin(Change(i, i, i, i, "event", np.inf, events[i]), i - 1)
            weight[i] = self._weigh(i, learnt=i > full)
            self.fit.add(self.design[i], i)
            if i < full:
                continue
            self._solve(i)
            if i > full:
                evidence[i] = self._watch(i, full)
            known[i] = self._known(i)
        return Path(*known.swapaxes(0, 1), evidence, weight, tuple(self.changes))

    def _design(self) -> np.ndarray:
        """Columns of the path: level, rate, curvature, temperature, and those of changes."""
        columns = [np.ones_like(self.time), self.time, np.square(self.time)]
        if self.warm is not None:
            columns.append(self.warm)
        for change in self._standing():
            after = np.arange(self.time.size) >= change.start
            since = np.where(after, self.time - self.time[max(change.start - 1, 0)], 0.0)
            columns += self._columns(change, after, since, np.square(since))
        return np.stack(columns, axis=1).astype(float)

    @staticmethod
    def _columns(change: Change, step, rate, bend) -> list:
        """Columns that a kind of change has, of a step, a rate and a curvature."""
        kinds = {"step": [step], "event": [step, rate, bend]}
        return kinds.get(change.kind, [rate, bend])

    def _standing(self) -> list[Change]:
        """Changes that were not taken back."""
        return [change for change in self.changes if change.evidence >= 0.0]

    def _renew(self, last: int) -> None:
        """Make the design anew, and add up the records before ``last``."""
        self.design = self._design()
        self.fit.sum_up(self.design, last)

    def _precision(self, i: int) -> np.ndarray:
        """Prior precisions of the path, ``(k, p)``."""
        family, past = self.fit.variance, max(self.time[i] - self.time[0], 1e-9)
        along, aside = self.fit.bends()
        bends = self.tracker.bend**2 * along + self.tracker.aside**2 * aside + 1e-12
        columns = [
            np.square(_LEVEL) * family + 1.0,
            (np.square(_RATE) * family + 1.0) / past**2,
            bends / past**4,
        ]
        if self.warm is not None:
            columns.append(np.square(self.tracker.warmth) * family)
        later = np.square(_LATER) * family + 1.0
        for change in self._standing():
            since = max(self.time[i] - self.time[max(change.start - 1, 0)], 1e-9)
            columns += self._columns(change, later, later / since**2, bends / since**4)
        return 1.0 / np.stack(columns, axis=1)

    def _solve(self, i: int) -> None:
        """Fit the path to the records up to ``i``."""
        self.fit.solve(i, self._precision(i))
        self.fit.change = self.fit.mean @ self._since_new(i)

    def _weigh(self, i: int, *, learnt: bool) -> float:
        """Weigh record ``i`` by how far it is from what is expected; nan without one."""
        fit, there = self.fit, self.fit.there[i]
        if not there.any():
            return np.nan
        if not learnt:
            return 1.0
        off = fit.off(self.design, slice(i, i + 1), slice(None))[0]
        sought = fit.sought[there[fit.sought]]
        left, count = off[sought], sought.size
        weight = (self.tracker.tails + count) / (self.tracker.tails + float(left @ left))
        self.counted = min(self.counted + 1.0, _MEMORY)
        if count:
            alike = float(np.clip(weight * (left @ fit.last[sought]) / count, -1.0, 1.0))
            self.alike += (alike - self.alike) / self.counted
            colour = float(np.clip(self.alike, 0.0, _ALIKE))
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
        best = self._seek(i, self._first(full))
        if best.evidence > self.tracker.threshold and i > full + self.tracker.settle:
            self._begin(Change(i, **best._asdict()), i)
            self._solve(i)
        return best.evidence

    def _first(self, full: int) -> int:
        """Index of the first record after which a change may be."""
        standing = self._standing()
        return standing[-1].start + self.tracker.settle if standing else full

    def _begin(self, change: Change, i: int) -> None:
        """Let a change be part of the path from now on."""
        self.changes.append(change)
        self._renew(i + 1)
        self._solve(i)
        if change.kind != "event":
            self._reweigh(change.start, i)

    def _reweigh(self, start: int, i: int) -> None:
        """Weigh the records after a change by the path that has it."""
        rows, fit = slice(start, i + 1), self.fit
        there = fit.there[rows, fit.sought]
        square = np.square(fit.off(self.design, rows, fit.sought) * there).sum(axis=1)
        tails = self.tracker.tails
        fit.weight[rows] = (tails + there.sum(axis=1)) / (tails + square)
        fit.sum_up(self.design, i + 1)

    def _place(self, i: int, full: int) -> None:
        """Place the last change by all that is known now; take it back if nothing speaks for it."""
        last = self.changes.pop()
        self._renew(i + 1)
        self._solve(i)
        best = self._seek(i, self._first(full), last.start)
        if best.evidence < 0.0 or not best.kind:
            self.changes.append(last._replace(evidence=-1.0))
            self._renew(i + 1)
        else:
            self._begin(last._replace(**best._asdict()), i)
        self._solve(i)

    def _seek(self, i: int, first: int, near: int | None = None) -> _Best:
        """Weigh all changes that may have begun since ``first``; of those near one, each."""
        if i + 1 - first < _AGE:
            return _Best(-np.inf)
        ages = np.geomspace(_AGE, i + 1 - first, _STARTS).round().astype(int)
        if near is not None:
            ages = np.append(ages, i + 1 - np.arange(near - _NEAR, near + _NEAR + 1))
        ages = np.unique(np.clip(ages, _AGE, i + 1 - first))
        starts = i + 1 - ages
        now, before = self.time[i], self.time[starts - 1]
        step, ramp = np.zeros((2, starts.size, self.design.shape[1]))
        step[:, 0] = 1.0
        ramp[:, 0], ramp[:, 1] = -before / (now - before), 1.0 / (now - before)
        ramps, steps = (self.fit.explained(starts, i, each) for each in (ramp, step))
        speed = (self.fit.mean @ self._rate(i))[self.fit.sought]
        other = np.square(self.tracker.size) * self.fit.variance[self.fit.sought]
        total = np.stack(
            [
                ramps.evidence(np.square(self.tracker.faster * np.outer(now - before, speed))),
                *(e.evidence(size) for size in (other, _LARGE**2 * other) for e in (ramps, steps)),
            ]
        )
        gaps = np.gradient(ages.astype(float)) if ages.size > 1 else np.ones(1)
        total += np.log(gaps / (gaps.sum() * len(_SOUGHT)))
        evidence = float(np.logaddexp.reduce(total.ravel()))
        kind, place = np.unravel_index(total.argmax(), total.shape)
        share = np.cumsum(np.exp(total - evidence).sum(axis=0)[::-1])  # from the earliest on
        low, high = (
            int(starts[::-1][min((share < level).sum(), share.size - 1)]) for level in (0.05, 0.95)
        )
        return _Best(evidence, int(starts[place]), low, high, _SOUGHT[kind])

    def _rate(self, i: int) -> np.ndarray:
        """Row of the design that gives the rate after operation ``i``."""
        row = np.zeros(self.design.shape[1])
        row[1], row[2] = 1.0, 2.0 * self.time[i]
        found = [0.0] * (self.warm is not None)
        for change in self._standing():
            since = self.time[i] - self.time[max(change.start - 1, 0)]
            found += self._columns(change, 0.0, 1.0, 2.0 * since)
        row[_BASE:] = found
        return row

    def _since_new(self, i: int) -> np.ndarray:
        """Row of the design that gives the change since new; what a transducer moved is none."""
        row = self.design[i] - self.design[self.new].mean(axis=0)
        return self._cleared(row)

    def _cleared(self, row: np.ndarray) -> np.ndarray:
        """Return a row without temperature and transducers."""
        kept = [0.0] * (self.warm is not None)
        for change in self._standing():
            kept += self._columns(change, float(not change.transducer), 1.0, 1.0)
        row[_BASE:] *= kept
        return row

    def _known(self, i: int) -> list[np.ndarray]:
        """What ``Path`` has of operation ``i``, in its order."""
        row, rate = self._since_new(i), self._rate(i) / self.span
        events = [change for change in self._standing() if change.kind == "event"]
        after = self.design[i] - self.design[events[-1].start] if events else np.nan * row
        mean, cov = self.fit.about(np.stack([row, self._cleared(after), rate]))
        pairs = [each for k in range(3) for each in (mean[:, k], cov[:, k, k])]
        return [*pairs, cov[:, 0, 2]]
