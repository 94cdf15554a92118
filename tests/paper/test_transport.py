"""The triangular map: a normalised density, the one of its draws, that bends with the posterior."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_t, ortho_group

from breaker.common.randomness import generator
from breaker.paper.correction import TriangularMap, importance
from tests.paper.known import Banana

FREEDOM = 5  # of the Student-t


def bent(n, q, rng):
    """Draws along a curve, ``(n, q)``, turned: the first coordinate is the widest and bends all."""
    z = rng.standard_normal((n, q)) * 0.6 ** np.arange(q)
    for k in range(1, q):
        z[:, k] += 0.3 * (z[:, 0] ** 2 - 1) / k + 0.2 * z[:, 0] * z[:, k - 1]
    turn = ortho_group.rvs(q, random_state=5) if q > 1 else np.eye(1)
    return z @ turn + np.arange(q)


class Given:
    """Generator whose normal numbers ``(n, q)`` are given, and whose Student-t is then normal."""

    def __init__(self, noise):
        self.standard_normal = lambda shape: noise.T.reshape(shape).copy()
        self.chisquare = lambda freedom, n: np.full(n, freedom)


def change_of_variables(chosen, noise, step=1e-5):
    """Log density at the images of noise ``(n, q)``, by central differences, and the images."""
    (n, q), images = noise.shape, []
    for off in step * np.vstack([np.eye(q), -np.eye(q)]):
        images.append(chosen.sample(n, Given(noise + off)))
    jacobian = (np.array(images[:q]) - images[q:]) / (2 * step)
    base = multivariate_t(np.zeros(q), np.eye(q), FREEDOM).logpdf(noise)
    slope = np.linalg.slogdet(jacobian.swapaxes(0, 1))[1]
    return base - slope, chosen.sample(n, Given(noise))


@pytest.mark.parametrize("q", [1, 8])
def test_density_is_the_change_of_variables_of_the_draws(q):
    chosen = TriangularMap.fit(bent(1000, q, generator(1, "test transport", "fitted", q)))
    noise = generator(1, "test transport", "noise", q).standard_normal((20, q))
    expected, points = change_of_variables(chosen, noise)
    np.testing.assert_allclose(chosen.log_prob(points), expected, atol=1e-6)


BANANA = Banana(0.5, 0.25)
# Of weights to a standard normal in four dimensions: 1 / E[p^2 / q], by its radial integral.
BEST_EFFICIENCY = 0.865


def efficiency(chosen):
    z = chosen.sample(20_000, generator(1, "test transport", "efficiency"))
    return importance(BANANA.log_posterior(z), chosen.log_prob(z)).efficiency


def test_a_bent_density_is_recovered():
    """To nine tenths of what a Student-t can do for a Gaussian, from weighted draws."""
    wide = multivariate_t(np.zeros(4), np.diag(BANANA.variance), 3)
    draws = wide.rvs(40_000, random_state=generator(1, "test transport", "banana"))
    weights = np.exp(BANANA.log_posterior(draws) - wide.logpdf(draws))
    weights /= weights.sum()
    chosen = TriangularMap.fit(draws, weights)
    assert 0.9 * BEST_EFFICIENCY < efficiency(chosen) < 1.02 * BEST_EFFICIENCY
    # Planted fault: no functions, a plain Student-t of the right moments.
    straight = replace(chosen, coefficients=0 * chosen.coefficients, scales=np.ones(4))
    assert efficiency(straight) < 0.5 * BEST_EFFICIENCY


def test_functions_are_ridge_regressions():
    """Of skewed draws, whose features correlate; a coefficient's prior is worth 2 or 8 draws."""
    draws = np.exp(0.5 * bent(300, 3, generator(1, "test transport", "skewed")))
    weights = generator(1, "test transport", "weights").dirichlet(np.ones(300))
    chosen = TriangularMap.fit(draws, weights)
    a, b, last = np.linalg.solve(chosen.axes, (draws - chosen.mean).T)
    features = np.stack([np.ones(300), a, a * a, b, a * b, b * b])
    ridge = np.diag([0, 2, 8, 2, 8, 8]) * np.sum(weights**2)
    gram, right = features * weights @ features.T + ridge, features * weights @ last
    np.testing.assert_allclose(chosen.coefficients[2], np.linalg.solve(gram, right), rtol=1e-8)
    bend = np.linalg.solve(gram[:3, :3], features[:3] * weights @ b)
    np.testing.assert_allclose(chosen.coefficients[1], [*bend, 0, 0, 0], rtol=1e-8)
