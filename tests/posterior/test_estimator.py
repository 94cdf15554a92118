"""The posterior of one motion: units, densities, independence of curves."""

import numpy as np
import pytest
import torch
from scipy.stats import lognorm, norm

from breaker.model.parameters import NAMES
from breaker.paper.posterior import Posterior
from tests.networks_fixtures import PRIOR, SENSOR, frozen, noise_of, pin, settings


@pytest.fixture(params=[True, False], ids=["onset", "no onset"])
def new(request):
    return Posterior(settings(onset=request.param))


def values_of(posterior, *shape):
    """Outputs in physical units, without the code under test."""
    rng = np.random.default_rng(1)
    median = np.array([PRIOR[name]["median"] for name in NAMES])
    log_sd = np.array([PRIOR[name]["log_sd"] for name in NAMES])
    z = rng.standard_normal((*shape, len(posterior.outputs)))
    values = z.copy()
    values[..., :7] = median * np.exp(log_sd * z[..., :7])
    values[..., 7:] = SENSOR["onset_sd"] * z[..., 7:]
    return values, z


# ---- draws and densities ------------------------------------------------------------------------


def exact_density(values, mean, sd):
    """Density of a model pinned to N(mean, sd^2), in physical units, by scipy."""
    density = np.zeros(values.shape[:-1])
    for i, name in enumerate(NAMES):
        spread = sd * PRIOR[name]["log_sd"]
        centre = PRIOR[name]["median"] * np.exp(mean[i] * PRIOR[name]["log_sd"])
        density += lognorm(spread, scale=centre).logpdf(values[..., i])
    for i in range(len(NAMES), values.shape[-1]):
        onset_sd = SENSOR["onset_sd"]
        density += norm(mean[i] * onset_sd, sd * onset_sd).logpdf(values[..., i])
    return density


def test_density_changes_variables_once(new):
    """Float32 networks: a density of some 30 nats is exact to about 1e-4."""
    mean, sd = np.linspace(-0.5, 0.7, len(new.outputs)), 0.6
    pin(new, mean, sd)
    values, _ = values_of(new, 3, 6)
    records = np.zeros((3, SENSOR["samples"]))
    expected = exact_density(values, mean, sd)
    density = new.log_prob(values, records)
    np.testing.assert_allclose(density, expected, rtol=0, atol=2e-4)
    # Planted faults: the change of variables left out, or made twice, is seen.
    for times in (-1, 1):
        assert np.abs(density + times * new.model.log_scaling(values) - expected).min() > 0.1


def test_density_of_draws_is_that_of_the_network(series):
    """In physical units it is the network's own times the Jacobian, for every curve by itself."""
    posterior, records = series
    draws = posterior.sample(records, noise_of(posterior, 5, 4))
    with torch.no_grad():
        z = torch.from_numpy(posterior.model.standardise(draws)).float()
        features = posterior.summary(torch.from_numpy(records).float())
        network = posterior.inference.log_prob(z, features, steps=3).numpy()
    expected = network + posterior.model.log_scaling(draws)
    np.testing.assert_allclose(posterior.log_prob(draws, records), expected, rtol=0, atol=2e-3)


def test_draws_of_a_curve_do_not_depend_on_the_others(series):
    """Bit for bit: alone, among others, in any order."""
    posterior, records = series
    noise = noise_of(posterior, 5, 40)
    together = posterior.sample(records, noise)
    density = posterior.log_prob(together, records)
    order = np.array([3, 0, 4])
    np.testing.assert_array_equal(posterior.sample(records[order], noise[order]), together[order])
    for i in range(5):
        row = slice(i, i + 1)
        np.testing.assert_array_equal(posterior.sample(records[row], noise[row]), together[row])
        alone = posterior.log_prob(together[row], records[row])
        np.testing.assert_array_equal(alone, density[row])
    assert np.unique(together[:, 0, 0]).size == 5


@pytest.mark.filterwarnings("ignore:overflow encountered")
def test_draws_that_are_not_finite_raise(series):
    _, records = series
    posterior = pin(frozen(), 1e30, 1.0)
    with pytest.raises(FloatingPointError, match="draws of 5 of 5 curves are not finite"):
        posterior.sample(records, noise_of(posterior, 5, 3))


def test_first_weights_come_from_the_seed_and_the_motion():
    state = torch.random.get_rng_state()
    one, again = Posterior(settings(), seed=1), Posterior(settings(), seed=1)
    others = Posterior(settings(), seed=2), Posterior(settings(motion="opening"), seed=1)
    assert torch.equal(torch.random.get_rng_state(), state)
    for name, weight in one.state_dict().items():
        assert torch.equal(weight, again.state_dict()[name]), name
    for other in others:
        first = next(iter(one.parameters()))
        assert not torch.equal(first, next(iter(other.parameters())))
