"""Verdicts on limits, and the simultaneity of poles, by planted values and errors."""

import numpy as np
import pytest
from scipy.stats import norm

from breaker.diagnosis.limits import NORMAL, interval_of, judge, simultaneity_of
from breaker.diagnosis.tables import limits_table, simultaneity_in_words
from breaker.model.limits import Limit
from breaker.records.measurements import Measured

POLES = [
    {"motion": "closing", "operation": 3, "file": "a.csv", "phase": phase, "fit": fit}
    for phase, fit in (
        ("R", {"first_motion": 20.0, "contact_time": 30.0, "contact_sd": 0.3, "trigger": 0.0}),
        ("S", {"first_motion": 21.0, "contact_time": 33.0, "contact_sd": 0.4, "trigger": 2.5}),
        ("T", {"first_motion": 20.5, "contact_time": 30.5, "trigger": 0.2}),
    )
]


def verdict(value, *limits, sd=1.0, of="record"):
    """The verdict on a quantity that is measured, by limits such as ("lower", 10.0)."""
    sides = [
        Limit("slow", "closing", (("stroke", bound, side == "upper"),), of=of, pair="stroke")
        for side, bound in limits
    ]
    (row,) = judge(sides, lambda limit, name: Measured(value, sd, ""), 1)
    return row


def test_an_interval_is_central():
    value, ends = interval_of(Measured(10.0, 2.0, ""))
    assert value == 10.0
    assert ends == pytest.approx([10.0 - 2.0 * 1.96, 10.0 + 2.0 * 1.96])
    assert interval_of(Measured(0.5, 1.0, ""))[1] == pytest.approx([0.0, 2.46])  # no time below 0
    value, ends = interval_of(np.linspace(0.0, 1.0, 1001))
    assert [value, *ends] == pytest.approx([0.5, 0.025, 0.975])
    assert [norm.cdf(NORMAL[share]) for share in (90, 95)] == pytest.approx([0.95, 0.975], abs=1e-4)


@pytest.mark.parametrize(
    ("value", "word"), [(100.0, "pass"), (91.0, "inconclusive"), (85.0, "fail"), (115.0, "fail")]
)
def test_both_sides_of_a_range_are_one_verdict(value, word):
    row = verdict(value, ("lower", 90.0), ("upper", 110.0))
    assert (row["name"], row["verdict"]) == ("stroke", word)
    assert [part["bounds"] for part in row["parts"]] == [[90.0, 110.0]]
    assert (row["reason"] is None) == (word != "inconclusive")


def test_a_probability_is_that_of_the_normal_error():
    assert verdict(100.0, ("upper", 101.0))["p_exceeded"] == pytest.approx(0.158655, abs=1e-6)
    assert verdict(100.0, ("lower", 0.0), sd=100.0)["p_exceeded"] == 0.0  # none is below 0
    change = verdict(100.0, ("lower", 0.0), sd=100.0, of="model")["p_exceeded"]
    assert change == pytest.approx(0.158655, abs=1e-6)


@pytest.mark.parametrize(("factor", "doubt"), [(19.0, False), (21.0, True)])
def test_a_bound_in_another_unit_is_doubted(factor, doubt):
    for bound in (100.0 * factor, 100.0 / factor):
        for unit in (1.0, 0.005):  # a value of 100, and one of 0.5
            row = verdict(unit * 100.0, ("upper", unit * bound), sd=unit)
            code = row["reason"].code if row["reason"] else ""
            assert (code == "limit-in-other-unit") == doubt


def test_a_row_of_several_poles_shows_one_value_and_names_its_pole():
    values = {"R": 12.5, "S": 13.5, "T": 5.0}.items()
    rows = [(pole, verdict(value, ("upper", 10.0))) for pole, value in values]
    ((_, result, value, interval, *_),) = limits_table(rows).rows
    assert (result, value, interval) == ("FAIL (R, S)", "13.5 (S)", "11.54 to 15.46")


def test_an_unknown_quantity_is_inconclusive_with_its_reason():
    limit = Limit("slow", "closing", (("stroke", 1.0, True),), of="record")
    (row,) = judge([limit], lambda *_: Measured(np.nan, np.nan, "hidden"), 1)
    assert (row["verdict"], row["reason"].text) == ("inconclusive", "hidden")
    assert np.isnan(row["p_exceeded"])


def test_draws_and_a_measurement_are_judged_together():
    """Half of the draws are beyond their bound, and the measurement is by half an sd away."""
    limit = Limit("both", "closing", (("stroke", 1.0, True), ("travel_time", 2.0, False)))
    draws = 1.0 + norm.ppf((np.arange(20_000) + 0.5) / 20_000)
    known = {"stroke": draws, "travel_time": Measured(2.2, 0.4, "")}
    (row,) = judge([limit], lambda _, name: known[name], 1)
    assert row["p_exceeded"] == pytest.approx(0.5 * norm.cdf(-0.5), abs=0.012)  # four errors


def test_poles_in_one_record_share_its_clock():
    result = simultaneity_of(POLES, {"closing": 5.0})
    assert (result["base"], result["first"], result["last"]) == ("record", "R", "S")
    assert (result["value"], result["sd"]) == (pytest.approx(4.0), pytest.approx(0.5))
    assert (result["verdict"], result["limit"]) == ("pass", 5.0)
    words = [simultaneity_of(POLES, {"closing": most})["verdict"] for most in (4.5, 2.0)]
    assert words == ["inconclusive", "fail"]
    assert "verdict" not in simultaneity_of(POLES, {"closing": None, "opening": 1.0})
    for last, ordered in (("S", True), ("R", False)):
        words = simultaneity_in_words({**result, "last": last})
        assert ("R first" in words) == ordered


def test_poles_in_several_files_count_from_their_triggers():
    apart = [pole | {"file": f"{k}.csv"} for k, pole in enumerate(POLES)]
    result = simultaneity_of(apart, {})
    assert (result["base"], result["first"], result["last"]) == ("trigger", "R", "S")
    assert result["value"] == pytest.approx(1.5)
    without = [pole | {"fit": {**pole["fit"], "trigger": None}} for pole in apart[1:]]
    unknown = simultaneity_of([apart[0], *without], {"closing": 5.0})
    assert "value" not in unknown
    assert unknown["reason"].code == "simultaneity-unknown-by-trigger"
