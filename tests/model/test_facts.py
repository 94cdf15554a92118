"""Facts beside a record: against their densities written out, and numeric integration."""

import numpy as np
import pytest
from scipy.stats import norm

from breaker.mechanism import Size, evaluate
from breaker.model import Facts, Model
from tests.networks_fixtures import PRIOR, SENSOR

SETTINGS = {
    "mu": [2.4, 0.07],
    "wipe": [3.5, 0.3],
    "touch_time": [9.9, 0.2],
    "part_time": [1.8, 0.1],
}


@pytest.fixture(scope="module", params=["closing", "opening"])
def model(request):
    return Model.from_settings({"prior": PRIOR, "sensor": SENSOR, "motion": request.param})


def test_facts_multiply_the_density(model):
    """Of both motions, whichever is recorded. Planted fault: sd and value changed over."""
    z = 0.3 * np.random.default_rng(1).standard_normal((6, 8))
    theta = model.destandardise(z)[:, :7]
    record = model.curves(np.append(model.prior.medians, 0.0)[None])[0]
    columns = {
        "mu": theta[:, 0],
        "wipe": evaluate(["wipe"], theta, "opening")[:, 0],
        "touch_time": evaluate(["touch_time"], theta, "closing")[:, 0],
        "part_time": evaluate(["part_time"], theta, "opening")[:, 0],
    }
    expected = sum(norm.logpdf(columns[name], *each) for name, each in SETTINGS.items())
    found = model.conditioned_on(Facts.from_settings(SETTINGS)).log_joint(z, record)
    np.testing.assert_allclose(found, model.log_joint(z, record) + expected, rtol=1e-10)
    swapped = Facts.from_settings({name: each[::-1] for name, each in SETTINGS.items()})
    assert np.abs(model.conditioned_on(swapped).log_joint(z, record) - found).max() > 1.0


def test_a_quantity_that_does_not_exist_contradicts_any_fact(model):
    theta = np.tile(model.prior.medians, (2, 1))
    theta[1, 5] *= 0.3  # a force so weak that the contact does not touch
    facts = Facts.from_settings({"touch_time": [9.9, 0.2]})
    assert np.isnan(facts.residuals(theta)).ravel().tolist() == [False, True]
    assert np.isfinite(facts.log_density(theta)).tolist() == [True, False]


def test_facts_are_in_units_of_the_real_drive(model):
    size = Size(lengths=10.0, times=4.0)
    z = 0.3 * np.random.default_rng(2).standard_normal((5, 8))
    record = model.curves(np.append(model.prior.medians, 0.0)[None])[0]
    small = Facts.from_settings({"mu": [2.4, 0.07], "L": [10.2, 0.2], "f": [0.8, 0.05]})
    force = size.factor("mm/ms²")
    large = Facts.from_settings(
        {"mu": [2.4, 0.07], "L": [102.0, 2.0], "f": [0.8 * force, 0.05 * force]}
    )
    one = model.conditioned_on(small).log_joint(z, record) - model.log_joint(z, record)
    bigger = model.sized(size)
    other = bigger.conditioned_on(large).log_joint(z, 10 * record) - bigger.log_joint(
        z, 10 * record
    )
    np.testing.assert_allclose(other, one - np.log(10.0) - np.log(force), rtol=1e-9)


def test_contradictions_are_named(model):
    facts = Facts.from_settings({"mu": [2.4, 0.07], "L": [10.1, 0.1]})
    theta = np.tile(model.prior.medians, (5, 1))
    theta[0] = np.nan
    (text,) = facts.contradicted(theta)
    assert text.startswith("the records contradict known.mu, 2.4 with an sd of 0.07: the posterior")
    assert "is -5.7 sd off; check its value and unit" in text
    assert facts.contradicted(theta[:1]) == []
    assert Facts.from_settings({}).contradicted(theta) == []
