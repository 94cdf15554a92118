"""The coupling flow: splines, inverse and density against zuko, autograd and closed forms."""

import itertools
import math

import pytest
import torch
from zuko.transforms import MonotonicRQSTransform

from breaker.networks.coupling_flow import CouplingFlow, spline
from tests.networks_fixtures import MARKS, built, density_by_autograd, normal, perturb

pytestmark = MARKS

DIMS, FEATURES = 3, 4
SIZES = {"transforms": 4, "bins": 5, "hidden": [11, 9]}


def curved(dims=DIMS, **sizes):
    """A network of random weights, whose density is far from a Gaussian."""
    return perturb(built(CouplingFlow, dims, FEATURES, **SIZES | sizes).double(), 0.35)


# ---- splines and couplings ----------------------------------------------------------------------


def test_splines_are_those_of_zuko():
    sizes, slopes = 3 * normal(50, 4, 12), 3 * normal(50, 4, 5, seed=2)
    own, zukos = spline(sizes, slopes), MonotonicRQSTransform(*sizes.chunk(2, -1), slopes)
    for name in ("horizontal", "vertical", "derivatives"):
        torch.testing.assert_close(getattr(own, name), getattr(zukos, name), rtol=0, atol=1e-12)
    assert own.bins == 6
    # The ends are where zuko has them, so that what is beyond is left alone.
    assert (own.horizontal[..., [0, -1]] == torch.tensor([-5.0, 5.0])).all()
    y = 8 * normal(50, 4, seed=3)
    torch.testing.assert_close(own(y), zukos(y), rtol=0, atol=1e-11)
    torch.testing.assert_close(own.inv(own(y)), y, rtol=0, atol=1e-9)
    assert torch.equal(own(y)[y.abs() > 5], y[y.abs() > 5])
    assert (own(y) - y).abs().max() > 0.5


@pytest.mark.parametrize("dims", [2, 3, 7, 8])
def test_any_two_dimensions_meet_both_ways(dims):
    digits = math.ceil(math.log2(dims))
    masks = built(CouplingFlow, dims, FEATURES, **SIZES | {"transforms": 2 * digits}).masks
    for i, j in itertools.permutations(range(dims), 2):
        assert any(mask[i] and not mask[j] for mask in masks), (i, j)
    assert all(0 < mask.sum() < dims for mask in masks)


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


def test_steps_noise_and_time_make_no_difference():
    network, features, theta = curved(), normal(4, FEATURES), normal(4, DIMS, seed=2)
    with torch.no_grad():
        one, seven = (network.log_prob(theta[:, None], features, steps=k)[:, 0] for k in (1, 7))
        draws = [network.sample(theta[:, None], features, steps=k) for k in (1, 7)]
        losses = [
            network.loss(theta, features, normal(4, k, DIMS, seed=k), torch.rand(4, k, 1))
            for k in (1, 3)
        ]
    assert not network.solves
    assert torch.equal(one, seven)
    assert torch.equal(*draws)
    assert torch.equal(*losses)
    assert torch.equal(losses[0], -one)


def test_sizes_that_make_no_coupling_raise():
    with pytest.raises(ValueError, match="at least two dimensions, not 1"):
        CouplingFlow(1, FEATURES, **SIZES)
    with pytest.raises(ValueError, match="at least one hidden layer"):
        CouplingFlow(2, FEATURES, **SIZES | {"hidden": []})
