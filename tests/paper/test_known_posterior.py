"""A network trained on a problem whose curved posterior is known in closed form."""

import math

import numpy as np
import torch
from scipy.stats import norm

from breaker.networks.flow_matching import FlowMatching
from tests.networks_fixtures import built

SD = 0.5


def banana(n, seed):
    """Features of x; theta_1 ~ N(x, SD^2), theta_2 ~ N(2 theta_1^2, SD^2); and their density."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(-1, 1, n)
    first = x + SD * rng.standard_normal(n)
    second = 2 * first**2 + SD * rng.standard_normal(n)
    density = norm.logpdf(first, x, SD) + norm.logpdf(second, 2 * first**2, SD)
    return np.stack([x, x**2], axis=1), np.stack([first, second], axis=1), density


def trained(steps=500):
    """A network trained on the banana, in a few seconds."""
    network = built(FlowMatching, 2, 2, width=48, blocks=2)
    features, theta = (torch.from_numpy(v).float() for v in banana(20_000, 1)[:2])
    rng = torch.Generator().manual_seed(2)
    optimiser = torch.optim.AdamW(network.parameters(), lr=1e-2, weight_decay=0.0)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, 1e-2, total_steps=steps)
    for _ in range(steps):
        rows = torch.randint(len(theta), (256,), generator=rng)
        noise = torch.randn((256, 2, 2), generator=rng)
        time = torch.rand((256, 2, 1), generator=rng)
        optimiser.zero_grad()
        network.loss(theta[rows], features[rows], noise, time).mean().backward()
        optimiser.step()
        schedule.step()
    return network.double()


def test_a_trained_network_has_the_density_of_a_known_posterior():
    """A divergence is not negative, and a few hundredths of a nat here.

    Given x and theta_1 - x = SD u, the best Gaussian cannot follow 2 SD^2 (u^2 - 1), of variance
    8 SD^4 beside SD^2: it leaves log(1 + 8 SD^2) / 2 = 0.55 nats. The mean of log p - log q over
    fresh rows may be off by 3.3 standard errors, a false-alarm probability of 1e-3.
    """
    network = trained()
    features, theta, exact = banana(1000, 3)
    points, condition = torch.from_numpy(theta[:, None]), torch.from_numpy(features)
    with torch.no_grad():
        density = network.log_prob(points, condition, steps=24)[:, 0].numpy()
    gaps = exact - density
    error = gaps.std(ddof=1) / math.sqrt(len(gaps))
    assert -3.3 * error < gaps.mean() < 0.02 + 3.3 * error
    assert error < 0.015
