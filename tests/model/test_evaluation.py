"""Quantities of motions on a dense grid of exact curves, and definitions of speeds."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.model.curves import travel
from breaker.model.equations import closed_rest
from breaker.model.evaluation import evaluate
from breaker.model.parameters import NAMES, Size
from breaker.model.quantities import (
    SPEEDS,
    Point,
    check_fact,
    check_quantity,
    quantities_of,
    speeds_of,
)
from tests.model_references import changed

CLOSING = ("spring_compression", "touch_time", "closing_speed", "over_travel")
OPENING = ("spring_compression", "separation_time", "opening_speed", "opening_over_travel")
MEDIANS = np.array([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0])
TIMES = np.arange(60_001) * 1e-3
DEFINED = {
    "closing_speed": ["10 ms before touch", "touch"],
    "closing_speed_last": ["2.5 mm before touch", "1 mm after touch"],
    "closing_speed_mean": ["10 % of stroke", "90 % of stroke"],
    "closing_speed_mixed": ["20 % of stroke", "touch"],
    "closing_speed_rests": ["3 mm from open", "2 mm from closed"],
    "closing_speed_whole": ["0 % of stroke", "5 ms after 30 % from open"],
    "opening_speed": ["separation", "10 ms after separation"],
    "opening_speed_rests": ["1 mm from closed", "30 % from open"],
    "opening_speed_before": ["4 ms before 50 % of stroke", "50 % of stroke"],
    "opening_speed_mean": ["12.5 % of stroke", "75 % of stroke"],
    "opening_speed_first": ["0.5 mm before separation", "4 mm after separation"],
}


def test_texts_of_points():
    for text in (
        *("touch", "6 mm before touch", "10 ms after touch", "0 % of stroke", "20 mm from open"),
        *("15.5 mm from closed", "5 ms before 50 % of stroke", "10 ms after 20 mm from open"),
    ):
        assert Point.read(text, "closing").text("closing") == text
        assert Point.read(f"  {text.replace(' ', '  ')} ", "closing").text("closing") == text
    for text in (
        *("", "6 mm", "6 cm before touch", "-6 mm before touch", "101 % of stroke", "3 ms"),
        *("6 mm before separation", "1e3 mm before touch", "touch touch"),
    ):
        with pytest.raises(ValueError, match="closing_speed"):
            speeds_of({"closing_speed": [text, "touch"]})


@pytest.mark.parametrize(
    ("name", "points"),
    [
        ("closing_speed", ["touch", "6 mm before touch"]),
        ("closing_speed", ["touch", "touch"]),
        ("opening_speed", ["90 % of stroke", "10 % of stroke"]),
        ("closing_speed", ["9 mm from open", "8 mm from open"]),
        ("closing_speed", ["50 % of stroke", "2 ms before 50 % of stroke"]),
        ("closing_speed", ["touch"]),
        ("closing_speed_b", None),
    ],
)
def test_speeds_need_two_points_forward_in_time(name, points):
    with pytest.raises(ValueError, match=name):
        speeds_of({name: points})


def brute_force(point, curve, switching, rests, motion):
    """Time and travel of a point of a dense curve (t,) at 1,000 points a ms."""
    sign = 1.0 if motion == "closing" else -1.0
    if point.later:
        at = brute_force(replace(point, later=0.0), curve, switching, rests, motion)[0]
        return at + point.later, np.interp(at + point.later, TIMES, curve)
    at = np.interp(switching, TIMES, curve)
    if point.unit == "ms":
        return switching + point.amount, np.interp(switching + point.amount, TIMES, curve)
    if (point.unit, point.amount) == ("mm", 0):
        return switching, at
    share = point.amount / 100
    level = at + sign * point.amount
    if point.unit == "%":
        level = rests[0] + share * (rests[1] - rests[0])
        if share == 0.0:
            return 0.0, level
    if point.rest:
        level = rests[0 if point.amount > 0.0 else 1] + sign * point.amount
    left = sign * (level - curve)
    last = np.flatnonzero((left[:-1] > 0) & (left[1:] <= 0))
    passed = TIMES[last] + 1e-3 * left[last] / (left[last] - left[last + 1])
    if point.unit == "mm" and not point.rest:
        passed = passed[passed < switching][::-1] if share < 0 else passed[passed > switching]
    return passed[0] if passed.size else np.nan, level


@pytest.fixture(scope="module", params=["closing", "opening"])
def dense(request, prior):
    """A motion, parameters of which the first come to rest without passing it, and curves."""
    motion = request.param
    theta = prior.sample(12, generator(1, "test", "quantities", motion))
    theta[0] = changed(MEDIANS, gamma_a=0.7 if motion == "closing" else 0.5)
    return motion, theta, travel(theta, TIMES, motion)


def test_speeds_are_those_of_dense_curves(dense):
    motion, theta, (curves, switching) = dense
    rests = np.column_stack([np.zeros(len(theta)), closed_rest(theta)])
    rests = rests if motion == "closing" else rests[:, ::-1]
    speeds = speeds_of(DEFINED)
    for speed in (record for record in speeds if record.motion == motion):
        result = evaluate([speed.name], theta, motion, speeds)[:, 0]
        for i, of_curve in enumerate(zip(curves, switching, rests, strict=True)):
            begin, low = brute_force(speed.start, *of_curve, motion)
            end, high = brute_force(speed.end, *of_curve, motion)
            expected = abs(high - low) / (end - begin)
            assert result[i] == pytest.approx(expected, rel=1e-4, nan_ok=True)


def test_other_quantities_are_those_of_dense_curves(dense, prior):
    """Without the parabola over-travels would be ten times further away."""
    assert np.array_equal(MEDIANS, prior.medians)  # on which the sizes of ``evaluation`` rest
    motion, theta, (curves, switching) = dense
    held = closed_rest(theta)
    done = (curves if motion == "closing" else held[:, None] - curves) / held[:, None]
    ten, ninety = (TIMES[np.argmax(done >= share, axis=1)] for share in (0.1, 0.9))
    names = (CLOSING if motion == "closing" else OPENING)[1::2]
    result = evaluate(["stroke", "travel_time", *names], theta, motion)
    np.testing.assert_allclose(result[:, 0], held, rtol=1e-12)
    np.testing.assert_allclose(result[:, 1], ninety - ten, atol=2e-3)
    np.testing.assert_allclose(result[:, 2], switching, rtol=1e-12)
    beyond = np.maximum(0.0, (done.max(axis=1) - 1.0) * held)
    np.testing.assert_allclose(result[:, 3], beyond, atol=1e-4)
    assert result[0, 3] == 0.0


@pytest.mark.parametrize(
    ("motion", "change", "missing"),
    [
        ("closing", {"f": 8 * 0.045}, [1, 2, 3]),  # at rest at f / k_a = 8 mm, short of the gap
        # It swings to the gap, but there is no closed position to travel beyond, or to open from.
        ("closing", {"f": 0.44}, [3]),
        ("opening", {"f": 0.44}, [1, 2, 3]),
        # At 5.6 mm at the touch; at 5.3 mm at the separation, and then 0.6 mm beyond 0: never 6 mm.
        ("closing", {"L": 3.0}, [2]),
        ("opening", {"L": 2.0}, [2]),
        ("closing", {"L": 4.0}, []),
        # So slow that at 60 ms it is millimetres from rest, on its way there.
        ("closing", {"gamma_a": 2.5}, [3]),
        ("opening", {"gamma_a": 2.5}, [3]),
    ],
)
def test_what_does_not_exist_is_nan(motion, change, missing):
    """The wipe is that of the formula, also where it is negative."""
    theta = changed(MEDIANS, **change)[None]
    row = evaluate(CLOSING if motion == "closing" else OPENING, theta, motion)[0]
    assert np.flatnonzero(np.isnan(row)).tolist() == missing
    _, k_a, k_b, _, _, f, gap = theta[0]
    assert row[0] == pytest.approx((f - k_a * gap) / (k_a + k_b))
    stroke = evaluate(["stroke"], theta, motion).item()
    assert np.isnan(stroke) if row[0] < 0 else stroke == pytest.approx(gap + row[0])


@pytest.mark.parametrize("size", [Size(1.7, 0.9), Size(0.031, 40.0), Size(4.0, 8.0)])
@pytest.mark.parametrize("motion", ["closing", "opening"])
def test_quantities_scale_with_the_drive(prior, motion, size):
    """Also where rows of several sizes are in a batch; powers of 2 are exact."""
    theta = prior.sample(50, generator(1, "test", "sizes", motion))
    names = list(quantities_of(motion))
    factors = [size.factor(quantity.unit) for quantity in quantities_of(motion).values()]
    sized = tuple(speed.sized(size) for speed in SPEEDS)
    both = np.vstack([theta, theta * size.factors])
    there = evaluate(names, both, motion, sized)[len(theta) :]
    expected = evaluate(names, theta, motion) * factors
    known = np.isfinite(there) & np.isfinite(expected)  # some are just at rest at the end, or not
    assert known.mean() > 0.97
    rtol = 0.0 if size.lengths == 4.0 else 2e-3
    np.testing.assert_allclose(there[known], expected[known], rtol=rtol, atol=rtol * size.lengths)


def test_either_rest_counts():
    """A share from a rest is one of the stroke; at the rest itself, a way is a share."""
    for motion, texts in {
        "closing": ["30 % of stroke", "30 % from open", "70 % from closed"],
        "opening": ["30 % of stroke", "30 % from closed", "70 % from open"],
    }.items():
        assert {Point.read(text, motion) for text in texts} == {Point(30.0, "%")}
    assert Point.read("0 mm from closed", "closing") == Point(100.0, "%")


def test_usual_speeds_grow_with_the_drive_and_given_ones_do_not():
    size, given = Size(lengths=1.2345, times=3.0), ["12 mm before touch", "touch"]
    sized = Point.read("4 ms after 6 mm from closed", "closing").sized(Size(2.0, 3.0))
    assert sized.text("closing") == "12 ms after 12 mm from closed"
    closing, opening = speeds_of({"opening_speed": None}, size)
    assert closing.points == ["7.4 mm before touch", "touch"]
    assert opening.points == ["separation", "7.4 mm after separation"]
    assert speeds_of({"closing_speed": given}, size)[0].points == given


def test_names_of_each_source():
    for motion, names in (("closing", CLOSING), ("opening", OPENING)):
        assert not any(check_quantity(name, motion) for name in (*NAMES, *names))
        assert check_quantity("f", motion, of="change") is None
        assert check_quantity("reaction_time", motion, of="record") is None
    assert "touch_time" in check_quantity("touch_time", "opening")
    assert "stroke" in check_quantity("stroke", "closing", (), "change")
    assert "spring_compression" in check_quantity("spring_compression", "closing", of="record")
    assert check_fact(13.0, 0.1) is None
    assert all(check_fact(*wrong) for wrong in ((-13.0, 0.1), (13.0, 0.0), (13.0, 0.001)))


def test_errors():
    for names, theta, motion, words in (
        (["f", "speed"], MEDIANS[None], "closing", "speed is not"),
        ([], MEDIANS[None], "sideways", "unknown motion"),
        (["f"], np.nan * MEDIANS[None], "closing", "the first is mu = nan in row 0"),
        (["f"], MEDIANS, "closing", r"shape \(n, 7\)"),
    ):
        with pytest.raises(ValueError, match=words):
            evaluate(names, theta, motion)
