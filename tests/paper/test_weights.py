"""Importance weights against problems in closed form: evidence, size, divergence, tail."""

from types import SimpleNamespace

import numpy as np
import pytest
from arviz_stats.base import array_stats
from scipy.stats import chisquare, norm

from breaker.common.randomness import generator
from breaker.paper.correction import importance, resample

TWO_SIDED = norm.isf(0.5e-3)  # 3.29 standard errors: false alarm 1e-3

# A posterior N(0, I) in three dimensions, and a proposal N(SHIFT, WIDTH^2 I).
WIDTH, SHIFT, LOG_EVIDENCE = 1.3, np.array([0.4, -0.3, 0.2]), -17.25
# In units of the proposal, the posterior is N(M, S^2) in each coordinate.
S, M = 1 / WIDTH, -SHIFT / WIDTH
DIVERGENCE = 0.5 * np.sum(S**2 + M**2 - 1 - 2 * np.log(S))


def moment(j):
    """``E_q[w^j]`` of weights of mean one: ``p^j q^(1-j)`` is a Gaussian."""
    precision = j / S**2 - (j - 1)
    exponent = (j * M / S**2) ** 2 / (2 * precision) - j * M**2 / (2 * S**2)
    return float(np.prod(np.exp(exponent) / (S**j * np.sqrt(precision))))


def test_evidence_efficiency_and_divergence_in_closed_form():
    """False alarm 1e-3 each; errors by the delta method."""
    n = 40_000
    z = SHIFT + WIDTH * generator(1, "test exact", "judged").standard_normal((n, 3))
    joint, density = norm.logpdf(z).sum(1) + LOG_EVIDENCE, norm.logpdf(z, SHIFT, WIDTH).sum(1)
    result = importance(joint, density)
    second, third, fourth = (moment(j) for j in (2, 3, 4))
    assert abs(result.log_evidence - LOG_EVIDENCE) < TWO_SIDED * np.sqrt((second - 1) / n)
    covariance = np.array([[second - 1, third - second], [third - second, fourth - second**2]])
    gradient = np.array([2 / second, -1 / second**2])
    error = np.sqrt(gradient @ covariance @ gradient / n)
    assert abs(result.efficiency - 1 / second) < TWO_SIDED * error
    log_w = joint - density - LOG_EVIDENCE
    error = np.std(np.exp(log_w) * (log_w - DIVERGENCE - 1)) / np.sqrt(n)
    assert abs(result.gap - DIVERGENCE) < TWO_SIDED * error


def test_the_best_classifier_in_closed_form():
    """Draws twice as wide as the exact normal; it calls all within +-t exact. False alarm 1e-3."""
    z = 2.0 * generator(1, "test exact", "classifier").standard_normal(40_000)
    weighed = importance(norm.logpdf(z), norm.logpdf(z, scale=2.0))
    t = np.sqrt(8.0 / 3.0 * np.log(2.0))
    right = 0.5 * (1.0 - 2.0 * norm.sf(t)) + norm.sf(t / 2.0)
    error = 0.25 * np.abs(np.exp(weighed.log_weights) * z.size - 1.0).std() / np.sqrt(z.size)
    assert abs(weighed.c2st - right) < TWO_SIDED * error


@pytest.mark.parametrize("n", [25, 225, 500])
@pytest.mark.parametrize("width", [0.5, 0.8, 1.3])
def test_pareto_k_is_that_of_arviz(n, width):
    """Of ``N(0, I)`` in the plane by draws of another width: narrow, heavy tails; wide, bounded."""
    z = width * generator(1, "test exact", "tail", n).standard_normal((n, 2))
    log_ratio = norm.logpdf(z).sum(1) - norm.logpdf(z, scale=width).sum(1)
    _, expected = array_stats.psislw(-log_ratio)  # it takes the negative
    assert importance(log_ratio, np.zeros(n)).pareto_k == pytest.approx(expected, abs=1e-9)
    assert np.isnan(importance(log_ratio[:24], np.zeros(24)).pareto_k)  # too few


def test_equal_weights_and_a_single_one():
    """Also with the round-off of a density taken off a large joint."""
    density = generator(1, "test exact", "equal").normal(size=300)
    result = importance(density + 120.0, density)
    assert (result.size, result.log_evidence) == (pytest.approx(300), pytest.approx(120.0))
    assert result.gap == pytest.approx(0, abs=1e-12)
    assert (result.pareto_k, result.c2st) == (-np.inf, pytest.approx(0.5))
    for ahead in (30, 740, 1e5):  # one weight is everything, also where the others underflow
        for others in (density, 0.0 * density):
            result = importance(np.r_[ahead, others], np.zeros(301))
            assert not result.pareto_k < 0.7
            assert result.size == pytest.approx(1)


def test_zero_weights_are_legitimate():
    """A proposal cut by the support: everything is a binomial share, in closed form."""
    z = generator(1, "test exact", "cut").standard_normal(4000)
    share = np.mean(z > 0.3)
    result = importance(np.where(z > 0.3, norm.logpdf(z), -np.inf), norm.logpdf(z))
    assert result.faulty == 0
    assert result.size == pytest.approx(4000 * share)
    assert result.log_evidence == pytest.approx(np.log(share))
    assert result.gap == pytest.approx(-np.log(share))
    none = importance(np.full(50, -np.inf), np.zeros(50))
    assert (none.size, none.efficiency, none.faulty) == (0, 0, 0)
    assert (none.log_evidence, none.gap) == (-np.inf, np.inf)
    assert np.isnan(none.pareto_k)


@pytest.mark.parametrize(
    ("joint", "density"),
    [(np.nan, 0.0), (np.inf, 0.0), (0.0, np.nan), (0.0, -np.inf), (-np.inf, -np.inf)],
)
def test_faults_are_counted_and_leave_nothing_defined(joint, density):
    log_joint, log_density = np.zeros(40), generator(1, "test exact", "faults").normal(size=40)
    log_joint[5] = -np.inf  # legitimate
    log_joint[10:13], log_density[10:13] = joint, density
    result = importance(log_joint, log_density)
    assert result.faulty == 3
    numbers = (result.size, result.pareto_k, result.log_evidence, result.gap, result.efficiency)
    assert np.isnan([*numbers, *result.log_weights]).all()


WEIGHTS = np.array([0.0, 0.31, 0.004, 0.0, 0.11, 0.2, 0.05, 0.0, 0.026, 0.3, 0.0])


@np.errstate(divide="ignore")
def test_each_draw_is_taken_its_number_of_times_and_at_any_place():
    """Means of counts, and the first place: false alarm 1e-3 each."""
    rng, positive = generator(1, "test exact", "counts"), WEIGHTS > 0
    taken = np.array([resample(np.log(WEIGHTS), 37, rng) for _ in range(4000)])
    counts = np.array([np.bincount(row, minlength=len(WEIGHTS)) for row in taken])
    expected = 37 * WEIGHTS
    assert np.all((counts >= np.floor(expected)) & (counts <= np.ceil(expected)))
    share = expected % 1  # of roundings up
    error = np.sqrt(share * (1 - share) / 4000)
    assert np.all(np.abs(counts.mean(0) - expected) <= norm.isf(1e-3 / 14) * error + 1e-12)
    first = np.bincount(taken[:, 0], minlength=len(WEIGHTS))[positive]
    assert chisquare(first, 4000 * WEIGHTS[positive]).pvalue > 1e-3


@np.errstate(divide="ignore")
@pytest.mark.parametrize("start", [0.0, 1e-300, np.nextafter(1.0, 0.0)])
@pytest.mark.parametrize("n", [1, 99_991])
def test_zero_weights_are_never_taken(start, n):
    """Not at either end either, where positions meet edges in round-off."""
    rng = SimpleNamespace(random=lambda: start, permutation=lambda values: values)
    weights = np.concatenate([WEIGHTS, np.full(5, 0.1), np.zeros(2)])
    assert np.all(weights[resample(np.log(weights / weights.sum()), n, rng)] > 0)
