"""What tests of corrected posteriors share: how results are judged."""

import numpy as np
from scipy.stats import chi2
from scipy.stats import t as student

__all__ = ["errors_p_value", "from_prior", "means_p_value"]


def from_prior(model, n, rng):
    """Outputs drawn from the prior, ``(n, q)``, physical units."""
    onset = model.sensor.onset_sd * rng.standard_normal((n, 1))
    return np.hstack([model.prior.sample(n, rng), onset])


def errors_p_value(errors, sds):
    """Two-sided, of the sum of squared z-scores: chi-square."""
    law, square = chi2(len(errors)), np.square(np.divide(errors, sds)).sum()
    return 2 * min(law.cdf(square), law.sf(square))


def means_p_value(errors):
    """That all means of independent rows ``(n, k)`` are 0, by their own scatter: Student's t."""
    score = np.mean(errors, axis=0) / (np.std(errors, axis=0, ddof=1) / np.sqrt(len(errors)))
    return min(1.0, 2 * student(len(errors) - 1).sf(np.abs(score).max()) * score.size)
