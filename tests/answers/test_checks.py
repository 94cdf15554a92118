"""Checks of a fitted prior: what is as it should be, and what is not."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.drive.answers.prior_checks import _far_limits, check_fitted
from breaker.drive.answers.type_prior import FittedPrior, precision_of
from breaker.drive.answers.type_spread import TypeFit, find_spread
from breaker.mechanism.limits import Limit
from breaker.mechanism.prior import Prior
from breaker.quantities.size import Size

P = 7
KNOWN = 100.0 * np.eye(P)


def fitted_of(prior, places):
    """A prior from breakers that are known well at standardised places."""
    fits = {f"Q{i}": TypeFit(KNOWN, KNOWN @ z) for i, z in enumerate(places)}
    spread = find_spread([*fits.values()], precision_of(prior), generator(1, "test"))
    return FittedPrior(prior, fits, spread, np.zeros(P))


PLACES = 0.3 * generator(2, "test places").standard_normal((6, P))


@pytest.fixture(scope="module")
def fitted(prior):
    return fitted_of(prior, PLACES)


def found(fitted, *, limits=(), records=None, levels=None):
    recorded = SimpleNamespace(records=records or {}, levels=levels, tried=["this"])
    recorded.size, recorded.motions = Size(), ["closing", "opening"]
    return check_fitted(fitted, recorded, limits, 1, 1e-3)


def limit(side="upper", **value):
    return Limit.from_settings({"name": "late", "motion": "closing", side: value})


def test_limits_within_three_sds(fitted):
    (near,) = found(fitted, limits=[limit(L=10.5)])["limits"]
    (far,) = found(fitted, limits=[limit(L=15.0)])["limits"]
    assert near.good
    assert "late: L 10.5 is" in near.text
    assert not far.good
    assert "widen" in far.text
    (none,) = found(fitted)["limits"]
    assert none.good
    assert "none were given" in none.text


@pytest.mark.parametrize(("side", "value"), [("lower", 0.5), ("upper", 2.0)])
def test_limits_are_off_by_the_width_of_their_own_side(side, value):
    """Of a skewed distribution; 0.68 times its half is a standard deviation."""
    theta = np.exp(np.linspace(-1.0, 1.0, 1001))[:, None] * np.ones(P)
    (found,) = _far_limits([limit(side, L=value ** (0.68 / np.log(2.0)))], theta)
    assert f" is 1.0 sd of the prior {'below' if side == 'lower' else 'above'} its" in found.text


def test_records_out_of_the_family(fitted):
    """What the network sees of a record is its p-value here."""
    levels = SimpleNamespace(match=lambda motion, seen: SimpleNamespace(p_value=seen))
    records = {"Q0": {"closing": [0.3, 0.5]}, "Q1": {"closing": [0.3, 1e-6, 0.1]}}
    checks = found(fitted, records=records, levels=levels)
    good, bad = checks["records in the family"]
    assert good.good
    assert "Q0, closing: 2 records, median p = 0.4" in good.text
    assert not bad.good
    assert "1 are out of the family" in bad.text


def test_spread_that_the_configuration_does_not_take_is_said(fitted):
    wide, spread = replace(fitted, widest=np.full(7, 0.15)), fitted.spread_seen
    (bounded,) = found(wide)["breakers"][1:]
    assert not bounded.good
    assert f"log-sds of gamma_b {spread[4]:.3g} are bounded to 0.15" in bounded.text
    assert len(found(fitted)["breakers"]) == 1
    (unlike,) = found(replace(fitted, unlike=("f", "L")))["breakers"][1:]
    assert not unlike.good
    assert "medians of f, L are bounded" in unlike.text


def test_openings_that_the_model_does_not_stop_are_said(prior):
    (stopped,) = found(fitted_of(prior, PLACES))["openings of the two-spring model"]
    assert stopped.good
    free = Prior(prior.medians * [1, 1, 1, 0.05, 0.05, 1, 1], prior.log_sds)
    (swings,) = found(fitted_of(free, PLACES))["openings of the two-spring model"]
    assert not swings.good
    assert "motions: [closing]" in swings.text


def test_a_breaker_of_another_type_stands_out(prior):
    places = PLACES.copy()
    places[2, 5] = 8.0
    findings = found(fitted_of(prior, places))["each breaker by the others"]
    assert [each.good for each in findings] == [True, True, False, True, True, True]
    # A breaker is known to a tenth of the prior's sds, and so hardly widens those of the others.
    assert findings[2].text.startswith("Q2: farthest off is f, by +14.5 sd")


def test_one_breaker_alone_is_a_warning_and_none_of_two_is_left_out(fitted, prior):
    alone, two = (fitted_of(prior, np.zeros((count, P))) for count in (1, 2))
    (each,) = found(two)["each breaker by the others"]
    assert "needs 3 breakers" in each.text
    first, *_ = found(alone)["breakers"]
    assert not first.good
    assert "the only source" in first.text
    assert alone.between.min() == 1.0
    assert alone.design == pytest.approx(np.sqrt(0.6) * 0.1, rel=0.01)
    assert found(fitted)["breakers"][0].good


def test_a_contact_that_may_not_be_pressed(prior):
    places = np.zeros((6, P))
    places[:, 5] = np.log(0.6) / 0.1
    (each,) = found(fitted_of(prior, places))["contact pressed, f > k_a L"]
    assert not each.good
