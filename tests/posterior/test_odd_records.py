"""Records that a network does not accept, and records unlike any of the bank."""

import numpy as np
import pytest
import torch

from breaker.paper.correction import correct_validation
from breaker.paper.inference import infer, predict_stages, summaries
from tests.networks_fixtures import (
    COMBINATIONS,
    curved_model,
    new_trainer,
    noise_of,
    operations_of,
)


@pytest.mark.parametrize("method", ["sample", "log_prob", "distance"])
def test_records_that_a_network_does_not_accept_are_refused(series, method):
    posterior, whole = series
    infinite, gaps, empty = whole.copy(), whole.copy(), whole.copy()
    infinite[2, 3], gaps[:2, 4], empty[1] = -np.inf, np.nan, np.nan
    for records, message in (
        (infinite, "1 of 5 records have infinite samples"),
        (gaps, "2 of 5 records have missing samples"),
        (empty, "1 of 5 records have missing samples"),
        (whole[:, ::2], r"shape \(o, 31\), not \(5, 16\)"),
        (whole[0], r"shape \(o, 31\), not \(31,\)"),
    ):
        more = {
            "sample": [records, noise_of(posterior, 5, 2)],
            "log_prob": [np.ones((5, 1, 8)), records],
            "distance": [records],
        }
        with pytest.raises(ValueError, match=message):
            getattr(posterior, method)(*more[method])


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
    some = found.isel(operation=found.accepted.values).rename(operation="curve", travel="measured")
    exact = correct_validation(posterior.model, some, rounds=3, seed=1)
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
def test_every_network_trains(tmp_path, name):
    """A new network is the prior; a short training gains at least a nat on fixed records."""
    settings = {"steps": 60, "batch": 48, "ema": 0.8, "evaluate_every": 60, "learning_rate": 2e-2}
    training = new_trainer(tmp_path, network=COMBINATIONS[name], **settings)
    batch = training.fixed_batch
    with torch.no_grad():
        start = training.network.validation_loss(*batch).mean().item()
    assert start - float(training.run().validation_loss[-1]) > 1.0
