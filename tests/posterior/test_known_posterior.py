"""Networks trained on a problem whose curved posterior is known in closed form."""

import math
from typing import NamedTuple

import numpy as np
import pytest
import torch
from scipy.stats import norm
from torch import nn

from breaker.networks.coupling_flow import CouplingFlow
from breaker.networks.flow_matching import FlowMatching
from tests.networks import test_coupling_flow, test_flow_matching
from tests.networks_fixtures import MARKS, built, normal

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


class Case(NamedTuple):
    """A kind of network, planted faults, how it is trained, and how closely it is judged."""

    kind: type[nn.Module]
    sizes: dict
    faults: tuple[type[nn.Module], ...]
    training: int  # steps
    steps: int  # of the solver
    rows: int
    nats: float  # that it may be off
    error: float  # of the estimate, at most

    def built(self, kind=None):
        return built(kind or self.kind, 2, 2, **self.sizes)

    def divergence(self, network, kind=None):
        """Mean of log p - log q over fresh rows, and its standard error: KL(p | q).

        By the density of a network of another kind, if any, that is given the weights.
        """
        judged = self.built(kind).double()
        judged.load_state_dict(network.state_dict())
        features, theta = banana(self.rows, 3)
        points, condition = torch.from_numpy(theta[:, None]), torch.from_numpy(features)
        with torch.no_grad():
            density = judged.log_prob(points, condition, steps=self.steps)[:, 0].numpy()
        gaps = banana_density(theta, features[:, 0]) - density
        return gaps.mean(), gaps.std(ddof=1) / math.sqrt(len(gaps))


COUPLING = {"transforms": 2, "bins": 8, "hidden": [32, 32]}
CASES = {
    "flow matching": Case(
        FlowMatching,
        {"width": 48, "blocks": 2},
        test_flow_matching.FAULTS,
        500,
        24,
        1000,
        0.02,
        0.01,
    ),
    "coupling flow": Case(
        CouplingFlow, COUPLING, test_coupling_flow.FAULTS, 600, 1, 4000, 0.05, 0.015
    ),
}


@pytest.fixture(scope="module", params=CASES)
def trained(request):
    """A network trained on the banana, in a few seconds, and its case."""
    case = CASES[request.param]
    network = case.built()
    features, theta = (torch.from_numpy(v).float() for v in banana(20_000, 1))
    rng = torch.Generator().manual_seed(2)
    batch = 512
    optimiser = torch.optim.AdamW(network.parameters(), lr=1e-2, weight_decay=0.0)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, 1e-2, total_steps=case.training)
    for _ in range(case.training):
        rows = torch.randint(len(theta), (batch,), generator=rng)
        noise = torch.randn((batch, 2, 2), generator=rng)
        time = torch.rand((batch, 2, 1), generator=rng)
        optimiser.zero_grad()
        network.loss(theta[rows], features[rows], noise, time).mean().backward()
        optimiser.step()
        schedule.step()
    return case, network.double()


def test_a_trained_network_has_the_density_of_a_known_posterior(trained):
    """A divergence is not negative, and a few hundredths of a nat here.

    Given x and theta_1 - x = SD u, the best Gaussian cannot follow 2 SD^2 (u^2 - 1), of variance
    8 SD^4 beside SD^2: it leaves log(1 + 8 SD^2) / 2 = 0.55 nats. Estimates may be off by 3.3
    standard errors, a false-alarm probability of 1e-3.
    """
    case, network = trained
    estimate, error = case.divergence(network)
    assert -3.3 * error < estimate < case.nats + 3.3 * error
    assert error < case.error
    for fault in case.faults:
        wrong, wrong_error = case.divergence(network, fault)
        assert not -3.3 * wrong_error < wrong < case.nats + 3.3 * wrong_error
    base = case.built().double()
    base.head.load_state_dict(network.head.state_dict())
    of_base, base_error = case.divergence(base)
    assert of_base > 0.5 * math.log(1 + 8 * SD**2) - 3.3 * base_error


def test_draws_of_a_trained_network_are_those_of_a_known_posterior(trained):
    """Residuals of the banana's two equations are independent standard normal numbers.

    A Gaussian of the same mean and covariance leaves second residuals that depend on the first.
    The network errs a little, so that bounds are 0.1 beyond what 4,000 exact draws give with a
    false-alarm probability of 1e-3 (five numbers, 3.8 standard errors of at most sqrt(2/4000)).
    """
    x, d = 0.6, 4000
    case, network = trained
    features = torch.tensor([[x, x**2]], dtype=torch.float64)
    noise = normal(1, d, 2, seed=4)
    with torch.no_grad():
        draws = network.sample(noise, features, steps=case.steps)[0].numpy()
        of_base = network.base(features).restore(noise)[0].numpy()

    def worst(draws):
        first = (draws[:, 0] - x) / SD
        second = (draws[:, 1] - 2 * draws[:, 0] ** 2) / SD
        moments = np.cov(first, second)
        off = [first.mean(), second.mean(), *(moments - np.eye(2))[np.triu_indices(2)]]
        return np.abs([*off, np.corrcoef(first**2, second)[0, 1]]).max()

    assert worst(draws) < 0.1 + 3.8 * math.sqrt(2 / d)
    assert worst(of_base) > 0.1 + 3.8 * math.sqrt(2 / d)
