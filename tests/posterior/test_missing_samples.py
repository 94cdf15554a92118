"""Records with missing samples: in batches, and through a posterior, of the default network too."""

import numpy as np
import pytest
import torch
from scipy.stats import kstest

from breaker.model.randomness import generator
from breaker.posterior.batches import Rows
from breaker.posterior.corrections import correct
from breaker.posterior.exactness import correct_operations
from breaker.posterior.missing import completed
from breaker.posterior.predictive import infer, predict_stages, summaries
from breaker.posterior.tables import table
from tests.corrections import SETTINGS
from tests.networks_fixtures import (
    COMBINATIONS,
    DEEP_SET,
    bank_of,
    curved_model,
    lose,
    new_trainer,
    noise_of,
    operations_of,
)

# ---- batches ------------------------------------------------------------------------------------


def test_samples_are_missing_by_a_share_of_each_record():
    """Shares are uniform up to the largest, and samples independent given a record's share.

    Of 400 samples a record, shares are uniform on [0, 0.5] but for 0.025, so that the largest
    distance of the distributions is below 0.05 plus the one of the Kolmogorov-Smirnov test with a
    false-alarm probability of 1e-3, 1.95 / sqrt(2000).
    """
    rows = Rows(torch.zeros(2000, 400), torch.zeros(2000, 2), 0.0, 0.0, missing=0.5)
    drawn = rows.draw(torch.arange(2000), torch.Generator().manual_seed(1))
    lost = drawn.measured.isnan().double().numpy()
    bound = 0.05 + 1.95 / np.sqrt(2000)
    assert kstest(lost.mean(axis=1), "uniform", args=(0, 0.5)).statistic < bound
    # Independent: neighbours covary by the variance of the shares, 1/48, and no more. The standard
    # error of a product's mean is at most 1/4 / sqrt(2000), smaller still over 399 neighbours.
    centred = lost - 0.25
    neighbours = (centred[:, 1:] * centred[:, :-1]).mean()
    assert abs(neighbours - 1 / 48) < 4 * np.std((centred**2).mean(1)) / np.sqrt(2000)


# ---- through a posterior ------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["sample", "log_prob", "distance"])
def test_records_that_nothing_is_known_of_are_refused(sets, series, method):
    def ask(posterior, records):
        values, noise = np.ones((5, 1, 8)), noise_of(posterior, 5, 2)
        more = {"sample": [records, noise], "log_prob": [values, records], "distance": [records]}
        return getattr(posterior, method)(*more[method])

    _, whole = sets
    infinite, empty = whole.copy(), whole.copy()
    infinite[2, 3], empty[1] = -np.inf, np.nan
    for posterior in (sets[0], series[0]):
        for records, message in (
            (infinite, "1 of 5 records have infinite samples"),
            (empty, "1 of 5 records have no sample"),
            (whole[:, ::2], r"shape \(o, 31\), not \(5, 16\)"),
            (whole[0], r"shape \(o, 31\), not \(31,\)"),
        ):
            with pytest.raises(ValueError, match=message):
                ask(posterior, records)
    assert np.isfinite(ask(sets[0], lose(whole, 0.5))).all()


def test_there_is_no_density_of_completed_records(sets, series):
    """The message has the remedy."""
    whole, values = sets[1], np.ones((5, 1, 8))
    few = lose(whole, 0.5)
    few[3, np.flatnonzero(~np.isnan(few[3]))[:2]] = np.nan
    train = "has no density; train it with (a larger )?network.closing.summary"
    for posterior, records, message in (
        (sets[0], few, rf"1 of 5 records miss more than 50% .* {train}.deep_set.missing"),
        (series[0], lose(whole, 0.1), rf"5 of 5 .* more than 0% .* {train}.kind: deep_set"),
    ):
        with pytest.raises(ValueError, match=message):
            posterior.log_prob(values, records)


@pytest.mark.parametrize("draws", [7, 250])
def test_a_network_of_whole_records_draws_from_completed_ones(series, draws):
    """As many draws from each, whatever their number; those of whole records stay as they are."""
    posterior, whole = series
    records, noise = whole.copy(), noise_of(posterior, 5, draws)
    records[1, 4:20:3] = np.nan
    found = posterior.sample(records, noise)
    assert posterior.completes(records).tolist() == [False, True, False, False, False]
    others = [0, 2, 3, 4]
    np.testing.assert_array_equal(found[others], posterior.sample(whole, noise)[others])
    each = completed(posterior.model, records[1], 100)
    for k in (0, 1, draws - 1):
        alone = posterior.sample(each[k % 100][None], noise[1:2, k : k + 1])[0]
        np.testing.assert_allclose(found[1, k], alone[0], rtol=1e-4)


def test_distance_of_records_with_missing_samples(sets, series):
    posterior, _ = sets
    fresh = bank_of(posterior, 300, seed=9).travel.values.astype(np.float64)
    records = posterior.sensor.corrupt(fresh, generator(2, "test records"))
    plain = series[0].distance(records)
    # Whole records: the same as without a deep set, for both banks are the same.
    np.testing.assert_array_equal(posterior.distance(records), plain)
    irregular = lose(records, 0.4)
    found = posterior.distance(irregular)
    assert np.corrcoef(found, plain)[0, 1] > 0.8
    # The farthest that the bank produces is for whole records, and fewer samples stay closer.
    assert (found > 1).mean() < 0.02
    # Planted: three times the travel, and a bump, on the samples that are left.
    bump = 3 * np.exp(-np.square((posterior.sensor.times - 20) / 6))
    for strange in (3 * fresh, records + bump):
        assert (posterior.distance(lose(strange, 0.4)) > 1).mean() > 0.75
    # One sample outside of the envelope, where the components may see little of it.
    spike = irregular.copy()
    for record in spike:
        last = np.flatnonzero(~np.isnan(record))[-1]
        record[last] = posterior.highest[last] + 1.5 * posterior.margin
    assert (posterior.distance(spike) > 1).all()


# ---- operations ---------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def pair(sets):
    """The same closing twice: the second time 40 % of the samples after its rise are missing."""
    model = sets[0].model
    exact = model.curves(np.append(model.prior.medians, 0.0)[None])
    records = np.repeat(model.sensor.corrupt(exact, generator(1, "test noise")), 2, axis=0)
    times = model.sensor.times
    records[1, (times > 4.0) & (np.arange(times.size) % 5 < 2)] = np.nan
    return operations_of(records, times)


def test_a_network_of_whole_records_answers_and_says_that_it_approximates(pair, series):
    posterior, _ = series
    lost = np.isnan(pair.travel.values).sum(axis=1)
    found = infer(
        posterior, pair.assign(missing=("operation", lost)), draws=30, seed=1, misfit_p_value=1e-3
    )
    assert found.accepted.all(), found.reason.values
    assert found.completed.values.tolist() == [False, True]
    assert np.isfinite(found.draws.values).all()
    rows = table(found)
    assert rows.missing.tolist() == np.repeat(lost, 8).tolist()
    assert rows.completed.tolist() == [False] * 8 + [True] * 8


def test_a_deep_set_infers_them_and_the_exact_posterior_is_wider(pair, sets):
    """Of the same noise, less is known: the log determinant of the covariance is larger.

    From 2,000 draws of eight outputs its difference has an error of sqrt(2 * 2 * 8 / 2000) = 0.13,
    so that equal posteriors would differ by 0.5 with a probability of 4e-5.
    """
    posterior, _ = sets
    found = infer(posterior, pair, draws=2000, seed=1, misfit_p_value=1e-3)
    assert found.accepted.all()
    settings = SETTINGS | {"draws": 3000, "rounds": 40, "efficiency": 0.5}
    exact = correct_operations(posterior.model, found, settings, seed=1, misfit_p_value=1e-3)
    assert exact.resolved.all()
    assert ((exact.p_value > 1e-3) & (exact.p_value < 1 - 1e-3)).all()
    z = posterior.model.standardise(exact.draws.values.astype(np.float64))
    whole, lacking = (np.linalg.slogdet(np.cov(draws.T))[1] for draws in z)
    assert lacking > whole + 0.5
    # Predicted records have no gaps, and samples that are missing are not outside of the band.
    stages = predict_stages(posterior.model, exact, stages=2, seed=1)
    assert np.isfinite(stages.lower.values).all()
    np.testing.assert_array_equal(stages.travel, pair.travel)
    assert (stages.share_inside.values > 0.7).all()


# ---- exact posteriors ---------------------------------------------------------------------------


def odd_records(record):
    """Records that a reader might let through, one by one."""
    at = np.arange(record.size)
    return {
        "zeros": 0.0 * record,
        "constant": np.full(record.size, 10.0),
        "huge": np.full(record.size, 1e6),
        "huge times": 1e30 * record,
        "two samples": np.where(np.isin(at, [3, 20]), record, np.nan),
        "one sample": np.where(at == 20, record, np.nan),
        "one huge sample": np.where(at == 20, 1e12, np.nan),
        "no sample": np.full(record.size, np.nan),
        "infinite": np.where(at == 5, np.inf, record),
        "backwards": record[::-1],
        "spike": np.where(at == 9, 1e5, record),
    }


def test_no_odd_record_stops_the_others():
    """Each has a posterior, or a reason; the ones beside it are as without it."""
    posterior, whole = curved_model()
    odd = odd_records(whole[0])
    records = np.array([whole[1], *odd.values(), whole[2]])
    curves = operations_of(records, posterior.sensor.times, ["first", *odd, "last"])
    settings = SETTINGS | {"rounds": 3, "round_draws": 200, "draws": 500}
    common = {"seed": 1, "misfit_p_value": 1e-3}
    found = infer(posterior, curves, draws=60, **common)
    exact = correct_operations(posterior.model, found, settings, **common)
    for i, name in enumerate(found.file.values):
        answered = np.isfinite(found.draws.values[i]).all()
        assert answered == found.accepted.values[i] == (found.reason.values[i] == "")
        if answered:
            assert exact.resolved.values[i] == (exact.why_unresolved.values[i] == ""), name
        else:
            assert found.reason.values[i].startswith(f"{name}: no posterior: ")
    assert found.accepted.values[[0, 5, 6, -1]].all()
    assert not found.accepted.values[[8, 9]].any()
    ends = infer(posterior, curves.isel(operation=[0, -1]), draws=60, **common)
    np.testing.assert_array_equal(found.draws[[0, -1]], ends.draws)
    predict_stages(posterior.model, exact, stages=len(records), seed=1)


def test_an_error_in_the_correction_is_its_reason(pair, series, monkeypatch):
    posterior, _ = series
    found = infer(posterior, pair, draws=30, seed=1, misfit_p_value=1e-3)

    def fails(model, record, *rest):
        if np.isnan(record).any():
            raise ZeroDivisionError("a planted fault")
        return correct(model, record, *rest)

    monkeypatch.setattr("breaker.posterior.exactness.correct", fails)
    exact = correct_operations(posterior.model, found, SETTINGS, seed=1, misfit_p_value=1e-3)
    assert not exact.resolved.values[1]
    assert exact.why_unresolved.values[1] == (
        "no exact posterior: ZeroDivisionError: a planted fault"
    )
    assert np.isfinite(exact.draws.values[0]).all()


def test_an_onset_far_from_the_time_that_was_read_is_a_flag(series):
    """Beyond 4 prior sd, early or late."""
    posterior, _ = series
    values = np.tile(np.append(posterior.model.prior.medians, 0.0), (4, 20, 1))
    values[:, :, 7] = 0.3 * np.array([-4.1, -3.9, 3.9, 4.1])[:, None]
    found = summaries(posterior.model, values, np.full(4, 0.5), 1e-3)
    assert found["far_onset"].values.tolist() == [True, False, False, True]


# ---- training -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", COMBINATIONS)
def test_every_combination_trains(tmp_path, name):
    """A new network is the prior; a short training gains at least a nat on fixed records."""
    settings = {"steps": 60, "batch": 48, "ema": 0.8, "evaluate_every": 60, "learning_rate": 2e-2}
    training = new_trainer(tmp_path, network=COMBINATIONS[name], **settings)
    batch = training.fixed_batch
    assert batch.measured.isnan().any() == (COMBINATIONS[name]["summary"] is DEEP_SET)
    with torch.no_grad():
        start = training.posterior.validation_loss(*batch).mean().item()
    assert start - float(training.run().validation_loss[-1]) > 1.0
