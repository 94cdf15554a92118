"""Deep set: its highway and features against loops over records that have fewer samples."""

import math

import numpy as np
import pytest
import torch

from breaker.model.sensor import Sensor
from breaker.networks.deep_set import DeepSet, SetHighway
from breaker.paper.bank import principal_components
from tests.networks_fixtures import built, gradients_of, perturb, residual_by_hand

# No two sizes alike, so that no axis can pass for another.
SAMPLES, COMPONENTS, ROWS = 23, 3, 6
SENSOR = Sensor(start=-2.0, stop=20.0, samples=SAMPLES, noise_sd=0.2, onset_sd=0.0, zero_sd=0.3)
SIZES = {
    "features": 7,
    "components": COMPONENTS,
    "pair_width": 5,
    "pair_blocks": 1,
    "width": 11,
    "blocks": 2,
    "missing": 0.6,
}


@pytest.fixture(scope="module")
def bank():
    """Noise-free curves of four components, of which the highway gets three."""
    rng = np.random.default_rng(1)
    waves = np.sin(np.outer(np.arange(1, 5), np.linspace(0, 3, SAMPLES)) + 0.3)
    return rng.standard_normal((400, 4)) * [3.0, 1.0, 0.3, 0.1] @ waves + np.linspace(1, 2, SAMPLES)


@pytest.fixture(scope="module")
def components(bank):
    """Centre ``(t,)`` and components ``(t, c)`` of the bank."""
    return principal_components(bank, SENSOR, COMPONENTS)


@pytest.fixture(scope="module")
def network(components):
    mean, weights = map(torch.from_numpy, components)
    network = perturb(built(DeepSet, SAMPLES, **SIZES).double(), 0.4)
    sds = {"noise_sd": SENSOR.noise_sd, "offset_sd": SENSOR.zero_sd}
    network.freeze(mean, torch.tensor(1.7), weights, **sds)
    return network


@pytest.fixture(scope="module")
def records(bank):
    """Records with a third of the samples missing, one of them with three left."""
    rng = np.random.default_rng(2)
    records = SENSOR.corrupt(bank[:ROWS], rng)
    records[rng.random(records.shape) < 1 / 3] = np.nan
    records[4, :20] = np.nan
    return records


def tensors(*arrays):
    return tuple(torch.from_numpy(np.asarray(array)) for array in arrays)


# ---- the highway --------------------------------------------------------------------------------


def regressed_by_hand(record, components, bank):
    """Scores and sds of one record's components, by conditioning a joint Gaussian.

    Amplitudes a of ``mean + loadings a`` have unit variance; the record is what is present of it,
    with noise of the sensor's dense covariance. Scores are in units of their sd given a whole
    record, as is the plain highway.
    """
    mean, weights = components
    covariance = SENSOR.noise_sd**2 * np.eye(SAMPLES) + SENSOR.zero_sd**2
    whitened = SENSOR.whiten(bank - bank.mean(axis=0))
    signal = np.sort(np.linalg.eigvalsh(whitened.T @ whitened / len(bank)))[::-1][:COMPONENTS]
    loadings = covariance @ weights * np.sqrt(1 + signal) * np.sqrt(signal)
    there = ~np.isnan(record)
    mean, loadings = mean[there], loadings[there]
    m = there.sum()
    noise = SENSOR.noise_sd**2 * np.eye(m) + SENSOR.zero_sd**2
    gain = loadings.T @ np.linalg.inv(loadings @ loadings.T + noise)
    amplitudes = gain @ (record[there] - mean)
    variance = np.diag(np.eye(COMPONENTS) - gain @ loadings)
    whole = 1 / (1 + signal)  # posterior variance of an amplitude given a whole record
    # (record - mean) @ weights is sqrt(signal (1 + signal)) / signal times the mean amplitude
    return amplitudes * np.sqrt((1 + signal) / signal), 0.5 * np.log(variance / whole)


def test_highway_is_the_regression_on_the_samples_there(network, components, bank, records):
    (x,) = tensors(records)
    scores, log_sd, centred = network.highway(x)
    for i, record in enumerate(records):
        expected = regressed_by_hand(record, components, bank)
        np.testing.assert_allclose(scores[i].numpy(), expected[0], rtol=1e-7, atol=1e-7)
        np.testing.assert_allclose(log_sd[i].numpy(), expected[1], rtol=0, atol=1e-8)
    assert (centred[x.isnan()] == 0).all()
    # The one with three samples left knows far less.
    assert log_sd[4].max() > 1.0 > log_sd[[0, 1, 2, 3, 5]].max()
    # Planted fault: missing samples taken for the centre curve.
    filled = torch.where(x.isnan(), torch.from_numpy(components[0]), x)
    assert (network.highway(filled)[0] - scores).abs().max() > 0.5


def test_components_without_signal_do_no_harm():
    """As many components as samples, of curves that have four: the rest is noise."""
    rng = np.random.default_rng(1)
    curves = rng.standard_normal((400, 2)) @ rng.standard_normal((2, SAMPLES))
    mean, weights = principal_components(curves, SENSOR, SAMPLES)
    highway = SetHighway(SAMPLES, SAMPLES)
    highway.freeze(*tensors(mean, weights), noise_sd=SENSOR.noise_sd, offset_sd=SENSOR.zero_sd)
    whole = SENSOR.corrupt(curves[:5], rng)
    scores, log_sd, _ = highway(*tensors(whole))
    np.testing.assert_allclose(scores.numpy(), (whole - mean) @ weights, rtol=0, atol=1e-6)
    np.testing.assert_allclose(log_sd.numpy(), 0, rtol=0, atol=1e-6)


# ---- the whole network --------------------------------------------------------------------------


def features_by_hand(record, network, components, bank):
    """Features of one record, from the pairs that are there, one after the other."""
    pairs = []
    for k in np.flatnonzero(~np.isnan(record)):
        share = k / (SAMPLES - 1)
        centred = (record[k] - components[0][k]) / 1.7
        angles = math.pi * share * np.arange(1, 5)
        pair = np.r_[centred, 2 * share - 1, np.sin(angles), np.cos(angles)]
        pairs.append(residual_by_hand(pair, network.pair, SIZES["pair_blocks"]))
    scores, log_sd = regressed_by_hand(record, components, bank)
    joined = np.r_[scores, log_sd, np.mean(pairs, axis=0), len(pairs) / SAMPLES]
    return residual_by_hand(joined, network.join, SIZES["blocks"])


@torch.no_grad()
def test_network_by_hand_row_by_row_and_in_single_precision(network, components, bank, records):
    """Missing samples are not there: the hand has a loop over those that are."""
    (x,) = tensors(records)
    found = network(x)
    for i, record in enumerate(records):
        expected = features_by_hand(record, network, components, bank)
        np.testing.assert_allclose(found[i].numpy(), expected, rtol=0, atol=1e-6)
        torch.testing.assert_close(network(x[i : i + 1]), found[i : i + 1], rtol=0, atol=1e-10)
    single = built(DeepSet, SAMPLES, **SIZES)
    single.load_state_dict(network.state_dict())
    torch.testing.assert_close(single(x.float()).double(), found, rtol=0, atol=2e-3)


def test_gradients_are_finite_and_reach_every_weight(components, records):
    """NaN times zero is NaN: a missing sample must not reach a product, nor a derivative."""
    network = built(DeepSet, SAMPLES, **SIZES)
    network.freeze(*tensors(components[0], 2.0, components[1]), noise_sd=0.2, offset_sd=0.3)
    buffers = {name: value.clone() for name, value in network.named_buffers()}
    x = torch.from_numpy(records).float()
    x[0] = torch.nan
    gradients = gradients_of(network, lambda: network(x).square().mean(), steps=2)
    assert all(grad.isfinite().all() for grad in gradients.values())
    for name, value in network.named_buffers():
        torch.testing.assert_close(value, buffers[name], rtol=0, atol=0)
