"""Remaining lives: of straight paths, of wear that may change, of what is known badly."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from breaker.model.limits import Limit
from breaker.prognosis.drift import Drift
from breaker.prognosis.forecast import Forecast, Future, Onward, _crossings
from breaker.prognosis.readout import Readout
from breaker.prognosis.tracker import Tracker

LIMIT = Limit("slow", "closing", (("travel_time", 10.0, True),), of="record")
SURE = Future(horizon=10000, changes=1e-9, drift=1e-6)


class OneQuantity:
    """A readout of one coordinate: what is measured is 8 and the coordinate."""

    size, seed = 1, 1

    def ways(self):
        return []

    def condition(self, change, variance, where):
        normal = np.linspace(-2.0, 2.0, 201)
        values = (8.0 + change + np.sqrt(variance) * normal)[:, :, None]
        return SimpleNamespace(of_record=lambda limit: values)


def path(change, rate, sd=0.01, rate_sd=1e-6, bend=0.0, bend_sd=1.0):
    one = np.ones((1, 1))
    return SimpleNamespace(
        change=change * one,
        variance=sd**2 * one,
        rate=rate * one,
        rate_variance=rate_sd**2 * one,
        covariance=0.0 * one,
        bend=bend * one,
        bend_variance=bend_sd**2 * one,
    )


def forecast(path, future=SURE, past=1000.0):
    first, past = np.array([0]), np.array([past])
    onward = Onward(path, OneQuantity(), first, future.horizon, "new")
    drift = Drift.of(path, first, past, future.drift, future.drifting, 1)
    return Forecast.of(LIMIT, onward, drift, past, future)


@dataclass(frozen=True)
class TwoCoordinates:
    """A readout of two coordinates: what is inferred is 8 and the first of them."""

    draws: int = 200
    seed: int = 1
    theta: None = None

    size, ways = 2, Readout.ways

    def condition(self, change, variance, where):
        values = np.tile(8.0 + change[:, :1, None], (1, self.draws, 1))
        return SimpleNamespace(of_change=lambda limit: values)


@pytest.mark.parametrize(("rate_sd", "spread"), [([3e-4, 1e-9], 0.15), ([1e-9, 3e-4], 0.0)])
def test_a_rate_is_uncertain_in_its_own_direction(rate_sd, spread):
    """What is not known of a coordinate that an inferred quantity does not show moves no life."""
    known = path(np.array([1.0, 0.0]), np.array([0.002, 0.0]), rate_sd=np.array(rate_sd))
    first, past = np.array([0]), np.array([1000.0])
    onward = Onward(known, TwoCoordinates(), first, SURE.horizon, "new")
    drift = Drift.of(known, first, past, 1e-6, 1e-6, 1)
    limit = Limit("stiff", "", (("gamma_a", 10.0, True),), of="change")
    (lives,) = Forecast.of(limit, onward, drift, past, SURE).lives
    assert lives.size == 200
    assert np.median(lives) == pytest.approx(500.0, rel=0.05)
    assert np.log(lives).std() == pytest.approx(spread, abs=0.02)
    # Of few ways the draws have tails as of a normal, by which a service is planned.
    assert np.log(500.0 / lives[0]) == pytest.approx(2.3 * spread, abs=0.06)


def test_what_is_not_given_is_as_in_the_configuration(defaults):
    assert Future.from_settings(defaults["trend"]) == Future()
    assert Tracker.from_settings(defaults["trend"]) == Tracker()


def test_a_straight_path_crosses_where_it_does():
    found = forecast(path(1.0, 0.002))
    assert found.beyond[0] == 0.0
    assert found.value[0, 0, 1] == pytest.approx(9.0)
    assert np.median(found.lives[0]) == pytest.approx(500.0, rel=0.02)
    steady = np.quantile(found.lives[0], [0.05, 0.5, 0.95])
    np.testing.assert_allclose(found.remaining[0], steady, rtol=0.1)


@pytest.mark.parametrize(("at", "rate", "left"), [(1.0, -0.002, np.inf), (2.5, 0.002, 0.0)])
def test_a_path_that_leads_away_never_does_and_one_beyond_has_nothing_left(at, rate, left):
    found = forecast(path(at, rate))
    assert found.beyond[0] == (at > 2.0)
    assert (found.remaining[0] == left).all()
    assert (found.lives[0] == left).all()


def test_wear_that_may_become_faster_shortens_the_early_end_alone():
    steady, may = (forecast(path(1.0, 0.002), SURE._replace(changes=c)) for c in (1e-9, 1.0))
    assert may.remaining[0, 0] < 0.6 * steady.remaining[0, 0]
    np.testing.assert_allclose(may.lives, steady.lives)
    vague = forecast(path(1.0, 0.002, sd=0.6))  # what is known badly is told so
    assert np.ptp(vague.remaining[0]) > 5.0 * np.ptp(steady.remaining[0])


def test_a_rate_that_drifts_brings_the_limit_sooner_or_later():
    """A limit 500 operations ahead at the rate so far, of a drive that has made 1,000."""
    about = {"bend_sd": 1e-8}  # well known
    goes_on = SURE._replace(drift=1.0, drifting=1e-6)
    faster, slower = (
        np.median(forecast(path(1.0, 0.002, bend=k * 0.002 / 1000.0, **about), goes_on).lives)
        for k in (1.0, -1.0)
    )
    assert faster == pytest.approx(1000.0 * (np.sqrt(2.0) - 1.0), rel=0.02)
    assert slower == pytest.approx(1000.0 * np.expm1(0.5), rel=0.02)
    unknown = forecast(path(1.0, 0.002), Future(changes=1e-9))
    steady = forecast(path(1.0, 0.002))
    assert np.ptp(unknown.remaining[0]) > 5.0 * np.ptp(steady.remaining[0])


def test_changes_come_as_often_in_any_unit_of_operations():
    future = Future(horizon=10000, changes=1.5)
    ways, shares = future.ways(), future.shares(500.0)
    assert shares.sum() == pytest.approx(1.0)
    ahead = future.ahead()
    np.testing.assert_allclose(ways[:, 0], ahead)
    assert shares[0] == pytest.approx((10500.0 / 500.0) ** -1.5)
    assert (ways >= ahead[:, None] - 1e-9).all()  # faster is the usual change
    lives = np.tile(2000.0 * np.linspace(0.9, 1.1, 101), (1, 1))
    left = future.quantiles(future.fails(lives, np.array([500.0])))
    twice = Future(horizon=20000, changes=1.5)
    doubled = twice.quantiles(twice.fails(2.0 * lives, np.array([1000.0])))
    np.testing.assert_allclose(doubled, 2.0 * left, rtol=0.05)


def test_a_change_may_come_however_far_off_the_limit_seems():
    """Nine of ten draws never reach it, the tenth after 6,000 operations; a change is 6 times."""
    lives = np.append(np.full(10, 6000.0), np.full(90, np.inf))[None]
    fails = Future(changes=1.0, spread=0.0).fails(lives, np.array([500.0]))[0]
    # After 1,500 more: of the tenth, those whose rate changed before 600 operations, of 1,100.
    share = np.interp(1500.0, Future().ahead(), fails)
    assert share == pytest.approx(0.1 * 600.0 / 1100.0, rel=0.1)


def test_a_change_that_is_noticed_leads_no_further():
    """Draws that last 1,000 more, and one change, at once, which makes them 4 times as fast."""
    future = Future(changes=100.0, faster=4.0, spread=0.0)
    lives, past = np.full((1, 50), 1000.0), np.array([1000.0])
    unseen, seen = (future.fails(lives, past, lag)[0] for lag in (np.inf, 100.0))
    ahead = future.ahead()
    assert np.interp(200.0, ahead, unseen) < 0.01
    assert np.interp(400.0, ahead, unseen) > 0.99
    # After 100 operations it has come 300 further, and is serviced: what fails came later.
    assert np.interp(600.0, ahead, seen) < 0.01


def test_crossings_lie_on_the_line_between_nodes():
    nodes = np.array([0.0, 10.0, 100.0])
    excess = np.array([[-1.0, -1.0, 1.0], [-0.5, 1.0, 2.0], [4.0, 2.0, -1.0]])[:, :, None]
    np.testing.assert_allclose(_crossings(excess, nodes), [20.0, 5.0, 0.0])
    assert np.isinf(_crossings(-np.ones((3, 2, 1)), nodes)).all()
    parts = np.array([[[-1.0, -3.0]], [[1.0, 1.0]]])  # all parts of a limit have to hold
    np.testing.assert_allclose(_crossings(parts, nodes[:2]), [7.5])


def test_quantiles_of_a_distribution_that_ends_early():
    future = Future(horizon=100)
    ahead = future.ahead()
    low = np.where(ahead < 10.0, 0.04 * ahead, np.minimum(0.4 + (ahead - 10.0) / 450.0, 0.6))
    found = future.quantiles(np.stack([low, np.ones(ahead.size), np.full(ahead.size, np.nan)]))
    np.testing.assert_allclose(found[0], [1.25, 55.0, np.inf], rtol=0.02)
    assert (found[1] == 0.0).all()
    assert np.isnan(found[2]).all()
