"""Limits: parts and words, exceeded and how probably, and refused where they cannot be one."""

import numpy as np
import pytest
from scipy.stats import norm

from breaker.model.limits import Limit, entries_of_type, from_list

NAN, BOTH = np.nan, ["closing", "opening"]
SLOW = {"name": "slow", "motion": "closing", "upper": {"touch_time": 10}}
TIRED = Limit("tired", "closing", (("touch_time", 9.8, True), ("f", 0.77, False)))


def test_parts_and_words():
    both = SLOW | {"name": "tired", "lower": {"f": 0.77}, "upper": {"touch_time": 9.8}}
    slow, tired = from_list([SLOW, both], BOTH)
    assert tired == TIRED
    assert (tired.quantities, tired.units) == (("touch_time", "f"), ("ms", "mm/ms²"))
    assert Limit("worn", "", (("f", -7.0, False),), of="change").units == ("%",)
    assert slow.words == "touch_time above 10 ms"
    assert tired.words == "touch_time above 9.8 ms and f below 0.77 mm/ms²"
    assert from_list([SLOW], ["opening"]) == []
    late = Limit.from_settings(SLOW | {"of": "record", "upper": {"reaction_time": 8}})
    assert (late.of, late.words) == ("record", "measured reaction_time above 8 ms")
    with pytest.raises(ValueError, match="reaction_time"):
        late.evaluate(np.ones((1, 7)))


def test_limits_that_cannot_be_are_refused():
    for parts, of in (
        ((), "model"),
        ((("speed", 1.0, False),), "model"),
        ((("f", 0.7, True), ("f", 0.8, False)), "model"),
        ((("spring_compression", 1.0, True),), "record"),
        ((("separation_time", 1.0, True),), "record"),
        ((("stroke", 1.0, True),), "file"),
        ((("stroke", 1.0, True),), "change"),
    ):
        with pytest.raises(ValueError, match=r"^worn: "):
            Limit("worn", "closing", parts, of=of)
    for entry in (
        {"quantity": "stroke", "reference": 178},
        {"quantity": "stroke", "reference": 1, "tolerance": 1, "upper": {"stroke": 2}},
        {"quantity": "stroke", "reference": 10, "tolerance": "100 %"},
        {"quantity": "stroke", "reference": "3 %", "tolerance": 3},
        {"quantity": "stroke", "reference": 10, "tolerance": "3 ms"},
        {"name": "a", "motion": "closing", "upper": {"stroke": "3 cm"}},
        {"motion": "closing", "upper": {"stroke": 3}},
        {"name": "a", "upper": {"stroke": 3}},
    ):
        with pytest.raises(ValueError, match=r"stroke|name|a: "):
            from_list([entry], BOTH)


def test_excess_and_exceeded():
    values = np.array([[9.9, 0.7], [9.9, 0.8], [9.7, 0.7], [9.8, 0.77], [NAN, 0.7], [9.9, NAN]])
    expected = [[0.1, 0.07], [0.1, -0.03], [-0.1, 0.07], [0, 0], [NAN, 0.07], [0.1, NAN]]
    np.testing.assert_allclose(TIRED.excess(values), expected, atol=1e-12)
    # A touch that does not come exceeds every bound.
    assert TIRED.exceeded(values).tolist() == [True, False, False, False, True, True]
    assert TIRED.exceeded(values[None]).tolist() == [TIRED.exceeded(values).tolist()]
    with pytest.raises(ValueError, match=r"\(\.\.\., 2\)"):
        TIRED.excess(values[:, :1])


def test_probability_of_measured_values():
    """Of two quantities, against the normal distribution."""
    parts = (("stroke", 14.0, False), ("travel_time", 9.0, True))
    limit = Limit("odd", "closing", parts, of="record")
    values = np.array([[13.6, 9.1], [13.4, NAN], [20.0, 9.0]])
    result = limit.measured_exceedance(values, np.full((3, 2), 0.2))
    np.testing.assert_allclose(result, [norm.cdf(2.0) * norm.cdf(0.5), NAN, 0.0], atol=1e-12)
    assert limit.measured_exceedance(values[0], np.zeros(2)) == 1.0


@pytest.mark.parametrize(
    ("quantity", "reference", "tolerance", "more", "bounds", "of"),
    [
        ("stroke", 178, 5, {}, [183, 173] * 2, "record"),
        ("closing_speed", "4.0 m/s", "± 2.5 %", {}, [4.1, 3.9], "record"),
        ("travel_time", 36, "±2 ms", {"motion": "closing"}, [38, 34], "record"),
        ("L", 10, "+-10%", {"motion": "opening"}, [11, 9], "model"),
        ("f", -3, "15 %", {"of": "change"}, [12, -18], "change"),
    ],
)
def test_a_reference_is_two_limits_in_each_motion_that_has_the_quantity(
    quantity, reference, tolerance, more, bounds, of
):
    entry = {"name": "own", "quantity": quantity, "reference": reference, "tolerance": tolerance}
    limits = from_list([entry | more], BOTH)
    assert [limit.parts[0][1] for limit in limits] == pytest.approx(bounds)
    assert [limit.parts[0][2] for limit in limits] == [True, False] * (len(bounds) // 2)
    assert {limit.of for limit in limits} == {of}
    assert len({limit.pair for limit in limits}) == len(limits) / 2
    assert {limit.name.split()[0] for limit in limits} == {"own"}


def test_ranges_of_a_type():
    result = from_list(entries_of_type({"travel_time": [None, 30], "touch_time": [8, 9]}), BOTH)
    bounds = [(record.motion, *record.parts[0][1:]) for record in result]
    both = [("closing", 30, True), ("opening", 30, True)]
    assert bounds == [*both, ("closing", 9, True), ("closing", 8, False)]
    names = ["closing travel_time", "opening travel_time", "touch_time", "touch_time"]
    assert [record.pair for record in result] == [f"{name} by type" for name in names]
    for ranges in ({"stroke": ["14 m/s", None]}, {"strok": [1, None]}):
        with pytest.raises(ValueError, match=r"strok"):
            entries_of_type(ranges)
