"""Flow matching: loss, draws and density against closed forms and automatic differentiation."""

import math

import numpy as np
import torch
from scipy.stats import multivariate_normal

from breaker.networks import flow_matching
from breaker.networks.flow_matching import FlowMatching
from tests.networks_fixtures import arrays, built, density_by_autograd, normal, perturb, silu

DIMS, FEATURES, WIDTH, BLOCKS = 3, 4, 10, 2


def curved():
    """A network of random weights, whose density is far from a Gaussian."""
    return perturb(built(FlowMatching, DIMS, FEATURES, width=WIDTH, blocks=BLOCKS).double(), 0.35)


# ---- velocity field and loss --------------------------------------------------------------------


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
    network, n, k = curved(), 4, 5
    theta, features, noise = (
        normal(n, DIMS),
        normal(n, FEATURES, seed=2),
        normal(n, k, DIMS, seed=3),
    )
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
    network = curved()
    theta, features = normal(6, DIMS), normal(6, FEATURES, seed=2)
    noise, time = normal(6, 2, DIMS, seed=3), torch.full((6, 2, 1), 0.3, dtype=torch.float64)
    network.loss(theta, features, noise, time).sum().backward()
    from_loss = network.head.weight.grad.clone()
    network.zero_grad()
    mean, factor, log_det = network.head(features)
    whitened = (factor @ (theta - mean).unsqueeze(-1)).squeeze(-1)
    (0.5 * whitened.square().sum(-1) - log_det).sum().backward()
    torch.testing.assert_close(from_loss, network.head.weight.grad, rtol=0, atol=1e-12)


def test_blocks_of_points_make_no_difference(monkeypatch):
    network, features, theta = curved(), normal(6, FEATURES), normal(6, 5, DIMS, seed=2)
    densities = []
    for tangents in (10**9, 1, 4 * DIMS * WIDTH):
        monkeypatch.setitem(flow_matching._TANGENTS, "cpu", tangents)
        with torch.no_grad():
            densities.append(network.log_prob(theta, features, steps=3))
        torch.testing.assert_close(densities[-1], densities[0], rtol=0, atol=1e-12)


# ---- draws and density of a curved posterior -----------------------------------------------------


def test_density_is_that_of_the_sampling_map():
    """The backward rule undoes the forward rule but for O(1/steps^3).

    Each errs by order two, and the leading errors cancel: they are odd in the step.
    """
    network, steps, errors = curved(), [4, 8, 16], []
    noise, features = normal(2, 2, DIMS), normal(2, FEATURES, seed=2)
    for count in steps:
        points, expected = density_by_autograd(network, noise, features, count)
        with torch.no_grad():
            density = network.log_prob(points, features, steps=count)
        errors.append(float((density - expected).abs().max()))
    assert 2.4 < -np.polyfit(np.log(steps), np.log(errors), 1)[0] < 3.5
    assert errors[-1] < 5e-3
