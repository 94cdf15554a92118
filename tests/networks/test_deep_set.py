"""Deep set: its highway and features against loops over records that have fewer samples."""

import math

import numpy as np
import pytest
import torch
from scipy.stats import multivariate_normal, norm

from breaker.model.plausibility import principal_components
from breaker.model.sensor import Sensor
from breaker.networks.deep_set import DeepSet, SetHighway
from breaker.networks.flow_matching import FlowMatching
from breaker.posterior.batches import Rows
from tests.networks_fixtures import MARKS, built, gradients_of, perturb, residual_by_hand

pytestmark = MARKS

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


def test_with_nothing_missing_it_is_the_plain_highway(network, components, bank):
    mean, weights = components
    whole = SENSOR.corrupt(bank[:50], np.random.default_rng(4))
    scores, log_sd, _ = network.highway(*tensors(whole))
    np.testing.assert_allclose(scores.numpy(), (whole - mean) @ weights, rtol=0, atol=1e-10)
    np.testing.assert_allclose(log_sd.numpy(), 0, rtol=0, atol=1e-10)


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


@pytest.mark.parametrize("missing", [1.0, -0.1])
def test_a_share_that_makes_no_sense_raises(missing):
    with pytest.raises(ValueError, match=r"missing is .*, but must be in \[0, 1\)"):
        DeepSet(SAMPLES, **SIZES | {"missing": missing})


# ---- a known posterior --------------------------------------------------------------------------

TOY = Sensor(start=-1.0, stop=11.0, samples=13, noise_sd=0.5, onset_sd=0.0, zero_sd=0.4)
WAVES = np.stack([np.linspace(-1, 1, 13), np.cos(np.linspace(0, 2, 13))])


def exact_posterior(record, there):
    """Mean and covariance of theta ~ N(0, 1) given ``theta @ WAVES`` with the sensor's errors."""
    design = WAVES[:, there].T
    m = there.sum()
    inverse = np.linalg.inv(TOY.noise_sd**2 * np.eye(m) + TOY.zero_sd**2)
    covariance = np.linalg.inv(np.eye(2) + design.T @ inverse @ design)
    return covariance @ design.T @ inverse @ record[there], covariance


@pytest.fixture(scope="module")
def trained():
    """Both networks, trained for a few seconds on a linear Gaussian problem."""
    rng = np.random.default_rng(1)
    theta = rng.standard_normal((20_000, 2))
    sizes = {**SIZES, "components": 2, "width": 32, "blocks": 1, "pair_blocks": 0}
    summary = built(DeepSet, 13, **sizes)
    inference = built(FlowMatching, 2, sizes["features"], width=24, blocks=1)
    mean, weights = principal_components(theta @ WAVES, TOY, 2)
    sds = {"noise_sd": TOY.noise_sd, "offset_sd": TOY.zero_sd}
    summary.freeze(*tensors(mean, 1.0, weights), **sds)
    travel, z = (torch.from_numpy(v).float() for v in (theta @ WAVES, theta))
    rows = Rows(travel, z, TOY.noise_sd, TOY.zero_sd, missing=0.6)
    weights = [*summary.parameters(), *inference.parameters()]
    optimiser = torch.optim.AdamW(weights, lr=4e-3, weight_decay=0.0)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, 4e-3, total_steps=600)
    draw = torch.Generator().manual_seed(2)
    for _ in range(600):
        batch = rows.draw(torch.randint(len(theta), (256,), generator=draw), draw)
        optimiser.zero_grad()
        features = summary(batch.measured)
        inference.loss(batch.z, features, batch.noise, batch.time).mean().backward()
        optimiser.step()
        schedule.step()
    return summary.eval(), inference.eval()


def toy_records(n, share, seed=3):
    """Truth ``(n, 2)``, and records ``(n, t)`` of which a share is missing at random."""
    rng = np.random.default_rng(seed)
    theta = rng.standard_normal((n, 2))
    records = TOY.corrupt(theta @ WAVES, rng)
    records[rng.random(records.shape) < share] = np.nan
    return theta, records


@torch.no_grad()
def gap(trained, theta, records):
    """Mean of log p - log q of the truth, and its standard error: the divergence KL(p | q)."""
    summary, inference = trained
    z, x = (torch.from_numpy(v).float() for v in (theta[:, None], records))
    density = inference.log_prob(z, summary(x), steps=8)[:, 0].double().numpy()
    exact = np.array(
        [
            multivariate_normal(*exact_posterior(record, ~np.isnan(record))).logpdf(truth)
            for truth, record in zip(theta, records, strict=True)
        ]
    )
    return (exact - density).mean(), (exact - density).std(ddof=1) / math.sqrt(len(exact))


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_density_is_that_of_a_known_posterior(trained, share):
    """A divergence is not negative, and below 0.03 nats here, whatever is missing.

    Estimates may be off by 3.3 standard errors, a false-alarm probability of 1e-3. Planted fault:
    missing samples that are filled with the centre curve are taken for measured ones.
    """
    theta, records = toy_records(1500, share)
    estimate, error = gap(trained, theta, records)
    assert -3.3 * error < estimate < 0.03 + 3.3 * error
    assert error < 0.01
    if share:
        z = torch.from_numpy(theta[:, None]).float()
        with torch.no_grad():
            right, filled = (
                trained[1].log_prob(z, trained[0](torch.from_numpy(x).float()), steps=8).mean()
                for x in (records, np.where(np.isnan(records), 0.0, records))
            )
        assert right - filled > 0.1


def draws_of(trained, records, draws):
    """Draws ``(n, draws, 2)`` of records."""
    rng = torch.Generator().manual_seed(4)
    with torch.no_grad():
        noise = torch.randn((len(records), draws, 2), generator=rng)
        features = trained[0](torch.from_numpy(records).float())
        return trained[1].sample(noise, features, steps=4).double().numpy()


def test_posterior_is_calibrated_with_samples_missing(trained):
    """Ranks of the truth among the draws are uniform, with 30 % of the samples missing.

    Ranks, moved to normal scores, of 1,000 records and two parameters: mean and variance within
    4 standard errors, a false-alarm probability of 4 * 6e-5 = 2.5e-4. The network's own error is
    well below. Planted faults: posteriors 15 % too narrow, and those of filled records.
    """
    theta, records = toy_records(1000, 0.3, seed=5)

    def off(draws):
        below = (draws < theta[:, None]).sum(axis=1)
        scores = norm.ppf((below + 0.5) / (draws.shape[1] + 1))
        n = len(scores)
        mean, variance = scores.mean(axis=0) * np.sqrt(n), (scores.var(axis=0) - 1) * np.sqrt(n / 2)
        return np.abs([*mean, *variance]).max()

    draws = draws_of(trained, records, 100)
    assert off(draws) < 4
    middle = draws.mean(axis=1, keepdims=True)
    assert off(middle + 0.85 * (draws - middle)) > 4
    assert off(draws_of(trained, np.where(np.isnan(records), 0.0, records), 100)) > 4
