"""Posteriors in closed form, standing in for those of a model and a record."""

import numpy as np
from scipy.stats import multivariate_t, norm

RECORD = np.zeros(3)
LOG_EVIDENCE = 118.25


class Known:
    """Stands in for a model; outputs in physical units are ``centre + unit * z``."""

    centre, unit = np.array([2.0, -1.0, 30.0, 0.0]), np.array([0.5, 2.0, 10.0, 1e-3])
    mean, variance = np.zeros(4), np.ones(4)

    def standardise(self, values):
        return (values - self.centre) / self.unit

    def destandardise(self, z):
        return self.centre + self.unit * z

    def log_joint(self, z, record):
        assert record is RECORD
        return self.log_posterior(z) + LOG_EVIDENCE

    def log_posterior(self, z):
        """Standard normal."""
        return norm.logpdf(z).sum(1)

    def sample(self, n, rng):
        return rng.standard_normal((n, 4))


class Banana(Known):
    """The second output is bent by the square of the first."""

    def __init__(self, bend, rest):
        self.bend, self.rest = bend, rest
        self.variance = np.array([1.0, 2 * bend**2 + rest**2, 0.25, 0.04])

    def log_posterior(self, z):
        return (
            norm.logpdf(z[:, 0])
            + norm.logpdf(z[:, 1], self.bend * (z[:, 0] ** 2 - 1), self.rest)
            + norm.logpdf(z[:, 2:], 0, [0.5, 0.2]).sum(1)
        )

    def sample(self, n, rng):
        z = rng.standard_normal((n, 4)) * [1.0, self.rest, 0.5, 0.2]
        z[:, 1] += self.bend * (z[:, 0] ** 2 - 1)
        return z


class Truncated(Known):
    """Standard normal where ``(z_1 + z_2) / sqrt(2) > -1/2``: 31 per cent are cut off."""

    direction, bound = np.array([1.0, 1.0, 0.0, 0.0]) / np.sqrt(2), -0.5
    hazard = norm.pdf(bound) / norm.sf(bound)
    mean = hazard * direction
    variance = 1 + (bound * hazard - hazard**2) * direction**2

    def log_posterior(self, z):
        inside = z @ self.direction > self.bound
        return np.where(inside, norm.logpdf(z).sum(1) - norm.logsf(self.bound), -np.inf)

    def sample(self, n, rng):
        z = rng.standard_normal((3 * n, 4))
        return z[z @ self.direction > self.bound][:n]


class HeavyTailed(Known):
    """A multivariate Cauchy: its tail outweighs every Student-t of eight degrees of freedom."""

    law = multivariate_t(np.zeros(4), np.eye(4), 1)

    def log_posterior(self, z):
        return self.law.logpdf(z)

    def sample(self, n, rng):
        return self.law.rvs(n, random_state=rng)
