"""Inference networks: density and draws against closed forms, differences and autograd."""

import itertools
import math

import numpy as np
import pytest
import torch
from scipy.stats import multivariate_normal, norm

from breaker.networks import flow_matching
from breaker.networks.coupling_flow import CouplingFlow, bend, unbend
from breaker.networks.flow_matching import FlowMatching
from tests.networks_fixtures import arrays, built, density_by_autograd, normal, perturb, silu

DIMS, FEATURES, WIDTH, BLOCKS = 3, 4, 10, 2
KINDS = {
    FlowMatching: {"width": WIDTH, "blocks": BLOCKS},
    CouplingFlow: {"transforms": 4, "bins": 5, "hidden": [11, 9]},
}


def curved(kind, dims=DIMS):
    """A network of random weights, whose density is far from a Gaussian."""
    return perturb(built(kind, dims, FEATURES, **KINDS[kind]).double(), 0.35)


@pytest.mark.parametrize("steps", [1, 7])
@pytest.mark.parametrize("kind", KINDS)
def test_a_new_network_is_the_gaussian_of_its_head(kind, steps):
    new = built(kind, DIMS, FEATURES, **KINDS[kind]).double()
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
    torch.testing.assert_close(torch.autograd.grad(y.sum(), x)[0].log(), log_slope)


@pytest.mark.parametrize("dims", [2, 3, 7, 8])
def test_any_two_dimensions_meet_both_ways(dims):
    sizes = KINDS[CouplingFlow] | {"transforms": 2 * math.ceil(math.log2(dims))}
    network = built(CouplingFlow, dims, FEATURES, **sizes)
    orders = zip(network.conditioners, network.orders.tolist(), strict=True)
    stay = [set(order[: conditioner.enter.in_features]) for conditioner, order in orders]
    for i, j in itertools.permutations(range(dims), 2):
        assert any(i in kept and j not in kept for kept in stay), (i, j)
    assert all(0 < len(kept) < dims for kept in stay)


@pytest.mark.parametrize("dims", [2, 3, 7])
def test_density_of_couplings_is_that_of_the_sampling_map(dims):
    """Exactly, for one pass undoes the other; also where splines end, at five whitened sds."""
    features, noise = normal(2, FEATURES, seed=2), 2.5 * normal(2, 8, dims)
    assert (noise.abs() > 5).any() or dims == 2
    points, expected = density_by_autograd(curved(CouplingFlow, dims), noise, features)
    with torch.no_grad():
        network = curved(CouplingFlow, dims)
        density = network.log_prob(points, features, steps=1)
        loss = network.loss(points[:, 0], features, None, None)
    torch.testing.assert_close(density, expected, rtol=0, atol=1e-8)
    torch.testing.assert_close(loss, -expected[:, 0], rtol=0, atol=1e-8)


def velocity_by_hand(field, y, t, features):
    """Velocity at one point ``(q,)``, one time, one condition ``(s,)``, in numpy."""
    w = arrays(field)
    waves = math.pi / 2 * np.arange(1, 9) * t
    embedded = w["time.weight"] @ np.r_[np.sin(waves), np.cos(waves)] + w["time.bias"]
    condition = w["condition.weight"] @ features + w["condition.bias"]
    shifts = np.split(embedded + condition, BLOCKS + 1)
    h = w["enter.weight"] @ y + w["enter.bias"] + shifts[0]
    for k in range(BLOCKS):
        inside = w[f"inner.{k}.weight"] @ silu(h) + w[f"inner.{k}.bias"] + shifts[k + 1]
        h = h + w[f"outer.{k}.weight"] @ silu(inside) + w[f"outer.{k}.bias"]
    return w["leave.weight"] @ silu(h) + w["leave.bias"]


def test_loss_by_hand():
    """The velocity to match is the path's derivative, taken here by a central difference."""
    network, n, k = curved(FlowMatching), 4, 5
    theta, features = normal(n, DIMS), normal(n, FEATURES, seed=2)
    noise = normal(n, k, DIMS, seed=3)
    time = torch.from_numpy(np.random.default_rng(4).random((n, k, 1)))
    result = network.loss(theta, features, noise, time).detach().numpy()
    mean, factor, _ = (value.detach().numpy() for value in network.head(features))

    expected = np.zeros(n)
    for i in range(n):
        whitened = factor[i] @ (theta[i].numpy() - mean[i])
        covariance = np.linalg.inv(factor[i].T @ factor[i])
        base = multivariate_normal(mean[i], covariance).logpdf(theta[i].numpy())
        expected[i] = -base - DIMS / 2 * math.log(2 * math.pi)
        for j in range(k):
            start, at, step = noise[i, j].numpy(), float(time[i, j, 0]), 1e-5

            def path(t, start=start, whitened=whitened):
                return math.sin(math.pi * t / 2) * whitened + math.cos(math.pi * t / 2) * start

            velocity = (path(at + step) - path(at - step)) / (2 * step)
            field = velocity_by_hand(network.field, path(at), at, features[i].numpy())
            expected[i] += np.sum((field - velocity) ** 2) / k
    # The difference errs by pi^3/48 step^2 = 6e-11 relative and 1e-16/step by rounding; the
    # frequencies are float32 numbers, off by 3e-8.
    np.testing.assert_allclose(result, expected, rtol=1e-6)


def test_the_flow_does_not_pull_at_the_base():
    """The head learns by likelihood alone, or it would make the matching easy by a wide base."""
    network = curved(FlowMatching)
    theta, features = normal(6, DIMS), normal(6, FEATURES, seed=2)
    noise, time = normal(6, 2, DIMS, seed=3), torch.full((6, 2, 1), 0.3, dtype=torch.float64)
    losses = network.loss(theta, features, noise, time).sum()
    mean, factor, log_det = network.head(features)
    whitened = (factor @ (theta - mean).unsqueeze(-1)).squeeze(-1)
    likelihood = (0.5 * whitened.square().sum(-1) - log_det).sum()
    grads = (torch.autograd.grad(value, network.head.weight)[0] for value in (losses, likelihood))
    torch.testing.assert_close(*grads, rtol=0, atol=1e-12)


def test_blocks_of_points_make_no_difference(monkeypatch):
    network, features, theta = curved(FlowMatching), normal(6, FEATURES), normal(6, 5, DIMS, seed=2)
    densities = []
    for tangents in (10**9, 1, 4 * DIMS * WIDTH):
        monkeypatch.setitem(flow_matching._TANGENTS, "cpu", tangents)
        with torch.no_grad():
            densities.append(network.log_prob(theta, features, steps=3))
        torch.testing.assert_close(densities[-1], densities[0], rtol=0, atol=1e-12)


def test_density_of_a_flow_is_that_of_the_sampling_map():
    """The backward rule undoes the forward rule but for O(1/steps^3).

    Each errs by order two, and the leading errors cancel: they are odd in the step.
    """
    network, steps, errors = curved(FlowMatching), [4, 8, 16], []
    noise, features = normal(2, 2, DIMS), normal(2, FEATURES, seed=2)
    for count in steps:
        points, expected = density_by_autograd(network, noise, features, count)
        with torch.no_grad():
            density = network.log_prob(points, features, steps=count)
        errors.append(float((density - expected).abs().max()))
    assert 2.4 < -np.polyfit(np.log(steps), np.log(errors), 1)[0] < 3.5
    assert errors[-1] < 5e-3


def banana(n, seed):
    """Features of x; theta_1 ~ N(x, 1/4), theta_2 ~ N(2 theta_1^2, 1/4); and their density."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(-1, 1, n)
    first = x + 0.5 * rng.standard_normal(n)
    second = 2 * first**2 + 0.5 * rng.standard_normal(n)
    density = norm.logpdf(first, x, 0.5) + norm.logpdf(second, 2 * first**2, 0.5)
    return (*map(torch.from_numpy, (np.c_[x, x**2], np.c_[first, second])), density)


def test_a_trained_network_has_the_density_of_a_known_posterior():
    """A divergence is not negative, and a few hundredths of a nat here, within 3.3 standard errors
    (false alarm 1e-3). Given x, the best Gaussian leaves log(1 + 8 / 4) / 2 = 0.55 nats.
    """
    network, rng = built(FlowMatching, 2, 2, width=48, blocks=2), torch.Generator().manual_seed(2)
    features, theta = (values.float() for values in banana(20_000, 1)[:2])
    optimiser = torch.optim.AdamW(network.parameters(), lr=1e-2, weight_decay=0.0)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, 1e-2, total_steps=400)
    for _ in range(400):
        rows = torch.randint(len(theta), (256,), generator=rng)
        noise, time = (
            f((256, 2, k), generator=rng) for f, k in ((torch.randn, 2), (torch.rand, 1))
        )
        optimiser.zero_grad()
        network.loss(theta[rows], features[rows], noise, time).mean().backward()
        optimiser.step()
        schedule.step()
    features, theta, exact = banana(1000, 3)
    with torch.no_grad():
        density = network.double().log_prob(theta[:, None], features, steps=24)[:, 0].numpy()
    gaps = exact - density
    error = gaps.std(ddof=1) / math.sqrt(len(gaps))
    assert error < 0.015
    assert -3.3 * error < gaps.mean() < 0.02 + 3.3 * error
