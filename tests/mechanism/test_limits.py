"""Limits in words, exceeded and how probably, and refused where they cannot be one."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import norm

from breaker.model.limits import SOURCES, Limit, from_list

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
        ((("f", 0.8, True), ("f", 0.7, False)), "model", r"f cannot be above 0\.8 and below 0\.7"),
        ((("f", 0.8, False), ("f", 0.8, True)), "model", r"f cannot be above 0\.8 and below 0\.8"),
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


def test_probability_of_measured_values():
    """Two bounds of one quantity, and a second one, against the normal distribution."""
    parts = (("stroke", 13.0, True), ("stroke", 14.0, False), ("travel_time", 9.0, True))
    limit = Limit("odd", "closing", parts, of="record")
    values = np.array([[13.4, 13.4, 9.1], [13.4, 13.4, NAN], [10.0, 10.0, 9.0]])
    found = limit.measured_exceedance(values, np.full((3, 3), 0.2))
    between = norm.cdf(3.0) - norm.cdf(-2.0)
    np.testing.assert_allclose(found, [between * norm.cdf(0.5), NAN, 0.0], atol=1e-12)
    assert limit.measured_exceedance(values[0], np.zeros(3)) == 1.0


# ---- a reference and a tolerance ---------------------------------------------------------------


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        (
            {"quantity": "stroke", "reference": 178, "tolerance": 5},
            [f"measured stroke {end}" for end in ("above 183 mm", "below 173 mm")] * 2,
        ),
        (
            {"quantity": "closing_speed", "reference": 4.0, "tolerance": "± 2.5 %"},
            [f"measured closing_speed {end} m/s" for end in ("above 4.1", "below 3.9")],
        ),
        (
            {"quantity": "L", "motion": "opening", "reference": 10, "tolerance": "+-10%"},
            ["L above 11 mm", "L below 9 mm"],
        ),
        (
            {
                "quantity": "f",
                "of": "change",
                "since": "event",
                "reference": 0,
                "tolerance": "15 %",
            },
            [f"change of f {end} % since the last event" for end in ("above +15", "below -15")],
        ),
    ],
)
def test_a_reference_is_two_limits_in_each_motion_that_has_the_quantity(entry, words):
    limits = from_list([entry], ["closing", "opening"])
    assert [limit.words for limit in limits] == words
    assert len({limit.pair for limit in limits}) == len(limits) / 2
    named = from_list([entry | {"name": "own"}], ["closing", "opening"])
    assert {limit.name.split()[0] for limit in named} == {"own"}


@pytest.mark.parametrize(
    ("entry", "text"),
    [
        ({"quantity": "stroke", "reference": 178}, "stroke: a limit has all of quantity, ref"),
        (
            {"quantity": "stroke", "reference": 1, "tolerance": 1, "upper": {"stroke": 2}},
            "leave out what is of the other form",
        ),
        (
            {"quantity": "stroke", "reference": 0, "tolerance": "3 %"},
            "the tolerance allows nothing",
        ),
        ({"quantity": "stroke", "reference": "3 %", "tolerance": 3}, "3 % is of no change"),
        ({"quantity": "way", "reference": 1, "tolerance": 3}, "way is not a known quantity"),
        ({"motion": "closing", "upper": {"stroke": 3}}, "a limit has no name"),
        ({"name": "a", "motion": "closing", "upper": {"stroke": "3 %"}}, "a: 3 % is of no change"),
        (
            {"name": "a", "motion": "closing", "since": "event", "upper": {"stroke": 3}},
            "since: event is of changes",
        ),
    ],
)
def test_what_is_no_limit_is_refused(entry, text):
    with pytest.raises(ValueError, match=text):
        from_list([entry], ["closing", "opening"])


@pytest.mark.parametrize("of", SOURCES)
def test_a_reader_is_asked_by_the_source_of_a_limit(of):
    limit = Limit("a", "closing", (("f" if of != "record" else "stroke", 1.0, True),), of=of)
    reader = SimpleNamespace(
        of_model=lambda *about: ("model", *about),
        of_record=lambda *about: ("record", *about),
        of_change=lambda *about: ("change", *about),
    )
    assert limit.read(reader, 7) == (of, limit, 7)
    assert limit.source.inferred == (of != "record")
    assert limit.source.single == (of != "change")
