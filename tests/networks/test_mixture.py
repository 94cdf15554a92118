"""The autoregressive mixture: a density, with atoms, whose draws from arrays are its own."""

import numpy as np
import pytest
import torch
from scipy.integrate import cumulative_trapezoid
from scipy.stats import kstest

from breaker.family.networks import Network
from breaker.family.training import FamilyNetwork

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
        {name: item.numpy() for name, item in made.state_dict().items()},
        made.inference.atoms.tolist(),
    )


def test_the_density_is_one_over_all_outputs():
    """Also where an output is an atom with some probability."""
    line = torch.linspace(-12.0, 12.0, 161, dtype=torch.float64)
    first, second = torch.cartesian_prod(line, line).T
    theta = torch.stack([first, second, 0.0 * first], dim=1)
    there = torch.tensor([1.0, 1.0, 0.0]).expand(len(theta), 3)  # the third is not there
    features = 0.3 * torch.ones(len(theta), 6, dtype=torch.float64)
    density = network().inference.log_prob(theta, features, there).sum(dim=1).exp()
    assert density.sum() * (line[1] - line[0]) ** 2 == pytest.approx(1.0, abs=1e-3)
    mixture, line = network(atoms=(True, False, False)).inference, torch.linspace(-15, 15, 3001)
    theta = torch.stack([line + 1e-6, 0.0 * line, 0.0 * line], dim=1).double()
    theta[-1] = 0.0  # the atom
    there = torch.tensor([1.0, 0.0, 0.0]).expand(3001, 3)
    *free, atom = mixture.log_prob(theta, features[:3001], there)[:, 0].exp().tolist()
    assert 0.05 < atom < 0.95
    assert sum(free) * 0.01 + atom == pytest.approx(1.0, abs=1e-3)


def test_draws_of_arrays_are_of_the_density():
    """Conditional probabilities of draws, each output given those before it, are uniform.

    By quadrature of the torch density; two outputs that are there, and one that is not. Two tests
    at 2.5e-4 each: a false alarm has a probability of 5e-4.
    """
    made = network(size=0.3)
    with torch.no_grad():
        made.inference.head.bias[7] = 1.5  # what the third output has of the first
    arrays = read(made)
    x = np.full((1, 4), 0.7)
    features = arrays.features(x)[0]
    np.testing.assert_allclose(features, made.summary(torch.as_tensor(x))[0], rtol=1e-12)
    known = np.array([True, False, True])
    draws = arrays.sample(features[None], known, 400, np.random.default_rng(5))[0]
    there = torch.as_tensor(known.astype(float)).expand(201, 3)
    condition = torch.as_tensor(np.tile(features, (201, 1)))
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
        assert kstest(places, "uniform").pvalue > 2.5e-4


def test_atoms_are_drawn_as_often_as_they_are_probable():
    """Planted fault: an output does not see which before it are atoms, and the second is 0 as often
    whether the first is or not. Beyond 3.5 sd with a probability of 5e-4 each."""
    made = network(size=0.3, atoms=(True, True, False))
    with torch.no_grad():
        made.inference.enter[1, 3] = 3.0  # what the second sees of the first
    arrays = read(made)
    features = arrays.features(np.full((1, 4), 0.7))
    there, n = np.array([True, True, False]), 20_000
    zero = arrays.sample(features, there, n, np.random.default_rng(3))[0] == 0.0
    given = (
        torch.zeros(1, 3).double(),
        torch.as_tensor(features),
        torch.as_tensor(there[None] * 1.0),
    )
    shares = made.inference.log_prob(*given)[0].exp().tolist()
    for atoms, share in zip((zero[:, 0], zero[zero[:, 0], 1]), shares, strict=False):
        assert abs(atoms.mean() - share) < 3.5 * np.sqrt(share * (1.0 - share) / atoms.size)
    assert zero[:, 2].all()
