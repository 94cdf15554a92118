"""What draws say of one breaker: the likelihood without the prior they were drawn under."""

import numpy as np

from breaker.common.randomness import generator
from breaker.drive.answers.type_spread import fit_breaker
from breaker.quantities.size import powers

P = 7


def posterior_draws(family, place, sd, n=20_000):
    """Draws of the posterior of a normal likelihood about a place, each of sd, at any size."""
    along, _ = np.linalg.qr((powers() / family.log_sds).T)
    precision = np.eye(P) / sd**2 + np.eye(P) - along @ along.T
    cov = np.linalg.inv(precision)
    mean = cov @ (place / sd**2)
    return family.destandardise(generator(1, "test fits").multivariate_normal(mean, cov, n))


def test_the_prior_that_draws_had_is_taken_off(prior):
    """With no more than its own prior, another one: not the family's twice, the planted fault."""
    place = np.array([1.0, -1.0, 0.5, 0.0, 2.0, -0.5, 1.0])
    fit = fit_breaker(posterior_draws(prior, place, 0.5), prior)
    mean, cov = fit.posterior(np.zeros((P, P)))
    np.testing.assert_allclose(mean, place, atol=0.1)
    np.testing.assert_allclose(np.sqrt(cov.diagonal()), 0.5, rtol=0.05)
    twice, _ = fit.posterior(np.eye(P))
    assert np.abs(twice - place).max() > 0.3
