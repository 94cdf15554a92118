"""Limits in words, exceeded and how probably, alarms with hysteresis, and the configuration."""

import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
from scipy.stats import multivariate_normal

from breaker.mechanism.limits import Hysteresis, Limit, alarms, first, from_list, table
from breaker.model.randomness import generator

NAN = np.nan
SLOW, TIRED, BAND = from_list(
    [
        {"name": "slow", "motion": "closing", "upper": {"touch_time": 10}},
        {"name": "tired", "motion": "closing", "lower": {"f": 0.77}, "upper": {"touch_time": 9.8}},
        {"name": "band", "motion": "opening", "lower": {"mu": 2.5}, "upper": {"mu": 1.5}},
    ],
    ["closing", "opening"],
)
LEVELS = {"raise_at": 0.9, "clear_at": 0.5, "after": 2}


# ---- a limit ---------------------------------------------------------------------------------


def test_parts_and_words():
    assert SLOW.parts == (("touch_time", 10.0, True),)
    assert TIRED.parts == (("touch_time", 9.8, True), ("f", 0.77, False))
    assert TIRED.quantities == ("touch_time", "f")
    assert SLOW.words == "touch_time above 10 ms"
    assert TIRED.words == "touch_time above 9.8 ms and f below 0.77 mm/ms²"
    assert BAND.words == "mu above 1.5 and mu below 2.5"
    assert (BAND.name, BAND.motion) == ("band", "opening")
    entries = [{"name": name, "motion": name, "lower": {"L": 1}} for name in ("opening", "closing")]
    assert [limit.name for limit in from_list(entries, ["closing"])] == ["closing"]


@pytest.mark.parametrize(
    ("parts", "text"),
    [
        ((), "it has no quantity. Name one"),
        ((("part_time", 10.0, True),), "part_time is a quantity of opening, not of closing."),
        ((("speed", 1.0, False), ("rebound", 1.0, True)), r"speed is not .* rebound is a quantity"),
        ((("f", 0.8, True), ("f", 0.7, False)), r"f cannot be above 0\.8 and below 0\.7 at once"),
        ((("f", 0.8, False), ("f", 0.8, True)), r"f cannot be above 0\.8 and below 0\.8 at once"),
    ],
)
def test_what_cannot_be_a_limit_is_refused(parts, text):
    with pytest.raises(ValueError, match=f"^worn: {text}"):
        Limit("worn", "closing", parts)


def test_excess_and_exceeded():
    values = np.array([[9.9, 0.7], [9.9, 0.8], [9.7, 0.7], [9.8, 0.77], [NAN, 0.7], [9.9, NAN]])
    expected = [[0.1, 0.07], [0.1, -0.03], [-0.1, 0.07], [0, 0], [NAN, 0.07], [0.1, NAN]]
    np.testing.assert_allclose(TIRED.excess(values), expected, atol=1e-12)
    # Without a touch, or a force, there is nothing left to be within.
    assert TIRED.exceeded(values).tolist() == [True, False, False, False, True, True]
    assert TIRED.exceeded(values.reshape(3, 2, 2)).shape == (3, 2)
    assert SLOW.exceeded([10.1])
    with pytest.raises(ValueError, match=r"tired needs values \(..., 2\): touch_time above"):
        TIRED.excess(values[:, :1])


# ---- probabilities ---------------------------------------------------------------------------


def test_probability_by_hand():
    values = np.array([[9.9, 0.7], [9.9, 0.8], [9.7, 0.7], [9.9, 0.6]])
    assert TIRED.exceedance(values) == pytest.approx((0.5, 0.75 * 0.75, 0.0))
    joint, marginal, undefined = SLOW.exceedance([[10.1], [9.0], [11.0], [9.0], [9.0]])
    assert (joint, marginal, undefined) == (0.4, 0.4, 0.0)


def test_two_parts_of_one_quantity_have_one_marginal():
    """Above 1.5 and below 2.5 is one statement about mu: no product of 2/3 and 2/3."""
    joint, marginal, _ = BAND.exceedance([[1.0, 1.0], [2.0, 2.0], [3.0, 3.0]])
    assert joint == marginal == pytest.approx(1 / 3)


def test_probability_of_correlated_quantities():
    """Against the normal distribution, 4 standard errors: false alarm 4e-4 in all.

    A joint probability made of the marginals, 0.25, is 19 standard errors away.
    """
    d, correlation = 4000, -0.8
    sds = np.array([0.2, 0.02])
    rng = generator(1, "test", "limits")
    covariance = np.array([[1.0, correlation], [correlation, 1.0]])
    values = np.array([9.8, 0.77]) + sds * rng.multivariate_normal([0, 0], covariance, (3, d))
    joint, marginal, undefined = TIRED.exceedance(values)
    truth = multivariate_normal([0, 0], [[1, -correlation], [-correlation, 1]]).cdf([0, 0])
    error = 4 * np.sqrt(truth * (1 - truth) / d)
    assert joint.shape == marginal.shape == undefined.shape == (3,)
    np.testing.assert_allclose(joint, truth, atol=error)
    # Of two shares whose statements are correlated too: variance 0.2 / d.
    np.testing.assert_allclose(marginal, 0.25, atol=4 * np.sqrt(0.2 / d))
    assert np.all(np.abs(marginal - truth) > 3 * error)


def test_a_quantity_that_does_not_exist_is_beyond_any_limit():
    values = np.full((3, 200, 2), [9.9, 0.7])
    values[:, :100] = [9.0, 0.7]  # half of the draws do not exceed the limit
    values[1, 98:100, 0] = NAN  # two more do
    values[2, 190:, 1] = NAN  # as those did already
    joint, marginal, undefined = TIRED.exceedance(values)
    np.testing.assert_allclose(undefined, [0.0, 0.01, 0.05])
    np.testing.assert_allclose(joint, [0.5, 0.51, 0.5])
    np.testing.assert_allclose(marginal, [0.5, 0.51, 0.5])
    nothing = TIRED.exceedance(np.full((5, 2), NAN))
    assert nothing == (1.0, 1.0, 1.0)


def test_a_probability_needs_draws():
    for values in (np.empty((4, 0, 2)), np.empty(2)):
        with pytest.raises(ValueError, match="tired: a probability needs draws"):
            TIRED.exceedance(values)


# ---- alarms ----------------------------------------------------------------------------------


def raised(probability):
    return "".join(str(int(on)) for on in alarms(probability, **LEVELS))


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
    assert raised(probability) == expected


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
def test_alarms_of_random_series_and_from_every_state(after):
    """Whole, and cut in two anywhere with only the state handed over."""
    rng = generator(1, "test", "alarms", after)
    probability = rng.choice([0.1, 0.5, 0.7, 0.9, 1.0, NAN], 120, p=[0.2, 0.2, 0.1, 0.2, 0.2, 0.1])
    levels = {"raise_at": 0.9, "clear_at": 0.5, "after": after}
    expected = reference(probability, **levels)
    assert 10 < sum(expected) < 110
    assert alarms(probability, **levels).tolist() == expected
    for cut in range(121):
        before, state = Hysteresis(**levels).follow(probability[:cut])
        stored = {"active": bool(state.active), "count": int(state.count)}
        after_cut, _ = Hysteresis(**levels, **stored).follow(probability[cut:])
        assert [*before, *after_cut] == expected


def test_a_step_makes_a_new_state():
    start = Hysteresis(**LEVELS)
    once = start.step(0.95)
    assert (start.active, start.count, once.active, once.count) == (False, 0, False, 1)
    assert once.step(0.95) == Hysteresis(**LEVELS, active=True)
    assert once.step(NAN) == once


@pytest.mark.parametrize(
    "wrong",
    [
        {"clear_at": 0.95},
        {"raise_at": 1.5},
        {"clear_at": -0.1},
        {"raise_at": NAN},
        {"after": 0},
        {"count": 2},
        {"count": -1},
    ],
)
def test_unusable_levels_are_refused(wrong):
    with pytest.raises(ValueError, match="an alarm needs"):
        Hysteresis(**LEVELS | wrong)


@pytest.mark.parametrize("probability", [-0.1, 1.1, np.inf])
def test_no_probability(probability):
    with pytest.raises(ValueError, match="must be from 0 to 1"):
        alarms([0.5, probability], **LEVELS)


def test_first():
    assert first([False, True, True], [10, 15, 20]) == 15.0
    assert np.isnan(first([False, False], [10, 15]))
    assert np.isnan(first([], []))


def test_table():
    operations = np.array([5, 10, 15, 20, 25])
    active = np.array([[0, 1, 1, 0, 1], [1, 1, 0, 0, 0], [0, 0, 0, 0, 0]], dtype=bool).T
    probability = np.array([[1.0, 0.9, NAN, 0.99, 0.97], [NAN, NAN, 0.3, 1, 1], [1] * 5]).T
    found = table([SLOW, TIRED, BAND], operations, active, probability)
    expected = pd.DataFrame(
        {
            "limit": ["slow", "slow", "tired"],
            "words": [SLOW.words, SLOW.words, TIRED.words],
            "motion": ["closing"] * 3,
            "from_operation": pd.array([10, 25, 5], dtype="Int64"),
            "to_operation": pd.array([15, None, 10], dtype="Int64"),
            "highest_probability": [0.9, 0.97, NAN],
        }
    )
    pd.testing.assert_frame_equal(found, expected)
    assert "slow,touch_time above 10 ms,closing,25,,0.97" in found.to_csv(index=False)
    none = table([SLOW], operations, np.zeros((5, 1), dtype=bool), probability[:, :1])
    assert none.empty
    assert list(none.columns) == list(expected.columns)
    with pytest.raises(ValueError, match=r"shape \(o, l\) = \(5, 1\)"):
        table([SLOW], operations, active, probability)


def test_checked_without_compiled_code_or_tables():
    code = (
        "import sys; from breaker.mechanism import limits; "
        "sys.exit('numba' in sys.modules or 'pandas' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
