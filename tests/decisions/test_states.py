"""What is known of each limit: on single operations and trends made up for it."""

import numpy as np
import pytest

from breaker.decisions.series import remaining
from breaker.decisions.states import evidence, health, judge
from breaker.mechanism.parameters import MOTIONS, NAMES
from tests.decisions.made_up import ALARM, INF, LIMITS, NAN, NUMBERS, QUIET, condition_of, trend_of


def judged_of(own, trend, alarm=ALARM):
    """Judge three limits from single operations ``(o, 3)`` and a trend of both motions."""
    operations = trend.operation.values
    left = remaining({"both": trend}, LIMITS, operations)
    condition = condition_of(own, operations)
    return judge(condition, left, {"both": trend}, alarm=alarm, toward=0.95)


# ---- exceeded, since -------------------------------------------------------------------------


def reference(single, trend, up, down, after):
    """Exceeded or not after each operation of one limit, judged anew from its whole history."""
    on, counts, told = False, False, []
    for end in range(1, len(single) + 1):
        usable = [p for p in single[:end] if not np.isnan(p)][-after:]
        row = min(usable) if len(usable) == after else NAN
        known = [p for p in trend[:end] if not np.isnan(p)]
        counts = row >= up or (counts and row > down)
        probability = np.nanmax([row if counts or not known else -1.0, *known[-1:], -1.0])
        on = probability >= up or (on and not -1.0 < probability <= down)
        told.append(on)
    return told


@pytest.mark.parametrize("after", [1, 2, 3])
def test_exceeded_from_histories(after):
    """Against the whole history, judged anew at every operation: random, with gaps."""
    rng = np.random.default_rng(after)
    shape, shares = (150, 3), [0.15, 0.25, 0.1, 0.15, 0.15, 0.2]
    single, trend = rng.choice([0.1, 0.5, 0.7, 0.95, 1.0, NAN], (2, *shape), p=shares)
    beyond = {limit.name: trend[:, j] for j, limit in enumerate(LIMITS)}
    made = trend_of(MOTIONS, np.arange(1, 151), beyond=beyond)
    judged = judged_of(single, made, ALARM | {"after": after})
    for j in range(3):
        expected = reference(single[:, j], trend[:, j], 0.95, 0.5, after)
        assert 10 < sum(expected) < 140
        assert judged.exceeded.values[:, j].tolist() == expected


def test_since_is_of_the_present_spell_of_each_limit():
    own = np.full((9, 3), 0.01)
    own[[0, 1, 6, 7, 8], 0] = 0.99
    beyond = {"wide": [0, 0, 0, 0.96, 0.7, 0.6, 0.51, 0.51, 0.51]}
    judged = judged_of(own, trend_of(MOTIONS, 10 * np.arange(1, 10), beyond=beyond))
    np.testing.assert_array_equal(judged.since.sel(limit="slow"), [NAN, 20, *[NAN] * 5, 80, 80])
    stored = health(judged, ALARM)
    np.testing.assert_array_equal(stored.since, [80, NAN, 40])
    assert stored.attrs == ALARM
    assert "told" not in stored
    assert {"marginal", "trend_probability", "words", "source", "of"} < {*stored.variables}


def test_a_known_event_ends_a_spell_unless_it_goes_on_for_sure():
    """And single operations in a row begin anew, whatever those before it said."""
    own = np.full((9, 3), 0.01)
    own[:6, 0] = 0.99  # only one operation after the event, where it takes two
    beyond = {"tired": [0.97] * 9, "wide": [0.96] * 5 + [0.94] * 4}
    made = trend_of(MOTIONS, 10 * np.arange(1, 10), beyond=beyond)
    without = judged_of(own, made)
    made["event"] = made.event.astype("<U30")
    made["event"][5] = "greased: gamma_a starts anew"
    judged = judged_of(own, made)
    assert without.exceeded.sel(limit="wide").all()
    assert judged.exceeded.sel(limit="wide").values.tolist() == [True] * 5 + [False] * 4
    assert judged.exceeded.sel(limit="slow").values.tolist() == [0, 1, 1, 1, 1, 0, 0, 0, 0]
    assert judged.since.sel(limit="tired").values.tolist() == [10.0] * 9


def test_single_operations_count_beside_a_trend_only_once_they_are_sure():
    """Otherwise they leave it to the trend, which counts the prior only once."""
    single = np.array([0.9, 0.95, 0.51, 0.5, 0.9])[:, None]
    trend = np.array([0.01, 0.02, 0.6, 0.04, NAN])[:, None]
    given = {"after": 1, "sure": 0.95, "clear": 0.5}
    assert evidence(single, trend, **given).ravel().tolist() == [0.01, 0.95, 0.6, 0.04, 0.04]
    alone = evidence(single, np.full((5, 1), NAN), **given)
    assert alone.ravel().tolist() == single.ravel().tolist()


@pytest.mark.parametrize(
    "wrong",
    [{"clear": 0.96}, {"raise": 1.5}, {"clear": -0.1}, {"raise": NAN}, {"after": 0}],
)
def test_unusable_levels_are_refused(wrong):
    with pytest.raises(ValueError, match="an alarm needs"):
        judged_of(QUIET, trend_of(MOTIONS, NUMBERS), ALARM | wrong)


def test_other_operations_are_refused():
    trend = trend_of(MOTIONS, NUMBERS)
    left = remaining({"both": trend}, LIMITS, NUMBERS[1:])
    with pytest.raises(ValueError, match="the same operations"):
        judge(condition_of(QUIET), left, {"both": trend}, alarm=ALARM, toward=0.95)


# ---- remaining, state ------------------------------------------------------------------------


def test_states_and_what_is_told():
    trend = trend_of(
        MOTIONS,
        NUMBERS,
        toward={"slow": [0.5, 0.95, 0.91, 0.89], "tired": 0.99, "wide": 0.0},
        remaining={"slow": [100, 200, 300], "tired": [[50, INF, INF]] * 3 + [[INF, INF, INF]]},
        beyond={"wide": [0.04, 0.05, 0.95, 0.6]},
    )
    judged = judged_of(QUIET, trend)
    assert judged.state.values.tolist() == [
        # Most of what is probable is beyond the horizon, but it may come before.
        ["healthy", "plan", "healthy"],
        ["plan", "plan", "unknown"],
        ["plan", "plan", "now"],
        ["healthy", "drifting", "now"],
    ]
    assert judged.drive_state.values.tolist() == ["plan", "plan", "now", "now"]
    np.testing.assert_array_equal(
        judged.told.values[:, :, 0], [[NAN, 50, NAN], [100, 50, NAN], [100, 50, 0], [NAN, INF, 0]]
    )


def test_what_is_known_stays_known_without_a_record():
    """Operations count down meanwhile; what never was known stays unknown."""
    beyond = {"slow": [0.01, NAN, NAN, 0.02], "wide": NAN}
    trend = trend_of(
        MOTIONS,
        10 * NUMBERS,
        beyond=beyond,
        toward={"slow": [0.99, NAN, NAN, 0.99], "wide": NAN},
        remaining={"slow": [[15, 40, INF], [NAN] * 3, [NAN] * 3, [5, 6, 7]], "wide": NAN},
    )
    own = QUIET.copy()
    own[:, 2] = NAN
    judged = judged_of(own, trend)
    assert judged.state.sel(limit="slow").values.tolist() == ["plan"] * 4
    assert judged.told.sel(limit="slow").values.tolist() == [
        [15, 40, INF],
        [5, 30, INF],
        [0, 20, INF],
        [5, 6, 7],
    ]
    assert judged.state.sel(limit="wide").values.tolist() == ["unknown"] * 4
    assert np.isnan(judged.level_probability.sel(limit="wide")).all()


def test_a_drive_is_as_its_worst_limit_and_drifts_if_a_parameter_surely_wears():
    trend = trend_of(MOTIONS, NUMBERS)
    assert judged_of(QUIET, trend).drive_state.values.tolist() == ["healthy"] * 4
    i = NAMES.index("f")
    trend["slope"][1:, i], trend["slope_interval"][1:, i] = -2.0, [-3.0, -1.0]
    assert judged_of(QUIET, trend).drive_state.values.tolist() == ["healthy", *["drifting"] * 3]
    nothing = np.full((4, 3), NAN)
    for name in ("beyond", "toward", "remaining"):
        trend[name][:] = NAN
    judged = judged_of(nothing, trend)
    assert set(judged.drive_state.values) == {"unknown"}
    assert np.isnan(judged.told).all()
    nothing[2:, 2] = 0.01
    drive = judged_of(nothing, trend).drive_state.values.tolist()
    assert drive == ["unknown", "unknown", "unknown", "drifting"]
