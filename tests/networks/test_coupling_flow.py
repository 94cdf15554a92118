"""The coupling flow: splines, inverse and density by differences, autograd, closed forms."""

import itertools
import math

import pytest
import torch

from breaker.networks.coupling_flow import CouplingFlow, bend, unbend
from tests.networks_fixtures import built, density_by_autograd, normal, perturb

DIMS, FEATURES = 3, 4
SIZES = {"transforms": 4, "bins": 5, "hidden": [11, 9]}


def curved(dims=DIMS, **sizes):
    """A network of random weights, whose density is far from a Gaussian."""
    return perturb(built(CouplingFlow, dims, FEATURES, **SIZES | sizes).double(), 0.35)


# ---- splines and couplings ----------------------------------------------------------------------


def test_splines_are_inverted_and_leave_alone_what_is_beyond():
    x, numbers = 3 * normal(50, 4), 3 * normal(50, 4, 17, seed=2)
    y, log_slope = bend(x, numbers)
    torch.testing.assert_close(unbend(y, numbers), x, rtol=0, atol=1e-9)
    beyond = x.abs() > 5
    assert beyond.any()
    assert torch.equal(y[beyond], x[beyond])
    assert (log_slope[beyond] == 0).all()
    assert (y - x).abs().max() > 0.5


def test_gradients_of_splines_are_those_of_their_values():
    """Of value and log slope, by differences; the log slope is the derivative's."""
    x, numbers = 3 * normal(12, 2), 2 * normal(12, 2, 17, seed=2)
    x, numbers = x.requires_grad_(), numbers.requires_grad_()
    assert torch.autograd.gradcheck(bend, (x, numbers))
    y, log_slope = bend(x, numbers)
    (slope,) = torch.autograd.grad(y.sum(), x)
    torch.testing.assert_close(slope.log(), log_slope, rtol=0, atol=1e-9)


@pytest.mark.parametrize("dims", [2, 3, 7, 8])
def test_any_two_dimensions_meet_both_ways(dims):
    digits = math.ceil(math.log2(dims))
    network = built(CouplingFlow, dims, FEATURES, **SIZES | {"transforms": 2 * digits})
    orders = zip(network.conditioners, network.orders.tolist(), strict=True)
    stay = [set(order[: conditioner.enter.in_features]) for conditioner, order in orders]
    for i, j in itertools.permutations(range(dims), 2):
        assert any(i in kept and j not in kept for kept in stay), (i, j)
    assert all(0 < len(kept) < dims for kept in stay)


# ---- draws and density --------------------------------------------------------------------------


@pytest.mark.parametrize("dims", [2, 3, 7])
def test_density_is_that_of_the_sampling_map(dims):
    """Exactly, for one pass undoes the other; also where splines end, at five whitened sds."""
    features, noise = normal(2, FEATURES, seed=2), 2.5 * normal(2, 8, dims)
    assert (noise.abs() > 5).any() or dims == 2
    points, expected = density_by_autograd(curved(dims), noise, features)
    with torch.no_grad():
        density = curved(dims).log_prob(points, features, steps=1)
    torch.testing.assert_close(density, expected, rtol=0, atol=1e-8)
