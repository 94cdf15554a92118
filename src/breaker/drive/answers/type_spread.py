r"""Centre and spread of a type, from the fits of its breakers: a random-effects model.

All records of a breaker share what is particular in it, so that many of them say hardly more than
one does. So its posterior is that of one of its operations, whichever: the draws of all together.

In standardised parameters a breaker is ``z_b ~ N(m, diag(tau^2))``, and of each the records give a
normal likelihood. The type's centre m has the reference prior, less the share that is the spread
between breakers, and each tau that of a half-Student, whose tail gives way to what is seen. Gibbs
sampling draws centre, breakers and tau in turn: the centre with the breakers integrated out, and
tau on a grid. So a spread that few breakers show is not taken for none: with one breaker, tau is
what its prior says.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from breaker.mechanism.prior import Prior
from breaker.quantities.parameters import NAMES

# All in log-sds of a prior of drives of about one size: some of its variance is between types, some
# between breakers of a type.
_USUAL, _FREEDOM = 0.4, 3.0  # scale and freedom of the half-Student prior of tau
_BETWEEN = 0.3  # share of its variance that is between breakers
_SURE = 0.9  # probability that a spread is below what is stated
_TAUS = np.geomspace(0.25, 4.0, 60)  # the first is the floor of the spread
_SWEEPS = 1000
_UNSETTLED = 100  # first sweeps, left out


@dataclass(frozen=True, eq=False)
class TypeFit:
    """A breaker's normal likelihood of the standardised parameters.

    Attributes:
        matrix: Information of the records, ``(p, p)``.
        weighted: The information times the parameters that the records alone would lead to,
            ``(p,)``.
    """

    matrix: np.ndarray
    weighted: np.ndarray

    def posterior(self, precision: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and covariance under a normal prior with mean 0, ``(p,)`` and ``(p, p)``."""
        cov = np.linalg.inv(self.matrix + precision)
        return cov @ self.weighted, cov


def fit_breaker(theta: np.ndarray, family: Prior) -> TypeFit:
    """Return the likelihood of a breaker, from draws of its posterior.

    Args:
        theta: Draws by a network that knows no size, ``(n, p)``: its prior is that of the family,
            at all sizes alike.
        family: Prior of the family at a size near.

    Example:
        Draws of the prior say nothing, but for the size:

        >>> family = Prior([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], [0.1] * 7)
        >>> fit = fit_breaker(family.sample(4000, np.random.default_rng(1)), family)
        >>> bool((np.linalg.eigvalsh(fit.matrix)[:5] < 0.2).all())
        True
    """
    z = family.standardise(theta)
    precision = np.linalg.inv(np.cov(z.T))
    along = family.size_axes
    # The prior is taken off the posterior; where draws happen to be wider, they say nothing.
    sizes, axes = np.linalg.eigh(precision - (np.eye(len(z.T)) - along @ along.T))
    matrix = (axes * np.maximum(sizes, 0.0)) @ axes.T
    return TypeFit(matrix, precision @ z.mean(axis=0))


@dataclass(frozen=True, eq=False)
class Spread:
    """Centre and spread of a type, standardised.

    Attributes:
        centre, centre_sd: Of the type, and how well it is known, ``(p,)``.
        between: What tau is below with a probability of 0.9, ``(p,)``: a prior that is too narrow
            does more harm than one that is too wide.
    """

    centre: np.ndarray
    centre_sd: np.ndarray
    between: np.ndarray


def find_spread(
    fits: Sequence[TypeFit],
    precision: np.ndarray,
    rng: np.random.Generator,
    scale: np.ndarray | float = 1.0,
) -> Spread:
    """Estimate centre and spread.

    Args:
        fits: Of the breakers, at least one.
        precision: Of the reference prior, ``(p, p)``.
        scale: Log-sds of a prior of drives of about one size in those of the reference, ``(p,)``.

    Example:
        Five breakers, known well, that differ in nothing but the first parameter:

        >>> known = 400.0 * np.eye(7)
        >>> places = np.outer([-2.0, -1.0, 0.0, 1.0, 2.0], np.eye(7)[0])
        >>> fits = [TypeFit(known, known @ place) for place in places]
        >>> found = find_spread(fits, np.eye(7), np.random.default_rng(1))
        >>> bool(found.between[0] > 1.0), bool((found.between[1:] < 0.6).all())
        (True, True)
    """
    p, b = len(NAMES), len(fits)
    matrix = np.array([fit.matrix for fit in fits])
    weighted = np.array([fit.weighted for fit in fits])
    prior = np.linalg.inv(np.linalg.inv(precision) - _BETWEEN * np.diag(scale**2 * np.ones(p)))
    tau, kept = scale * np.full(p, _USUAL), []
    for sweep in range(_UNSETTLED + _SWEEPS):
        within = np.diag(tau**-2)
        cov = np.linalg.inv(matrix + within)  # of each breaker, given the centre
        gain = within @ cov
        total = prior + np.sum(gain @ matrix, axis=0)
        centre = _draw(total, np.einsum("bij,bj->i", gain, weighted), rng)
        right = weighted + within @ centre
        breakers = _draw(matrix + within, right, rng)
        tau = scale * _draw_tau(np.square((breakers - centre) / scale).sum(axis=0), b, rng)
        if sweep >= _UNSETTLED:
            kept.append((centre, tau))
    centres, taus = (np.array(each) for each in zip(*kept, strict=True))
    between = np.quantile(taus, _SURE, axis=0)
    return Spread(centres.mean(axis=0), centres.std(axis=0), between)


def _draw(precision: np.ndarray, right: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Draw from normals of precisions ``(..., p, p)``, times their means ``right (..., p)``."""
    root = np.linalg.cholesky(0.5 * (precision + np.swapaxes(precision, -1, -2)))
    half = np.linalg.solve(root, right[..., None]) + rng.standard_normal((*right.shape, 1))
    return np.linalg.solve(np.swapaxes(root, -1, -2), half)[..., 0]


def _draw_tau(square: np.ndarray, breakers: int, rng: np.random.Generator) -> np.ndarray:
    """Draw tau given the sum of squared distances from the centre, ``(p,)``, scaled."""
    # The grid is even in the logarithm.
    tail = np.log1p(np.square(_TAUS / _USUAL) / _FREEDOM)
    log_prior = np.log(_TAUS) - 0.5 * (_FREEDOM + 1.0) * tail
    log_density = log_prior - breakers * np.log(_TAUS) - square[:, None] / (2.0 * _TAUS**2)
    below = np.cumsum(np.exp(log_density - log_density.max(axis=1, keepdims=True)), axis=1)
    return _TAUS[np.argmax(below >= rng.random((len(square), 1)) * below[:, -1:], axis=1)]
