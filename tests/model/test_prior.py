"""The prior: normalised, sampled exactly, and zero outside its support."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import ks_2samp, lognorm, norm

from breaker.common.randomness import generator
from breaker.model.parameters import NAMES

K_A, F, GAP = (NAMES.index(name) for name in ("k_a", "f", "L"))


@pytest.fixture(scope="module")
def tight(prior):
    """A prior that its condition cuts hard: P(f > k_a L) is 0.36, so that leaving it out shows."""
    return replace(prior, medians=np.where(np.arange(7) == F, 0.42, prior.medians))


def integral(prior, log_density, rng, n=50_000):
    """Integral of a density by importance sampling, and its standard error.

    The proposal has 1.3 times the prior's log-sds, so the weights are bounded by 1.3^7 / P.
    """
    wide = 1.3 * prior.log_sds
    theta = prior.medians * np.exp(wide * rng.standard_normal((n, len(NAMES))))
    proposal = lognorm(s=wide, scale=prior.medians).logpdf(theta).sum(axis=1)
    weights = np.exp(log_density(theta) - proposal)
    return weights.mean(), weights.std() / np.sqrt(n)


@pytest.mark.parametrize("which", ["prior", "tight"])
def test_density_integrates_to_one(which, request):
    """4 standard errors: false alarm 6e-5. They are below 0.01, so the normal law holds."""
    chosen = request.getfixturevalue(which)
    value, error = integral(chosen, chosen.log_prob, generator(1, "test", "integral", which))
    assert error < 0.01
    assert abs(value - 1) < 4 * error


def test_probability_of_the_support(prior, tight):
    assert np.exp(prior.log_support) == pytest.approx(0.9968, abs=5e-5)
    # ln f - ln k_a - ln L is normal: mean ln(0.42 / 0.45), variance the sum of three.
    exact = norm.cdf(np.log(0.42 / 0.45) / np.sqrt(0.15**2 + 0.10**2 + 0.05**2))
    assert np.exp(tight.log_support) == pytest.approx(exact, rel=1e-13)


@pytest.mark.parametrize("which", ["prior", "tight"])
def test_sampling_is_rejection_sampling(which, request):
    """Along every parameter, and sums of two that the condition couples: false alarm 1e-3."""
    chosen = request.getfixturevalue(which)
    rng = generator(1, "test", "sampling", which)
    z = rng.standard_normal((40_000, len(NAMES)))
    kept = z[chosen.supported(chosen.destandardise(z))][:10_000]
    drawn = chosen.standardise(chosen.sample(10_000, rng))
    along = np.vstack([np.eye(len(NAMES)), np.eye(len(NAMES))[[F, F, GAP]]])
    along[-3:] -= np.eye(len(NAMES))[[K_A, GAP, K_A]]
    p_values = [ks_2samp(drawn @ axis, kept @ axis).pvalue for axis in along]
    assert min(p_values) * len(along) > 1e-3


def test_support_is_always_respected(prior):
    """Even where it is a tail of 1 in 100,000."""
    chosen = replace(prior, medians=np.where(np.arange(7) == F, 0.20, prior.medians))
    theta = chosen.sample(20_000, generator(1, "test", "support"))
    assert np.all(theta[:, F] > theta[:, K_A] * theta[:, GAP])
    assert np.all(np.isfinite(chosen.log_prob(theta)))


def test_density_is_zero_outside_the_support(prior):
    theta = np.tile(prior.medians, (4, 1))
    theta[1, F] = theta[1, K_A] * theta[1, GAP] * 0.999
    theta[2, 0] = 0.0
    theta[3, 3] = -0.3
    assert np.isneginf(prior.log_prob(theta)).tolist() == [False, True, True, True]
    assert prior.supported(theta).tolist() == [True, False, True, True]
    # Two negative factors make no support.
    assert np.isneginf(prior.log_prob(-prior.medians))


@pytest.mark.parametrize("wrong", [0.0, np.nan, np.inf])
def test_wrong_numbers_are_refused(prior, wrong):
    for name in ("medians", "log_sds"):
        with pytest.raises(ValueError, match=name):
            replace(prior, **{name: np.append(np.ones(6), wrong)})
