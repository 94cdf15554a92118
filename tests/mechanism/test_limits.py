"""Limits in words, exceeded and how probably, and refused where they cannot be one."""

import subprocess
import sys

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from breaker.mechanism.limits import Limit, from_list
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
    ("parts", "of", "text"),
    [
        ((), "model", "it has no quantity. Name one"),
        ((("part_time", 1.0, True),), "model", "part_time is a quantity of opening, not of clos"),
        ((("speed", 1.0, False), ("rebound", 1.0, True)), "model", "speed is .* rebound is a qu"),
        (
            (("f", 0.8, True), ("f", 0.7, False)),
            "model",
            r"f cannot be above 0\.8 and below 0\.7",
        ),
        (
            (("f", 0.8, False), ("f", 0.8, True)),
            "model",
            r"f cannot be above 0\.8 and below 0\.8",
        ),
        ((("wipe", 1.0, True),), "record", "wipe is a quantity of the model, which no record sho"),
        ((("part_time", 1.0, True),), "record", "part_time is a quantity of opening, not of clos"),
        ((("stroke", 1.0, True),), "file", r"of is file\. Set it to model or record or change\."),
    ],
)
def test_what_cannot_be_a_limit_is_refused(parts, of, text):
    with pytest.raises(ValueError, match=f"^worn: {text}"):
        Limit("worn", "closing", parts, of=of)


def test_limits_on_measured_quantities():
    entry = {"name": "late", "motion": "closing", "of": "record", "upper": {"latch_time": 8}}
    late = Limit.from_settings(entry)
    assert late.words == "measured latch_time above 8 ms"
    assert SLOW.of == "model"
    plain = {"name": "slow", "motion": "closing", "upper": {"touch_time": 10}}
    assert from_list([entry, plain], ["closing"], of=["record"]) == [late]
    assert [each.of for each in from_list([entry, plain], ["closing"])] == ["record", "model"]
    with pytest.raises(ValueError, match="late is about what records show"):
        late.evaluate(np.ones((1, 7)))


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


def test_probability_of_measured_values():
    """Two bounds of one quantity, and a second one, against the normal distribution."""
    parts = (("stroke", 13.0, True), ("stroke", 14.0, False), ("travel_time", 9.0, True))
    limit = Limit("odd", "closing", parts, of="record")
    values = np.array([[13.4, 13.4, 9.1], [13.4, 13.4, NAN], [10.0, 10.0, 9.0]])
    found = limit.measured_exceedance(values, np.full((3, 3), 0.2))
    between = norm.cdf(3.0) - norm.cdf(-2.0)
    np.testing.assert_allclose(found, [between * norm.cdf(0.5), NAN, 0.0], atol=1e-12)
    assert limit.measured_exceedance(values[0], np.zeros(3)) == 1.0


def test_a_probability_needs_draws():
    for values in (np.empty((4, 0, 2)), np.empty(2)):
        with pytest.raises(ValueError, match="tired: a probability needs draws"):
            TIRED.exceedance(values)


def test_checked_without_compiled_code_or_tables():
    code = (
        "import sys; from breaker.mechanism import limits; "
        "sys.exit('numba' in sys.modules or 'pandas' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
