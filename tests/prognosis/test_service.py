"""A service by its cost: an example by hand, and what is so of any life."""

import numpy as np
import pytest
import xarray as xr

from breaker.configuration.loading import defaults
from breaker.prognosis.service import days_per_operation, on_date, plan

PLANNING, NAN = defaults()["planning"], np.nan


def planned(lives, *, turns=np.inf, days=NAN, **settings):
    """The plan for one drive, 1,000 operations old, with draws of those that are left."""
    data = {"lives": (("asked", "limit", "draw"), np.array(lives)[None, None])}
    data |= {"turns": (("asked", "draw"), np.full((1, len(lives)), turns))}
    life = xr.Dataset(data | {"noticed_in": ("asked", [50.0])}, attrs={"horizon": 10000})
    return plan(life, PLANNING | settings, np.array([days]), np.array([1000.0]))


def best(lives, **about):
    return planned(lives, **about)[0].item()


def test_a_service_is_planned_where_it_costs_least_by_hand():
    """A tenth of the drives lasts 300 operations more, the others 900; all are 1,000 old.

    A service costs 1, a failure 11: 1 / 1300 an operation at 300, 2 / 1840 just before 900.
    """
    lives = np.repeat([300.0, 900.0], [10, 90])
    for failure_cost, left in ((11.0, 300.0), (3.0, 900.0)):
        best, _, extra = planned(lives, failure_cost=failure_cost)
        result = best.item()
        assert result == extra.ahead[extra.ahead < left][-1]
        assert extra.min() == extra.sel(ahead=result) == 0.0


def test_a_dearer_failure_never_plans_later():
    rng = np.random.default_rng(0)
    for spread in (0.1, 0.3, 0.8):
        lives = 500.0 * np.exp(spread * rng.standard_normal(200))
        result = [best(lives, failure_cost=c) for c in (2, 5, 10, 20, 100, 1000)]
        assert result == sorted(result, reverse=True)


def test_a_failure_counts_unless_records_show_it_before():
    lives, never = np.full(100, 500.0), np.full(100, np.inf)
    assert np.isinf(best(never))
    assert np.isinf(best(lives, turns=300.0))  # noticed at 351
    assert best(lives, turns=300.0, inspection="200 operations") < 500.0
    assert np.isnan(best(NAN * lives))


def test_a_sudden_failure_before_the_next_inspection_is_a_risk():
    """One in two years, on average, with 200 operations in 2,000 days to the next inspection."""
    about = {"days": 10.0, "inspection": "200 operations", "sudden_failures": 0.5}
    for lasts, by_then in ((np.inf, 0.0), (100.0, 1.0)):
        _, risk, _ = planned(np.full(100, lasts), **about)
        left = (1.0 - by_then) * np.exp(-0.5 * 2000.0 / 365.25)
        assert risk.item() == pytest.approx(1.0 - left, rel=1e-3)


def test_days_count_over_the_last_year_or_since_the_first_date():
    """Twenty operations in one year and eight years later, 200 numbers apart: 16 days each."""
    operations = np.concatenate([np.arange(101, 121), np.arange(301, 321)])
    pace = days_per_operation(operations, np.repeat([0.0, 2922.0], 20))
    assert np.isnan(pace[:20]).all()
    np.testing.assert_allclose(pace[20:], 2922 / np.arange(181, 201))
    pace = days_per_operation(np.array([1, 11, 12, 112]), np.array([0.0, 3652.0, 3653.0, 4019.0]))
    assert pace[-1] == pytest.approx(366 / 100)


def test_dates_of_operations_to_come():
    operations, days = np.array([10, 20, 30]), np.array([737424.0, NAN, 737484.0])
    result = on_date(np.full((3, 1), 40.0), operations, days, np.array([NAN, 2.0, 3.0]))
    assert result[:, 0].tolist() == ["", "2020-03-01", "2020-03-31"]
    far = np.array([[np.inf], [1e9], [25.0]])
    assert on_date(far, operations, days, np.full(3, 3.0))[:, 0].tolist() == ["", "", "2020-02-15"]
