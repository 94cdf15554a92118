r"""Importance weights of draws: how far their density is from the exact posterior.

The joint density of unknowns and record is exact here (``Model.log_joint``), so draws ``z_i`` from
a density ``q`` carry the log weights ``log p(z_i, x) - log q(z_i)``. From them follow, for one
record ``x``:

- the effective sample size ``(sum w)^2 / sum w^2`` (Kong, 1992) and the efficiency, its share of
  the draws;
- the shape ``k`` of a generalised Pareto distribution fitted to the largest weights (Vehtari et
  al., 2024, "Pareto smoothed importance sampling"): from 0.7 on they do not settle;
- the log evidence ``log p(x)``, the log of the mean weight, with its standard error;
- the divergence ``KL(p | q) = E_p[log p(z|x) - log q(z)]``, the gap to the exact posterior;
- the accuracy of the best classifier of draws of ``q`` and of ``p``, ``1/2 + E_q|p/q - 1| / 4``,
  which a classifier two-sample test (C2ST) approaches from below: 0.5 where ``q`` is exact.

A weight of zero is legitimate (outside the prior's support). A weight that is not a number, or
infinite, is a fault: it is counted, and leaves all of the above undefined.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import logsumexp

from breaker.common.randomness import systematic

_FEWEST = 25  # draws of weight above zero from which a tail is fitted


@dataclass(frozen=True)
class Importance:
    """Summary of the importance weights of one record.

    Attributes:
        log_weights: Normalised so that their exponentials sum to 1, ``(d,)``.
        size: Effective sample size.
        log_evidence: Log of the probability density of the record, standard error beside it.
        log_evidence_se: By the delta method, ``sqrt(1 / size - 1 / d)``.
        gap: Estimate of ``KL(p | q)``, nats.
        faulty: Number of weights that are nan or infinite; if any, all else is nan.
    """

    log_weights: np.ndarray
    size: float
    log_evidence: float
    log_evidence_se: float
    gap: float
    faulty: int

    @cached_property  # asked for of the last weights alone
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
        return Importance(np.full(d, np.nan), *[np.nan] * 4, faulty)
    total = logsumexp(log_ratio)
    if total == -np.inf:  # no draw in the support: nothing is known, and nothing is wrong
        return Importance(log_ratio, 0.0, -np.inf, np.inf, np.inf, 0)
    log_weights = log_ratio - total
    size = float(np.exp(-logsumexp(2 * log_weights)))
    log_evidence = total - np.log(d)
    positive = log_weights > -np.inf
    gap = float(np.exp(log_weights[positive]) @ (log_ratio[positive] - log_evidence))
    return Importance(
        log_weights=log_weights,
        size=size,
        log_evidence=float(log_evidence),
        log_evidence_se=float(np.sqrt(max(0.0, 1 / size - 1 / d))),
        gap=gap,
        faulty=0,
    )


def _pareto_k(log_weights: np.ndarray) -> float:
    if log_weights.size < _FEWEST:
        return np.nan
    # The largest weights, and the one below them.
    n = log_weights.size
    tail = np.sort(log_weights)[-(n // 5 if n <= 225 else int(3 * np.sqrt(n))) - 1 :]
    if tail[-1] - tail[1] < 1e-12:  # all alike: nothing is beyond them
        return -np.inf
    if tail[-1] - tail[0] > 700:  # one weight is everything: the others underflow, and k with them
        return np.inf
    weights = np.exp(tail - tail[-1])
    with np.errstate(all="ignore"):
        return _tail_shape(weights[1:] - weights[0])


def _tail_shape(excess: np.ndarray) -> float:
    """Fit a generalised Pareto distribution to excesses ``(n,)``, rising; return its shape.

    The posterior mean of Zhang & Stephens (2009, Technometrics 51) on their grid of ``theta``,
    shrunk towards 0.5 as if by ten more draws (Vehtari et al., 2024, appendix). Written out here,
    for ArviZ's own takes a second to import, in every job that weighs draws.
    """
    n = excess.size
    points = 30 + int(n**0.5)
    theta = 1 - np.sqrt(points / (np.arange(1, points + 1) - 0.5))
    theta = theta / (3 * excess[int(n / 4 + 0.5) - 1]) + 1 / excess[-1]
    shape = np.mean(np.log1p(-theta[:, None] * excess), axis=1)
    profile = n * (np.log(-theta / shape) - shape - 1)
    weight = np.exp(profile - logsumexp(profile))
    counted = weight >= 10 * np.finfo(float).eps
    weight, theta = weight[counted], theta[counted]
    mean = np.sum(theta * (weight / weight.sum()))
    return float((n * np.mean(np.log1p(-mean * excess)) + 10 * 0.5) / (n + 10))


def resample(log_weights: np.ndarray, n: int, rng: np.random.Generator) -> np.ndarray:
    """Return the indices of ``n`` draws taken by their normalised weights, ``(n,)``.

    As ``systematic`` does, from a start above 0, so that no draw of weight 0 is ever taken.
    """
    return systematic(np.exp(log_weights), n, 1.0 - rng.random(), rng)
