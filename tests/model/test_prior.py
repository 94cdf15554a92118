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


@pytest.mark.parametrize("which", ["prior", "tight"])
def test_density_is_that_of_normal_logarithms_over_the_probability_of_the_support(which, request):
    """Of ln f - ln k_a - ln L, whose variance is the sum of three."""
    chosen = request.getfixturevalue(which)
    theta = chosen.sample(50, generator(1, "test", "density"))
    places = [F, K_A, GAP]
    mean = np.log(chosen.medians[places]) @ [1.0, -1.0, -1.0]
    probability = norm.cdf(mean / np.linalg.norm(chosen.log_sds[places]))
    assert np.exp(chosen.log_support) == pytest.approx(probability, rel=1e-12)
    expected = lognorm(chosen.log_sds, scale=chosen.medians).logpdf(theta).sum(axis=1)
    np.testing.assert_allclose(chosen.log_prob(theta), expected - np.log(probability), rtol=1e-11)


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


def test_density_is_zero_outside_the_support(prior):
    theta = np.tile(prior.medians, (4, 1))
    theta[1, F] = theta[1, K_A] * theta[1, GAP] * 0.999
    theta[2, 0] = 0.0
    theta[3, 3] = -0.3
    assert np.isneginf(prior.log_prob(theta)).tolist() == [False, True, True, True]
    assert np.isneginf(prior.log_prob(-prior.medians))  # two negative factors


@pytest.mark.parametrize("wrong", [0.0, np.nan, np.inf])
def test_wrong_numbers_are_refused(prior, wrong):
    for name in ("medians", "log_sds"):
        with pytest.raises(ValueError, match=name):
            replace(prior, **{name: np.append(np.ones(6), wrong)})
