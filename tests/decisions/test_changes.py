"""Steps of a drive in words, in the decisions, the alarms and on the first page."""

import numpy as np
import pandas as pd
import pytest

from breaker.decisions.alarms import alarm_table
from breaker.decisions.changes import changes, latest_step, step_table, with_steps
from breaker.decisions.series import complete
from breaker.mechanism.parameters import MOTIONS
from tests.decisions.test_table import LIMITS, QUIET, SETTINGS, page_of, trend_of

NUMBERS = 10 * np.arange(120, 124)  # 1,200 to 1,230
ENDED = "closing: the end of the stroke changed at operation 1,200 (0.42 mm)"


def stepped(motions=MOTIONS, sizes=(0.1, 0.2, 0.42, 0.0, 0.2, 0.1), at=2, operations=NUMBERS):
    """A trend at rest with a step that the operation ``at`` completes."""
    trend = trend_of(motions, operations).drop_dims(["change", "jump"])
    trend["step"][at] = True
    trend["surprise"][at - 1 : at + 1] = 1e-6
    trend["step_size"][at] = list(sizes)
    return complete(trend, SETTINGS, "both" if len(motions) == 2 else motions[0])


def test_a_step_is_told_from_its_first_operation_on():
    trend = stepped()
    assert trend.jump_noticed.values.tolist() == [1220]
    assert trend.jump_from.values.tolist() == [1200]
    assert trend.jump_words.values.tolist() == [ENDED]
    assert changes({"both": trend}, NUMBERS) == ["", "", ENDED, ""]
    later = stepped(at=3)
    assert later.jump_from.values.tolist() == [1210]
    skipped = later.drop_dims("jump")
    skipped["surprise"][2] = np.nan  # without a usable record: the one before began it
    assert with_steps(skipped).jump_from.values.tolist() == [1200]
    none = trend.drop_dims("jump")
    none["step"][:] = False
    assert with_steps(none).sizes["jump"] == 0
    assert with_steps(none.isel(operation=slice(0, 0))).sizes["jump"] == 0


def test_a_known_event_is_told_once_and_ends_what_is_told_of_a_change():
    """Of trends apart, too; a change before it is described as known before it."""
    trend = stepped().drop_dims(["change", "jump"])
    trend["event"] = trend.event.astype("<U40")
    trend["event"][3] = "greased: gamma_a starts anew"
    trend["alarm"][1] = True
    trend["start_interval"][:] = np.arange(4.0)[:, None]
    trend["kind_probability"][:] = np.arange(8.0)
    whole = complete(trend, SETTINGS, "closing")
    assert whole.change_start.values.tolist() == [2.0]
    told = changes({"closing": whole, "opening": whole}, NUMBERS)
    assert told[3] == "greased: gamma_a starts anew"
    assert complete(trend.isel(operation=slice(0, 3)), SETTINGS, "closing").change_start == 2.0


@pytest.mark.parametrize(
    ("sizes", "words"),
    [
        (
            (0.3, 0.2, 0.1, 0.0, 0.25, 0.1),
            "closing: the start of the motion changed at operation 1,200 (0.3 mm), "
            "opening: the main motion changed at operation 1,200 (0.25 mm)",
        ),
        (
            (0.0, 0.01, 0.0, 0.0, 0.0, 1.234),
            "opening: the end of the stroke changed at operation 1,200 (1.2 mm)",
        ),
    ],
)
def test_motions_that_changed_are_named(sizes, words):
    assert stepped(sizes=sizes).jump_words.values.tolist() == [words]


def test_a_step_asks_for_a_closer_look_for_a_while():
    trend = {"both": stepped()}
    assert latest_step(trend, [1219, 1220, 1229, 1230, 1231], within=10) == [
        "",
        ENDED,
        ENDED,
        ENDED,
        "",
    ]
    twice = {
        "closing": stepped(["closing"], [0, 0, 0.42]),
        "opening": stepped(["opening"], [0, 1, 0], 3),
    }
    assert latest_step(twice, [1220, 1230], within=10) == [
        ENDED,
        "opening: the main motion changed at operation 1,210 (1 mm)",
    ]


def test_decisions_and_first_page_report_a_step():
    _, _, rows, page = page_of(QUIET, stepped(), settings=SETTINGS | {"notice": 10})
    assert rows.change.tolist() == ["", "", ENDED, ""]
    assert rows.state.tolist() == ["healthy"] * 4
    assert rows.action.tolist() == ["go on", "go on", *[f"look closer: {ENDED}"] * 2]
    assert page.attrs["healthy"] == f"In doubt at operation 1230: {ENDED}."
    assert page.attrs["wearing"] == (
        f"Wearing: no parameter that a trend could tell from none. Last change noticed: {ENDED}."
    )
    _, _, rows, page = page_of(QUIET, stepped(), settings=SETTINGS | {"notice": 5})
    assert rows.action.tolist() == ["go on", "go on", f"look closer: {ENDED}", "go on"]
    assert page.attrs["healthy"] == "Healthy at operation 1230: no limit exceeded."


def test_a_step_does_not_hide_what_is_worse():
    own = QUIET.copy()
    own[:, 0] = 0.99
    rows = page_of(own, stepped())[2]
    assert rows.action.tolist()[2] == "service now: slow exceeded"
    trend = stepped()
    trend["beyond"][2:, 2] = 0.5
    rows = page_of(QUIET, trend)[2]
    assert rows.action.tolist()[2] == f"look closer: wide may be exceeded; {ENDED}"


def test_a_change_that_was_taken_back_does_not_hide_a_step():
    trend = stepped().drop_dims("change")
    trend = trend.assign(
        change_alarm=("change", np.array([1220])),
        change_start=("change", np.array([np.nan])),
        change_interval=(("change", "bound"), np.full((1, 2), np.nan)),
        change_kind=(("change", "kind"), np.full((1, 8), np.nan)),
    )
    _, _, rows, page = page_of(QUIET, trend)
    assert rows.change[2] == f"both: a change that later ones took back; {ENDED}"
    assert page.attrs["wearing"].endswith(f"Last change noticed: {ENDED}.")


def test_alarms_list_steps():
    found = step_table({"both": stepped()})
    no_alarm = np.zeros((4, 3), dtype=bool)
    alarms = alarm_table(LIMITS, NUMBERS, no_alarm, QUIET)
    assert found.dtypes.tolist() == alarms.dtypes.tolist()
    row = pd.concat([alarms, found], ignore_index=True).iloc[0]
    assert row[["limit", "words", "motion"]].tolist() == ["", ENDED, "both"]
    assert row[["from_operation", "to_operation"]].tolist() == [1200, 1220]
    assert np.isnan(row.highest_probability)
    assert len(step_table({"both": trend_of(MOTIONS, NUMBERS)})) == 0
