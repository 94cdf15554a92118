"""What has changed between two visits to a drive: the posterior of both, from few records.

The mode of all unknowns of ``visits`` is climbed to, and adaptive importance sampling makes the
exact posterior of draws about it (``corrections``). Closing and opening share their parameters
where they agree, and are compared apart where they do not. Works without torch.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve
from scipy.special import chdtrc
from scipy.stats import multivariate_t

from breaker.mechanism import NAMES
from breaker.model import Model
from breaker.posterior.corrections import poor, temper
from breaker.posterior.integrated import Density
from breaker.posterior.laplace import mode
from breaker.posterior.visits import Look, Visits
from breaker.posterior.weights import Importance, importance, resample

__all__ = ["Compared", "compare_visits"]

_P = len(NAMES)
_STEPS, _REACHED, _SHORTEST = 100, 1e-3, 1e-6  # of the climb: most, nats, and prior sd
_FARTHEST = 2.0  # prior sd, of a step
_DAMPING, _FACTOR = 1e-3, 10.0
_DRAWS = 2000
_FREEDOM = 10.0  # of the Student-t that are drawn from
_ROUND, _ROUNDS = 4000, 8  # draws of one, and at most so many
_ENOUGH = 1000.0  # effective size of all draws from which no more are drawn
_FIT = 400.0  # effective size that a fit needs


@dataclass(frozen=True, eq=False)
class Compared:
    """Posterior of the parameters at both visits.

    Attributes:
        motions: Motions whose records it is of.
        before, today: Draws, ``(d, p)``, physical units.
        resolved: Whether the exact posterior was reached.
        reason: Why not; empty if resolved.
        importance: Weights of the draws that they come from.
        p_value: Of the misfit of all records together.
        agreement: p-value of the same parameters in both motions; 1 for one motion.
    """

    motions: tuple[str, ...]
    before: np.ndarray
    today: np.ndarray
    resolved: bool
    reason: str
    importance: Importance
    p_value: float
    agreement: float


def compare_visits(
    models: Mapping[str, Model],
    records: Mapping[str, np.ndarray],
    today: Mapping[str, np.ndarray],
    settings: Mapping,
    rng: np.random.Generator,
    *,
    draws: int = _DRAWS,
    agreement_p_value: float = 0.001,
) -> list[Compared]:
    """Compare two visits.

    Args:
        records: Records of each, ``(r, t)``, mm; NaN where a sample is missing.
        today: Which of them are of the second visit, ``(r,)`` of bool; each visit has one of each
            motion at least.
        settings: The section ``correction`` of the configuration.
        agreement_p_value: p-value below which motions have different parameters.

    Returns:
        One comparison of all motions together, or one for each where they do not agree.

    Example:
        >>> from breaker.model import Prior, Sensor
        >>> prior = Prior([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], [0.1] * 7)
        >>> sensor = Sensor(-2.0, 58.0, 151, noise_sd=0.1, onset_sd=0.3, zero_sd=0.1)
        >>> model, rng = Model(prior, sensor, "closing"), np.random.default_rng(1)
        >>> weaker = prior.medians * [1, 1, 1, 1, 1, 0.9, 1]
        >>> drive = np.append([prior.medians, weaker], np.zeros((2, 1)), axis=1)
        >>> records = sensor.corrupt(model.curves(drive), rng)
        >>> settings = {"rounds": 20, "round_draws": 500, "draws": 2000, "efficiency": 0.6,
        ...             "fit_size": 100, "smallest_size": 400, "largest_k": 0.7}
        >>> (found,) = compare_visits({"closing": model}, {"closing": records},
        ...                           {"closing": np.array([False, True])}, settings, rng)
        >>> change = found.today[:, 5] / found.before[:, 5] - 1.0
        >>> found.resolved, bool(np.mean(change < -0.05) > 0.95)
        (True, True)
    """
    whole = Visits(models, records, today)
    y, look = _highest(whole)
    agreement = 1.0
    if len(models) > 1:
        alone = [Visits({m: models[m]}, {m: records[m]}, {m: today[m]}) for m in models]
        found = [_highest(each) for each in alone]
        rise = look.misfit - sum(each.misfit for _, each in found)
        agreement = float(chdtrc(2 * _P, max(rise, 0.0)))
        if agreement < agreement_p_value:
            return [
                _compared(each, *at, settings, rng, draws, agreement)
                for each, at in zip(alone, found, strict=True)
            ]
    return [_compared(whole, y, look, settings, rng, draws, agreement)]


def _compared(
    visits: Visits,
    y: np.ndarray,
    look: Look,
    settings: Mapping,
    rng: np.random.Generator,
    draws: int,
    agreement: float,
) -> Compared:
    """Draw from the posterior whose mode is at ``(m,)``."""
    both = slice(2 * _P)
    density = Density(visits, y, look.precision)
    x, weights = _weighed(density, y[both], np.linalg.inv(look.precision)[both, both], rng)
    chosen = np.full((draws, 2 * _P), np.nan)  # where there is no draw in the prior's support
    if weights.size > 0.0:
        chosen = x[resample(weights.log_weights, draws, rng)]
    before, today = map(visits.prior.destandardise, visits.parameters(chosen))
    samples = sum(int(np.isfinite(each).sum()) for each in visits.records.values())
    fits = float(chdtrc(samples, 2.0 * look.depth))
    reason = poor(weights, settings)
    motions = tuple(visits.models)
    return Compared(motions, before, today, not reason, reason, weights, fits, agreement)


def _weighed(
    density: Density, mean: np.ndarray, cov: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, Importance]:
    """Draw from Student-t distributions until there are enough; returns all draws, weighed.

    The first is that of mean and covariance, ``(2 p,)``; each further one is fitted to all draws so
    far, by their weights over the mixture of all (Cornuet et al., 2012, "Adaptive multiple
    importance sampling").
    """
    rounds, x, log_joint = [], np.empty((0, len(mean))), np.empty(0)
    for _ in range(_ROUNDS):
        rounds.append(multivariate_t(mean, cov, df=_FREEDOM))
        drawn = rounds[-1].rvs(_ROUND, random_state=rng)
        x, log_joint = np.vstack([x, drawn]), np.append(log_joint, density.log_joint(drawn))
        mixture = np.logaddexp.reduce([each.logpdf(x) for each in rounds]) - np.log(len(rounds))
        weights = importance(log_joint, mixture)
        if weights.size >= _ENOUGH:
            break
        try:
            shares = temper(log_joint - mixture, _FIT)
        except np.linalg.LinAlgError:  # hardly a draw in the prior's support: more may be
            continue
        mean = shares @ x
        cov = (shares[:, None] * (x - mean)).T @ (x - mean)
    return x, weights


def _highest(visits: Visits) -> tuple[np.ndarray, Look]:
    """Find the mode of all unknowns, from the same parameters at both visits and from others."""
    first = {
        motion: [records[visits.today[motion] == when][0] for when in (False, True)]
        for motion, records in visits.records.items()
    }
    modes = np.array([[mode(visits.models[m], each)[0][:_P] for each in first[m]] for m in first])
    before, today = modes.mean(axis=0)
    starts = np.zeros((2, visits.size))
    starts[0, :_P], starts[1, :_P] = 0.5 * (before + today), before
    starts[1, _P : 2 * _P] = np.clip(np.sign(today - before), -1.0, 1.0)
    return min((_climb(visits, start) for start in starts), key=lambda each: each[1].depth)


def _climb(visits: Visits, y: np.ndarray) -> tuple[np.ndarray, Look]:
    """Climb from unknowns ``(m,)`` by Gauss-Newton steps, damped as far as each has to be to gain.

    Levenberg (1944), Marquardt (1963).
    """
    look, damping = visits.look(y), _DAMPING
    ridge = np.eye(len(y))
    for _ in range(_STEPS):
        step = solve(look.precision + damping * ridge, look.uphill, assume_a="pos")
        gain = look.uphill @ step - 0.5 * step @ look.precision @ step
        length = np.abs(step).max()
        if length < _SHORTEST or (gain < _REACHED and damping <= _DAMPING):
            break
        there = y + step * min(1.0, _FARTHEST / length)
        found = visits.look(there)
        if found.depth < look.depth:
            y, look, damping = there, found, damping / _FACTOR
        else:
            damping *= _FACTOR
    return y, look
