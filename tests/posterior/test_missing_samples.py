"""Records with missing samples: in batches, and through a posterior, of the default network too."""

import numpy as np
import pytest
import torch
from scipy.stats import kstest

from breaker.common.randomness import generator
from breaker.paper.correction import correct_validation
from breaker.paper.inference import infer, predict_stages, summaries
from breaker.paper.training import Rows
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


@pytest.mark.parametrize("method", ["sample", "log_prob", "distance"])
def test_records_that_a_network_was_not_trained_for_are_refused(sets, series, method):
    """The message has the remedy."""
    whole, values = sets[1], np.ones((5, 1, 8))
    few = lose(whole, 0.5)
    few[3, np.flatnonzero(~np.isnan(few[3]))[:2]] = np.nan
    train = "does not take; train it with (a larger )?network.closing.summary"
    for posterior, records, message in (
        (sets[0], few, rf"1 of 5 records miss more than 50% of .* {train}.deep_set.missing"),
        (series[0], lose(whole, 0.1), rf"5 of 5 records have missing .* {train}.kind: deep_set"),
    ):
        more = {"sample": [records, noise_of(posterior, 5, 2)], "log_prob": [values, records]}
        with pytest.raises(ValueError, match=message):
            getattr(posterior, method)(*more.get(method, [records]))


def test_distance_of_records_with_missing_samples(sets, series):
    posterior, _ = sets
    fresh = bank_of(posterior, 300, seed=9).travel.values.astype(np.float64)
    records = posterior.sensor.corrupt(fresh, generator(2, "test records"))
    plain = series[0].distance(records)
    # Whole records: the same as without a deep set, for both banks are the same.
    np.testing.assert_array_equal(posterior.distance(records), plain)
    # Of others their envelope alone: fewer samples stay closer, and nothing of the bank is far.
    irregular = lose(records, 0.4)
    found = posterior.distance(irregular)
    assert (found <= plain).all()
    assert (found > 1).mean() < 0.02
    assert (posterior.distance(lose(3 * fresh, 0.4)) > 1).mean() > 0.75  # planted
    spike = irregular.copy()  # one sample outside of the envelope
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


def test_a_network_of_whole_records_leaves_others_to_the_family_and_says_why(pair, series):
    found = infer(series[0], pair, draws=30, seed=1, misfit_p_value=1e-3)
    assert found.accepted.values.tolist() == [True, False]
    assert found.reason.values[1] == (
        "close_1.csv: no posterior: 1 of 1 records have missing samples, which the network of "
        "closing does not take; train it with network.closing.summary.kind: deep_set"
    )
    assert np.isfinite(found.draws.values[0]).all()
    assert np.isnan(found.draws.values[1]).all()


def test_a_deep_set_infers_them_and_predicts_them_without_gaps(pair, sets):
    posterior, _ = sets
    found = infer(posterior, pair, draws=60, seed=1, misfit_p_value=1e-3)
    assert found.accepted.all()
    stages = predict_stages(posterior.model, found, stages=2, seed=1)
    assert np.isfinite(stages.lower.values).all()
    np.testing.assert_array_equal(stages.travel, pair.travel)
    assert np.isfinite(stages.share_inside.values).all()


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
    found = infer(posterior, curves, draws=60, seed=1, misfit_p_value=1e-3)
    for i, name in enumerate(found.file.values):
        answered = np.isfinite(found.draws.values[i]).all()
        assert answered == found.accepted.values[i] == (found.reason.values[i] == "")
        if not answered:
            assert found.reason.values[i].startswith(f"{name}: no posterior: ")
    assert found.accepted.values[[0, -1]].all()
    assert not found.accepted.values[5:10].any()
    ends = infer(posterior, curves.isel(operation=[0, -1]), draws=60, seed=1, misfit_p_value=1e-3)
    np.testing.assert_array_equal(found.draws[[0, -1]], ends.draws)
    predict_stages(posterior.model, found, stages=len(records), seed=1)
    # The judge, too: what it cannot correct has a reason.
    settings = SETTINGS | {"rounds": 3, "round_draws": 200, "draws": 500}
    some = found.isel(operation=found.accepted.values).rename(operation="curve", travel="measured")
    exact = correct_validation(posterior.model, some, settings, seed=1)
    assert (exact.resolved.values == (exact.why_unresolved.values == "")).all()


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
