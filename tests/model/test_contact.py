"""The contact's time as one more datum: against the joint Gaussian of the augmented record."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from breaker.mechanism import Size, travel
from breaker.model import Contact, Facts, Model, linearise_auxiliary
from tests.model.laws import covariance
from tests.networks_fixtures import PRIOR

SAMPLES = 12
SENSOR = {"start": -1.0, "stop": 40.0, "samples": SAMPLES}
ERRORS = {"noise_sd": 0.2, "onset_sd": 0.3, "zero_sd": 0.1}
CONTACT = Contact(10.3, 0.1)


@pytest.fixture(scope="module", params=["closing", "opening"])
def model(request):
    settings = {"prior": PRIOR, "sensor": {**SENSOR, **ERRORS}, "motion": request.param}
    return Model.from_settings(settings)


def augmented(model, z, contact):
    """Mean ``(n, t + 1)`` and covariance of record and time together, written out."""
    values = model.destandardise(z)
    found = travel(values[:, :7], model.sensor.times, model.motion, onset=values[:, 7])
    whole = np.zeros((SAMPLES + 1, SAMPLES + 1))
    whole[:-1, :-1] = covariance(model.sensor)
    whole[-1, -1] = contact.sd**2
    return np.column_stack([found.travel, found.switching + values[:, 7]]), whole


def some_record(model, missing):
    rng = np.random.default_rng(3)
    record = model.curves(np.append(model.prior.medians, 0.1)[None])[0] + rng.normal(
        0, 0.2, SAMPLES
    )
    record[rng.permutation(SAMPLES)[:missing]] = np.nan
    return record


@pytest.mark.parametrize("missing", [0, 5, SAMPLES - 1])
def test_record_and_time_are_one_gaussian(model, missing):
    """Planted fault: a time after the nominal first motion taken for one after the motion's own."""
    contact = CONTACT if model.motion == "closing" else Contact(2.2, 0.1)
    record = some_record(model, missing)
    z = 0.4 * np.random.default_rng(2).standard_normal((8, 8))
    means, whole = augmented(model, z, contact)
    there = np.append(~np.isnan(record), True)
    datum = np.append(record, contact.time)[there]
    normal = multivariate_normal(np.zeros(there.sum()), whole[np.ix_(there, there)])
    expected = model.log_prior(z) + normal.logpdf(datum - means[:, there])
    found = model.conditioned_on(contact=contact).log_joint(z, record)
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    onset = model.destandardise(z)[:, 7]
    faulty = model.log_joint(z, record) + contact.log_density(means[:, -1] - onset)
    assert np.abs(faulty - expected).max() > 0.1


def test_a_contact_that_does_not_switch_excludes_its_parameters(model):
    """Long before the grid ends, a drive with a gap that it does not reach has no such time."""
    model = replace(
        model, sensor=replace(model.sensor, stop=2.0 if model.motion == "closing" else 0.5)
    )
    z, record = np.zeros((1, 8)), np.zeros(SAMPLES)
    assert np.isfinite(model.log_joint(z, record)).all()
    known = model.conditioned_on(contact=CONTACT)
    assert known.log_joint(z, record).tolist() == [-np.inf]
    residuals, slopes = linearise_auxiliary(known, z[0])
    assert not residuals.any()
    assert not slopes.any()


@pytest.mark.parametrize("wrong", [(np.nan, 0.1), (1.0, 0.0), (np.inf, 0.1), (1.0, np.nan)])
def test_times_that_are_none_are_refused(wrong):
    with pytest.raises(ValueError, match="must be finite and its sd positive"):
        Contact(*wrong)


def test_any_size(model):
    """The density of a stretched record and time is that of the small one, per unit of each."""
    size = Size(lengths=7.0, times=3.0)
    record, z = some_record(model, 3), 0.3 * np.random.default_rng(4).standard_normal((6, 8))
    small = model.conditioned_on(contact=Contact(10.0, 0.1)).log_joint(z, record)
    large = model.sized(size).conditioned_on(contact=Contact(30.0, 0.3)).log_joint(z, 7.0 * record)
    there = np.sum(~np.isnan(record))
    np.testing.assert_allclose(large, small - there * np.log(7.0) - np.log(3.0), rtol=1e-9)


def test_derivatives_lead_to_the_mode(model):
    """Those beside the record, against differences of the joint density less that of the record."""
    contact = Contact(10.4 if model.motion == "closing" else 2.3, 0.1)
    facts = Facts.from_settings({"mu": [2.4, 0.07], "wipe": [3.5, 0.3]})
    known, record = model.conditioned_on(facts, contact), some_record(model, 3)
    z = 0.3 * np.random.default_rng(6).standard_normal(8)
    residuals, slopes = linearise_auxiliary(known, z)
    assert residuals.shape == (3,)
    step = 1e-5 * np.eye(8)
    parts = [known.log_joint(z + s, record) - model.log_joint(z + s, record) for s in (step, -step)]
    np.testing.assert_allclose(
        -slopes @ residuals, (parts[0] - parts[1]) / 2e-5, rtol=1e-4, atol=1e-3
    )
