"""From trends and probabilities to decisions: on small tables made up for it."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from breaker.decisions.series import health, join, remaining
from breaker.decisions.summary import verdict
from breaker.decisions.table import STATES, decide, states, wearing
from breaker.decisions.trust import trust_table
from breaker.mechanism.limits import from_list
from breaker.mechanism.parameters import MOTIONS, NAMES
from breaker.mechanism.quantities import evaluate
from breaker.synthetic.failure_times import failures
from tests.decisions.test_trust import trust_of

NAN, INF = np.nan, np.inf
LIMITS = from_list(
    [
        {"name": "slow", "motion": "closing", "upper": {"touch_time": 10.0}},
        {"name": "tired", "motion": "closing", "upper": {"touch_time": 9.8}, "lower": {"f": 0.7}},
        {"name": "wide", "motion": "opening", "upper": {"L": 11.0}},
    ],
    MOTIONS,
)
ALARM = {"raise": 0.95, "clear": 0.5, "after": 2}
SETTINGS = {"notice": 200, "toward": 0.95, "baseline": 2, "alarm_level": 0.95, "horizon": 10000}
QUANTILES = [0.05, 0.5, 0.95]
KINDS = [*NAMES, "several", "all"]


# ---- tables ----------------------------------------------------------------------------------


def condition_of(probability, operations=None):
    """What single operations say, ``(o, 3)``: marginals are half of the probabilities."""
    values = np.array(probability, dtype=float)
    dims = ("operation", "limit")
    return xr.Dataset(
        {"probability": (dims, values), "marginal": (dims, values / 2)},
        {
            "operation": np.arange(1, len(values) + 1) if operations is None else operations,
            "limit": [limit.name for limit in LIMITS],
            "words": ("limit", [limit.words for limit in LIMITS]),
        },
    )


def trend_of(motions, operations, **changed):
    """A trend at rest: no drift, nothing near. ``changed`` are values by the name of a limit."""
    limits = [limit for limit in LIMITS if limit.motion in motions]
    o, parts = len(operations), [(each.name, part) for each in limits for part in each.parts]
    full = {
        "remaining": np.full((o, len(limits), 3), INF),
        "toward": np.full((o, len(limits)), 0.1),
        "beyond": np.zeros((o, len(limits))),
        "soon": np.zeros((o, len(limits))),
    }
    for name, values in changed.items():
        for limit, each in values.items():
            full[name][:, [one.name for one in limits].index(limit)] = each
    dims = {"remaining": ("operation", "limit", "quantile")}
    value = np.array([9.0, 9.5, 10.0, 9.0, 9.5, 10.0, 0.75, 0.8, 0.85, 9.0, 10.0, 11.0])
    value = value.reshape(4, 3)[[i for i, each in enumerate(PARTS) if each in limits_names(limits)]]
    p = len(NAMES)
    return xr.Dataset(
        {name: (dims.get(name, ("operation", "limit")), each) for name, each in full.items()}
        | {
            "value": (("operation", "part", "quantile"), np.tile(value, (o, 1, 1))),
            "slope": (("operation", "parameter"), np.zeros((o, p))),
            "slope_interval": (
                ("operation", "parameter", "bound"),
                np.tile([-1.0, 1.0], (o, p, 1)),
            ),
            "alarm": ("operation", np.zeros(o, dtype=bool)),
            "event": ("operation", np.full(o, "")),
            "step": ("operation", np.zeros(o, dtype=bool)),
            "surprise": ("operation", np.full(o, 0.5)),
            "step_size": (("operation", "phase"), np.full((o, 3 * len(motions)), NAN)),
            "start_interval": (("operation", "quantile"), np.full((o, 3), NAN)),
            "kind_probability": (("operation", "kind"), np.full((o, len(KINDS)), NAN)),
            "change_alarm": ("change", np.zeros(0)),
            "change_start": ("change", np.zeros(0)),
            "change_interval": (("change", "bound"), np.zeros((0, 2))),
            "change_kind": (("change", "kind"), np.zeros((0, len(KINDS)))),
            "change_moved": (("change", "parameter"), np.zeros((0, p))),
            "change_parameters": ("change", np.zeros(0, dtype=str)),
            "jump_noticed": ("jump", np.zeros(0, dtype=int)),
            "jump_from": ("jump", np.zeros(0, dtype=int)),
            "jump_words": ("jump", np.zeros(0, dtype=str)),
        },
        {
            "operation": operations,
            "limit": [limit.name for limit in limits],
            "words": ("limit", [limit.words for limit in limits]),
            "part_limit": ("part", [name for name, _ in parts]),
            "part_quantity": ("part", [part[0] for _, part in parts]),
            "part_bound": ("part", [part[1] for _, part in parts]),
            "part_upper": ("part", [part[2] for _, part in parts]),
            "quantile": QUANTILES,
            "parameter": list(NAMES),
            "kind": KINDS,
            "phase": [f"{m} {each}" for m in motions for each in ("start", "main motion", "end")],
        },
        {"source": "both" if len(motions) == 2 else motions[0], "horizon": 10000},
    )


def changed(trend, alarm, start, interval, **kinds):
    """A trend with a change, of the kinds and with the probabilities of ``kinds``."""
    kind = np.array([[kinds.get(name, 0.0) for name in KINDS]])
    return trend.drop_dims("change").assign(
        change_alarm=("change", np.array([alarm])),
        change_start=("change", np.array([start])),
        change_interval=(("change", "bound"), np.array([interval])),
        change_kind=(("change", "kind"), kind),
        change_moved=(("change", "parameter"), kind[:, : len(NAMES)]),
    )


PARTS = [limit.name for limit in LIMITS for _ in limit.parts]


def limits_names(limits):
    return [limit.name for limit in limits]


def curves_of(operations, **flags):
    o = len(operations)
    known = {
        "accepted": np.ones(o, bool),
        "resolved": np.ones(o, bool),
        "misfit": np.zeros(o, bool),
    }
    return xr.Dataset(
        {name: ("operation", np.array(each)) for name, each in (known | flags).items()},
        {"operation": operations},
    )


def page_of(own, trend, settings=SETTINGS, **more):
    """Everything that follows from probabilities ``(o, 3)`` and a fused trend."""
    condition = condition_of(own, trend.operation.values)
    left = remaining({"both": trend}, LIMITS)
    judged = health(condition, left, ALARM)
    curves = more.get("curves") or {"closing": curves_of(trend.operation.values)}
    rows = decide(judged, left, {"both": trend}, curves, settings)
    trust = more.get("trust", trust_table([trust_of(MOTIONS)]))
    return judged, left, rows, verdict(judged, left, {"both": trend}, rows, trust, settings)


QUIET = np.full((4, 3), 0.01)
NUMBERS = np.arange(1, 5)


# ---- joining ---------------------------------------------------------------------------------


def test_chunks_are_joined():
    first = trend_of(MOTIONS, NUMBERS[:2], toward={"slow": 0.3})
    second = trend_of(MOTIONS, NUMBERS[2:], toward={"slow": 0.7}).assign_attrs(horizon=1)
    whole = join([first, second])
    assert whole.operation.values.tolist() == [1, 2, 3, 4]
    assert whole.toward.sel(limit="slow").values.tolist() == [0.3, 0.3, 0.7, 0.7]
    assert whole.part_bound.dims == ("part",)
    assert whole.attrs["horizon"] == 10000
    with pytest.raises(ValueError, match="limit"):
        join([first, second.isel(limit=[0, 1])])


def test_remaining_is_read_from_the_source_of_each_limit():
    closing = trend_of(["closing"], NUMBERS, remaining={"slow": [1, 2, 3], "tired": [4, 5, 6]})
    opening = trend_of(["opening"], NUMBERS[1:], remaining={"wide": [7, 8, 9]})
    left = remaining({"closing": closing, "opening": opening}, LIMITS)
    assert left.limit.values.tolist() == ["slow", "tired", "wide"]
    assert left.source.values.tolist() == ["closing", "closing", "opening"]
    assert left.attrs["source"] == "separate"
    assert left.operation.values.tolist() == [1, 2, 3, 4]
    assert left.remaining.sel(operation=2, quantile=0.5).values.tolist() == [2, 5, 8]
    assert np.isnan(left.remaining.sel(operation=1, limit="wide")).all()
    assert np.isnan(left.beyond.sel(operation=1, limit="wide"))
    assert left.part_limit.values.tolist() == PARTS
    assert left.value.sel(operation=4, quantile=0.5).values.tolist() == [9.5, 9.5, 0.8, 10.0]
    both = trend_of(MOTIONS, NUMBERS, remaining={"wide": [1, 1, 1]})
    left = remaining({"both": both}, LIMITS)
    assert set(left.source.values.tolist()) == {"both"}
    assert left.attrs["source"] == "both"
    assert left.remaining.sel(operation=4, limit="wide").values.tolist() == [1, 1, 1]


# ---- health ----------------------------------------------------------------------------------


def test_health():
    """Probabilities of single operations as they are, with alarms; of the trend where it is."""
    own = [[0.99, 0.1, NAN], [0.99, 0.1, 0.2], [0.4, 0.1, 0.2], [0.4, 0.1, 0.2]]
    trend = trend_of(MOTIONS, NUMBERS, beyond={"slow": 0.6})
    left = remaining({"both": trend.isel(operation=slice(0, 3))}, LIMITS)
    judged = health(condition_of(own), left, ALARM)
    np.testing.assert_array_equal(judged.probability.values, own)
    np.testing.assert_array_equal(judged.marginal.values, np.array(own) / 2)
    assert judged.alarm.sel(limit="slow").values.tolist() == [False, True, True, False]
    assert not judged.alarm.sel(limit=["tired", "wide"]).any()
    np.testing.assert_array_equal(judged.first_alarm.values, [2.0, NAN, NAN])
    assert judged.attrs == ALARM
    assert judged.words.values.tolist() == [limit.words for limit in LIMITS]
    assert judged.trend_probability.dims == ("operation", "limit")
    np.testing.assert_array_equal(judged.trend_probability.values[:, 0], [0.6, 0.6, 0.6, NAN])


def test_alarms_need_a_row_and_pass_over_what_is_missing():
    p = np.array([0.96, NAN, 0.96, 0.4, 0.9, 0.4, NAN, 0.4])
    own = np.column_stack([p, np.zeros(8), np.zeros(8)])
    trend = trend_of(MOTIONS, np.arange(1, 9))
    left = remaining({"both": trend}, LIMITS)
    judged = health(condition_of(own), left, ALARM)
    on = judged.alarm.sel(limit="slow").values.tolist()
    assert on == [False, False, True, True, True, True, True, False]
    assert judged.first_alarm.sel(limit="slow") == 3


def test_failures_are_where_true_parameters_pass_a_limit(prior):
    theta = np.tile(prior.medians, (801, 1))
    theta[:, NAMES.index("L")] = np.linspace(10.0, 11.6, 801)
    theta[:, NAMES.index("f")] = np.linspace(0.85, 0.75, 801)
    operations = {"operation": np.arange(1, 802)}
    truth = xr.DataArray(theta, dims=("operation", "parameter"), coords=operations)
    found = failures(truth, LIMITS)
    assert found["wide"] in (501, 502)  # 11.0
    touch = evaluate(["touch_time"], theta, "closing")[:, 0]
    at = int(found["slow"]) - 1
    assert touch[at - 1] <= 10.0 < touch[at]
    assert np.isnan(found["tired"])  # the force stays above 0.7
    truth.values[:, NAMES.index("L")] = 9.0
    assert np.isnan(failures(truth, LIMITS)["wide"])


# ---- states and actions ----------------------------------------------------------------------


def test_states():
    trend = trend_of(
        MOTIONS,
        NUMBERS,
        toward={"slow": [0.5, 0.95, 0.96, 0.99], "tired": 0.99, "wide": 0.0},
        remaining={"slow": [100, 200, 300], "tired": [[50, INF, INF]] * 3 + [[50, 60, INF]]},
        beyond={"wide": [0.04, 0.94, 0.95, NAN]},
    )
    own = QUIET.copy()
    own[2:, 0] = 0.99
    judged, left, *_ = page_of(own, trend)
    found = states(judged, left, SETTINGS["toward"])
    assert found.tolist() == [
        # The second limit may come early, though most of what is probable is beyond the horizon.
        ["healthy", "wearing", "healthy"],
        ["wearing", "wearing", "wearing"],  # the third one: exceeded, perhaps
        ["wearing", "wearing", "alarm"],
        ["alarm", "wearing", "unknown"],
    ]
    assert set(found.ravel()) == set(STATES)


@pytest.mark.parametrize(
    ("changed", "own", "state", "action", "left"),
    [
        ({}, 0.01, "healthy", "go on", "Left: no trend leads to a limit."),
        (
            {"toward": {"wide": 0.97}, "remaining": {"wide": [201, 400, 900]}},
            0.01,
            "wearing",
            "go on; wide in 400 operations (201 to 900)",
            "Left: 400 operations to wide (201 to 900, 90 %).",
        ),
        (
            {"toward": {"wide": 0.97}, "remaining": {"wide": [201, 400, INF]}},
            0.01,
            "wearing",
            "go on; wide in 400 operations (201 to beyond the horizon)",
            "Left: 400 operations to wide (201 to beyond the horizon, 90 %).",
        ),
        (
            {"toward": {"wide": 0.97}, "remaining": {"wide": [199.6, 400, 900]}},
            0.01,
            "wearing",
            "plan service within 200 operations, before wide",
            "Left: 400 operations to wide (200 to 900, 90 %).",
        ),
        (
            {"toward": {"wide": 0.9}, "remaining": {"wide": [10, 20, 30]}},
            0.01,
            "healthy",
            "go on",
            "Left: no trend leads to a limit.",
        ),
        (
            {"beyond": {"slow": 0.99, "wide": 0.99}},
            0.01,
            "alarm",
            "service now: slow, wide exceeded",
            "Left: nothing; service now.",
        ),
        (
            {},
            0.99,
            "alarm",
            "service now: slow, tired, wide exceeded",
            "Left: nothing; service now.",
        ),
    ],
)
def test_actions(changed, own, state, action, left):
    _, _, rows, page = page_of(np.full((4, 3), own), trend_of(MOTIONS, NUMBERS, **changed))
    last = rows.iloc[-1]
    assert (last.state, last.action) == (state, action)
    assert page.attrs["left"] == left
    over = (
        action.removeprefix("service now: ").removesuffix(" exceeded") if state == "alarm" else ""
    )
    assert last.limits_exceeded == over.replace(",", ";")


def test_the_nearest_limit_is_told():
    trend = trend_of(
        MOTIONS,
        NUMBERS,
        toward={"slow": 0.99, "tired": 0.5, "wide": 0.99},
        remaining={"slow": [500, 700, 900], "tired": [1, 2, 3], "wide": [300, 400, INF]},
    )
    last = page_of(QUIET, trend)[2].iloc[-1]
    assert last.next_limit == "wide"
    assert last[["remaining_5", "remaining_median", "remaining_95"]].tolist() == [300, 400, INF]
    quiet = page_of(QUIET, trend_of(MOTIONS, NUMBERS))[2].iloc[-1]
    assert quiet.next_limit == ""
    assert np.isnan(quiet[["remaining_5", "remaining_median", "remaining_95"]].astype(float)).all()


def test_a_limit_that_may_be_near_is_not_hidden_by_a_nearer_median():
    trend = trend_of(
        MOTIONS,
        NUMBERS,
        toward={"slow": 0.99, "wide": 0.99},
        remaining={"slow": [250, 300, 350], "wide": [20, 400, 900]},
    )
    assert page_of(QUIET, trend)[2].iloc[-1].action.startswith("plan service within 20 operations")


def test_drifts_are_told_steepest_first():
    trend = trend_of(MOTIONS, NUMBERS)
    # The line is at 2.69 sds, 1.635 of half an interval: mu stays below it, L is just above it.
    halves = {"f": 0.1, "gamma_a": 0.1, "mu": 0.25, "L": 0.15}
    for name, slope in (("f", -1.5), ("gamma_a", 12.34), ("mu", 0.4), ("L", 0.25)):
        i, half = NAMES.index(name), halves[name]
        trend["slope"][:, i] = slope
        trend["slope_interval"][:, i] = [slope - half, slope + half]
    other = trend.sel(operation=[4])
    trends = {"closing": trend, "opening": other}
    text = "gamma_a +12 %, f -1.5 %, L +0.25 %"
    expected = ["", f"closing: {text}", f"closing: {text}; opening: {text}"]
    assert wearing(trends, [9, 3, 4]) == expected
    assert wearing(trends, [3], most=1) == ["closing: gamma_a +12 %"]
    assert wearing({"both": trend_of(MOTIONS, NUMBERS)}, NUMBERS) == [""] * 4


def test_changes_are_noted_where_they_were_noticed():
    trend = changed(trend_of(MOTIONS, NUMBERS), 3, 1.6, (1.0, 2.4), several=1.0)
    trend["change_moved"][0, 5:] = [0.96, 0.97]
    trend["slope"][:, 5], trend["slope_interval"][:, 5] = -2.0, [-3.0, -1.0]
    _, _, rows, page = page_of(QUIET, trend)
    noted = "both: change of f, L at about 2 (1 to 2)"
    assert rows.change.tolist() == ["", "", noted, ""]
    assert page.attrs["wearing"] == (
        f"Wearing, in 1,000 operations: both: f -2 %. Last change noticed: {noted}."
    )


def test_what_was_not_used_says_why():
    closing = curves_of(NUMBERS[:3], accepted=[False, True, True], resolved=[False, False, True])
    opening = curves_of(NUMBERS, resolved=[False, True, True, True])
    curves = {"closing": closing, "opening": opening}
    rows = page_of(QUIET, trend_of(MOTIONS, NUMBERS), curves=curves)[2]
    assert rows.not_used.tolist() == [
        "closing: rejected; opening: not resolved",
        "closing: not resolved",
        "",
        "closing: no record",
    ]
    assert list(rows) == [
        "operation",
        "state",
        "limits_exceeded",
        "next_limit",
        "remaining_5",
        "remaining_median",
        "remaining_95",
        "wearing",
        "change",
        "action",
        "not_used",
    ]
    assert isinstance(rows, pd.DataFrame)


# ---- the first page --------------------------------------------------------------------------


def test_way_is_from_the_baseline_to_the_limit():
    """Of a limit of two parts, the part that is farthest; below a limit as above it."""
    trend = trend_of(MOTIONS, NUMBERS)
    trend["value"][:2] = np.array([[9.0] * 3, [9.0] * 3, [0.8] * 3, [10.0] * 3])
    trend["value"][3] = np.array(
        [[9.1, 9.25, 9.5], [9.4, 9.6, 9.8], [0.77, 0.78, 0.79], [9.8, 9.9, 10.5]]
    )
    page = page_of(QUIET, trend)[3]
    assert page.limit.values.tolist() == ["slow", "tired", "wide"]
    np.testing.assert_allclose(
        page.way.values, [[10, 25, 50], [10, 20, 30], [-20, -10, 50]], atol=1e-9
    )
    page = page_of(QUIET, trend, settings=SETTINGS | {"baseline": 100})[3]
    np.testing.assert_allclose(page.way.sel(quantile=0.5), 0, atol=1e-9)


def test_way_of_a_limit_exceeded_from_the_start():
    trend = trend_of(MOTIONS, NUMBERS, beyond={"wide": 1.0})
    trend["value"][:2, 3] = 11.2
    trend["value"][2:, 3] = 11.4
    page = page_of(QUIET, trend)[3]
    assert page.way.sel(limit="wide", quantile=0.5) >= 100


def test_sentence_of_health():
    own = QUIET.copy()
    page = page_of(own, trend_of(MOTIONS, NUMBERS))[3]
    assert page.attrs["healthy"] == "Healthy at operation 4: no limit exceeded."
    assert page.attrs["wearing"] == "Wearing: no parameter that a trend could tell from none."
    assert page.attrs["operation"] == 4
    assert page.state.values.tolist() == ["healthy"] * 3
    assert not page.trend.any()
    own[1:, :2] = [[0.1, 0.99], [0.99, 0.99], [0.99, 0.99]]
    page = page_of(own, trend_of(MOTIONS, NUMBERS))[3]
    assert page.attrs["healthy"] == (
        "Not healthy at operation 4: slow, tired exceeded, since operation 3."
    )
    page = page_of(QUIET, trend_of(MOTIONS, NUMBERS, beyond={"wide": 0.97}))[3]
    assert page.attrs["healthy"] == "Not healthy at operation 4: wide exceeded."
    assert page.state.values.tolist() == ["healthy", "healthy", "alarm"]


def test_since_is_of_the_alarm_that_is_on():
    own = np.full((9, 3), 0.01)
    own[[0, 1, 6, 7, 8], 0] = 0.99
    page = page_of(own, trend_of(MOTIONS, np.arange(1, 10)))[3]
    assert "since operation 8" in page.attrs["healthy"]


def unknown_page():
    trend = trend_of(MOTIONS, NUMBERS)
    for name in ("remaining", "toward", "beyond", "soon", "value", "slope", "slope_interval"):
        trend[name][:] = NAN
    curves = {"closing": curves_of(NUMBERS, accepted=[False] * 4)}
    return page_of(np.full((4, 3), NAN), trend, curves=curves)


def test_nothing_is_made_up_of_nothing():
    judged, _, rows, page = unknown_page()
    assert np.isnan(judged.probability).all()
    assert np.isnan(judged.trend_probability).all()
    assert not judged.alarm.any()
    assert np.isnan(judged.first_alarm).all()
    assert set(rows.state) == {"unknown"}
    assert set(rows.action) == {"cannot tell: no usable operation yet"}
    assert set(rows.not_used) == {"closing: rejected"}
    for name in ("limits_exceeded", "next_limit", "wearing", "change"):
        assert set(rows[name]) == {""}
    for name in ("remaining_5", "remaining_median", "remaining_95"):
        assert rows[name].isna().all()
    assert page.attrs["healthy"] == "Unknown at operation 4: no operation could be used."
    assert set(page.state.values) == {"unknown"}
    assert np.isnan(page.way).all()
    assert np.isnan(page.remaining).all()
    assert not page.trend.any()


def test_sentences_of_nothing_are_not_those_of_a_drive_at_rest():
    unknown, rest = unknown_page()[3], page_of(QUIET, trend_of(MOTIONS, NUMBERS))[3]
    assert unknown.attrs["left"] != rest.attrs["left"]
    assert unknown.attrs["wearing"] != rest.attrs["wearing"]


def test_a_limit_of_which_nothing_is_known_is_not_passed_over():
    trend = trend_of(MOTIONS, NUMBERS, beyond={"wide": NAN}, toward={"wide": NAN})
    own = QUIET.copy()
    own[:, 2] = NAN
    assert "wide" in page_of(own, trend)[3].attrs["healthy"]


def test_decisions_name_what_is_known_of_an_operation_in_any_motion():
    """A date of closing 1, and of opening 3, which closing has no record of."""
    closing = {"date": ["2024-11-20", "", ""], "event": ["", "", ""], "breaker": ["Q0"] * 3}
    opening = {"date": ["2024-11-21", "", "2024-11-23"], "temperature": [NAN, 21.5, NAN]}
    curves = {
        "closing": curves_of([1, 2, 4], **closing),
        "opening": curves_of([1, 2, 3], **opening),
    }
    trend = trend_of(MOTIONS, NUMBERS)
    rows = page_of(QUIET, trend, curves=curves)[2]
    added = [name for name in rows.columns if name not in page_of(QUIET, trend)[2].columns]
    assert added == ["breaker", "date", "temperature"]
    assert rows.date.fillna("").tolist() == ["2024-11-20", "", "2024-11-23", ""]
    assert rows.breaker.fillna("").tolist() == ["Q0", "Q0", "", "Q0"]
    assert rows.temperature.tolist()[1] == 21.5
