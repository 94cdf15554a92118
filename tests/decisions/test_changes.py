"""Steps of a drive in words, in the decisions, the alarms and on the first page."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from breaker.decisions.alarms import alarm_table
from breaker.decisions.changes import changes, named, same_bend, step_table, with_steps
from breaker.decisions.series import complete
from breaker.mechanism.parameters import MOTIONS, NAMES
from tests.decisions.made_up import KINDS, LIMITS, QUIET, SETTINGS, changed, page_of, trend_of

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
    trend["kind_probability"][:] = np.arange(float(len(KINDS)))
    whole = complete(trend, SETTINGS, "closing")
    assert whole.change_start.values.tolist() == [2.0]
    told = changes({"closing": whole, "opening": whole}, NUMBERS)
    assert told[3] == "greased: gamma_a starts anew"
    assert complete(trend.isel(operation=slice(0, 3)), SETTINGS, "closing").change_start == 2.0


def test_motions_that_changed_are_named():
    """Each with the phase that changed most."""
    assert stepped(sizes=(1.1, 0.2, 0.1, 0.0, 1.234, 0.1)).jump_words.item() == (
        "closing: the start of the motion changed at operation 1,200 (1.1 mm), "
        "opening: the main motion changed at operation 1,200 (1.2 mm)"
    )


def test_decisions_and_first_page_report_a_step():
    _, _, rows, page = page_of(QUIET, stepped(), notice=10)
    assert rows.change.tolist() == ["", "", ENDED, ""]
    assert rows.state.tolist() == ["healthy"] * 4
    assert rows.action.tolist() == ["none", "none", "watch", "watch"]
    assert page.attrs["headline"] == f"Healthy: watch {ENDED}. As of operation 1,230."
    assert page.attrs["wearing"] == (
        f"Wearing: nothing that a trend could tell from none. Last change noticed: {ENDED}."
    )
    _, _, rows, page = page_of(QUIET, stepped(), notice=5)
    assert rows.action.tolist() == ["none", "none", "watch", "none"]
    assert page.attrs["headline"] == "Healthy: go on. As of operation 1,230."
    assert page.attrs["left"] == "Left: no trend leads to a limit."


def test_a_step_does_not_hide_what_is_worse():
    own = QUIET.copy()
    own[:, 0] = 0.99
    rows = page_of(own, stepped()).rows
    assert rows.to_do[2] == f"service now: slow exceeded since operation 1,210; {ENDED}"
    trend = stepped()
    trend["beyond"][2:, 2] = 0.5
    rows = page_of(QUIET, trend).rows
    assert rows.to_do[2] == f"check wide: it may be exceeded already (50 %); {ENDED}"


def test_a_change_that_was_taken_back_does_not_hide_a_step():
    trend = changed(stepped(), 1220, np.nan, (np.nan, np.nan))
    _, _, rows, page = page_of(QUIET, trend)
    assert rows.change[2] == f"both: a change that later ones took back; {ENDED}"
    assert page.attrs["wearing"].endswith(f"Last change noticed: {ENDED}.")


def test_alarms_list_steps():
    found = step_table({"both": stepped()})
    motions = {limit.name: limit.motion for limit in LIMITS}
    alarms = alarm_table(page_of(QUIET, stepped()).judged, motions)
    assert found.dtypes.tolist() == alarms.dtypes.tolist()
    row = pd.concat([alarms, found], ignore_index=True).iloc[0]
    assert row[["limit", "words", "motion"]].tolist() == ["", ENDED, "both"]
    assert row[["from_operation", "to_operation"]].tolist() == [1200, 1220]
    assert np.isnan(row.highest_probability)
    assert len(step_table({"both": trend_of(MOTIONS, NUMBERS)})) == 0


# ---- changes of the wear -----------------------------------------------------------------------


def alarmed(alarms, starts, kind="f", source="both"):
    """A trend with alarms (indices), each with the interval of its start until the next."""
    trend = trend_of(MOTIONS if source == "both" else [source], 10 * np.arange(1, 41))
    for at, start in zip(alarms, starts, strict=True):
        trend["alarm"][at] = True
        trend["start_interval"][at:] = start
        trend["kind_probability"][at:] = np.eye(len(KINDS))[KINDS.index(kind)]
    return complete(trend.drop_dims("change"), SETTINGS, source)


def test_changes_are_told_as_known_before_the_next_or_a_hundred_operations_on():
    trend = alarmed([2, 25], [[15, 20, 25], [235, 240, 250]])
    trend["start_interval"][12] = [17, 19, 24]  # at 130, a hundred after 30
    whole = complete(trend.drop_dims(["change", "jump"]), SETTINGS, "both")
    assert whole.change_alarm.values.tolist() == [30, 260]
    assert whole.change_start.values.tolist() == [19, 240]
    assert whole.change_interval.values.tolist() == [[17, 24], [235, 250]]
    assert whole.change_parameters.values.tolist() == ["f", "f"]
    assert whole.attrs["source"] == "both"
    assert whole.attrs["toward_level"] == 0.95
    none = alarmed([], [])
    assert none.sizes["change"] == 0
    empty = trend.drop_dims(["change", "jump"]).isel(operation=slice(0, 0))
    assert complete(empty, SETTINGS, "both").sizes["change"] == 0


def test_neighbouring_alarms_of_one_bend_are_one_change_and_two_bends_are_two():
    """The first notice, and the interval of the last, which has seen most."""
    one = alarmed([10, 14], [[80, 100, 120], [95, 102, 108]])
    assert one.change_alarm.values.tolist() == [110]
    assert one.change_interval.values.tolist() == [[95, 108]]
    two = alarmed([10, 30], [[80, 100, 110], [280, 290, 300]])
    assert two.change_alarm.values.tolist() == [110, 310]
    both = changes({"both": two}, two.operation.values)
    assert [each for each in both if each] == [
        "both: change of f at about 100 (80 to 110)",
        "both: change of f at about 290 (280 to 300)",
    ]


def test_a_bend_that_both_motions_saw_is_one_line():
    closing = alarmed([10], [[80, 100, 110]], source="closing")
    opening = alarmed([14], [[90, 100, 104]], kind="L", source="opening")
    noted = changes({"closing": closing, "opening": opening}, closing.operation.values)
    assert {i: each for i, each in enumerate(noted) if each} == {
        10: "closing and opening: change of f, L at about 100 (90 to 104)"
    }
    apart = alarmed([34], [[290, 300, 304]], kind="L", source="opening")
    noted = changes({"closing": closing, "opening": apart}, closing.operation.values)
    assert [each for each in noted if each] == [
        "closing: change of f at about 100 (80 to 110)",
        "opening: change of L at about 300 (290 to 304)",
    ]


def seen(alarms, starts):
    """Trends of two measured quantities: the first with alarms (indices), as of ``alarmed``."""
    trend = alarmed(alarms, starts)[["alarm", "start_interval", "event"]]
    rest = alarmed([], [])[["alarm", "start_interval", "event"]]
    followed = xr.DataArray(["closing travel_time", "opening stroke"], dims="followed")
    both = xr.concat([trend, rest], dim="followed", data_vars=["alarm", "start_interval"])
    return both.assign_coords(followed=followed)


def test_changes_of_measured_quantities_are_told_with_those_of_parameters():
    """Once each, as first noticed. A wide notice does not make one of two bends of the wear."""
    two = alarmed([10, 30], [[80, 100, 110], [280, 290, 300]])
    numbers = two.operation.values
    same = seen([8, 32], [[70, 75, 82], [285, 288, 295]])
    assert {i: each for i, each in enumerate(changes({"both": two}, numbers, same)) if each} == {
        8: "both: change of f at about 100 (80 to 110)",
        30: "both: change of f at about 290 (280 to 300)",
    }
    wide = changes({"both": two}, numbers, seen([28], [[90, 200, 285]]))
    assert wide == changes({"both": two}, numbers)
    alone = changes({"both": two}, numbers, seen([18], [[150, 160, 170]]))
    assert alone[18] == "change of measured travel_time of closing at about 160 (150 to 170)"
    assert len([each for each in alone if each]) == 3
    back = changes({"both": two}, numbers, seen([18], [[np.nan] * 3]))
    assert back[18] == "measured travel_time of closing: a change that later ones took back"
    jump = changes({"both": stepped()}, NUMBERS, seen_step())
    assert jump[2] == f"{ENDED}, with a change of measured stroke of opening"


def seen_step():
    """A measured quantity that changed where ``stepped`` did."""
    return xr.Dataset(
        {
            "alarm": (("operation", "followed"), np.arange(4)[:, None] == 3),
            "start_interval": (
                ("operation", "followed", "quantile"),
                np.tile([1195.0, 1201.0, 1210.0], (4, 1, 1)),
            ),
            "event": ("operation", np.full(4, "")),
            "level": (("operation", "followed"), np.full((4, 1), 14.0)),
            "slope": (("operation", "followed"), np.zeros((4, 1))),
            "slope_interval": (("operation", "followed", "bound"), np.tile([-1.0, 1.0], (4, 1, 1))),
        },
        {"operation": NUMBERS, "followed": ["opening stroke"]},
    )


def test_decisions_tell_changes_of_measured_quantities():
    noted = page_of(QUIET, trend_of(MOTIONS, NUMBERS), measured=seen_step()).rows
    words = "change of measured stroke of opening at about 1,201 (1,195 to 1,210)"
    assert noted.change.tolist() == ["", "", "", words]
    assert noted.action.tolist() == ["none", "none", "none", "watch"]


def test_a_step_and_a_change_in_the_same_place_are_one():
    trend = stepped()
    near = changed(trend, 1230, 1204, (1200, 1210), f=1.0)
    assert changes({"both": near}, NUMBERS) == ["", "", f"{ENDED}, with a change of f", ""]
    far = changed(trend, 1230, 1225, (1221, 1228), f=1.0)
    assert changes({"both": far}, NUMBERS) == [
        *("", "", ENDED),
        "both: change of f at about 1,225 (1,221 to 1,228)",
    ]


def test_intervals_that_are_unknown_are_like_no_other():
    nan = np.full((2, 2), np.nan)
    assert same_bend(np.vstack([nan, [[1, 2], [2, 3]]])) == [[0], [1], [2, 3]]
    assert same_bend(np.zeros((0, 2))) == []


def test_every_parameter_that_surely_moved_is_named():
    """f from -1 to -5 and L from 0 to 2 % in 1,000 operations, known to 0.5; the rest as before."""
    trend = trend_of(MOTIONS, 10 * np.arange(1, 41)).drop_dims("change")
    f, gap = NAMES.index("f"), NAMES.index("L")
    trend["slope"][:, f], trend["slope"][20:, f], trend["slope"][20:, gap] = -1.0, -5.0, 2.0
    trend["slope_interval"][:] = trend.slope.values[..., None] + 0.5 * 1.6449 * np.array([-1, 1])
    trend["alarm"][22] = True
    trend["start_interval"][22:] = [180, 190, 200]
    trend["kind_probability"][22:] = np.eye(len(KINDS))[KINDS.index("several")]
    whole = complete(trend, SETTINGS, "both")
    assert whole.change_parameters.values.tolist() == ["f, L"]
    moved = whole.change_moved.values[0]
    assert moved[f] > 0.999
    assert moved[gap] == pytest.approx(0.9977, abs=1e-3)  # 2 over 0.5 times the root of two
    assert moved[NAMES.index("mu")] == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("kinds", "moved", "words"),
    [
        ({"f": 0.99}, {"f": 0.99}, "f"),
        ({"f": 0.6, "L": 0.37}, {"f": 0.6, "L": 0.37}, "f or L"),
        ({"several": 1.0}, {"f": 0.9, "L": 0.7}, "several parameters"),
        ({"several": 0.6, "f": 0.4}, {"f": 0.9, "L": 0.5}, "the wear"),
        ({"all": 0.96}, {"f": 0.99}, "all levels, as in a repair"),
    ],
)
def test_names_of_a_change(kinds, moved, words):
    values = np.array([moved.get(name, 0.0) for name in NAMES])
    assert named(values, np.array([kinds.get(name, 0.0) for name in KINDS])) == words
