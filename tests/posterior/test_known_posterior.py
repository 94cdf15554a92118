"""Flow matching trained on a problem whose curved posterior is known in closed form."""

import math

import numpy as np
import pytest
import torch
from scipy.stats import norm

from breaker.networks.flow_matching import FlowMatching
from tests.networks_fixtures import (
    MARKS,
    NoScale,
    WrongSign,
    built,
    normal,
    one_thread,  # noqa: F401
)

pytestmark = MARKS

SD = 0.5


def banana(n, seed):
    """Features of x, and theta: theta_1 ~ N(x, SD^2), theta_2 ~ N(2 theta_1^2, SD^2)."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(-1, 1, n)
    first = x + SD * rng.standard_normal(n)
    second = 2 * first**2 + SD * rng.standard_normal(n)
    return np.stack([x, x**2], axis=1), np.stack([first, second], axis=1)


def banana_density(theta, x):
    first, second = theta.T
    return norm.logpdf(first, x, SD) + norm.logpdf(second, 2 * first**2, SD)


@pytest.fixture(scope="module")
def trained():
    """A network trained on the banana, in a few seconds."""
    network = built(FlowMatching, 2, 2, width=48, blocks=2)
    features, theta = (torch.from_numpy(v).float() for v in banana(20_000, 1))
    rng = torch.Generator().manual_seed(2)
    steps, batch = 500, 512
    optimiser = torch.optim.AdamW(network.parameters(), lr=1e-2, weight_decay=0.0)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, 1e-2, total_steps=steps)
    for _ in range(steps):
        rows = torch.randint(len(theta), (batch,), generator=rng)
        noise = torch.randn((batch, 2, 2), generator=rng)
        time = torch.rand((batch, 2, 1), generator=rng)
        optimiser.zero_grad()
        network.loss(theta[rows], features[rows], noise, time).mean().backward()
        optimiser.step()
        schedule.step()
    return network.double()


def divergence(network, judged, *, rows, steps):
    """Mean of log p - log q over fresh rows, and its standard error: the divergence KL(p | q).

    By the density of another network, ``judged``, that is given the weights.
    """
    judged = judged.double()
    judged.load_state_dict(network.state_dict())
    features, theta = banana(rows, 3)
    points, condition = torch.from_numpy(theta[:, None]), torch.from_numpy(features)
    with torch.no_grad():
        density = judged.log_prob(points, condition, steps=steps)[:, 0].numpy()
    gaps = banana_density(theta, features[:, 0]) - density
    return gaps.mean(), gaps.std(ddof=1) / math.sqrt(len(gaps))


def gap(network, kind=FlowMatching):
    return divergence(network, built(kind, 2, 2, width=48, blocks=2), rows=1000, steps=24)


def test_a_trained_network_has_the_density_of_a_known_posterior(trained):
    """A divergence is not negative, and below 0.02 nats here.

    Given x and theta_1 - x = SD u, the best Gaussian cannot follow 2 SD^2 (u^2 - 1), of variance
    8 SD^4 beside SD^2: it leaves log(1 + 8 SD^2) / 2 = 0.55 nats. Estimates may be off by 3.3
    standard errors, a false-alarm probability of 1e-3.
    """
    estimate, error = gap(trained)
    assert -3.3 * error < estimate < 0.02 + 3.3 * error
    assert error < 0.01
    for fault in (WrongSign, NoScale):
        wrong, wrong_error = gap(trained, fault)
        assert not -3.3 * wrong_error < wrong < 0.02 + 3.3 * wrong_error
    base = built(FlowMatching, 2, 2, width=48, blocks=2).double()
    base.head.load_state_dict(trained.head.state_dict())
    of_base, base_error = gap(base)
    assert of_base > 0.5 * math.log(1 + 8 * SD**2) - 3.3 * base_error


def test_draws_of_a_trained_network_are_those_of_a_known_posterior(trained):
    """Residuals of the banana's two equations are independent standard normal numbers.

    A Gaussian of the same mean and covariance leaves second residuals that depend on the first.
    The network errs a little, so that bounds are 0.1 beyond what 4,000 exact draws give with a
    false-alarm probability of 1e-3 (five numbers, 3.8 standard errors of at most sqrt(2/4000)).
    """
    x, d = 0.6, 4000
    features = torch.tensor([[x, x**2]], dtype=torch.float64)
    noise = normal(1, d, 2, seed=4)
    with torch.no_grad():
        draws = trained.sample(noise, features, steps=16)[0].numpy()
        mean, factor, _ = trained.base(features)
        gaussian_draws = mean[0].numpy() + noise[0].numpy() @ np.linalg.inv(factor[0].numpy()).T

    def worst(draws):
        first = (draws[:, 0] - x) / SD
        second = (draws[:, 1] - 2 * draws[:, 0] ** 2) / SD
        moments = np.cov(first, second)
        off = [first.mean(), second.mean(), *(moments - np.eye(2))[np.triu_indices(2)]]
        return np.abs([*off, np.corrcoef(first**2, second)[0, 1]]).max()

    assert worst(draws) < 0.1 + 3.8 * math.sqrt(2 / d)
    assert worst(gaussian_draws) > 0.1 + 3.8 * math.sqrt(2 / d)
