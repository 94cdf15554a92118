"""The autoregressive mixture: a density, with atoms, whose draws from arrays are its own."""

import numpy as np
import pytest
import torch
from scipy.integrate import cumulative_trapezoid
from scipy.stats import kstest

from breaker.family.networks import Network
from breaker.family.training import FamilyNetwork
from breaker.networks.mixture import AutoregressiveMixture

SIZES = {"width": 12, "blocks": 2, "features": 6, "components": 3, "head": 5}


def network(atoms: tuple[bool, ...] = (), seed: int = 3, size: float = 0.2) -> FamilyNetwork:
    """An untrained network with random weights of some size."""
    made = FamilyNetwork(SIZES, "levels", (4, 3), atoms=atoms, seed=seed)
    rng = torch.Generator().manual_seed(seed)
    with torch.no_grad():
        for weight in made.parameters():
            weight.copy_(size * torch.randn(weight.shape, generator=rng))
    return made.double().requires_grad_(False)


def read(made: FamilyNetwork) -> Network:
    """The same without torch."""
    return Network(
        {name: each.numpy() for name, each in made.state_dict().items()},
        made.inference.atoms.tolist(),
    )


def test_the_density_is_one_over_all_outputs():
    mixture = network().inference
    line = torch.linspace(-12.0, 12.0, 161, dtype=torch.float64)
    points = torch.cartesian_prod(line, line)
    theta = torch.cat([points, torch.zeros(len(points), 1)], dim=1)
    there = torch.tensor([1.0, 1.0, 0.0]).expand(len(theta), 3)  # the third is not there
    features = 0.3 * torch.ones(len(theta), 6, dtype=torch.float64)
    density = mixture.log_prob(theta, features, there).sum(dim=1).exp()
    assert density.sum() * (line[1] - line[0]) ** 2 == pytest.approx(1.0, abs=1e-3)


def test_atoms_have_a_probability_and_the_rest_the_rest():
    mixture = network(atoms=(True, False, False)).inference
    line = torch.linspace(-15.0, 15.0, 3001, dtype=torch.float64)[:, None]
    theta = torch.cat([line + 1e-6, torch.zeros(len(line), 2)], dim=1)
    there = torch.tensor([1.0, 0.0, 0.0]).expand(len(theta), 3)
    features = 0.3 * torch.ones(len(theta), 6, dtype=torch.float64)
    free = mixture.log_prob(theta, features, there)[:, 0].exp().sum() * 0.01
    atom = mixture.log_prob(0.0 * theta[:1], features[:1], there[:1])[0, 0].exp()
    assert 0.05 < atom < 0.95
    assert free + atom == pytest.approx(1.0, abs=1e-3)


def test_features_of_arrays_are_those_of_torch():
    made = network()
    x = np.random.default_rng(1).standard_normal((4, 4))
    with torch.no_grad():
        expected = made.summary(torch.as_tensor(x)).numpy()
    np.testing.assert_allclose(read(made).features(x), expected, rtol=1e-12)


def p_value_of_draws(made: FamilyNetwork, arrays: Network) -> float:
    """Of uniform conditional probabilities of draws, each output given those before it.

    By quadrature of the torch density; two outputs that are there, and one that is not.
    """
    x = np.full((1, 4), 0.7)
    features = arrays.features(x)[0]
    told = np.array([True, False, True])
    draws = arrays.sample(features[None], told, 400, np.random.default_rng(5))[0]
    there = torch.as_tensor(told.astype(float)).expand(201, 3)
    condition = torch.as_tensor(np.tile(features, (201, 1)))
    found = []
    for i in (0, 2):
        far = np.ptp(draws[:, i])
        line = np.linspace(draws[:, i].min() - far, draws[:, i].max() + far, 201)
        places = []
        for draw in draws:
            theta = np.tile(draw, (len(line), 1))
            theta[:, i] = line
            density = made.inference.log_prob(torch.as_tensor(theta), condition, there)[:, i]
            below = cumulative_trapezoid(np.exp(density.numpy()), initial=0.0)
            places.append(np.interp(draw[i], line, below / below[-1]))
        found.append(kstest(places, "uniform").pvalue)
    return min(found)


def test_draws_of_arrays_are_of_the_density():
    # Two tests at 2.5e-4 each: a false alarm has a probability of 5e-4.
    made = network(size=0.3)
    with torch.no_grad():
        made.inference.head.bias[7] = 1.5  # what the third output has of the first
    assert p_value_of_draws(made, read(made)) > 2.5e-4


def test_atoms_are_drawn_as_often_as_they_are_probable():
    made = network(atoms=(True, True, False))
    arrays = read(made)
    features = arrays.features(np.full((1, 4), 0.7))[0]
    told, n = np.array([True, False, False]), 20_000
    draws = arrays.sample(features[None], told, n, np.random.default_rng(2))[0]
    with torch.no_grad():
        log_share = made.inference.log_prob(
            torch.zeros(1, 3, dtype=torch.float64),
            torch.as_tensor(features)[None],
            torch.as_tensor(told.astype(float))[None],
        )[0, 0]
    share = float(log_share.exp())
    # Beyond 3.5 sd with a probability of 5e-4.
    assert abs((draws[:, 0] == 0.0).mean() - share) < 3.5 * np.sqrt(share * (1.0 - share) / n)
    assert (draws[:, 1:] == 0.0).all()


def test_an_output_sees_which_before_it_are_atoms():
    """Planted fault: that of the first is not kept, and the second is 0 as often as without it."""
    made = network(size=0.3, atoms=(True, True, False))
    with torch.no_grad():
        made.inference.enter[1, 3] = 3.0  # what the second sees of it
    arrays = read(made)
    features = arrays.features(np.full((1, 4), 0.7))[0]
    told, n = np.array([True, True, False]), 20_000
    draws = arrays.sample(features[None], told, n, np.random.default_rng(3))[0]
    after = draws[draws[:, 0] == 0.0, 1] == 0.0
    with torch.no_grad():
        log_share = made.inference.log_prob(
            torch.zeros(1, 3, dtype=torch.float64),
            torch.as_tensor(features)[None],
            torch.as_tensor(told.astype(float))[None],
        )[0, 1]
    share = float(log_share.exp())
    # Beyond 3.5 sd with a probability of 5e-4.
    assert abs(after.mean() - share) < 3.5 * np.sqrt(share * (1.0 - share) / after.size)


def test_a_mixture_learns_a_posterior_that_is_known():
    rng = torch.Generator().manual_seed(4)
    torch.manual_seed(4)
    torch.set_num_threads(1)  # small arrays: more threads only wait for each other
    mixture = AutoregressiveMixture(2, 1, components=4, width=16)
    optimiser = torch.optim.Adam(mixture.parameters(), lr=0.01)
    for _ in range(250):
        s = torch.randn(128, 1, generator=rng)
        first = s + 0.5 * torch.randn(128, 1, generator=rng)
        second = first**2 + 0.2 * torch.randn(128, 1, generator=rng)  # curved
        theta = torch.cat([first, second], dim=1)
        loss = -mixture.log_prob(theta, s, torch.ones_like(theta)).sum(dim=1).mean()
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
    exact = np.log(0.5 * 0.2) + 1.0 + np.log(2.0 * np.pi)  # entropy of both
    assert float(loss.detach()) < exact + 0.3
