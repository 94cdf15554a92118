"""Records with missing samples and uneven times: in batches, and through a posterior."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from scipy.stats import binom, kstest

from breaker.mechanism.curves import travel
from breaker.mechanism.parameters import NAMES
from breaker.model.bank import simulate
from breaker.model.randomness import generator
from breaker.posterior.batches import Rows
from breaker.posterior.irregular import positions
from tests.networks_fixtures import (
    COMBINATIONS,
    DEEP_SET,
    MARKS,
    NETWORK,
    bank_of,
    curved_model,
    frozen,
    new_trainer,
    noise_of,
    one_thread,  # noqa: F401
)

pytestmark = MARKS

SETS = {"summary": DEEP_SET, "inference": NETWORK["inference"]}
ON_GRID = {**SETS, "summary": {**DEEP_SET, "uneven": 0.0}}


@pytest.fixture(scope="module")
def curved():
    """A model that accepts missing samples, and whole records."""
    return curved_model(SETS)


@pytest.fixture(scope="module")
def series():
    """A model that does not, and whole records."""
    return curved_model()


def lose(records, share, *, seed=3):
    """Records of which a share of the samples is missing, as many in each."""
    rng, found = np.random.default_rng(seed), records.copy()
    for record in found:
        record[rng.permutation(record.size)[: int(share * record.size)]] = np.nan
    return found


# ---- batches ------------------------------------------------------------------------------------


def plain_rows(n, t, **more):
    """Rows of zeros without noise."""
    return Rows(torch.zeros(n, t), torch.zeros(n, 2), 0.0, 0.0, **more)


def drawn(rows, seed=1):
    """All rows once."""
    return rows.draw(torch.arange(len(rows.z)), torch.Generator().manual_seed(seed))


def test_rows_take_what_the_summary_network_accepts(curved, series):
    for (posterior, _), expected in ((curved, (0.5, 0.5)), (series, (0.0, 0.0))):
        rows = Rows.of(bank_of(posterior, 4), posterior, torch.device("cpu"))
        assert (rows.missing, rows.uneven) == expected
    batch = drawn(rows)
    assert batch.positions is None
    assert not batch.measured.isnan().any()


def test_samples_are_missing_by_a_share_of_each_record():
    """Shares are uniform up to the largest, and samples independent given a record's share.

    Of 400 samples a record, shares are uniform on [0, 0.5] but for 0.025, so that the largest
    distance of the distributions is below 0.05 plus the one of the Kolmogorov-Smirnov test with a
    false-alarm probability of 1e-3, 1.95 / sqrt(2000).
    """
    lost = drawn(plain_rows(2000, 400, missing=0.5)).measured.isnan().double().numpy()
    bound = 0.05 + 1.95 / np.sqrt(2000)
    assert kstest(lost.mean(axis=1), "uniform", args=(0, 0.5)).statistic < bound
    # Planted fault: one share for all records.
    wrong = np.random.default_rng(1).random(lost.shape) < 0.25
    assert kstest(wrong.mean(axis=1), "uniform", args=(0, 0.5)).statistic > bound
    # Independent: neighbours covary by the variance of the shares, 1/48, and no more. The standard
    # error of a product's mean is at most 1/4 / sqrt(2000), smaller still over 399 neighbours.
    centred = lost - 0.25
    neighbours = (centred[:, 1:] * centred[:, :-1]).mean()
    assert abs(neighbours - 1 / 48) < 4 * np.std((centred**2).mean(1)) / np.sqrt(2000)


def test_a_share_of_the_records_is_off_the_grid_by_up_to_half_a_step():
    n, t = 1000, 40
    at = drawn(plain_rows(n, t, uneven=0.3)).positions.double().numpy()
    off = at - np.arange(t)
    moved = off.any(axis=1)
    # Two-sided, false-alarm probability 1e-3.
    assert binom.ppf(5e-4, n, 0.3) <= moved.sum() <= binom.isf(5e-4, n, 0.3)
    assert at.min() == 0.0
    assert at.max() == t - 1
    inner = off[moved, 1:-1].ravel()
    # The test's own false-alarm probability is 1e-3.
    assert kstest(inner, "uniform", args=(-0.5, 1.0)).pvalue > 1e-3


@pytest.mark.parametrize("motion", ["closing", "opening"])
def test_travel_off_the_grid_is_that_of_the_mechanism(prior, sensor, motion):
    """On the default grid: within 0.01 mm, a tenth of the noise, where acceleration jumps.

    Over a record the errors, in units of the noise, have a norm below 0.1: against the exact
    record the log likelihood errs by at most 0.005 nats. Planted fault: linear interpolation.
    """
    n = 60
    rng = generator(1, "test bank", motion)
    bank = simulate(prior, sensor.times, motion, n, rng, onset_sd=sensor.onset_sd)
    rows = Rows(torch.from_numpy(bank.travel.values), torch.zeros(n, 2), 0.0, 0.0, uneven=1.0)
    batch = drawn(rows)
    at = batch.positions.double().numpy()
    errors, linear = np.empty((2, n, sensor.samples))
    for i in range(n):
        order = np.argsort(at[i])
        exact = np.empty(sensor.samples)
        exact[order] = travel(
            bank.parameters.values[i : i + 1],
            sensor.start + sensor.step * at[i, order],
            motion,
            onset=bank.onset.values[i : i + 1],
        ).travel[0]
        errors[i] = batch.measured[i].double().numpy() - exact
        linear[i] = np.interp(at[i], np.arange(sensor.samples), bank.travel.values[i]) - exact
    assert np.abs(errors).max() < 0.01 < np.abs(linear).max()
    norms = np.sqrt(np.square(errors).sum(axis=1)) / sensor.noise_sd
    assert norms.max() < 0.1 < np.sqrt(np.square(linear).sum(axis=1)).max() / sensor.noise_sd


def test_noise_is_that_of_the_sensor_off_the_grid_too(curved):
    """It is a sample's, not the grid's: interpolated noise would be smaller."""
    rows = replace(plain_rows(2000, 30, uneven=1.0), noise_sd=0.1)
    spread = drawn(rows).measured.std().item()
    # 60,000 numbers: four standard errors are 1.2 %.
    assert spread == pytest.approx(0.1, rel=0.012)


# ---- through a posterior ------------------------------------------------------------------------


def test_draws_and_density_are_those_of_the_networks(curved):
    """Of the record as it is, NaN and all; every curve by itself."""
    posterior, whole = curved
    records, noise = lose(whole, 0.3), noise_of(posterior, 5, 6)
    times = np.tile(posterior.sensor.times, (5, 1))
    times[:, 1:-1] += 0.4 * posterior.sensor.step * np.sin(np.arange(5 * 29)).reshape(5, 29)
    for more in ({}, {"times": times}):
        draws = posterior.sample(records, noise, **more)
        density = posterior.log_prob(draws, records, **more)
        x, z = torch.from_numpy(records).float(), torch.from_numpy(posterior.standardise(draws))
        at = (times - posterior.sensor.start) / posterior.sensor.step if more else None
        with torch.no_grad():
            features = posterior.summary(x, None if at is None else torch.from_numpy(at).float())
            expected = posterior.inference.log_prob(z.float(), features, steps=3).numpy()
        expected = expected + posterior.log_scaling(draws)
        np.testing.assert_allclose(density, expected, rtol=0, atol=2e-3)
        for i in range(5):
            row = slice(i, i + 1)
            alone = {"times": times[row]} if more else {}
            found = posterior.sample(records[row], noise[row], **alone)
            np.testing.assert_array_equal(found, draws[row])
            found = posterior.log_prob(draws[row], records[row], **alone)
            np.testing.assert_array_equal(found, density[row])
    # Planted faults: the samples filled with the bank's mean, and the times forgotten.
    filled = np.where(np.isnan(records), posterior.curve_mean.numpy(), records)
    for wrong in (posterior.sample(filled, noise, times=times), posterior.sample(records, noise)):
        assert np.abs(posterior.standardise(wrong) - posterior.standardise(draws)).max() > 1e-3


@pytest.mark.parametrize("models", ["curved", "series"])
def test_times_of_the_grid_are_no_times_at_all(request, models):
    posterior, records = request.getfixturevalue(models)
    noise, times = noise_of(posterior, 5, 4), posterior.sensor.times
    expected = posterior.sample(records, noise)
    for given in (times, np.tile(times, (5, 1)), np.round(times, 6)):
        found = posterior.sample(records, noise, times=given)
        np.testing.assert_array_equal(found, expected)


def test_samples_left_out_are_samples_missing(curved):
    """Records that hold just what is there, with its times: also for a network of the grid."""
    for posterior, whole in (curved, curved_model(ON_GRID)):
        records, noise = lose(whole, 0.3), noise_of(posterior, 5, 4)
        expected = posterior.sample(records, noise)
        for i, record in enumerate(records):
            there = ~np.isnan(record)
            times = posterior.sensor.times[there]
            found = posterior.sample(record[None, there], noise[i : i + 1], times=times)
            np.testing.assert_allclose(found[0], expected[i], rtol=1e-4, atol=1e-5)


def test_records_that_a_time_series_network_does_not_take_are_refused(series):
    posterior, whole = series
    remedy = r"\(network.closing.summary.kind: deep_set\)"
    with pytest.raises(ValueError, match=rf"5 of 5 records are not finite; .* samples {remedy}"):
        posterior.sample(lose(whole, 0.1), noise_of(posterior, 5, 2))
    times = posterior.sensor.times.copy()
    times[7] += 0.1
    with pytest.raises(ValueError, match=rf"other times than the sensor's grid; .* {remedy}"):
        posterior.sample(whole, noise_of(posterior, 5, 2), times=times)
    with pytest.raises(ValueError, match=rf"other times than the sensor's grid; .* {remedy}"):
        posterior.log_prob(np.ones((5, 1, 8)), whole[:, ::2], times=posterior.sensor.times[::2])
    with pytest.raises(ValueError, match="a deep set takes other positions"):
        posterior.summary(torch.zeros(1, 31), torch.arange(31.0)[None])


def shifted(sensor, index, step):
    """The sensor's times with one of them moved by some steps."""
    times = sensor.times.copy()
    times[index] += step * sensor.step
    return times


def test_records_that_a_deep_set_was_not_trained_on_are_refused(curved):
    posterior, whole = curved
    sensor, infinite = posterior.sensor, whole.copy()
    infinite[2, 3] = -np.inf
    twice = np.repeat(whole, 2, axis=1), np.repeat(sensor.times, 2)
    few = lose(whole, 0.5)
    few[3, np.flatnonzero(~np.isnan(few[3]))[:2]] = np.nan
    for records, times, message in (
        (infinite, None, "1 of 5 records are not finite; reject them first$"),
        (few, None, r"1 of 5 records have fewer than 16 samples \(one has 14\), .* up to 50%"),
        (whole[:, ::2], None, r"shape \(o, 31\), not \(5, 16\)"),
        (whole, sensor.times[:-1], r"times must have the shape \(5, 31\) of the records, or \(31,"),
        (whole, shifted(sensor, 0, -0.1), "5 of 5 records have samples outside of the sensor's -2"),
        (whole, shifted(sensor, 5, np.nan), "or at no finite time"),
        (*twice, "a record has 62 samples, the sensor's grid 31"),
    ):
        with pytest.raises(ValueError, match=message):
            posterior.sample(records, noise_of(posterior, 5, 2), times=times)
    # What is just allowed: times of missing samples may be anything.
    records, times = lose(whole, 0.5), np.tile(sensor.times, (5, 1))
    times[np.isnan(records)] = np.nan
    noise = noise_of(posterior, 5, 2)
    found = posterior.sample(records, noise, times=times)
    np.testing.assert_array_equal(found, posterior.sample(records, noise))


def test_a_deep_set_of_the_grid_takes_no_other_times():
    posterior = frozen(network=ON_GRID)
    records = np.zeros((1, 31))
    message = r"trained on it alone; train with network.closing.summary.deep_set.uneven above 0"
    with pytest.raises(ValueError, match=message):
        posterior.sample(
            records, noise_of(posterior, 1, 2), times=shifted(posterior.sensor, 5, 0.2)
        )


def test_positions_are_steps_of_the_grid(curved):
    posterior, whole = curved
    sensor, taken = posterior.sensor, posterior.summary
    arguments = {"motion": "closing", "taken": taken}
    assert positions(whole, None, sensor, **arguments) is None
    found = positions(whole, shifted(sensor, 5, 0.25), sensor, **arguments)
    expected = np.arange(31.0)
    expected[5] = 5.25
    np.testing.assert_allclose(found, np.tile(expected, (5, 1)), rtol=0, atol=1e-12)


def test_distance_of_irregular_records(curved, series):
    posterior, _ = curved
    fresh = bank_of(posterior, 300, seed=9).travel.values.astype(np.float64)
    records = posterior.sensor.corrupt(fresh, generator(2, "test records"))
    plain = series[0].distance(records)
    # Whole records: the same as without a deep set, for both banks are the same.
    np.testing.assert_array_equal(posterior.distance(records), plain)
    times = posterior.sensor.times
    np.testing.assert_array_equal(posterior.distance(records, times=times), plain)
    irregular = lose(records, 0.4)
    found = posterior.distance(irregular)
    assert np.corrcoef(found, plain)[0, 1] > 0.8
    # The farthest that the bank produces is for whole records, and fewer samples stay closer.
    assert (found > 1).mean() < 0.02
    # Planted: three times the travel, and a bump, on the samples that are left.
    bump = 3 * np.exp(-np.square((times - 20) / 6))
    for strange in (3 * fresh, records + bump):
        assert (posterior.distance(lose(strange, 0.4)) > 1).mean() > 0.75
    moved = np.tile(times, (300, 1))
    moved[:, 1:-1] += 0.3 * posterior.sensor.step
    assert (posterior.distance(irregular + bump, times=moved) > 1).mean() > 0.75
    # One sample outside of the envelope, where the components may see little of it.
    spike = irregular.copy()
    for record in spike:
        last = np.flatnonzero(~np.isnan(record))[-1]
        record[last] = posterior.highest[last] + 1.5 * posterior.margin
    assert (posterior.distance(spike) > 1).all()


# ---- training -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", COMBINATIONS)
def test_every_combination_trains(tmp_path, name):
    """A new network is the prior; a short training gains at least a nat on fixed records.

    Planted fault: a training that does not move gains nothing.
    """
    gains = []
    for rate in (2e-2, 0.0):
        settings = {"steps": 60, "batch": 48, "ema": 0.8, "evaluate_every": 60}
        training = new_trainer(tmp_path, network=COMBINATIONS[name], learning_rate=rate, **settings)
        batch = training.fixed_batch
        accepts = COMBINATIONS[name]["summary"] is DEEP_SET
        assert batch.measured.isnan().any() == accepts
        assert (batch.positions is not None) == accepts
        with torch.no_grad():
            start = training.posterior.log_density(
                batch.measured, batch.z, positions=batch.positions, steps=8
            )
        history = training.run()
        training.checkpoint.unlink()
        gains.append(-start.mean().item() - float(history.validation_loss[-1]))
        again = new_trainer(tmp_path, network=COMBINATIONS[name]).fixed_batch
        torch.testing.assert_close(batch.measured, again.measured, rtol=0, atol=0, equal_nan=True)
    assert gains[0] > 1.0
    assert gains[1] == pytest.approx(0.0, abs=1e-5)
    assert len(training.posterior.names) == len(NAMES) + 1
