"""Definitions of speeds, from texts to values on exact curves."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.model.curves import travel
from breaker.model.equations import closed_rest
from breaker.model.evaluation import evaluate
from breaker.model.parameters import Size
from breaker.model.quantities import SPEEDS, Point, Speed, quantities, speeds_of

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
        *("touch", "6 mm before touch", "10 ms after touch", "5 % of stroke", "0 % of stroke"),
        *("100 % of stroke", "20 mm from open", "15.5 mm from closed"),
        *("5 ms before 50 % of stroke", "10 ms after 20 mm from open"),
    ):
        assert Point.read(text, "closing").text("closing") == text
        assert Point.read(f"  {text.replace(' ', '  ')} ", "closing").text("closing") == text
    for text in (
        *("", "6 mm", "6 cm before touch", "-6 mm before touch", "separation", "101 % of stroke"),
        *("6 mm before separation", "6 mm of stroke", "1e3 mm before touch", "touch touch"),
        *("5 mm from shut", "3 ms", "3 ms before 4 ms after touch"),
    ):
        with pytest.raises(ValueError, match="closing_speed"):
            speeds_of({"closing_speed": [text, "touch"]})


def test_wrong_speeds():
    """Points that are not forward in time, or not two."""
    for name, points in (
        ("closing_speed", ["touch", "6 mm before touch"]),
        ("closing_speed", ["touch", "touch"]),
        ("opening_speed", ["9 ms after separation", "8 ms after separation"]),
        ("opening_speed", ["90 % of stroke", "10 % of stroke"]),
        ("opening_speed", ["10 % from open", "30 % from open"]),
        ("closing_speed", ["9 mm from open", "8 mm from open"]),
        ("closing_speed", ["50 % of stroke", "2 ms before 50 % of stroke"]),
        ("closing_speed", ["touch"]),
        ("closing_speed_b", None),
    ):
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
    beyond = sign * curve >= sign * level
    passed = TIMES[1:][~beyond[:-1] & beyond[1:]] - 0.5e-3
    if point.unit == "mm" and not point.rest:
        passed = passed[passed < switching][::-1] if share < 0 else passed[passed > switching]
    return passed[0] if passed.size else np.nan, level


@pytest.mark.parametrize("motion", ["closing", "opening"])
def test_speeds_are_those_of_dense_curves(prior, motion):
    theta = prior.sample(8, generator(1, "test", "speeds", motion))
    curves, switching, _ = travel(theta, TIMES, motion)
    rests = [np.zeros(len(theta)), closed_rest(theta)]
    rests = rests if motion == "closing" else rests[::-1]
    speeds = speeds_of(DEFINED)
    for speed in (record for record in speeds if record.motion == motion):
        result = evaluate([speed.name], theta, motion, speeds)[:, 0]
        for i in range(len(theta)):
            rest = [item[i] for item in rests]
            places = [
                brute_force(item, curves[i], switching[i], rest, motion)
                for item in (speed.start, speed.end)
            ]
            (begin, low), (end, high) = places
            assert result[i] == pytest.approx(
                abs(high - low) / (end - begin), rel=1e-3, nan_ok=True
            )


@pytest.mark.parametrize("size", [Size(1.7, 0.9), Size(0.031, 40.0)])
@pytest.mark.parametrize("motion", ["closing", "opening"])
def test_quantities_scale_with_the_drive(prior, motion, size):
    """Also where rows of several sizes are in a batch; powers of 2 are exact."""
    theta = prior.sample(50, generator(1, "test", "sizes", motion))
    there = [quantity for quantity in quantities().values() if motion in quantity.motions]
    names = [item.name for item in there if "model" in item.of]
    units = [quantities()[name].unit for name in names]
    here = evaluate(names, theta, motion)
    sized = tuple(speed.sized(size) for speed in SPEEDS)
    both = np.vstack([theta, theta * size.factors])
    there = evaluate(names, both, motion, sized)[len(theta) :]
    expected = here * [size.factor(unit) for unit in units]
    both = np.isfinite(there) & np.isfinite(expected)  # some are just at rest at the end, or not
    assert both.mean() > 0.97
    np.testing.assert_allclose(there[both], expected[both], rtol=2e-3, atol=2e-3 * size.lengths)
    np.testing.assert_array_equal(there, evaluate(names, theta * size.factors, motion, sized))
    double = Size(4.0, 8.0)
    sized = tuple(speed.sized(double) for speed in SPEEDS)
    there = evaluate(names, theta * double.factors, motion, sized)
    np.testing.assert_array_equal(there, here * [double.factor(unit) for unit in units])


def test_either_rest_counts():
    """A share from a rest is one of the stroke; at the rest itself, a way is a share."""
    for motion, texts in {
        "closing": ["30 % of stroke", "30 % from open", "70 % from closed"],
        "opening": ["30 % of stroke", "30 % from closed", "70 % from open"],
    }.items():
        assert {Point.read(text, motion) for text in texts} == {Point(30.0, "%")}
    assert Point.read("0 mm from closed", "closing") == Point(100.0, "%")
    sized = Point.read("4 ms after 6 mm from closed", "closing").sized(Size(2.0, 3.0))
    assert sized.text("closing") == "12 ms after 12 mm from closed"
    # Usual speeds grow with the drive, given ones do not.
    closing, opening = speeds_of({"opening_speed": None}, Size(lengths=1.2345, times=3.0))
    assert closing.points == ["7.4 mm before touch", "touch"]
    assert opening.points == ["separation", "7.4 mm after separation"]
    given = Speed.read("closing_speed", ["12 mm before touch", "touch"])
    assert speeds_of({"closing_speed": given.points}, Size(9.0, 1.0))[0] == given
