"""A service by its cost: an example by hand, and what holds for any life."""

from itertools import pairwise

import numpy as np
import pytest

from breaker.configuration.loading import defaults
from breaker.prognosis.service import Costs, ahead_of, plan

PLANNING = defaults()["planning"]
AHEAD = ahead_of(10000)


def planned(lives, past=1000.0, *, turns=np.inf, days=np.nan, **settings):
    """The plan of one drive with draws of the operations that are left."""
    one, lives = np.ones(1), np.array(lives)[None]
    costs, turns = Costs.from_settings(PLANNING | settings), np.full(lives.shape, turns)
    return plan(AHEAD, costs, lives, turns, 50.0 * one, age=past * one, days=days * one)


def test_a_service_is_planned_where_it_costs_least_by_hand():
    """A tenth of the drives lasts 300 operations more, the others 900; all are 1,000 old.

    A service costs 1, a failure 11: 1 / 1300 an operation at 300, 2 / 1840 just before 900.
    """
    lives = np.repeat([300.0, 900.0], [10, 90])
    found = planned(lives, failure_cost=11.0, sudden_failures=0.0)
    last = AHEAD[np.searchsorted(AHEAD, 300.0) - 1]
    assert found.best[0] == last
    cheap = planned(lives, failure_cost=3.0, sudden_failures=0.0)
    assert cheap.best[0] == AHEAD[np.searchsorted(AHEAD, 900.0) - 1]


@pytest.mark.parametrize("number", range(6))
def test_a_dearer_failure_never_plans_later(number):
    rng = np.random.default_rng(number)
    lives = 500.0 * np.exp(rng.uniform(0.05, 0.8) * rng.standard_normal(200))
    found = [planned(lives, failure_cost=c).best[0] for c in (2, 5, 10, 20, 100, 1000)]
    assert all(later <= sooner for sooner, later in pairwise(found))


def test_a_failure_counts_unless_records_show_it_before():
    lives, never = np.full(100, 500.0), np.full(100, np.inf)
    assert np.isinf(planned(never).best[0])
    assert np.isinf(planned(lives, turns=300.0).best[0])  # noticed at 351
    assert planned(lives, turns=300.0, inspection="200 operations").best[0] < 500.0
    assert np.isnan(planned(np.nan * lives).best[0])
