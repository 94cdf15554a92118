"""The table of decisions: actions, limits, dates and columns, on small tables made up for it."""

import numpy as np
import pandas as pd
import pytest

from breaker.decisions.actions import ACTIONS
from breaker.decisions.table import dated
from breaker.mechanism.parameters import MOTIONS, NAMES
from tests.decisions.made_up import INF, NAN, NUMBERS, QUIET, changed, curves_of, page_of, trend_of

LEADS = {"toward": {"wide": 0.97}}


@pytest.mark.parametrize(
    ("changed", "own", "expected", "to_do"),
    [
        ({}, 0.01, ("healthy", "none", ""), "go on"),
        (
            LEADS | {"remaining": {"wide": [201.7, 1404, 4321]}},
            0.01,
            ("plan", "plan", "wide"),
            "plan service by operation 202, before wide (202 to 4,320 operations left)",
        ),
        (
            LEADS | {"remaining": {"wide": [0, 400, 900]}, "beyond": {"wide": 0.07}},
            0.01,
            ("plan", "check", "wide"),
            "check wide: it may be exceeded already (7 %); 0 to 900 operations left",
        ),
        (
            LEADS,
            0.01,
            ("drifting", "watch", "wide"),
            "watch wide: a trend leads there beyond the horizon",
        ),
        (
            {},
            0.99,
            ("now", "service", "slow"),
            "service now: slow exceeded since operation 2, tired since 2, wide since 2",
        ),
    ],
)
def test_actions(changed, own, expected, to_do):
    page = page_of(np.full((4, 3), own), trend_of(MOTIONS, NUMBERS, **changed))
    last = page.last
    assert (last.state, last.action, last.limit) == expected
    assert last.to_do == to_do
    assert last.action in ACTIONS


def test_an_action_is_about_the_limit_that_may_come_first():
    trend = trend_of(
        MOTIONS,
        NUMBERS,
        toward={"slow": 0.99, "tired": 0.5, "wide": 0.99},
        remaining={"slow": [250, 300, 350], "tired": [1, 2, 3], "wide": [20, 400, INF]},
    )
    last = page_of(QUIET, trend).last
    assert (last.limit, last.service_by) == ("wide", 21)  # as estimated first
    left = ["operations_left_5", "operations_left", "operations_left_95"]
    assert last[left].tolist() == [20, 400, INF]
    quiet = page_of(QUIET, trend_of(MOTIONS, NUMBERS)).last
    assert quiet.limit == ""
    assert quiet[[*left, "service_by"]].isna().all()


def test_a_limit_that_cannot_be_told_is_measured_first_if_it_is_likely_exceeded():
    """And otherwise named beside, where others can be planned for."""
    trend = {"toward": {"slow": 0.99}, "remaining": {"slow": [250, 300, 350]}}
    for probability, limit in ((0.3, "slow"), (0.6, "wide")):
        made = trend_of(MOTIONS, NUMBERS, beyond={"wide": probability}, **trend)
        last = page_of(QUIET, made).last
        assert last.limit == limit
        assert f"cannot tell: wide ({100 * probability:.0f} %)" in last.trust


def changed_trend(**given):
    """A trend that notices a change at the third operation."""
    return changed(trend_of(MOTIONS, NUMBERS, **given), 3, 1.6, (1.0, 2.4), f=1.0)


def test_after_a_change_nobody_just_goes_on():
    rows = page_of(QUIET, changed_trend()).rows
    noted = "both: change of f at about 2 (1 to 2)"
    assert rows.change.tolist() == ["", "", noted, ""]
    assert rows.action.tolist() == ["none", "none", "watch", "watch"]
    assert rows.to_do.tolist()[2:] == [f"watch {noted}"] * 2
    left = {"toward": {"slow": 0.99}, "remaining": {"slow": [250, 300, 350]}}
    last = page_of(QUIET, changed_trend(**left)).last
    assert last.action == "plan"
    assert last.to_do.endswith(noted)


def test_a_service_date_moves_back_with_a_reason_only():
    early = [[50, 90, 200], [150, 190, 300], [149, 190, 300], [148, 190, 300]]
    left = {"toward": {"slow": 0.99}, "remaining": {"slow": np.array(early)}}
    rows = page_of(QUIET, trend_of(MOTIONS, NUMBERS, **left)).rows
    assert rows.service_by.tolist() == [51, 51, 51, 51]
    assert rows.why.tolist() == [""] * 4
    rows = page_of(QUIET, changed_trend(**left)).rows
    assert rows.service_by.tolist() == [51, 51, 152, 152]
    assert rows.why.tolist()[2] == rows.change.tolist()[2]
    repaired = {"closing": curves_of(NUMBERS, event=["", "new spring", "", ""])}
    rows = page_of(QUIET, trend_of(MOTIONS, NUMBERS, **left), curves=repaired).rows
    assert rows.service_by.tolist() == [51, 152, 152, 152]
    assert rows.why.tolist()[1] == "new spring"


def test_what_wears_is_named_with_its_direction():
    trend = trend_of(MOTIONS, NUMBERS)
    for name, slope in (("f", -1.5), ("L", 0.9)):
        i = NAMES.index(name)
        trend["slope"][1:, i] = slope
        trend["slope_interval"][1:, i] = [slope - 0.5, slope + 0.5]
    _, _, rows, page = page_of(QUIET, trend)
    assert rows.wearing.tolist() == ["", *["both: f falls, L rises"] * 3]
    assert rows.action.tolist() == ["none", *["watch"] * 3]
    assert rows.state.tolist() == ["healthy", *["drifting"] * 3]
    told = "Wearing, in 1,000 operations: both: f -1.5 %, L +0.9 %."
    assert page.attrs["wearing"] == told


def test_what_was_not_used_says_why():
    closing = curves_of(NUMBERS[:3], accepted=[False, True, True], resolved=[False, False, True])
    opening = curves_of(NUMBERS, resolved=[False, True, True, True])
    curves = {"closing": closing, "opening": opening}
    rows = page_of(QUIET, trend_of(MOTIONS, NUMBERS), curves=curves).rows
    assert rows.not_used.tolist() == [
        "closing: rejected; opening: not resolved",
        "closing: not resolved",
        "",
        "closing: no record",
    ]


def test_a_motion_that_falls_silent_is_not_healthy_for_ever():
    """No record of opening after the second operation, 250 numbers before the last."""
    numbers = np.array([1, 2, 200, 252])
    silent = curves_of(numbers, accepted=[True, True, False, False])
    curves = {"closing": curves_of(numbers), "opening": silent}
    rows = page_of(QUIET, trend_of(MOTIONS, numbers), curves=curves).rows
    assert rows.action.tolist() == ["none", "none", "none", "check"]
    words = "no record of opening could be used since operation 2"
    assert rows.to_do.tolist()[3] == f"check the records: {words}"
    left = {"toward": {"slow": 0.99}, "remaining": {"slow": [250, 300, 350]}}
    rows = page_of(QUIET, trend_of(MOTIONS, numbers, **left), curves=curves).rows
    assert rows.action.tolist()[3] == "plan"
    assert rows.to_do.tolist()[3].endswith(words)


def test_decisions_name_what_is_known_of_an_operation_in_any_motion():
    """A date of closing 1, and of opening 3, which closing has no record of; all events of an
    operation, and the mean of its temperatures, as trends have them.
    """
    closing = {"date": ["2024-11-20", "", ""], "event": ["inspected", "greased", ""]}
    closing |= {"breaker": ["Q0"] * 3, "temperature": [10.0, 12.0, NAN]}
    opening = {"date": ["2024-11-21", "", "2024-11-23"], "event": ["remounted", "greased", ""]}
    opening |= {"temperature": [14.0, NAN, 21.5]}
    curves = {
        "closing": curves_of([1, 2, 4], **closing),
        "opening": curves_of([1, 2, 3], **opening),
    }
    rows = page_of(QUIET, trend_of(MOTIONS, NUMBERS), curves=curves).rows
    assert rows.date.tolist() == ["2024-11-20", "", "2024-11-23", ""]
    assert rows.breaker.tolist() == ["Q0", "Q0", "", "Q0"]
    assert rows.event.tolist() == ["inspected, remounted", "greased", "", ""]
    assert rows.temperature.tolist()[:3] == [12.0, 12.0, 21.5]


def test_dates_turn_operations_into_days():
    """Ten days an operation: service in 20 operations is in 200 days."""
    dates = ["2024-01-01", "2024-01-11", "", "2024-01-31"]
    left = {"toward": {"slow": 0.99}, "remaining": {"slow": [20, 40, INF]}}
    curves = {"closing": curves_of(NUMBERS, date=dates)}
    last = page_of(QUIET, trend_of(MOTIONS, NUMBERS, **left), curves=curves).last
    assert last[["days_left_5", "days_left", "days_left_95"]].tolist() == [200, 400, INF]
    assert (last.service_by, last.service_by_date) == (21, "2024-07-19")
    assert "by operation 21 (2024-07-19)" in last.to_do


def test_alarms_are_dated():
    decisions = pd.DataFrame({"operation": [10, 20], "breaker": "Q0", "date": ["2024-01-01", ""]})
    numbers = {"from_operation": [10, 20], "to_operation": [20, None]}
    alarms = pd.DataFrame({"limit": ["slow", ""], "words": ["a", "b"]} | numbers)
    found = dated(alarms.astype(dict.fromkeys(numbers, "Int64")), decisions)
    assert found.from_date.tolist() == ["2024-01-01", ""]
    assert found.to_date.tolist() == ["", ""]
    assert found.breaker.tolist() == ["Q0", "Q0"]


def test_nothing_is_made_up_of_nothing():
    trend = trend_of(MOTIONS, NUMBERS)
    for name in ("remaining", "toward", "beyond", "value", "slope", "slope_interval"):
        trend[name][:] = NAN
    curves = {"closing": curves_of(NUMBERS, accepted=[False] * 4)}
    _, _, rows, page = page_of(np.full((4, 3), NAN), trend, curves=curves)
    assert set(rows.state) == set(page.state.values) == {"unknown"}
    assert set(rows.action) == {"check"}
    assert set(rows.to_do) == {"check the records: no limit can be told from them yet"}
    assert set(rows.not_used) == {"closing: rejected"}
    for name in ("exceeded", "limit", "wearing", "change", "why"):
        assert set(rows[name]) == {""}
    for name in ("operations_left", "days_left", "service_by"):
        assert rows[name].isna().all()
    told = "Check the records: no limit can be told from them yet. As of operation 4."
    assert page.headline == told
    assert (page.attrs["left"], page.attrs["wearing"]) == ("Left: unknown.", "Wearing: unknown.")
    assert np.isnan(page.way).all()
