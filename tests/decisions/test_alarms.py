"""Alarms raised and cleared with hysteresis, and their table."""

import numpy as np
import pandas as pd
import pytest

from breaker.decisions.alarms import alarm_table, first, raised
from breaker.mechanism.limits import Limit
from breaker.model.randomness import generator

NAN = np.nan
LIMITS = [
    Limit.from_settings({"name": "slow", "motion": "closing", "upper": {"touch_time": 10}}),
    Limit.from_settings({"name": "tired", "motion": "closing", "lower": {"f": 0.77}}),
    Limit.from_settings({"name": "wide", "motion": "opening", "upper": {"L": 11.0}}),
]
LEVELS = {"raise_at": 0.9, "clear_at": 0.5, "after": 2}


@pytest.mark.parametrize(
    ("probability", "expected"),
    [
        ([], ""),
        ([0.9, 0.9, 0.9], "011"),  # at the level counts
        ([0.89, 0.95, 0.89, 0.95], "0000"),  # not in a row
        ([0.95, 0.95, 0.6, 0.5, 0.6, 0.5, 0.4, 0.4], "01111100"),
        ([0.95, NAN, NAN, 0.95], "0001"),  # skipped, not reset
        ([0.95, NAN, 0.6, 0.95], "0000"),
        ([0.95, 0.95, NAN, 0.1, NAN, 0.1, NAN], "0111100"),
        ([0.95, 0.95, 0.1, 0.1, 0.95, 0.1, 0.95, 0.95], "01100001"),
        ([NAN, NAN], "00"),
    ],
)
def test_hysteresis(probability, expected):
    on = raised(probability, **LEVELS)
    assert "".join(str(int(each)) for each in on) == expected


def reference(probability, raise_at, clear_at, after):
    """The alarm after each operation, from the whole history: the last row of ``after`` usable
    ones on one side decides."""
    active = []
    for end in range(1, len(probability) + 1):
        usable = [p for p in probability[:end] if not np.isnan(p)]
        on = False
        for i in range(after, len(usable) + 1):
            row = usable[i - after : i]
            if min(row) >= raise_at:
                on = True
            elif max(row) <= clear_at:
                on = False
        active.append(on)
    return active


@pytest.mark.parametrize("after", [1, 2, 3])
def test_alarms_of_random_series(after):
    """Against the whole history, judged anew at every operation."""
    rng = generator(1, "test", "alarms", after)
    probability = rng.choice([0.1, 0.5, 0.7, 0.9, 1.0, NAN], 120, p=[0.2, 0.2, 0.1, 0.2, 0.2, 0.1])
    levels = {"raise_at": 0.9, "clear_at": 0.5, "after": after}
    expected = reference(probability, **levels)
    assert 10 < sum(expected) < 110
    assert raised(probability, **levels).tolist() == expected


@pytest.mark.parametrize(
    "wrong",
    [
        {"clear_at": 0.95},
        {"raise_at": 1.5},
        {"clear_at": -0.1},
        {"raise_at": NAN},
        {"after": 0},
    ],
)
def test_unusable_levels_are_refused(wrong):
    with pytest.raises(ValueError, match="an alarm needs"):
        raised([], **LEVELS | wrong)


@pytest.mark.parametrize("probability", [-0.1, 1.1, np.inf])
def test_no_probability(probability):
    with pytest.raises(ValueError, match="must be from 0 to 1"):
        raised([0.5, probability], **LEVELS)


def test_first():
    assert first([False, True, True], [10, 15, 20]) == 15.0
    assert np.isnan(first([False, False], [10, 15]))
    assert np.isnan(first([], []))


def test_table():
    operations = np.array([5, 10, 15, 20, 25])
    active = np.array([[0, 1, 1, 0, 1], [1, 1, 0, 0, 0], [0, 0, 0, 0, 0]], dtype=bool).T
    probability = np.array([[1.0, 0.9, NAN, 0.99, 0.97], [NAN, NAN, 0.3, 1, 1], [1] * 5]).T
    found = alarm_table(LIMITS, operations, active, probability)
    expected = pd.DataFrame(
        {
            "limit": ["slow", "slow", "tired"],
            "words": [LIMITS[0].words, LIMITS[0].words, LIMITS[1].words],
            "motion": ["closing"] * 3,
            "from_operation": pd.array([10, 25, 5], dtype="Int64"),
            "to_operation": pd.array([15, None, 10], dtype="Int64"),
            "highest_probability": [0.9, 0.97, NAN],
        }
    )
    pd.testing.assert_frame_equal(found, expected)
    assert "slow,touch_time above 10 ms,closing,25,,0.97" in found.to_csv(index=False)
    none = alarm_table(LIMITS[:1], operations, np.zeros((5, 1), dtype=bool), probability[:, :1])
    assert none.empty
    assert list(none.columns) == list(expected.columns)
    with pytest.raises(ValueError, match=r"shape \(o, l\) = \(5, 1\)"):
        alarm_table(LIMITS[:1], operations, active, probability)
