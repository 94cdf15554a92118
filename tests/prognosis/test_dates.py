"""Days from operations: visits years apart, bursts, and dates that are missing."""

import numpy as np
import pytest

from breaker.prognosis.tables import days_per_operation, on_date

NAN = np.nan


def test_visits_years_apart_and_bursts_count_as_what_they_are():
    """Twenty operations on a day in 2016 and in 2024, 200 numbers apart: 16 days each."""
    operations = np.concatenate([np.arange(101, 121), np.arange(301, 321)])
    dates = ["2016-05-01"] * 20 + ["2024-05-01"] * 20
    pace = days_per_operation(operations, dates)
    assert np.isnan(pace[:20]).all()
    np.testing.assert_allclose(pace[20:], 2922 / np.arange(181, 201))


def test_a_recent_year_counts_not_the_years_before():
    operations = np.array([1, 11, 12, 112])
    dates = ["2010-01-01", "2020-01-01", "2020-01-02", "2021-01-01"]
    pace = days_per_operation(operations, dates)
    assert pace[-1] == pytest.approx(365 / 100)  # from 2020-01-02 on
    assert np.isnan(days_per_operation(operations[:2], ["2020-01-01", "2020-01-30"])).all()


def test_dates_that_are_missing_or_not_in_order():
    operations = np.array([1, 2, 3, 4])
    assert np.isnan(days_per_operation(operations, [""] * 4)).all()
    pace = days_per_operation(operations, ["2020-01-01", "", "2020-03-01T12:00:00", ""])
    np.testing.assert_array_equal(pace, [NAN, NAN, 60.5 / 2, 60.5 / 2])
    assert np.isnan(days_per_operation(operations[:2], ["2020-03-01", "2020-01-01"])).all()
    zone = days_per_operation(operations[:2], ["2020-01-01T00:00:00+02:00", "2020-03-01"])
    assert zone[1] == pytest.approx(60.0, abs=0.1)


def test_dates_of_operations_to_come():
    operations, dates = np.array([10, 20, 30]), ["2020-01-01", "", "2020-03-01"]
    pace = np.array([NAN, 2.0, 3.0])
    assert on_date(np.array([40.0, 40.0, 40.0]), operations, dates, pace) == [
        *("", "2020-03-01"),
        "2020-03-31",
    ]
    far = np.array([np.inf, 1e9, 25.0])
    assert on_date(far, operations, dates, np.full(3, 3.0)) == ["", "", "2020-02-15"]
    first = on_date(np.array([1.0]), np.array([500]), ["0001-01-01"], np.array([9.0]))
    assert first == [""]  # before the first year there is
    last = on_date(np.array([600.0]), np.array([500]), ["9999-12-01"], np.array([9.0]))
    assert last == [""]
