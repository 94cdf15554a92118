"""Limits in words, exceeded and how probably, and the configuration."""

import subprocess
import sys

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from breaker.mechanism.limits import Limit, complaint
from breaker.mechanism.parameters import MOTIONS
from breaker.model.randomness import generator

NAN = np.nan
SLOW = Limit.from_settings("slow", {"motion": "closing", "upper": {"touch_time": 10}})
TIRED = Limit.from_settings(
    "tired", {"motion": "closing", "lower": {"f": 0.77}, "upper": {"touch_time": 9.8}}
)
BAND = Limit.from_settings(
    "band", {"motion": "opening", "lower": {"mu": 2.5}, "upper": {"mu": 1.5}}
)


# ---- a limit ---------------------------------------------------------------------------------


def test_parts_and_words():
    assert SLOW.parts == (("touch_time", 10.0, True),)
    assert TIRED.parts == (("touch_time", 9.8, True), ("f", 0.77, False))
    assert TIRED.quantities == ("touch_time", "f")
    assert SLOW.words == "touch_time above 10 ms"
    assert TIRED.words == "touch_time above 9.8 ms and f below 0.77 mm/ms²"
    assert BAND.words == "mu above 1.5 and mu below 2.5"
    assert (BAND.name, BAND.motion) == ("band", "opening")
    empty = {"motion": "closing", "upper": None, "lower": {"wipe": 1}}  # as YAML reads "upper:"
    assert Limit.from_settings("worn", empty).words == "wipe below 1 mm"


def test_unusable_settings_are_refused():
    with pytest.raises(ValueError, match=r"be used\. slow: part_time is a quantity of"):
        Limit.from_settings("slow", {"motion": "closing", "upper": {"part_time": 10.0}})


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


# ---- configuration ---------------------------------------------------------------------------


def test_usable_limits():
    limits = {
        "slow": {"motion": "closing", "upper": {"touch_time": 10}},
        "band": {"motion": "opening", "lower": {"mu": 2.5}, "upper": {"mu": 1.5, "rebound": 2.0}},
    }
    assert complaint(limits, MOTIONS) is None
    assert complaint({}, ["closing"]) is None


@pytest.mark.parametrize(
    ("settings", "text"),
    [
        ({"motion": "closing"}, "it has no quantity. Name one under upper or lower, with a value."),
        ({"motion": "closing", "upper": {}, "lower": None}, "it has no quantity."),
        (
            {"motion": "closing", "upper": {"touch": 10.0}},
            "touch is not a known quantity. Known of closing: mu,",
        ),
        (
            {"motion": "closing", "lower": {"rebound": 1.0}},
            "rebound is a quantity of opening, not of closing. Known of closing: mu,",
        ),
        (
            {"motion": "opening", "upper": {"f": 0.8}},
            "motion is opening, but must be one of motions (closing).",
        ),
        ({"upper": {"f": 0.8}}, "motion is None, but must be one of motions (closing)."),
        (
            {"motion": "closing", "lower": {"f": 0.7}, "upper": {"f": 0.8}},
            "f cannot be above 0.8 mm/ms² and below 0.7 mm/ms² at once.",
        ),
        (
            {"motion": "closing", "lower": {"mu": 2}, "upper": {"mu": 2.0}},
            "mu cannot be above 2 and below 2 at once.",
        ),
        ({"motion": "closing", "uper": {"f": 1}}, "uper is not known. Known here: motion, upper,"),
        ({"motion": "closing", "upper": {"f": "0,8"}}, "f is 0,8, but must be a finite number."),
        ({"motion": "closing", "upper": {"f": True}}, "f is True, but must be a finite number."),
        ({"motion": "closing", "upper": {"f": NAN}}, "f is nan, but must be a finite number."),
        (None, "it must be a section with motion, and upper or lower with quantities."),
        ({"motion": "closing", "upper": 10.0}, "it must be a section with motion, and upper or"),
    ],
)
def test_complaints(settings, text):
    good = {"motion": "closing", "upper": {"f": 0.8}}
    found = complaint({"good": good, "bad": settings}, ["closing"])
    assert found.startswith(f"cannot be used. bad: {text}")
    with pytest.raises(ValueError, match="limits cannot be used"):
        Limit.from_settings("bad", settings if text[:7] != "motion " else {"motion": "sideways"})


def test_every_complaint_is_made():
    parts = {"upper": {"speed": 1.0, "part_time": 2.0}}
    found = complaint({"a": {"motion": "closing"}, "b": {"motion": "closing", **parts}}, MOTIONS)
    assert found.count("a: ") == 1
    assert found.count("b: ") == 2
    assert "speed is not a known" in found
    assert "part_time is a quantity of opening" in found


def test_checked_without_compiled_code_or_tables():
    code = (
        "import sys; from breaker.mechanism import limits; "
        "sys.exit('numba' in sys.modules or 'pandas' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
