"""Muon: steps are orthogonal, and only matrices between hidden layers take them."""

import torch

from breaker.networks.blocks import Hidden, ResidualMLP
from breaker.networks.training import full_width, optimisers, orthogonal
from tests.networks_fixtures import normal

RATES = {"learning_rate": 5e-3, "weight_decay": 0.01}


def test_a_step_is_nearly_orthogonal():
    for shape in ((20, 20), (12, 30), (30, 12)):
        matrix = normal(*shape).float()
        left, _, right = torch.linalg.svd(matrix, full_matrices=False)
        found = left.T @ orthogonal(torch.stack([matrix, -matrix]))[0] @ right.T
        assert (found.diagonal() > 0.6).all()
        assert (found.diagonal() < 1.3).all()
        assert (found - found.diagonal().diag()).abs().max() < 0.05


def test_matrices_between_hidden_layers_take_them():
    network = ResidualMLP(4, 16, 3, blocks=2)
    adamw, muon = optimisers(network, "muon", **RATES)
    of_muon = {id(weight) for weight in muon.param_groups[0]["params"]}
    hidden = [layer for layer in network.modules() if isinstance(layer, Hidden)]
    assert of_muon == {id(layer.weight) for layer in hidden}
    others = {id(weight) for weight in adamw.param_groups[0]["params"]}
    assert of_muon | others == {id(weight) for weight in network.parameters()}
    assert not of_muon & others
    _, edges = optimisers(network, "muon_edges", **RATES)
    matrices = {id(weight) for weight in network.parameters() if weight.ndim == 2}
    assert {id(weight) for weight in edges.param_groups[0]["params"]} == matrices > of_muon
    (alone,) = optimisers(network, "adamw", **RATES)
    assert len(alone.param_groups[0]["params"]) == len([*network.parameters()])


def test_the_full_width_rounds_nothing():
    x, y = normal(96, 300).float(), normal(300, 64).float()
    exact, size = x.double() @ y.double(), x.double().abs() @ y.double().abs()
    before = torch.backends.mkldnn.matmul.fp32_precision
    with full_width():
        found = x @ y
    # Of bfloat16 the error is some 2e-3 of the size.
    assert ((found - exact).abs() / size).max() < 1e-6
    assert ((x.bfloat16().double() @ y.double() - exact).abs() / size).max() > 1e-5
    assert torch.backends.mkldnn.matmul.fp32_precision == before
