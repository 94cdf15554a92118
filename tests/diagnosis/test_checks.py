"""Checks of a fitted prior: what is as it should be, and what is not."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.diagnosis.prior_checks import _far_limits, check_fitted
from breaker.diagnosis.type_model import TypeDraws, learn_type
from breaker.diagnosis.type_prior import FittedPrior
from breaker.model.limits import Limit
from breaker.model.parameters import Size
from breaker.model.prior import Prior

P, KNOWN = 7, 0.1  # of the prior's sds, to which a breaker is known
USUAL = np.array([0.20, 0.15, 0.20, 0.20, 0.40, 0.10, 0.05])


def fitted_of(prior, places):
    """A prior from breakers that are known well at standardised places."""
    rng = generator(1, "test draws")
    z = np.asarray(places)[:, None, None] + KNOWN * rng.standard_normal((len(places), 2, 250, P))
    drawn = TypeDraws.of(map(list, prior.destandardise(z)))
    names = tuple(f"Q{i}" for i in range(len(places)))
    return FittedPrior(prior, names, drawn, learn_type(drawn, USUAL), np.zeros(P))


PLACES = 0.3 * generator(2, "test places").standard_normal((6, P))


@pytest.fixture(scope="module")
def fitted(prior):
    return fitted_of(prior, PLACES)


def found(fitted, *, limits=(), records=None):
    recorded = SimpleNamespace(records=records or {}, tried=["this"])
    recorded.size, recorded.motions = Size(), ["closing", "opening"]
    return check_fitted(fitted, recorded, limits, 1)


def limit(side="upper", **value):
    return Limit.from_settings({"name": "late", "motion": "closing", side: value})


def test_limits_within_three_sds(fitted):
    (near,) = found(fitted, limits=[limit(L=10.2)])["limits"]
    (far,) = found(fitted, limits=[limit(L=15.0)])["limits"]
    (none,) = found(fitted)["limits"]
    assert [near.good, far.good, none.good] == [True, False, True]


@pytest.mark.parametrize(("side", "value"), [("lower", 0.5), ("upper", 2.0)])
def test_limits_are_off_by_the_width_of_their_own_side(side, value):
    """Of a skewed distribution; 0.68 times its half is a standard deviation."""
    theta = np.exp(np.linspace(-1.0, 1.0, 1001))[:, None] * np.ones(P)
    (found,) = _far_limits([limit(side, L=value ** (0.68 / np.log(2.0)))], theta)
    assert f" is 1.0 sd of the prior {'below' if side == 'lower' else 'above'} its" in found.text


def test_records_out_of_the_family(fitted):
    def answers(*p_values):
        return [
            SimpleNamespace(match=SimpleNamespace(p_value=p), misfit=p < 1e-3) for p in p_values
        ]

    records = {"Q0": {"closing": answers(0.3, 0.5)}, "Q1": {"closing": answers(0.3, 1e-6, 0.1)}}
    good, bad = found(fitted, records=records)["records in the family"]
    assert [good.good, bad.good] == [True, False]
    assert "p = 0.4" in good.text


def test_spread_that_the_configuration_does_not_take_is_said(fitted):
    wide, spread = (
        replace(fitted, widest=np.where(np.arange(7) == 4, 0.04, np.inf)),
        fitted.spread_seen,
    )
    (bounded,) = found(wide)["breakers"][1:]
    assert not bounded.good
    assert f"log-sds of gamma_b {spread[4]:.3g} are bounded to 0.04" in bounded.text
    assert len(found(fitted)["breakers"]) == 1
    (unlike,) = found(replace(fitted, unlike=("f", "L")))["breakers"][1:]
    assert not unlike.good
    assert "f, L" in unlike.text


def test_openings_that_the_model_does_not_stop_are_said(prior):
    (stopped,) = found(fitted_of(prior, PLACES))["openings of the two-spring model"]
    assert stopped.good
    free = Prior(prior.medians * [1, 1, 1, 0.08, 0.08, 1, 1], prior.log_sds)
    (swings,) = found(fitted_of(free, PLACES))["openings of the two-spring model"]
    assert not swings.good


def test_a_breaker_of_another_type_stands_out(prior):
    places = PLACES.copy()
    places[2, 5] = 8.0
    findings = found(fitted_of(prior, places))["each breaker beside the others"]
    assert [each.good for each in findings] == [True, True, False, True, True, True]
    assert {"Q2:", "f,"} <= {*findings[2].text.split()}


def test_one_breaker_alone_is_a_warning_and_none_of_four_is_odd(fitted, prior):
    alone, four = (fitted_of(prior, np.zeros((count, P))) for count in (1, 4))
    assert len(found(four)["each breaker beside the others"]) == 1
    assert not found(alone)["breakers"][0].good
    assert (alone.learned.spread == USUAL).all()
    assert alone.learned.shared == pytest.approx(np.sqrt(0.6) * KNOWN * prior.log_sds, rel=0.2)
    assert found(fitted)["breakers"][0].good


def test_a_contact_that_may_not_be_pressed(prior):
    places = np.zeros((6, P))
    places[:, 5] = np.log(0.6) / 0.1
    (each,) = found(fitted_of(prior, places))["contact pressed, f > k_a L"]
    assert not each.good
