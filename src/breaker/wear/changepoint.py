r"""Bayesian online change points of a drive that wears: lines, and a run length that all share.

After Adams & MacKay (2007), "Bayesian online changepoint detection". Wear drifts, so a segment is a
line: the standardised parameters of operation ``o`` are ``a + b o`` plus scatter from operation to
operation, and are observed through ``breaker.model.fisher``. Within a segment all of that is
Gaussian, and its evidence exact. Discrete hypotheses are kept about *when* the segment began, in
what *kind* of change, and how large the scatter is.

Wear changes its rate; the drive does not become new by itself. So a segment continues where the
one before it ended. In a change of one parameter, the slope of that parameter becomes uncertain; in
a change of ``several``, such as a drive that wears faster at once, every slope does; in a change of
``all``, which a repair is, every level and slope. A new segment starts from those of the likeliest
kind, as one Gaussian of their mean and covariance: one of all would be wide where a change is
suspected, so that a later change could stand for it, too.

One pass over the operations, and bounded memory: hypotheses that began about as long ago (within
a fifth of their age) become one, of their mean and covariance, which for the start is its mean and
variance; the hopeless are dropped.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from breaker.mechanism import NAMES
from breaker.wear.hypotheses import FIRST, Hypotheses, merged
from breaker.wear.lines import evidence, thin, update

__all__ = ["KINDS", "PER", "Tracker"]

KINDS = (*NAMES, "several", "all")
"""Kinds of change of a drive: of the slope of one parameter, of every slope, of everything."""

PER = 1000.0
"""Operations in the unit of slopes."""

_RARE = 1e-6  # least weight of a scatter, so that it can become likely again
_SURELY = np.nextafter(1.0, 0.0)  # largest probability of a change in a gap, however long
_HOPELESS = 25.0  # log weight below the best one from which a hypothesis is dropped,
_YOUNG = 50.0  # unless it is of that age or less, operations


@dataclass(frozen=True, eq=False)
class Tracker:
    """The model of wear, and its step from one operation to the next.

    >>> tracker = Tracker(np.full(7, 0.1), 1e-3, 2.0, 0.05, np.array([0.001, 0.01]), 0.0, 0.2, 0.2)
    >>> before = tracker.predict(tracker.begin(1), 2)
    >>> seen = 1e4 * np.eye(7)  # information of an operation that sees each level with an sd 0.01,
    >>> after, _, _ = tracker.learn(before, seen, np.zeros(7), np.full(7, 0.5))  # all at 0.5
    >>> float(after.level()[0][0].round(2))
    0.5

    Attributes:
        log_sds: Standard deviations of the log parameters under the prior, ``(p,)``: they may be
            those of a drive, or any other positive quantities that are followed together.
        hazard: Probability of a change from one operation to the next.
        slope_sd: Prior sd of a slope, in sds of the prior per thousand operations.
        step_sd: sd of the jump of a level where everything changes, share of the parameter.
        scatters: Candidates of the scatter from operation to operation, shares, ``(k,)``.
        outliers: Probability that an operation is an outlier, from which nothing is learnt.
        whole: Probability that a change is of the kind ``all``,
        several: and that it is of the kind ``several``.
        bend: sd of the gradual change of a slope in a thousand operations, share of the slope.
    """

    log_sds: np.ndarray
    hazard: float
    slope_sd: float
    step_sd: float
    scatters: np.ndarray
    outliers: float
    whole: float
    several: float
    bend: float = 0.0

    @classmethod
    def from_settings(cls, settings: Mapping, log_sds: np.ndarray) -> "Tracker":
        """Build from the section ``wear_model`` of the configuration, whose shares are percent."""
        return cls(
            log_sds=np.asarray(log_sds, dtype=np.float64),
            hazard=1.0 / settings["operations_between_changes"],
            slope_sd=settings["slope_sd"],
            step_sd=settings["step_sd"] / 100.0,
            scatters=np.array(settings["scatters"]) / 100.0,
            outliers=settings["outliers"],
            whole=settings["whole"],
            several=settings["several"],
        )

    @property
    def size(self) -> int:
        """Number p of the parameters."""
        return len(self.log_sds)

    def begin(self, operation: int, passes: np.ndarray | float = 0.0) -> Hypotheses:
        """Return the hypotheses before the first operation: the prior of levels and slopes.

        Args:
            passes: Covariance of what passes for levels and is none, ``(p, p)``.
        """
        p, k = self.size, len(self.scatters)
        variance = np.append(np.ones(p), np.full(p, np.square(self.slope_sd)))
        prior = np.diag(variance)
        prior[:p, :p] += passes
        return Hypotheses(
            operation=operation,
            log_weight=np.full(k, -np.log(k)),
            mean=np.zeros((k, 2 * p)),
            cov=np.tile(prior, (k, 1, 1)),
            start=np.full(k, float(operation)),
            kind=np.full(k, FIRST),
            scatter=np.arange(k),
            start_variance=np.zeros(k),
        )

    def predict(self, hypotheses: Hypotheses, operation: int) -> Hypotheses:
        """Return the hypotheses at a later operation, before anything of it is seen.

        A change may have happened after the last operation that was seen.
        """
        gap = operation - hypotheses.operation
        if gap <= 0:
            return hypotheses
        hazard = -np.expm1(gap * np.log1p(-self.hazard)) if self.hazard else 0.0
        hazard = min(hazard, _SURELY)
        grown = self._with_changes(hypotheses, hazard) if hazard else hypotheses
        p, way = self.size, gap / PER
        mean, cov = grown.mean.copy(), grown.cov.copy()
        slopes = np.arange(p, 2 * p)
        mean[:, :p] += way * mean[:, slopes]
        cov[:, :p] += way * cov[:, slopes]
        cov[:, :, :p] += way * cov[:, :, slopes]
        if self.bend:
            cov[:, slopes, slopes] += way * np.square(self.bend * mean[:, slopes])
        return replace(grown, operation=operation, mean=mean, cov=cov)

    def _unknown(self, size: int) -> np.ndarray:
        """Covariance that a change of each kind adds to a state, ``(kind, size, size)``."""
        p = self.size
        added = np.zeros((p + 2, size, size))
        one = np.arange(p)
        added[one, p + one, p + one] = added[p:, p + one, p + one] = np.square(self.slope_sd)
        added[p + 1, one, one] = np.square(self.step_sd / self.log_sds)
        return added

    @cached_property
    def shares(self) -> np.ndarray:
        """Probability of each kind of change, ``(kind,)``."""
        one = (1.0 - self.several - self.whole) / self.size
        return np.array([*[one] * self.size, self.several, self.whole])

    def _with_changes(self, old: Hypotheses, hazard: float) -> Hypotheses:
        """Add the segments that may begin after the last operation, and thin out the old."""
        n = len(self.shares)
        log_odds = np.log(hazard) + np.log(self.shares)
        begun = []
        for scatter in np.unique(old.scatter):
            mine = old.of(old.scatter == scatter)
            mean, cov = mine.of(mine.kind == mine.likeliest()).level()
            log_weight = np.log(mine.weight.sum()) + log_odds
            cov = cov + self._unknown(len(cov))
            when = np.full(n, float(old.operation)), np.arange(n), np.full(n, scatter), np.zeros(n)
            begun.append(Hypotheses(old.operation, log_weight, np.tile(mean, (n, 1)), cov, *when))
        stays = replace(old, log_weight=old.log_weight + np.log1p(-hazard))
        every = stays.with_others(begun)
        return every.of(thin(*every._fields(), float(old.operation), _HOPELESS, _YOUNG))

    def learn(
        self, predicted: Hypotheses, matrix: np.ndarray, slope: np.ndarray, centre: np.ndarray
    ) -> tuple[Hypotheses, float, float]:
        """Learn from an operation.

        Args:
            predicted: What ``predict`` returns for it.
            matrix, slope: Its information about standardised parameters, ``(p, p)`` and ``(p,)``,
            centre: and where that is taken, ``(p,)``.

        Returns:
            The hypotheses after it, the log evidence of the operation, up to a constant of its
            own, and the probability that it is an outlier.
        """
        p, group = self.size, predicted.scatter
        mean, cov = predicted.mean.copy(), predicted.cov.copy()
        mean[:, :p] -= centre
        log_out = self._outlier(replace(predicted, mean=mean), matrix, slope)
        weights, slopes, base = self._scattered(matrix, slope, self.scatters)
        base = base + np.log1p(-self.outliers)
        log_in = update(mean, cov, group, weights, slopes, base, log_out)
        mean[:, :p] += centre
        log_weight = predicted.log_weight + np.logaddexp(log_in, log_out[group])
        total = np.logaddexp.reduce(log_weight)
        share = np.exp(np.logaddexp.reduce(predicted.log_weight + log_out[group]) - total)
        log_weight = self._floored(log_weight - total, group)
        learnt = replace(predicted, log_weight=log_weight, mean=mean, cov=cov)
        return learnt, float(total), float(share)

    def _outlier(self, shifted: Hypotheses, matrix: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """Log probability of an outlier and of what was seen of it, for each scatter, ``(k,)``.

        An outlier scatters by as much as a level may jump. Means are relative to where the
        information is taken.
        """
        p, k = self.size, len(self.scatters)
        result = np.full(k, -np.inf)
        if not self.outliers:
            return result
        wide = np.full(k, np.hypot(self.scatters.max(), self.step_sd))
        weights, slopes, base = self._scattered(matrix, slope, wide)
        for q in np.unique(shifted.scatter):
            mine = shifted.scatter == q
            mean, cov = merged(shifted.weight[mine], shifted.mean[mine], shifted.cov[mine])
            result[q] = base[q] + evidence(mean[:p], cov[:p, :p], weights[q], slopes[q])
        return result + np.log(self.outliers)

    def _scattered(
        self, matrix: np.ndarray, slope: np.ndarray, scatters: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Integrate the scatter of an operation, for each candidate.

        Returns:
            Information about the line ``(k, p, p)`` and ``(k, p)``, and a constant ``(k,)``.
        """
        variance = np.square(scatters[:, None] / self.log_sds)  # (k, p), of standardised parameters
        spread = np.eye(len(slope)) + matrix * variance[:, None, :]  # I + J Q
        weights = np.linalg.solve(spread, np.broadcast_to(matrix, spread.shape))
        slopes = np.broadcast_to(slope, spread.shape[:2])[..., None]
        slopes = np.linalg.solve(spread, slopes)[..., 0]
        gain = 0.5 * np.einsum("ki,i,ki->k", variance, slope, slopes)
        return weights, slopes, gain - 0.5 * np.linalg.slogdet(spread)[1]

    def _floored(self, log_weight: np.ndarray, scatter: np.ndarray) -> np.ndarray:
        """Keep every scatter possible at a small weight, and normalise."""
        totals = np.full(len(self.scatters), -np.inf)
        np.logaddexp.at(totals, scatter, log_weight)
        log_weight = log_weight + (np.maximum(totals, np.log(_RARE)) - totals)[scatter]
        return log_weight - np.logaddexp.reduce(log_weight)
