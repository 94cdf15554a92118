"""Hysteresis, and the table of the spells in which limits were exceeded."""

import numpy as np
import pandas as pd
import xarray as xr

from breaker.decisions.alarms import alarm_table, first, latched

NAN = np.nan
MOTIONS_OF = {"slow": "closing", "wide": "opening"}


def test_latched_against_its_history():
    """Random series, of which each value follows from the last that says anything."""
    rng = np.random.default_rng(1)
    on, off = rng.random((2, 200, 3)) < 0.1
    found = latched(on, off)
    for j in range(3):
        state = False
        for i in range(200):
            state = bool(on[i, j]) or (state and not off[i, j])
            assert found[i, j] == state
    assert latched(on[:0], off[:0]).shape == (0, 3)


def test_first_of_none():
    assert np.isnan(first([False, False], [10, 15]))


def judged(exceeded, probability):
    """What ``judge`` returns of two limits, as far as alarms need it."""
    dims = ("operation", "limit")
    return xr.Dataset(
        {
            "exceeded": (dims, np.array(exceeded, dtype=bool)),
            "level_probability": (dims, np.array(probability)),
            "words": ("limit", ["touch_time above 10 ms", "L above 11 mm"]),
        },
        {"operation": [5, 10, 15, 20, 25], "limit": ["slow", "wide"]},
    )


def test_table():
    exceeded = np.array([[0, 1, 1, 0, 1], [1, 1, 0, 0, 0]]).T
    probability = np.array([[1.0, 0.9, 0.8, 0.99, 0.97], [0.98, 0.99, 0.3, 1, 1]]).T
    found = alarm_table(judged(exceeded, probability), MOTIONS_OF)
    expected = pd.DataFrame(
        {
            "limit": ["slow", "slow", "wide"],
            "words": ["touch_time above 10 ms"] * 2 + ["L above 11 mm"],
            "motion": ["closing", "closing", "opening"],
            "from_operation": pd.array([10, 25, 5], dtype="Int64"),
            "to_operation": pd.array([15, None, 10], dtype="Int64"),
            "highest_probability": [0.9, 0.97, 0.99],
        }
    )
    pd.testing.assert_frame_equal(found, expected)
    none = alarm_table(judged(0 * exceeded, probability), MOTIONS_OF)
    assert none.empty
    assert list(none.columns) == list(expected.columns)
