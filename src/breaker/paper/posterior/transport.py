r"""A density fitted to weighted draws: a quadratic triangular map of a Student-t.

After Parno & Marzouk (2018), "Transport map accelerated Markov chain Monte Carlo". In coordinates
``y`` along the principal axes of the draws, widest first and each of unit variance,

``y_k = c_k(y_1 ... y_{k-1}) + s_k e_k``,   ``e`` a standard multivariate Student-t,

with ``c_k`` quadratic. Widest first, because a posterior bends along what is hardly known: narrow
directions are curved functions of wide ones. The map is triangular, so density and draws are both
one pass, and the coefficients are a linear regression. A Student-t keeps importance weights
bounded where the posterior's tails are those of its prior.
"""

from dataclasses import dataclass
from functools import cached_property
from math import lgamma, log, pi
from typing import Self

import numpy as np
from scipy.linalg import solve_triangular

_FREEDOM = 5.0  # of the Student-t: heavy enough for tails that the fit has not seen
_LINEAR, _QUADRATIC = 2.0, 8.0  # ridge of the regression, in draws of unit variance


def _prefix(k: int) -> int:
    """Number of features that use only the first k coordinates."""
    return 1 + k * (k + 3) // 2


def _features(y: np.ndarray) -> np.ndarray:
    """Constant, linear and quadratic features ``(k, d) -> (f, d)``, by their last coordinate."""
    k, d = y.shape
    features = np.empty((_prefix(k), d))
    features[0] = 1.0
    for j in range(k):
        _append(features, y, j)
    return features


def _append(features: np.ndarray, y: np.ndarray, j: int) -> None:
    """Fill the features in which coordinate j is the last."""
    first = _prefix(j)
    features[first] = y[j]
    np.multiply(y[: j + 1], y[j], out=features[first + 1 : first + j + 2])


@dataclass(frozen=True)
class TriangularMap:
    """Density over ``(q,)``, with ``sample`` and ``log_prob``.

    Attributes:
        mean: Centre, ``(q,)``.
        axes: Principal axes times their standard deviations, in columns, widest first, ``(q, q)``.
        coefficients: Of the quadratic functions, one a row, ``(q, f)``.
        scales: Scale of the Student-t of each coordinate, ``(q,)``.
    """

    mean: np.ndarray
    axes: np.ndarray
    coefficients: np.ndarray
    scales: np.ndarray

    @classmethod
    def fit(cls, draws: np.ndarray, weights: np.ndarray | None = None) -> Self:
        """Fit to draws ``(d, q)`` with weights ``(d,)`` that sum to 1, or equal ones.

        Raises:
            numpy.linalg.LinAlgError: If a draw or weight is not finite, or the draws do not span
                all directions.
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
        ridge = np.full(len(features), _QUADRATIC)
        ridge[[_prefix(j) for j in range(q - 1)]] = _LINEAR
        ridge[0] = 0.0
        gram = weighted @ features.T + np.diag(ridge * (weights @ weights))
        # The features of each coordinate are the first few: one factor serves all regressions.
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
        features = np.empty((self.coefficients.shape[1], n))
        features[0] = 1.0
        for k in range(q):
            f = _prefix(k)
            y[k] += self.coefficients[k, :f] @ features[:f]
            if k < q - 1:
                _append(features, y, k)
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
