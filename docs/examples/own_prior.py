"""A prior of your own for the drive of the paper, with correlated springs.

In the configuration: ``model: {prior: own_prior:Springs}``
"""

import numpy as np
from scipy.stats import multivariate_normal

from breaker.model.equations import pressed
from breaker.model.parameters import NAMES


class Springs:
    """Opening spring and closing force come from one supplier, so they vary together."""

    names = NAMES

    def __init__(self):
        covariance = np.diag([0.2, 0.15, 0.2, 0.2, 0.4, 0.1, 0.05]) ** 2
        covariance[1, 5] = covariance[5, 1] = 0.8 * 0.15 * 0.1
        medians = [2.0, 0.045, 0.04, 0.3, 0.12, 0.75, 10.0]
        self.log_theta = multivariate_normal(np.log(medians), covariance)

    def sample(self, n, rng):
        theta = np.exp(self.log_theta.rvs(2 * n, random_state=rng))
        return theta[pressed(theta)][:n]

    def log_prob(self, theta):
        density = self.log_theta.logpdf(np.log(theta)) - np.log(theta).sum(axis=-1)
        return np.where(pressed(theta), density, -np.inf)
