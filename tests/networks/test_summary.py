"""Summary networks against forward passes written out by hand, in float64."""

import numpy as np
import pytest
import torch

from breaker.networks.summary import OwnNetwork, TimeSeriesNetwork, build
from tests.networks_fixtures import (
    NETWORK,
    arrays,
    built,
    gradients_of,
    perturb,
    residual_by_hand,
    silu,
)

# No two sizes alike, so that no axis can pass for another. The convolutions leave 8 steps, of
# which the skip GRU takes the last 6.
SAMPLES = 23
SIZES = {
    "features": 7,
    "components": 9,
    "channels": (3, 5),
    "kernels": (4, 3),
    "strides": (2, 1),
    "gru_width": 4,
    "skip": 3,
    "skip_width": 2,
    "width": 11,
    "blocks": 2,
}


@pytest.fixture
def network():
    return perturb(built(TimeSeriesNetwork, SAMPLES, **SIZES).double(), 0.4)


@pytest.fixture
def records():
    return np.random.default_rng(1).standard_normal((6, SAMPLES))


def sigmoid(x):
    return 1.0 / (1.0 + np.exp(-x))


def convolved(series, weight, bias, stride):
    """Sums over channels and taps, ``(channels in, t) -> (channels out, steps)``."""
    channels_out, channels_in, kernel = weight.shape
    steps = (series.shape[1] - kernel) // stride + 1
    out = np.zeros((channels_out, steps))
    for c in range(channels_out):
        for k in range(steps):
            out[c, k] = bias[c]
            for j in range(channels_in):
                for tap in range(kernel):
                    out[c, k] += weight[c, j, tap] * series[j, k * stride + tap]
    return out


def gru_cell(x, h, w):
    """One step of a gated recurrent unit (Cho et al. 2014; gates in the order r, z, n)."""
    w_r, w_z, w_n = np.split(w["weight_ih_l0"], 3)
    u_r, u_z, u_n = np.split(w["weight_hh_l0"], 3)
    b_r, b_z, b_n = np.split(w["bias_ih_l0"], 3)
    c_r, c_z, c_n = np.split(w["bias_hh_l0"], 3)
    r = sigmoid(w_r @ x + b_r + u_r @ h + c_r)
    z = sigmoid(w_z @ x + b_z + u_z @ h + c_z)
    n = np.tanh(w_n @ x + b_n + r * (u_n @ h + c_n))
    return (1.0 - z) * n + z * h


def gru_by_hand(steps, w):
    """Last state of a GRU over ``(steps, channels)``."""
    h = np.zeros(w["weight_hh_l0"].shape[1])
    for x in steps:
        h = gru_cell(x, h, w)
    return h


def skip_gru_by_hand(steps, skip, w):
    """States of the last ``skip`` steps, where a state follows from that ``skip`` steps before."""
    start = len(steps) % skip
    states = {}
    for k in range(start, len(steps)):
        before = states.get(k - skip, np.zeros(w["weight_hh_l0"].shape[1]))
        states[k] = gru_cell(steps[k], before, w)
    return np.concatenate([states[k] for k in range(len(steps) - skip, len(steps))])


def steps_by_hand(series, network):
    """What the convolutions make of one scaled series, ``(steps, channels)``."""
    w = arrays(network.convolutions)
    first = silu(convolved(series[None], w["0.weight"], w["0.bias"], SIZES["strides"][0]))
    return silu(convolved(first, w["2.weight"], w["2.bias"], SIZES["strides"][1])).T


def network_by_hand(record, network):
    w = arrays(network)
    centred = record - w["centre"]
    steps = steps_by_hand(centred / w["scale"], network)
    parts = [
        w["highway.weight"] @ centred + w["highway.bias"],
        gru_by_hand(steps, arrays(network.gru)),
        skip_gru_by_hand(steps, SIZES["skip"], arrays(network.skip_gru)),
    ]
    return residual_by_hand(np.concatenate(parts), network.join, SIZES["blocks"])


def test_whole_network_by_hand(network, records):
    rng = np.random.default_rng(5)
    centre, components = rng.standard_normal(SAMPLES), rng.standard_normal((SAMPLES, 9))
    network.freeze(*map(torch.from_numpy, (centre, np.array(1.7), components)))
    result = network(torch.from_numpy(records)).detach().numpy()
    expected = np.stack([network_by_hand(record, network) for record in records])
    np.testing.assert_allclose(result, expected, rtol=0, atol=1e-12)


def test_gradients_reach_every_weight_and_scales_stay_frozen():
    network = built(TimeSeriesNetwork, SAMPLES, **SIZES)
    network.freeze(torch.full((SAMPLES,), 0.5), torch.tensor(3.0), torch.ones(SAMPLES, 9) / 20)
    buffers = {name: value.clone() for name, value in network.named_buffers()}
    x = torch.from_numpy(np.random.default_rng(7).standard_normal((32, SAMPLES))).float()
    gradients_of(network, lambda: network(x).square().mean(), steps=2, rate=0.1)
    assert set(buffers) == {"centre", "scale"}
    for name, value in network.named_buffers():
        torch.testing.assert_close(value, buffers[name], rtol=0, atol=0)


@pytest.mark.parametrize("role", ["summary", "inference"])
def test_an_unknown_kind_is_named(role):
    wrong = {**NETWORK, role: {**NETWORK[role], "kind": "oracle"}}
    with pytest.raises(ValueError, match=f"unknown {role} network 'oracle'; known: "):
        build(wrong, samples=31, dims=5)


def own(samples, features):
    """A summary network of a user, as the configuration names it."""
    return torch.nn.Linear(samples, features)


def test_an_own_network_sees_centred_and_scaled_series():
    wanted = {"kind": "tests.networks.test_summary:own", "features": 12, "components": 8}
    settings = {**NETWORK, "summary": wanted}
    summary, inference = built(build, settings, samples=SAMPLES, dims=5)
    x, centre = torch.randn(6, SAMPLES), torch.randn(SAMPLES)
    summary.freeze(centre, torch.tensor(1.7), torch.ones(SAMPLES, 8))
    expected = summary.network((x - centre) / 1.7)
    torch.testing.assert_close(summary(x), expected, rtol=0, atol=1e-6)
    assert inference.head.in_features == 12


def test_an_own_network_of_another_shape_is_refused():
    with pytest.raises(ValueError, match=r"maps \(2, 23\) to \(2, 5\), not to \(2, 7\)"):
        OwnNetwork(torch.nn.Linear(SAMPLES, 5), SAMPLES, 7)
