"""The law of a sensor's errors in matrices, and residuals against it."""

import numpy as np
from scipy.stats import chi2, kstest


def covariance(sensor):
    """Covariance of a record about its expected curve, written out, ``(t, t)``."""
    t = sensor.samples
    return sensor.noise_sd**2 * np.eye(t) + sensor.zero_sd**2 * np.ones((t, t))


def covariance_p_value(residual, whole):
    """p-value of residuals ``(n, t)`` under a covariance.

    The sum of the n records' squares along each eigenvector is chi-square with n degrees of
    freedom; their joint normality is tested on all whitened numbers.
    """
    variances, vectors = np.linalg.eigh(whole)
    white = residual @ vectors / np.sqrt(variances)
    p_values = [two_sided(column @ column, len(column)) for column in white.T]
    return min(*p_values, kstest(white.ravel(), "norm").pvalue) * (len(p_values) + 1)


def two_sided(statistic, freedom):
    """p-value of a chi-square, both tails together."""
    law = chi2(freedom)
    return 2 * min(law.cdf(statistic), law.sf(statistic))
