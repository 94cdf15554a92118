"""Summary networks against forward passes written out by hand, in float64."""

import numpy as np
import pytest
import torch
from torch.nn import functional

from breaker.networks.summary import OwnNetwork, TimeSeriesNetwork, build
from tests.networks_fixtures import NETWORK, arrays, built, perturb, residual_by_hand

# No two sizes alike, so that no axis can pass for another. The convolutions leave 8 steps, of
# which the skip GRU takes the last 6.
SAMPLES = 23
SIZES = {"features": 7, "components": 9, "channels": (3, 5), "kernels": (4, 3), "strides": (2, 1)}
SIZES |= {"gru_width": 4, "skip": 3, "skip_width": 2, "width": 11, "blocks": 2}


def steps_by_hand(series, network):
    """What the convolutions make of one scaled series, ``(steps, channels)``."""
    w, x = network.convolutions.state_dict(), torch.from_numpy(series)[None]
    for layer, stride in zip("02", SIZES["strides"], strict=True):
        x = functional.conv1d(x, w[f"{layer}.weight"], w[f"{layer}.bias"], stride=stride)
        x = functional.silu(x)
    return x.T


def gru_by_hand(steps, gru, skip):
    """States of the last ``skip`` steps, where a state follows from that ``skip`` steps before."""
    cell = torch.nn.GRUCell(gru.input_size, gru.hidden_size).double()
    cell.load_state_dict({name.removesuffix("_l0"): w for name, w in gru.state_dict().items()})
    states = [torch.zeros(1, gru.hidden_size).double()] * skip
    for step in steps[len(steps) % skip :]:
        states.append(cell(step[None], states[-skip]))
    return torch.cat(states[-skip:]).detach().numpy().ravel()


def network_by_hand(record, network):
    w = arrays(network)
    centred = record - w["centre"]
    steps = steps_by_hand(centred / w["scale"], network)
    parts = [
        w["highway.weight"] @ centred + w["highway.bias"],
        gru_by_hand(steps, network.gru, 1),
        gru_by_hand(steps, network.skip_gru, SIZES["skip"]),
    ]
    return residual_by_hand(np.concatenate(parts), network.join, SIZES["blocks"])


def test_whole_network_by_hand():
    network = perturb(built(TimeSeriesNetwork, SAMPLES, **SIZES).double(), 0.4)
    rng = np.random.default_rng(5)
    records = rng.standard_normal((6, SAMPLES))
    centre, components = rng.standard_normal(SAMPLES), rng.standard_normal((SAMPLES, 9))
    network.freeze(*map(torch.from_numpy, (centre, np.array(1.7), components)))
    result = network(torch.from_numpy(records)).detach().numpy()
    expected = np.stack([network_by_hand(record, network) for record in records])
    np.testing.assert_allclose(result, expected, rtol=0, atol=1e-12)


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
    with pytest.raises(ValueError, match=r"maps \(2, 23\) to \(2, 5\), not to \(2, 7\)"):
        OwnNetwork(torch.nn.Linear(SAMPLES, 5), SAMPLES, 7)
