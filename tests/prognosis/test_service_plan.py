"""A service by its cost: an example by hand, and what holds for any life."""

from itertools import pairwise

import numpy as np
import pytest

from breaker.configuration.loading import defaults
from breaker.prognosis.forecast import Future
from breaker.prognosis.limit_states import standing
from breaker.prognosis.service_plan import Costs, plan
from tests.lives import OPERATIONS, a_life

PLANNING = defaults()["planning"]
STEADY = Future(changes=1e-9)
SOME = 12  # lives drawn
YEARLY = 3.65  # days, at 100 operations a year


def planned(lives, past=1000.0, *, age=None, days=np.nan, future=STEADY, spacing=1.0, **settings):
    """The plan of one drive with draws of the operations that are left."""
    one = np.ones(1)
    costs = Costs.from_settings(PLANNING | settings)
    about = {"age": (age or past) * one, "days": days * one, "spacing": spacing * one}
    return plan(future, costs, np.sort(lives)[None], past * one, **about)


def drawn(number):
    """Draws of a drive, how old it is, and what its future may be, as of a number."""
    rng = np.random.default_rng(number)
    past, left = np.exp(rng.uniform(np.log([100.0, 20.0]), np.log([5000.0, 5000.0])))
    lives = left * np.exp(rng.uniform(0.05, 0.8) * rng.standard_normal(200))
    lives[rng.random(200) < rng.choice([0.0, 0.3])] = np.inf
    return lives, past, Future(changes=rng.choice([0.2, 2.0]), noticed=rng.choice([0.0, 50.0]))


def test_a_service_is_planned_where_it_costs_least_by_hand():
    """A tenth of the drives lasts 300 operations more, the others 900; all are 1,000 old.

    A service costs 1, a failure 11. To go on to 300 is free, and gains. From there to 900 the tenth
    fails: that costs 10 more a failure, 1 in all, for 0.9 times 600 operations. Drives of this kind
    cost, in failures: 0.1 / 1300 an operation if serviced at 300, (0.1 + 0.1) / 1840 at 900. So an
    operation is worth 1 / 1300, and the 540 gain 0.42, less than 1.
    """
    lives = np.repeat([300.0, 900.0], [10, 90])
    costs = {"failure_cost": 11.0, "inspection": "1 operation", "sudden_failures": 0.0}
    found = planned(lives, **costs)
    ahead = STEADY.ahead()
    last = ahead[np.searchsorted(ahead, 300.0) - 1]
    assert found.best[0] == last
    assert found.rate[0] == pytest.approx(1.0 / (1000.0 + last))
    before = np.searchsorted(ahead, 900.0) - 1
    gained = 0.9 * (ahead[before] - last) / (1000.0 + last)
    assert found.extra[0, before] == pytest.approx(1.0 - gained, abs=0.02)
    # With a failure at 3 the tenth costs 0.2, and the others are worth going on for.
    cheap = planned(lives, **costs | {"failure_cost": 3.0})
    assert cheap.best[0] == ahead[before]


@pytest.mark.parametrize("number", range(SOME))
def test_a_dearer_failure_never_plans_later(number):
    lives, past, future = drawn(number)
    each = [planned(lives, past, future=future, failure_cost=c) for c in (2, 5, 10, 20, 100, 1000)]
    assert all(later.best[0] <= sooner.best[0] for sooner, later in pairwise(each))
    assert each[-1].best[0] < each[0].best[0] or np.isinf(each[-1].best[0])


@pytest.mark.parametrize("number", range(SOME))
def test_a_longer_interval_of_inspection_never_plans_later(number):
    lives, past, future = drawn(number)
    words = (
        "every operation",
        "7 operations",
        "100 operations",
        "150 operations",
        "3000 operations",
    )
    each = [planned(lives, past, future=future, inspection=each) for each in words]
    assert all(later.best[0] <= sooner.best[0] for sooner, later in pairwise(each))
    assert all(sooner.risk[0] <= later.risk[0] for sooner, later in pairwise(each))


def test_what_is_right_where_every_operation_is_watched_is_late_for_a_visit():
    lives = 800.0 + 20.0 * np.linspace(-2.0, 2.0, 200)
    future = Future(changes=2.0, noticed=0.0)
    watched, visited = (
        planned(lives, future=future, inspection=each)
        for each in ("every operation", "400 operations")
    )
    assert visited.best[0] < 0.5 * watched.best[0]
    # Nobody knows when the next visit is.
    unknown = planned(lives, future=future, inspection="4 years")
    assert unknown.best[0] <= visited.best[0]
    known = planned(lives, future=future, inspection="4 years", days=YEARLY, sudden_failures=0.0)
    assert known.best[0] == visited.best[0]


def test_sudden_failures_can_be_turned_off_and_no_service_prevents_them():
    lives = 800.0 + 20.0 * np.linspace(-2.0, 2.0, 200)
    about = {"days": YEARLY, "inspection": "1 year"}
    none, some = (planned(lives, **about, sudden_failures=each) for each in (0.0, 0.02))
    assert none.risk[0] == pytest.approx(0.0, abs=1e-9)
    assert some.risk[0] == pytest.approx(1.0 - np.exp(-0.02), rel=0.01)
    assert some.rate[0] - none.rate[0] == pytest.approx(0.02 / 100.0 * 19.0, rel=0.05)
    assert none.best[0] <= some.best[0] <= 1.1 * none.best[0]
    never = planned(np.full(200, np.inf), **about, sudden_failures=1.0)
    assert np.isinf(never.best[0])


def test_inspections_cost_and_move_nothing():
    lives = 800.0 + 20.0 * np.linspace(-2.0, 2.0, 200)
    free, paid = (
        planned(lives, inspection="10 operations", inspection_cost=each) for each in (0.0, 0.5)
    )
    assert free.best[0] == paid.best[0]
    assert paid.rate[0] - free.rate[0] == pytest.approx(0.05)


def test_a_drive_that_was_serviced_is_worth_going_on_with_for_longer():
    lives = 500.0 * np.exp(0.4 * np.random.default_rng(1).standard_normal(400))
    old, young = (planned(lives, 5000.0, age=each, failure_cost=3.0) for each in (5000.0, 10.0))
    assert old.best[0] < young.best[0]


@pytest.mark.parametrize("number", range(SOME))
def test_no_service_is_told_behind_the_quantile_beside_it(number):
    """Of every row: by construction, whatever the draws."""
    rng, life = np.random.default_rng(100 + number), a_life()
    future = Future(changes=2.0, noticed=rng.choice([0.0, 20.0]))
    asked, lives = life.asked.values, np.empty((*life.beyond.shape, 100))
    for j, end in enumerate(rng.uniform(200.0, 900.0, 2)):
        left = np.maximum(end - asked, 0.0) * np.exp(0.2 * rng.standard_normal(asked.size))
        lives[:, j] = np.sort(left[:, None] * np.exp(0.3 * rng.standard_normal(100)), axis=1)
        life.remaining[:, j] = future.quantiles(future.fails(lives[:, j], asked.astype(float)))
    life = life.assign(lives=(("asked", "limit", "draw"), lives)).assign_attrs(future._asdict())
    words = rng.choice(["every operation", "50 operations", "1 year"])
    stands = standing(life, PLANNING | {"inspection": words}, np.full(OPERATIONS.size, YEARLY))
    last = OPERATIONS[:, None] + stands.left.values[..., 0]
    told = np.isfinite(stands.service_by.values)
    assert told.any()
    assert (stands.service_by.values <= last)[told].all()
    # The probability is of the same draws: above 5 % where that quantile is before the next look.
    interval = Costs.from_settings(PLANNING | {"inspection": words}).interval(np.array(YEARLY))
    at = np.searchsorted(OPERATIONS, asked)
    risk, left = stands.risk.values[at], life.remaining.values[..., 0]
    assert (risk[left < 0.99 * interval] >= 0.05).all()
    assert (risk[left > 1.01 * interval] <= 0.05 + 0.0015 * interval / 100.0).all()
