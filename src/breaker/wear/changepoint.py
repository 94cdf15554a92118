r"""Bayesian online change points of a drive that wears: lines, and a run length that all share.

After Adams & MacKay (2007), "Bayesian online changepoint detection". Wear drifts, so a segment is a
line: the standardised parameters of operation ``o`` are ``a + b o`` plus scatter from operation to
operation, and are observed through ``breaker.model.fisher``. Within a segment all
of that is Gaussian, and its evidence exact. What is discrete is kept as hypotheses: *when* the
segment began, in what *kind* of change, and how large the scatter is.

Wear changes its rate, the drive does not jump back to new. So a segment goes on where the one
before it ended: in a change of a kind that is named by a parameter, what is known of its slope
widens; in one of the kind ``all``, which also is that of a repair, of every level and slope. A new
segment starts from all hypotheses it may follow, as one Gaussian of their mean and covariance.

One pass over the operations, and bounded memory: hypotheses that began about as long ago (within
a fifth of their age) become one, of their mean and covariance, and the hopeless are dropped.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from breaker.mechanism import NAMES
from breaker.wear.lines import evidence, thin, update

__all__ = ["KINDS", "Hypotheses", "Tracker"]

KINDS = (*NAMES, "all")
"""Kinds of change: of the slope of one parameter, or of everything."""

_FIRST = -1  # kind of the first segment, which no change began
_PER = 1000.0  # operations in the unit of slopes
_RARE = 1e-6  # least weight of a scatter: it may change, and then has to come back
_HOPELESS = 25.0  # log weight below the best one from which a hypothesis is dropped,
_YOUNG = 50.0  # unless it is of that age or less, operations


@dataclass(frozen=True)
class Hypotheses:
    """Hypotheses ``(h,)`` about the current segment, after an operation.

    Attributes:
        operation: Number of the operation.
        log_weight: Log probability of each, ``(h,)``.
        mean: Of level now and slope a thousand operations, standardised, ``(h, 2 p)``.
        cov: Their covariance, ``(h, 2 p, 2 p)``.
        start: Operation after which the segment began, ``(h,)``.
        kind: Kind of the change that began it, index into ``KINDS``, -1 for the first, ``(h,)``.
        scatter: Index of the scatter, ``(h,)``.
    """

    operation: int
    log_weight: np.ndarray
    mean: np.ndarray
    cov: np.ndarray
    start: np.ndarray
    kind: np.ndarray
    scatter: np.ndarray

    @property
    def weight(self) -> np.ndarray:
        """Probability of each hypothesis, ``(h,)``."""
        return np.exp(self.log_weight)

    def level(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean ``(2 p,)`` and covariance ``(2 p, 2 p)`` of all hypotheses together."""
        return _merged(self.weight, self.mean, self.cov)

    def began_after(self, operation: float) -> float:
        """Return the probability that the segment began after an operation."""
        return float(self.weight[self.start > operation].sum())


def _merged(weight: np.ndarray, mean: np.ndarray, cov: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    share = weight / weight.sum()
    centre = share @ mean
    apart = mean - centre
    return centre, np.tensordot(share, cov, 1) + (share[:, None] * apart).T @ apart


@dataclass(frozen=True, eq=False)
class Tracker:
    """The model of wear, and its one step.

    Attributes:
        log_sds: Standard deviations of the log parameters under the prior, ``(p,)``.
        hazard: Probability of a change from one operation to the next.
        slope_sd: Of a slope before it is known, in sds of the prior, a thousand operations.
        step_sd: Of the jump of a level where everything changes, share of the parameter.
        scatters: Candidates of the scatter from operation to operation, shares, ``(k,)``.
        outliers: Probability that an operation is an outlier, of which nothing is learnt.
        whole: Probability that a change is of the kind ``all``.
    """

    log_sds: np.ndarray
    hazard: float
    slope_sd: float
    step_sd: float
    scatters: np.ndarray
    outliers: float
    whole: float

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
        )

    def begin(self, operation: int) -> Hypotheses:
        """Return what is held before the first operation: the prior, and any slope."""
        p, k = len(NAMES), len(self.scatters)
        variance = np.append(np.ones(p), np.full(p, np.square(self.slope_sd)))
        return Hypotheses(
            operation=operation,
            log_weight=np.full(k, -np.log(k)),
            mean=np.zeros((k, 2 * p)),
            cov=np.tile(np.diag(variance), (k, 1, 1)),
            start=np.full(k, operation),
            kind=np.full(k, _FIRST),
            scatter=np.arange(k),
        )

    def predict(self, hypotheses: Hypotheses, operation: int) -> Hypotheses:
        """Go on to a later operation, before anything of it is seen.

        Changes are possible after every operation that was seen.
        """
        gap = operation - hypotheses.operation
        if gap <= 0:
            return hypotheses
        hazard = -np.expm1(gap * np.log1p(-self.hazard)) if self.hazard else 0.0
        grown = self._with_changes(hypotheses, hazard) if hazard else hypotheses
        p, way = len(NAMES), gap / _PER
        mean, cov = grown.mean.copy(), grown.cov.copy()
        mean[:, :p] += way * mean[:, p:]
        cov[:, :p] += way * cov[:, p:]
        cov[:, :, :p] += way * cov[:, :, p:]
        return replace(grown, operation=operation, mean=mean, cov=cov)

    def _with_changes(self, hypotheses: Hypotheses, hazard: float) -> Hypotheses:
        """Add the hypotheses that may begin after the last operation, and thin out the old."""
        p, n = len(NAMES), len(KINDS)
        odds = np.append(np.full(p, (1.0 - self.whole) / p), self.whole)
        log_odds = np.log(hazard) + np.log(odds)
        new = np.zeros((n, 2 * p, 2 * p))  # what becomes unknown in a change of each kind
        one = np.arange(p)
        new[one, p + one, p + one] = new[p, p + one, p + one] = np.square(self.slope_sd)
        new[p, one, one] = np.square(self.step_sd / self.log_sds)
        h = hypotheses
        stays = h.log_weight + np.log1p(-hazard)
        parts = [(stays, h.mean, h.cov, h.start, h.kind, h.scatter)]
        for scatter in np.unique(hypotheses.scatter):
            mine = hypotheses.scatter == scatter
            weight = hypotheses.weight[mine]
            mean, cov = _merged(weight, hypotheses.mean[mine], hypotheses.cov[mine])
            children = cov + new
            whole = (np.full(n, hypotheses.operation), np.arange(n), np.full(n, scatter))
            parts.append((np.log(weight.sum()) + log_odds, np.tile(mean, (n, 1)), children, *whole))
        log_weight, mean, cov, start, kind, scatter = map(np.concatenate, zip(*parts, strict=True))
        order = np.lexsort((start, kind, scatter))
        sorted_ = [each[order] for each in (log_weight, mean, cov, start, kind, scatter)]
        kept = thin(*sorted_, float(hypotheses.operation), _HOPELESS, _YOUNG)
        return Hypotheses(hypotheses.operation, *(each[kept] for each in sorted_))

    def learn(
        self, predicted: Hypotheses, matrix: np.ndarray, slope: np.ndarray, centre: np.ndarray
    ) -> tuple[Hypotheses, float, float]:
        """Learn from an operation.

        Args:
            predicted: What ``predict`` returns for it.
            matrix, slope: Its information about standardised parameters, ``(p, p)`` and ``(p,)``,
            centre: at these, ``(p,)``.

        Returns:
            The hypotheses after it, the log evidence of the operation, up to a constant of its
            own, and the probability that it is an outlier.
        """
        p = len(NAMES)
        weights, slopes, base = self._scattered(matrix, slope, self.scatters)
        wide = np.full(len(self.scatters), np.hypot(self.scatters.max(), self.step_sd))
        mean = predicted.mean.copy()
        mean[:, :p] -= centre
        log_out = np.full(len(self.scatters), -np.inf)
        if self.outliers:
            w_out, s_out, b_out = self._scattered(matrix, slope, wide)
            for q in np.unique(predicted.scatter):
                mine = predicted.scatter == q
                one = _merged(predicted.weight[mine], mean[mine], predicted.cov[mine])
                log_out[q] = b_out[q] + evidence(one[0][:p], one[1][:p, :p], w_out[q], s_out[q])
        cov = predicted.cov.copy()
        log_out += np.log(self.outliers) if self.outliers else 0.0
        log_in = update(
            mean,
            cov,
            predicted.scatter,
            *(weights, slopes, base + np.log1p(-self.outliers), log_out),
        )
        mean[:, :p] += centre
        log_weight = predicted.log_weight + np.logaddexp(log_in, log_out[predicted.scatter])
        total = np.logaddexp.reduce(log_weight)
        share = float(
            np.exp(np.logaddexp.reduce(predicted.log_weight + log_out[predicted.scatter]) - total)
        )
        log_weight = self._floored(log_weight - total, predicted.scatter)
        return replace(predicted, log_weight=log_weight, mean=mean, cov=cov), float(total), share

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
        slopes = np.linalg.solve(spread, np.broadcast_to(slope, spread.shape[:2])[..., None])[
            ..., 0
        ]
        gain = 0.5 * np.einsum("ki,i,ki->k", variance, slope, slopes)
        return weights, slopes, gain - 0.5 * np.linalg.slogdet(spread)[1]

    def _floored(self, log_weight: np.ndarray, scatter: np.ndarray) -> np.ndarray:
        """Keep every scatter possible, for it may change."""
        totals = np.full(len(self.scatters), -np.inf)
        np.logaddexp.at(totals, scatter, log_weight)
        log_weight = log_weight + (np.maximum(totals, np.log(_RARE)) - totals)[scatter]
        return log_weight - np.logaddexp.reduce(log_weight)
