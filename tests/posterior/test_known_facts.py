"""What is known beside records, in exact posteriors: against reweighted draws, near and far."""

import numpy as np
import pytest
from scipy.stats import kstest

from breaker.model import Contact, Facts, Model, generator
from breaker.posterior.exactness import correct_operations
from breaker.posterior.laplace import approximate, surprise
from breaker.posterior.predictive import coordinates
from tests.corrections import SETTINGS, from_prior
from tests.networks_fixtures import PRIOR, SENSOR, operations_of

COMMON = {"seed": 1, "misfit_p_value": 1e-3}


@pytest.fixture(scope="module")
def model():
    settings = {"prior": PRIOR, "sensor": SENSOR, "motion": "closing"}
    return Model.from_settings(settings)


@pytest.fixture(scope="module")
def curves(model):
    """Three records, of the last of which nothing is known of the contact."""
    rng = generator(1, "test facts")
    values = model.destandardise(0.5 * rng.standard_normal((3, 8)))
    records = model.sensor.corrupt(model.curves(values), rng)
    return operations_of(records, model.sensor.times)


def infer_exactly(model, curves, draws):
    """Exact posteriors, from the modes."""
    rng = generator(1, "test facts", "start")
    start = [approximate(model, record, draws, rng) for record in curves.travel.values]
    coords = coordinates(model) | {"draw": np.arange(draws)}
    data = curves.assign(draws=(("operation", "draw", "output"), np.array(start)))
    return correct_operations(model, data.assign_coords(coords), SETTINGS, **COMMON)


@pytest.fixture(scope="module")
def unaware(model, curves):
    return infer_exactly(model, curves, 4000)


def timed(model, curves, sd=0.1):
    """The records with measured times, off what is expected at the prior's medians."""
    expected = model.expected(np.append(model.prior.medians, 0.0)[None]).switching[0]
    times = np.array([expected - 0.4, expected + 0.3, np.nan])
    return curves.assign(
        contact_time=("operation", times), contact_sd=("operation", np.full(3, sd))
    )


def agree(model, found, unaware, log_weight, i):
    """z-score, at most, of the means of draws against those of reweighted draws."""
    draws = unaware.draws.values[i].astype(float)
    weights = np.exp(log_weight - log_weight.max())
    weights /= weights.sum()
    size = 1 / np.square(weights).sum()
    z, other = model.standardise(draws), model.standardise(found.draws.values[i].astype(float))
    mean = weights @ z
    sd = np.sqrt(weights @ np.square(z - mean))
    # Both sets are weighed draws: at least these effective sizes.
    error = sd * np.sqrt(1 / size + 1 / min(len(other), SETTINGS["smallest_size"]))
    assert size > 100
    return np.abs((other.mean(axis=0) - mean) / error).max()


def test_times_of_the_contact_weigh_the_draws_of_their_record(model, curves, unaware):
    """16 means: none beyond 4.2 standard errors, by chance with 4e-4.

    Planted fault: times that nothing counts. The record without a time is as it was.
    """
    data = timed(model, curves)
    found = infer_exactly(model, data, 4000)
    assert found.resolved.values.all()
    for i in range(2):
        z = model.standardise(unaware.draws.values[i].astype(float))
        record = data.travel.values[i]
        known = model.conditioned_on(contact=Contact(float(data.contact_time[i]), 0.1))
        weight = known.log_joint(z, record) - model.log_joint(z, record)
        assert agree(model, found, unaware, weight, i) < 4.2
        assert agree(model, unaware, unaware, weight, i) > 4.2
    np.testing.assert_array_equal(found.draws.values[2], unaware.draws.values[2])


def test_narrow_facts_far_from_a_network_s_draws(model, curves, unaware):
    """A network knows nothing of them: its draws are far off, and yet records resolve."""
    facts = Facts.from_settings({"mu": [2.9, 0.03], "L": [10.6, 0.05]})
    network = unaware.isel(draw=slice(200))
    far = correct_operations(
        model.conditioned_on(facts), timed(model, network, 0.02), SETTINGS, **COMMON
    )
    assert far.resolved.values.all()
    off = facts.residuals(far["median"].values[:, :7])
    assert np.abs(off).max() < 4.0
    before = facts.residuals(network["median"].values[:, :7])
    assert np.abs(before).max() > 10.0


def test_times_that_the_record_contradicts_are_remarked(model, curves):
    """Of 300 drives, times of their own are standard normal surprises: false alarm 1e-3.

    Planted fault: times of another record.
    """
    rng = generator(5, "test surprise")
    expected = model.expected(from_prior(model, 300, rng))
    records = model.sensor.corrupt(expected.travel, rng)
    times = expected.switching + 0.1 * rng.standard_normal(300)

    def surprises(times):
        known = [model.conditioned_on(contact=Contact(float(time), 0.1)) for time in times]
        return [surprise(each, record) for each, record in zip(known, records, strict=True)]

    own, other = surprises(times), surprises(np.roll(times, 1))
    assert kstest(own, "norm").pvalue > 1e-3
    assert kstest(other, "norm").pvalue < 1e-6
    data = timed(model, curves).assign(remarks=("operation", ["odd", "", ""]))
    data.contact_time[1] = 25.0
    found = infer_exactly(model, data, 50)
    assert np.isfinite(found.contact_surprise.values[:2]).all()
    assert np.isnan(found.contact_surprise.values[2])
    assert found.remarks.values[[0, 2]].tolist() == ["odd", ""]
    assert "sd from what the curve leads to expect" in found.remarks[1].item()
