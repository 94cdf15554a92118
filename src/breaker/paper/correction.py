"""Correction of a network's draws to the exact posterior of a record (not in the paper).

The likelihood of the paper's drive is tractable (``joint_model``), so adaptive importance sampling
reaches the exact posterior without the network's density (Cornuet et al., 2012, "Adaptive multiple
importance sampling"). A map is fitted to the network's draws. Draws from the map get weights: the
exact joint density over the mixture of all maps so far. The map is fitted again, until the
efficiency of a round is good. If the effective size is too small for a fit, the weights are
tempered: raised to the largest power below one that gives this size. New draws from the last map,
weighted by the density of this map only, are the result, so that their weights do not depend on the
fit. A record whose weights stay poor is *unresolved*. ``judge`` measures the divergence of a
network from the exact posterior.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import lgamma, log, pi
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np
import xarray as xr
from scipy.linalg import solve_triangular
from scipy.optimize import brentq
from scipy.special import logsumexp, softmax
from tqdm import tqdm

from breaker.common.randomness import generator, systematic
from breaker.paper.joint_model import Model

if TYPE_CHECKING:  # corrections need only a model, and do not load torch
    from breaker.paper.posterior import Posterior

_SMALLEST_SIZE = 400  # effective size of the result; sets the error of means to 5 % of a sd
_LARGEST_K = 0.7  # limit of reliable importance sampling (Vehtari et al., 2024)
_EFFICIENCY = 0.4  # of the last round: twice the 400 of 2000 draws that the result needs
_ROUND_DRAWS = 500  # draws of a round: five times the effective size that a fit needs
_RESULT_DRAWS = 2000  # draws of the result, whose weights are checked
_FIT_SIZE = 100  # effective size for a fit: three times the coefficients of its last coordinate
_FREEDOM = 5.0  # degrees of freedom of the Student-t: heavy tails cover what a fit has missed
_RIDGE = {"linear": 2.0, "quadratic": 8.0}  # weight of the coefficients' prior, in draws


# ---- importance weights --------------------------------------------------------------------------


@dataclass(frozen=True)
class Importance:
    """Summary of the importance weights of one record.

    Attributes:
        log_weights: Normalised so that their exponentials sum to 1, ``(d,)``.
        size: Effective sample size.
        log_evidence: Log of the probability density of the record, with a standard error of about
            ``sqrt(1 / size - 1 / d)``.
        gap: Divergence ``KL(p | q)``, nats.
        faulty: Number of weights that are nan or infinite; if any, the other attributes are nan.
    """

    log_weights: np.ndarray
    size: float
    log_evidence: float
    gap: float
    faulty: int

    @cached_property  # computed only for the last weights
    def pareto_k(self) -> float:
        """Shape of the largest weights' tail; nan if there are too few."""
        return _pareto_k(self.log_weights[self.log_weights > -np.inf])

    @property
    def efficiency(self) -> float:
        """Effective sample size over draws."""
        return self.size / self.log_weights.size

    @property
    def c2st(self) -> float:
        """Accuracy of the best classifier of these draws and exact ones, 0.5 to 1."""
        ratio = self.log_weights.size * np.exp(self.log_weights)
        return 0.5 + 0.25 * float(np.abs(ratio - 1.0).mean())

    @property
    def fault(self) -> str:
        """Reason why the weights are not good enough, in words; empty if they are."""
        if self.faulty:
            return f"{self.faulty} weights are not finite"
        if not self.size >= _SMALLEST_SIZE:
            return f"effective size {self.size:.0f}, {_SMALLEST_SIZE} are needed"
        if not self.pareto_k < _LARGEST_K:
            return f"Pareto k {self.pareto_k:.2f}, below {_LARGEST_K} is needed"
        return ""


def importance(log_joint: np.ndarray, log_density: np.ndarray) -> Importance:
    """Weigh draws ``(d,)`` by the joint density and the density that they were drawn from.

    Args:
        log_joint: ``log p(z_i, x)``; ``-inf`` where the prior is zero.
        log_density: ``log q(z_i)``, per unit of the same ``z``.
    """
    with np.errstate(invalid="ignore"):
        log_ratio = log_joint - log_density
    d = log_ratio.size
    faulty = int(np.sum(np.isnan(log_ratio) | (log_ratio == np.inf) | (log_density == np.inf)))
    if faulty:
        return Importance(np.full(d, np.nan), *[np.nan] * 3, faulty)
    total = logsumexp(log_ratio)
    if total == -np.inf:  # no draw is in the support, which is not a fault
        return Importance(log_ratio, 0.0, -np.inf, np.inf, 0)
    log_weights, log_evidence = log_ratio - total, float(total - np.log(d))
    size = float(np.exp(-logsumexp(2 * log_weights)))
    positive = log_weights > -np.inf
    gap = float(np.exp(log_weights[positive]) @ (log_ratio[positive] - log_evidence))
    return Importance(log_weights, size, log_evidence, gap, 0)


def _pareto_k(log_weights: np.ndarray) -> float:
    if log_weights.size < 25:  # a fit of the shape needs five weights in the tail
        return np.nan
    # The largest weights, and the next smaller one.
    n = log_weights.size
    tail = np.sort(log_weights)[-(n // 5 if n <= 225 else int(3 * np.sqrt(n))) - 1 :]
    if tail[-1] - tail[1] < 1e-12:  # equal weights have no tail
        return -np.inf
    if tail[-1] - tail[0] > 700:  # one weight dominates, and the others underflow
        return np.inf
    weights = np.exp(tail)
    with np.errstate(all="ignore"):
        return _tail_shape(weights[1:] - weights[0])


def _tail_shape(excess: np.ndarray) -> float:
    """Fit a generalised Pareto distribution to excesses ``(n,)``, rising; return its shape.

    This is the posterior mean of Zhang & Stephens (2009, Technometrics 51) on their grid of
    ``theta``, shrunk towards 0.5 with the weight of ten draws (Vehtari et al., 2024, appendix). It
    avoids ArviZ, which takes a second to import in every job.
    """
    n = excess.size
    points = 30 + int(n**0.5)
    theta = 1 - np.sqrt(points / (np.arange(1, points + 1) - 0.5))
    theta = theta / (3 * excess[int(n / 4 + 0.5) - 1]) + 1 / excess[-1]
    shape = np.mean(np.log1p(-theta[:, None] * excess), axis=1)
    mean = softmax(n * (np.log(-theta / shape) - shape)) @ theta
    return float((n * np.mean(np.log1p(-mean * excess)) + 10 * 0.5) / (n + 10))


def resample(log_weights: np.ndarray, n: int, rng: np.random.Generator) -> np.ndarray:
    """Return the indices of ``n`` draws, resampled by their normalised weights, ``(n,)``.

    Systematic resampling starts above 0, so that it never takes a draw of weight 0.
    """
    return systematic(np.exp(log_weights), n, 1.0 - rng.random(), rng)


# ---- the map -------------------------------------------------------------------------------------


def _prefix(k: int) -> int:
    """Return the number of features that use only the first k coordinates."""
    return 1 + k * (k + 3) // 2


def _features(y: np.ndarray) -> np.ndarray:
    """Return constant, linear and quadratic features, ``(k, d) -> (f, d)``, by last coordinate."""
    features = [np.ones((1, y.shape[1]))]
    for j, last in enumerate(y):
        features += [last[None], y[: j + 1] * last]
    return np.concatenate(features)


@dataclass(frozen=True)
class TriangularMap:
    """Density over ``(q,)`` whose principal axes bend, quadratically, along the wider axes.

    Attributes:
        mean: Centre, ``(q,)``.
        axes: Principal axes times their standard deviations, in columns, widest first, ``(q, q)``.
        coefficients: Coefficients of the quadratic functions, a row per function, ``(q, f)``.
        scales: Scale of the Student-t of each coordinate, ``(q,)``.
    """

    mean: np.ndarray
    axes: np.ndarray
    coefficients: np.ndarray
    scales: np.ndarray

    @classmethod
    def fit(cls, draws: np.ndarray, weights: np.ndarray | None = None) -> Self:
        """Fit to draws ``(d, q)`` with weights ``(d,)`` that sum to 1, or equal ones; raise a
        LinAlgError if a number is not finite, or the draws do not span all directions.
        """
        d, q = draws.shape
        if weights is None:
            weights = np.full(d, 1.0 / d)
        if not (np.all(np.isfinite(draws)) and np.all(np.isfinite(weights))):
            raise np.linalg.LinAlgError("draws and weights must be finite")
        mean = weights @ draws
        centred = draws - mean
        variances, vectors = np.linalg.eigh((weights[:, None] * centred).T @ centred)
        if variances[0] <= 1e-14 * variances[-1]:
            raise np.linalg.LinAlgError("the draws do not span all directions")
        axes = (vectors * np.sqrt(variances))[:, ::-1]
        y = (vectors / np.sqrt(variances))[:, ::-1].T @ centred.T

        features = _features(y[:-1])
        weighted = features * weights
        ridge = np.full(len(features), _RIDGE["quadratic"])
        ridge[[_prefix(j) for j in range(q - 1)]] = _RIDGE["linear"]
        ridge[0] = 0.0
        gram = weighted @ features.T + np.diag(ridge * (weights @ weights))
        # A coordinate uses only the first features, so one factor serves all regressions.
        factor = np.linalg.cholesky(gram)
        partial = solve_triangular(factor, weighted @ y.T, lower=True)
        coefficients = np.zeros((q, len(gram)))
        for k in range(q):
            f = _prefix(k)
            coefficients[k, :f] = solve_triangular(factor[:f, :f].T, partial[:f, k])
        residuals = y - coefficients @ features
        return cls(mean, axes, coefficients, np.sqrt(residuals**2 @ weights))

    @cached_property
    def _inverse(self) -> np.ndarray:
        return np.linalg.inv(self.axes)

    def sample(self, n: int, rng: np.random.Generator) -> np.ndarray:
        """Draw ``(n, q)``."""
        q = len(self.mean)
        spread = np.sqrt(rng.chisquare(_FREEDOM, n) / _FREEDOM)
        y = self.scales[:, None] * rng.standard_normal((q, n)) / spread
        for k in range(q):
            y[k] += self.coefficients[k, : _prefix(k)] @ _features(y[:k])
        return self.mean + (self.axes @ y).T

    def log_prob(self, points: np.ndarray) -> np.ndarray:
        """Return the log density of points ``(n, q)``, ``(n,)``."""
        q = len(self.mean)
        y = self._inverse @ (points - self.mean).T
        standard = (y - self.coefficients @ _features(y[:-1])) / self.scales[:, None]
        square = np.einsum("qn,qn->n", standard, standard)
        constant = lgamma((_FREEDOM + q) / 2) - lgamma(_FREEDOM / 2) - q / 2 * log(_FREEDOM * pi)
        log_volume = np.log(self.scales).sum() + np.linalg.slogdet(self.axes)[1]
        return constant - (_FREEDOM + q) / 2 * np.log1p(square / _FREEDOM) - log_volume


# ---- correction ----------------------------------------------------------------------------------


class _Draws(NamedTuple):
    """Draws of one map."""

    proposal: TriangularMap
    z: np.ndarray  # standardised, (n, q)
    log_joint: np.ndarray  # exact, with the record, (n,)
    weights: Importance  # by the density of this map alone


@dataclass(frozen=True)
class Corrected:
    """Exact posterior of one record, or the best approximation of it.

    Attributes:
        draws: Equally weighted draws, resampled, ``(d, q)``, physical units; the best draws of an
            unresolved record, nan if there are none.
        importance: Weights of the last round of adaptation.
        rounds: Number of rounds of adaptation.
        resolved: Whether effective size and tail of the weights are good enough.
        reason: Reason why they are not, in words; empty if they are.
    """

    draws: np.ndarray
    importance: Importance
    rounds: int
    resolved: bool
    reason: str


def correct(
    model: Model,
    record: np.ndarray,
    draws: np.ndarray,
    rng: np.random.Generator,
    *,
    rounds: int = 20,
) -> Corrected:
    """Correct a network's draws ``(d, q)``, physical units, for one record ``(t,)``, mm, nan where
    a sample is missing. Only rough location and spread of the draws matter.

    ``rounds`` is the largest number of rounds of adaptation. One round is enough for 99 % of the
    default run's records.
    """

    def draw(n: int) -> _Draws:
        z = proposal.sample(n, rng)
        log_joint = model.log_joint(z, record)
        return _Draws(proposal, z, log_joint, importance(log_joint, proposal.log_prob(z)))

    drawn: list[_Draws] = []  # all draws so far, of adaptation and result
    result, done, failure = None, 0, ""
    try:
        with np.errstate(divide="ignore"):  # a draw of 0 makes no map
            z = model.standardise(draws)
        proposal = TriangularMap.fit(z)
        while done < rounds and (result is None or result.weights.fault):
            drawn.append(draw(_ROUND_DRAWS))
            proposal = _refit(drawn)
            done += 1
            if drawn[-1].weights.efficiency >= _EFFICIENCY or done == rounds:
                last = draw(_RESULT_DRAWS)
                drawn.append(last)
                if last.weights.fault:
                    proposal = _refit(drawn)
                result = last
    except np.linalg.LinAlgError as error:
        failure = f"no map: {error}"
    weights = (result or drawn[-1]).weights if drawn else _UNKNOWN
    reason = failure or weights.fault
    if result is None or weights.size == 0:
        return Corrected(np.full(draws.shape, np.nan), weights, done, False, reason)
    chosen = result.z[resample(weights.log_weights, len(draws), rng)]
    return Corrected(model.destandardise(chosen), weights, done, not reason, reason)


_UNKNOWN = Importance(np.array([np.nan]), *[np.nan] * 3, 0)


def _refit(drawn: Sequence[_Draws]) -> TriangularMap:
    """Fit a map to all draws so far, weighted by the mixture of all maps so far.

    If too few of these draws are in the prior's support, return the last map for more draws.
    """
    z = np.concatenate([block.z for block in drawn])
    densities = [block.proposal.log_prob(z) + np.log(len(block.z) / len(z)) for block in drawn]
    log_joint = np.concatenate([block.log_joint for block in drawn])
    log_ratio = log_joint - np.logaddexp.reduce(densities)
    if np.sum(log_ratio > -np.inf) < _FIT_SIZE and np.all(log_ratio < np.inf):
        return drawn[-1].proposal
    return TriangularMap.fit(z, temper(log_ratio, _FIT_SIZE))


def temper(log_ratio: np.ndarray, size: float) -> np.ndarray:
    """Return normalised weights of at least an effective size, ``(d,) -> (d,)``.

    The ratios are raised to the largest power up to 1 that gives the effective size ``size``. At
    least ``size`` ratios must be finite. A ratio of nan or +inf raises a LinAlgError.
    """
    finite = np.isfinite(log_ratio)
    faulty = np.sum(~finite & (log_ratio != -np.inf))
    if faulty:
        raise np.linalg.LinAlgError(f"{faulty} weights are not finite")
    centred = log_ratio[finite] - log_ratio[finite].max()

    def excess(power: float) -> float:
        weights = np.exp(power * centred)
        return weights.sum() ** 2 / np.square(weights).sum() - size

    # The root has a relative error of 1e-3, however small it is, and is taken from below.
    power = 1.0
    if excess(power) < 0:
        power = (1 - 1e-3) * brentq(excess, 0.0, power, xtol=1e-300, rtol=1e-3)
    weights = np.zeros(log_ratio.size)
    weights[finite] = np.exp(power * centred)
    return weights / weights.sum()


# ---- all records of a validation -----------------------------------------------------------------


def correct_validation(
    model: Model, data: xr.Dataset, *, seed: int, rounds: int = 20
) -> xr.Dataset:
    """Correct the draws in the result of ``inference.validate``, in at most ``rounds`` rounds.

    Returns:
        ``data`` with corrected ``draws`` and, over ``curve``, the fields of ``Corrected`` and of
        its last weights: ``resolved``, ``why_unresolved``, ``rounds``, ``efficiency``,
        ``pareto_k``, ``faulty_weights`` and ``log_evidence``.
    """
    model.check_exact()
    rows, draws = [], np.empty(data.draws.shape)
    for i in tqdm(range(len(draws)), "correcting", mininterval=5, unit="curve"):
        rng = generator(seed, "correction", model.motion, i)
        record, given = data.measured.values[i], data.draws.values[i]
        exact = correct(model, record, given, rng, rounds=rounds)
        draws[i], weights = exact.draws, exact.importance
        row = {name: getattr(exact, name) for name in ("resolved", "rounds")}
        row |= {name: getattr(weights, name) for name in ("efficiency", "pareto_k", "log_evidence")}
        rows.append(row | {"why_unresolved": exact.reason, "faulty_weights": weights.faulty})
    return data.assign(_by_curve(rows) | {"draws": (data.draws.dims, draws)})


def _by_curve(rows: Sequence[dict]) -> dict:
    """Return variables over ``curve``, by name, from the rows of the curves."""
    return {name: ("curve", np.array([row[name] for row in rows])) for name in rows[0]}


def judge(posterior: "Posterior", data: xr.Dataset, corrected: xr.Dataset) -> xr.Dataset:
    """Judge a network's draws by its own density against the exact posterior.

    Args:
        data: Result of ``inference.validate``, the curves to judge.
        corrected: Result of ``correct_validation`` for the same curves, with the evidence. Other
            curves raise a ValueError.

    Returns:
        Dataset over ``curve``. From the importance weights of the network's draws: ``efficiency``,
        ``pareto_k``, ``faulty_weights``, ``divergence`` (KL of the exact posterior from the
        network's, nats) and ``c2st`` (accuracy of the best classifier of both posteriors). At the
        true values: ``gap`` (``log p - log q``, whose mean over curves is the mean divergence for
        any weights). ``resolved`` is copied from the corrected curve.
    """
    model, n = posterior.model, data.sizes["curve"]
    if not np.array_equal(corrected.truth.values[:n], data.truth.values):
        raise ValueError("the corrected curves are not those to be judged; validate both again")
    rows = []
    for i in tqdm(range(n), desc=f"judging {model.motion}", mininterval=5, unit="curve"):
        record, exact = data.measured.values[i], corrected.isel(curve=i)
        # The truth is one more point after the draws.
        values = np.concatenate([data.draws.values[i], data.truth.values[i : i + 1]])
        log_density = posterior.log_prob(values[None], record[None])[0] - model.log_scaling(values)
        log_joint = model.log_joint(model.standardise(values), record)
        weights = importance(log_joint[:-1], log_density[:-1])
        gap = log_joint[-1] - exact.log_evidence.item() - log_density[-1]
        row = {name: getattr(weights, name) for name in ("efficiency", "pareto_k", "c2st")}
        row |= {"faulty_weights": weights.faulty, "divergence": weights.gap}
        rows.append(row | {"gap": gap, "resolved": exact.resolved.item()})
    return xr.Dataset(_by_curve(rows), attrs={"motion": model.motion})
