"""Draws of programs of others, as parameters; the programs themselves are tested by the studies."""

import numpy as np
import pytest
import xarray as xr

from breaker.mechanism.probabilistic_programs import _pressed, theta_of
from breaker.quantities.parameters import NAMES


@pytest.fixture
def posterior(prior):
    theta = prior.sample(12, np.random.default_rng(1)).reshape(3, 4, -1)
    return theta, {name: theta[..., k] for k, name in enumerate(NAMES)}


def test_draws_are_put_in_the_order_of_the_parameters(posterior):
    theta, named = posterior
    backwards = dict(reversed(named.items())) | {"noise": np.zeros(5)}
    assert np.array_equal(theta_of(backwards), theta.reshape(12, -1))
    dataset = xr.Dataset({name: (("chain", "draw"), each) for name, each in named.items()})
    assert np.array_equal(theta_of(dataset), theta.reshape(12, -1))


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf])
def test_draws_that_are_no_parameters_are_refused(posterior, bad):
    named = posterior[1]
    named["f"] = named["f"].copy()
    named["f"][0, 0] = bad
    with pytest.raises(ValueError, match="positive and finite"):
        theta_of(named)


def test_missing_and_uneven_draws_are_refused(posterior):
    named = posterior[1]
    with pytest.raises(ValueError, match="no mu"):
        theta_of({name: each for name, each in named.items() if name != "mu"})
    with pytest.raises(ValueError, match="several shapes"):
        theta_of(named | {"mu": named["mu"][0]})


def test_the_condition_is_that_of_the_prior(prior):
    theta = prior.destandardise(3.0 * np.random.default_rng(1).standard_normal((500, len(NAMES))))
    logs = {name: np.log(theta[:, k]) for k, name in enumerate(NAMES)}
    holds = _pressed(prior, logs) > 0.0
    assert np.array_equal(holds, prior.supported(theta))
    assert 0.01 < holds.mean() < 0.99
