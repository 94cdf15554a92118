"""The posterior of one motion: units, densities, independence of curves."""

import numpy as np
import pytest
from scipy.stats import lognorm, norm

from breaker.model.parameters import NAMES
from breaker.paper.posterior import Posterior
from tests.networks_fixtures import PRIOR, SENSOR, frozen, noise_of, pin, settings


@pytest.mark.parametrize("onset", [True, False])
def test_density_changes_variables_once(onset):
    """Against scipy; float32 networks: a density of some 30 nats is exact to about 1e-4."""
    new = Posterior(settings(onset=onset))
    q = len(new.outputs)
    mean, sd, z = np.linspace(-0.5, 0.7, q), 0.6, np.random.default_rng(1).normal(size=(3, 6, q))
    pin(new, mean, sd)
    values, expected = z * SENSOR["onset_sd"], np.zeros((3, 6))
    for i, name in enumerate(NAMES):
        median, log_sd = PRIOR[name]["median"], PRIOR[name]["log_sd"]
        values[..., i] = median * np.exp(log_sd * z[..., i])
        law = lognorm(sd * log_sd, scale=median * np.exp(mean[i] * log_sd))
        expected += law.logpdf(values[..., i])
    if onset:
        law = norm(mean[7] * SENSOR["onset_sd"], sd * SENSOR["onset_sd"])
        expected += law.logpdf(values[..., 7])
    density = new.log_prob(values, np.zeros((3, SENSOR["samples"])))
    np.testing.assert_allclose(density, expected, rtol=0, atol=2e-4)
    # Planted faults: the change of variables left out, or made twice, is seen.
    for times in (-1, 1):
        assert np.abs(density + times * new.model.log_scaling(values) - expected).min() > 0.1


def test_draws_of_a_curve_do_not_depend_on_the_others(series):
    """Bit for bit: alone, among others, in any order."""
    posterior, records = series
    noise = noise_of(posterior, 5, 40)
    together = posterior.sample(records, noise)
    density = posterior.log_prob(together, records)
    order = np.array([3, 0, 4])
    some, draws = records[order], together[order]
    np.testing.assert_array_equal(posterior.sample(some, noise[order]), draws)
    np.testing.assert_array_equal(posterior.log_prob(draws, some), density[order])
    assert np.unique(together[:, 0, 0]).size == 5


@pytest.mark.filterwarnings("ignore:overflow encountered")
def test_draws_that_are_not_finite_raise(series):
    _, records = series
    posterior = pin(frozen(), 1e30, 1.0)
    with pytest.raises(FloatingPointError, match="5 of 5"):
        posterior.sample(records, noise_of(posterior, 5, 3))
