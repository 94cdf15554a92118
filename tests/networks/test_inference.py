"""What holds for every inference network: a new one is a Gaussian."""

import numpy as np
import pytest
import torch
from scipy.stats import multivariate_normal

from breaker.networks.coupling_flow import CouplingFlow
from breaker.networks.flow_matching import FlowMatching
from tests.networks_fixtures import built, normal, perturb

DIMS, FEATURES = 3, 4
KINDS = {
    FlowMatching: {"width": 10, "blocks": 2},
    CouplingFlow: {"transforms": 4, "bins": 5, "hidden": [11, 9]},
}


@pytest.fixture(params=KINDS)
def new(request):
    """A new network."""
    return built(request.param, DIMS, FEATURES, **KINDS[request.param]).double()


@pytest.mark.parametrize("steps", [1, 7])
def test_a_new_network_is_the_gaussian_of_its_head(new, steps):
    perturb(new.head, 0.4)
    features, noise = normal(2, FEATURES), normal(2, 50, DIMS, seed=2)
    with torch.no_grad():
        mean, factor, _ = (value.numpy() for value in new.head(features))
        draws = new.sample(noise, features, steps=steps)
        density = new.log_prob(draws, features, steps=steps).numpy()
    for i in range(2):
        inverse = np.linalg.inv(factor[i])
        # Draws are the noise carried by the inverse of the factor.
        expected = mean[i] + noise[i].numpy() @ inverse.T
        np.testing.assert_allclose(draws[i].numpy(), expected, rtol=0, atol=1e-12)
        exact = multivariate_normal(mean[i], inverse @ inverse.T).logpdf(draws[i].numpy())
        np.testing.assert_allclose(density[i], exact, rtol=0, atol=1e-10)
