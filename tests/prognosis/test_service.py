"""A service by its cost, and dates: examples by hand."""

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import cumulative_trapezoid
from scipy.stats import weibull_min

from breaker.configuration.loading import defaults
from breaker.prognosis.forecast import Future
from breaker.prognosis.service import days_per_operation, on_date, plan

PLANNING, NAN = defaults()["planning"], np.nan
LASTS = weibull_min(3).ppf((np.arange(100) + 0.5) / 100)


def planned(lives, *, turns=np.inf, days=NAN, noticed_in=50.0, **settings):
    """The plan for one drive, 1,000 operations old, with draws of those that are left."""
    data = {"lives": (("asked", "limit", "draw"), np.array(lives)[None, None])}
    data |= {"turns": (("asked", "draw"), np.full((1, len(lives)), turns))}
    life = xr.Dataset(data | {"noticed_in": ("asked", [noticed_in])}, attrs={"horizon": 10000})
    return plan(life, PLANNING | settings, np.array([days]), np.array([1000.0]))


def best(lives, **about):
    return planned(lives, **about)[0].item()


@pytest.mark.parametrize("ratio", [2.0, 3.0, 5.0, 11.0, 100.0])
@pytest.mark.parametrize("lives", [np.repeat([300.0, 900.0], [10, 90]), 2000.0 * LASTS])
def test_a_service_is_planned_where_an_operation_costs_least(lives, ratio):
    """All drives are 1,000 operations old; a failure costs some services."""
    ahead = np.append(0.0, np.geomspace(1.0, 10000.0, 159))
    fails = (lives <= ahead[:, None]).mean(axis=1)
    age = 1000.0 + cumulative_trapezoid(1.0 - fails, ahead, initial=0.0)
    least = ahead[np.argmin((1.0 + (ratio - 1.0) * fails) / age)]
    assert best(lives, service_cost=2.0, failure_cost=2.0 * ratio) == least


def test_a_failure_that_is_near_counts_and_one_that_is_over_does_not():
    """Half of the drives have failed, or fail within an operation, the others at 500."""
    assert best(np.repeat([0.0, 500.0], 50)) == pytest.approx(500.0, rel=0.06)
    assert best(np.repeat([0.5, 500.0], 50)) == 0.0


def test_a_failure_counts_unless_records_show_it_before():
    lives, never = np.full(100, 500.0), np.full(100, np.inf)
    assert np.isinf(best(never))
    assert np.isinf(best(lives, turns=300.0))  # noticed at 351
    assert best(lives, turns=300.0, inspection="200 operations") < 500.0
    assert np.isnan(best(NAN * lives))
    in_time = {"noticed_in": 1000.0 * Future().noticed}  # a quarter of the age after the change
    assert np.isinf(best(lives, turns=248.0, **in_time))  # noticed at 499
    assert best(lives, turns=250.0, **in_time) < 500.0  # at 501


def test_a_sudden_failure_before_the_next_inspection_is_a_risk():
    """One in two years, on average, with 200 operations in 2,000 days to the next inspection."""
    about = {"days": 10.0, "inspection": "200 operations", "sudden_failures": 0.5}
    for lasts, by_then in ((np.inf, 0.0), (100.0, 1.0)):
        _, risk = planned(np.full(100, lasts), **about)
        left = (1.0 - by_then) * np.exp(-0.5 * 2000.0 / 365.25)
        assert risk.item() == pytest.approx(1.0 - left, rel=1e-3)


def test_days_count_over_the_last_year_or_since_the_first_date():
    pace = days_per_operation(np.array([1, 11, 12, 112]), np.array([0.0, 3652.0, 3653.0, 4019.0]))
    assert pace[-1] == pytest.approx(366 / 100)
    pace = days_per_operation(np.array([1, 2, 3, 11]), np.array([0.0, 30.0, 31.0, 200.0]))
    np.testing.assert_allclose(pace, [NAN, NAN, 31.0 / 2.0, 200.0 / 10.0])  # not within a month


def test_dates_of_operations_to_come():
    operations, days = np.array([10, 20, 30]), np.array([737424.0, NAN, 737484.0])
    result = on_date(np.full((3, 1), 40.0), operations, days, np.array([NAN, 2.0, 3.0]))
    assert result[:, 0].tolist() == ["", "2020-03-01", "2020-03-31"]
    far = np.array([[np.inf], [10.0 + 12176.0], [25.0]])  # 36,528 days are over a century
    assert on_date(far, operations, days, np.full(3, 3.0))[:, 0].tolist() == ["", "", "2020-02-15"]
