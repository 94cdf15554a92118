"""Checks of a fitted prior: what is as it should be, and what is not."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.mechanism.limits import Limit
from breaker.model.prior import Prior
from breaker.model.randomness import generator
from breaker.model.reference import reference_model
from breaker.typical.checks import check_fitted
from breaker.typical.fits import Fit
from breaker.typical.fitted import FittedPrior
from breaker.typical.spread import find_spread

P = 7
KNOWN = 100.0 * np.eye(P)


def fitted_of(prior, places):
    """A prior from breakers that are known well at standardised places."""
    fits = {f"Q{i}": Fit(z, KNOWN, KNOWN @ z, True) for i, z in enumerate(places)}
    spread = find_spread([*fits.values()], prior.precision, generator(1, "test"))
    return FittedPrior(prior, fits, spread, np.zeros(P))


@pytest.fixture(scope="module")
def model():
    return reference_model("closing")


@pytest.fixture(scope="module")
def fitted(model):
    places = 0.3 * generator(2, "test places").standard_normal((6, P))
    return fitted_of(model.prior, places)


def found(fitted, model, *, limits=(), records=None):
    models = {"closing": replace(model, prior=fitted.prior)}
    checks = check_fitted(fitted, models, records or {}, limits, seed=1)
    return {check.name: check.findings for check in checks}


def limit(**upper):
    return Limit.from_settings({"name": "late", "motion": "closing", "upper": upper})


def test_limits_within_three_sds(fitted, model):
    (near,) = found(fitted, model, limits=[limit(L=10.5)])["limits"]
    (far,) = found(fitted, model, limits=[limit(L=15.0)])["limits"]
    assert near.good
    assert "late: L 10.5 is" in near.text
    assert not far.good
    assert "widen" in far.text
    (none,) = found(fitted, model)["limits"]
    assert none.good
    assert "none were given" in none.text


def test_records_in_the_band(fitted, model):
    """Missing samples do not count."""
    middle = model.curves(np.append(fitted.prior.medians, 0.0)[None])
    middle[0, 40:80] = np.nan
    name = "curves in the prior's band"
    (good,) = found(fitted, model, records={"Q0": {"closing": middle}})[name]
    (bad,) = found(fitted, model, records={"Q0": {"closing": 0.5 * middle}})[name]
    assert good.good
    assert "100 % of the samples of 1 records" in good.text
    assert not bad.good
    assert "1 records are unlike the prior's" in bad.text


def test_a_breaker_of_another_type_stands_out(model):
    places = 0.3 * generator(2, "test places").standard_normal((6, P))
    places[2, 5] = 8.0
    findings = found(fitted_of(model.prior, places), model)["each breaker by the others"]
    assert [each.good for each in findings] == [True, True, False, True, True, True]
    assert findings[2].text.startswith("Q2: farthest off is f, by +")


def test_leaving_one_out_needs_three(model):
    two = fitted_of(model.prior, np.zeros((2, P)))
    (each,) = found(two, model)["each breaker by the others"]
    assert "needs 3 breakers" in each.text


def test_one_breaker_alone_is_a_warning(fitted, model):
    alone = fitted_of(model.prior, np.zeros((1, P)))
    first, *_ = found(alone, model)["breakers"]
    assert not first.good
    assert "the only source" in first.text
    assert found(fitted, model)["breakers"][0].good


def test_a_contact_that_may_not_be_pressed(model):
    weak = Prior(model.prior.medians * [1, 1, 1, 1, 1, 0.6, 1], model.prior.log_sds)
    places = np.zeros((6, P))
    places[:, 5] = np.log(0.6) / 0.1
    (each,) = found(fitted_of(model.prior, places), model)["contact pressed, f > k_a L"]
    assert not each.good
    assert np.exp(weak.log_support) < 0.9
