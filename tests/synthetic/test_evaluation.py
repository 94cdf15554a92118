"""Scores of made-up lives with known answers, and two short lives followed all the way."""

import numpy as np
import pytest
import xarray as xr

from breaker.mechanism.parameters import MOTIONS
from breaker.model.joint import Model
from breaker.model.randomness import generator
from breaker.synthetic.evaluation import FRACTIONS, follow_lives
from breaker.synthetic.lives import simulate_life
from breaker.synthetic.scores import score

EVERY = 5
CHANGE = 600
HORIZON = 2000
DRAWS = (np.arange(200) + 0.5) / 200
BASELINES = [f"{kind}, {motion}" for kind in ("threshold", "CUSUM", "EWMA") for motion in MOTIONS]


def life(
    number,
    *,
    failure=1600,
    ratio=6.0,
    alarms=(),
    jump=None,
    off=1.0,
    width=0.2,
    spread=0.0,
    toward=1.0,
    good_from=0.0,
):
    """One life of ``follow_lives``.

    Args:
        alarms: Operations at which the model sees a change.
        jump: Operation from which the raw time of closing is another one; that of opening is nan.
        off: Median over the true remaining life.
        width: Half width of the interval, share of the median.
        spread: Of the draws, uniform, share of the median to both sides; 0 is all at one place.
        good_from: Share of the way from change to failure before which the median is 3 times off.
    """
    operation = np.arange(EVERY, failure + 1, EVERY)
    truth = failure - operation
    way = CHANGE + np.array(FRACTIONS) * (failure - CHANGE)
    at = np.abs(operation[:, None] - way).argmin(axis=0)
    early = operation < CHANGE + good_from * (failure - CHANGE)
    median = np.where(early, 3.0, 1.0) * off * truth
    raw = np.full((len(operation), 2), np.nan)
    raw[:, 0] = 10.0 + 0.01 * generator(1, "test", "raw", number).standard_normal(len(operation))
    if jump is not None:
        raw[operation >= jump, 0] += 5.0
    lives = median[at, None] * (1.0 + spread * (2 * DRAWS - 1))
    return xr.Dataset(
        {
            "operation": ("record", operation.astype(float)),
            "alarm": ("record", np.isin(operation, alarms).astype(float)),
            "remaining": (("record", "quantile"), median[:, None] * [1 - width, 1.0, 1 + width]),
            "toward": ("record", np.full(len(operation), float(toward))),
            "raw_time": (("record", "motion"), raw),
            "lives": (("fraction", "draw"), lives),
            "ideal": (
                ("fraction", "observer", "draw"),
                np.stack([lives, truth[at, None] + 0 * lives], 1),
            ),
            "horizon": HORIZON,
            "record_at": ("fraction", at),
        }
        | {"change": CHANGE, "failure": failure, "ratio": ratio},
        coords={"fraction": list(FRACTIONS), "motion": list(MOTIONS)}
        | {"observer": ["ideal", "told"]},
    )


WIDER = [1.0, 1.15, 4.0]


def together(rows):
    """Lives of different lengths, filled up with nan."""
    longest = max(row.sizes["record"] for row in rows)
    return xr.concat([row.pad(record=(0, longest - row.sizes["record"])) for row in rows], "life")


def scored(*rows, toward=0.95):
    data, table = score(together(rows), toward=toward, settle=30)
    assert list(table.columns) == ["score", "value", "lower_95", "upper_95"]
    assert not table.score.duplicated().any()
    return data, table.set_index("score")


def of(values, method):
    return values.sel({"method": method}).values


# ---- detection -------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def detected():
    return scored(
        life(0, ratio=2.0, alarms=[605, 800], jump=655),
        life(1, ratio=6.0, alarms=[700], jump=640),
        life(2, ratio=7.0, jump=610),
        life(3, ratio=20.0, alarms=[1600], failure=1600),
        life(4, ratio=100.0, alarms=[600 + 35], failure=1200),
    )


def test_delays(detected):
    """Shares of the life; the alarm at the failure is too late, and the second of a life idle."""
    data, _ = detected
    assert data.method.values.tolist() == ["model", *BASELINES]
    model = of(data.delay, "model")
    np.testing.assert_allclose(model, [5 / 1600, 100 / 1600, np.nan, np.nan, 35 / 1200])
    for kind in ("threshold", "CUSUM", "EWMA"):
        closing = of(data.delay, f"{kind}, closing")
        np.testing.assert_allclose(closing[:3], [55 / 1600, 40 / 1600, 10 / 1600])
        assert np.isnan(of(data.delay, f"{kind}, opening")).all()


def test_found_within_three_percent(detected):
    """Of 1600 operations 48, of 1200 36. A ratio beyond the last bin counts in it."""
    data, table = detected
    np.testing.assert_array_equal(data.bin_lower, [1.5, 3, 5, 8, 13])
    np.testing.assert_array_equal(data.bin_upper, [3, 5, 8, 13, 30])
    np.testing.assert_allclose(of(data.found, "model"), [1, np.nan, 0, np.nan, 0.5])
    raw = of(data.found, "CUSUM, closing")
    np.testing.assert_allclose(raw[:4], [0, np.nan, 1, np.nan])
    name = "found within 3 % of life, ratio of 5 or more, {}"
    assert table.value[name.format("model")] == 1 / 4
    assert table.lower_95[name.format("model")] == pytest.approx(0.0063, abs=1e-4)  # 1 of 4
    assert table.upper_95[name.format("model")] == pytest.approx(0.8059, abs=1e-4)
    assert table.value[name.format("EWMA, closing")] >= 2 / 4
    assert table.value["lives"] == 5


def test_earlier_than_the_best_raw_time(detected):
    """In life 0, not in 1 to 3; of life 4 there is no jump, and a false alarm at best."""
    data, table = detected
    raw = data.delay.sel({"method": BASELINES}).min("method").values
    wins = 1 + (not raw[4] <= 35 / 1200)
    assert table.value["earlier than the best raw time"] == wins / 5
    assert table.value["earlier than the best raw time, ratio of 5 or more"] == (wins - 1) / 4


def test_no_life_is_hard():
    data, table = scored(life(0, ratio=2.0), life(1, ratio=4.9))
    name = "found within 3 % of life, ratio of 5 or more, model"
    assert table.loc[name].isna().all()
    np.testing.assert_allclose(of(data.found, "model"), [0, 0, np.nan, np.nan, np.nan])


def test_false_alarms_and_those_of_the_baselines():
    """Two in 900 operations before the changes, but the first 150; raw times may have as many."""
    data, table = scored(life(0, alarms=[300, 500, 620], jump=610), life(1, jump=610))
    name = "false alarms in 10,000 operations, {}"
    row = table.loc[name.format("model")]
    assert row.value == pytest.approx(2 / 900 * 1e4)
    # Garwood's interval of 2 is 0.242 to 7.225.
    np.testing.assert_allclose(
        [row.lower_95, row.upper_95], np.array([0.2422, 7.2247]) / 0.09, rtol=1e-3
    )
    np.testing.assert_allclose(of(data.delay, "model"), [20 / 1600, np.nan])
    kept = table.value[[name.format(method) for method in BASELINES]].values
    assert kept.max() <= row.value + 1e-9
    assert kept.max() > 0  # the least level is at the rate, not far above it
    # Without any, the baselines are held to one in 10,000: none in 900.
    data, table = scored(life(0, alarms=[620], jump=610), life(1, jump=610))
    assert table.value[[name.format(method) for method in ("model", *BASELINES)]].max() == 0


# ---- remaining life --------------------------------------------------------------------------


def at(table, words, fraction):
    (row,) = (name for name in table.index if name.startswith(words) and f" {fraction:g} " in name)
    return table.loc[row]


FAR = "prognostic horizon, share of the life after the change, median"


def test_perfect_predictions():
    data, table = scored(life(0), life(1))
    np.testing.assert_array_equal(data.coverage, 1.0)
    np.testing.assert_array_equal(data.alpha_lambda, 1.0)
    np.testing.assert_allclose(data.crps, 0.0, atol=1e-12)
    assert table.value[FAR] == (1600 - 605) / 1000  # the first record after the change
    for k, fraction in enumerate(FRACTIONS):
        coverage = at(table, "coverage of the 90 % interval", fraction)
        assert coverage.value == 1.0
        assert coverage.lower_95 == pytest.approx(0.025 ** (1 / 2))
        assert data.coverage_interval.values[k].tolist() == [coverage.lower_95, 1.0]
        assert at(table, "no trend", fraction).value == 0.0


def test_coverage_and_accuracy_by_hand():
    """Medians off by 1, 1.15, 1.3 and 0.75 with an interval of 20 %: only accuracy up to 20 %
    and coverage where the interval, a share of the median, holds the truth."""
    data, table = scored(*(life(i, off=off) for i, off in enumerate((1.0, 1.15, 1.3, 0.75))))
    np.testing.assert_allclose(data.alpha_lambda, 2 / 4)
    np.testing.assert_allclose(data.coverage, 2 / 4)  # 1.3 * 0.8 > 1 and 0.75 * 1.2 < 1
    data, _ = scored(*(life(i, off=1.3, width=w) for i, w in enumerate((0.2, 0.25, 0.5))))
    np.testing.assert_allclose(data.coverage, 2 / 3)
    np.testing.assert_allclose(data.alpha_lambda, 0.0)
    assert at(table, "coverage of the 90 % interval", 0.5).value == 0.5


def test_crps_by_hand():
    """Uniform between 0.5 and 1.5 times the truth T: the integral is T / 12."""
    data, table = scored(life(0, spread=0.5))
    np.testing.assert_allclose(data.crps, 1 / 12, rtol=5e-3)
    assert at(table, "CRPS", 0.25).value == data.crps.values[1]
    # A step at 1.5 T: half of T. No crossing at all: the horizon less the truth.
    row = life(1, off=1.5)
    row["lives"][1] = np.inf
    data, _ = scored(row)
    expected = np.full(len(FRACTIONS), 0.5)
    expected[1] = (HORIZON - 750) / 750
    np.testing.assert_allclose(data.crps, expected, atol=0.01)


def test_ideal_observers_stand_beside():
    """One draws as the model does, 30 % off or not; the other one knows the truth."""
    data, table = scored(life(0, spread=0.25), life(1, spread=0.25, off=1.3))
    np.testing.assert_allclose(data.ideal_coverage, [[0.5] * 5, [1.0] * 5])
    middle = 0.9 * 0.5 * np.median([1.0, 1.3])
    np.testing.assert_allclose(data.ideal_width, [[middle] * 5, [0.0] * 5], atol=1e-9)
    np.testing.assert_allclose(data.width, 0.4 * np.median([1.0, 1.3]))
    assert at(table, "coverage of an ideal observer", 0.1).value == 0.5
    assert at(table, "coverage of one that is told", 0.9).value == 1.0


def test_no_trend_is_a_miss():
    """Whatever the median says; a nan as well. At the level there is a trend."""
    rows = [life(i, toward=t) for i, t in enumerate((1.0, 0.95, 0.949, np.nan))]
    data, table = scored(*rows)
    np.testing.assert_allclose(data.alpha_lambda, 2 / 4)
    assert at(table, "no trend", 0.5).value == 2 / 4
    np.testing.assert_allclose(data.coverage, 1.0)  # of the interval, which is there
    assert table.value[FAR] == 0.995 / 2  # median of two perfect lives and two without
    lenient, _ = scored(*rows, toward=0.9)
    np.testing.assert_allclose(lenient.alpha_lambda, 3 / 4)


def test_median_beyond_the_horizon_is_a_miss():
    row = life(0)
    row["remaining"][:, 1:] = np.inf
    data, table = scored(row)
    np.testing.assert_array_equal(data.alpha_lambda, 0.0)
    np.testing.assert_array_equal(data.coverage, 1.0)  # from 0.8 of the truth to anything
    assert table.value[FAR] == 0.0


@pytest.mark.parametrize(
    ("good_from", "expected"), [(0.0, 0.995), (0.3, 0.7), (0.6, 0.4), (0.9, 0.1), (0.95, 0.0)]
)
def test_prognostic_horizon(good_from, expected):
    """The share of the way left from which on all predictions are in the cone, up to 90 %."""
    data, table = scored(life(0, good_from=good_from))
    assert table.value[FAR] == pytest.approx(expected)
    np.testing.assert_array_equal(data.alpha_lambda, np.array(FRACTIONS) >= good_from)


@pytest.mark.parametrize("failure", [1600, 1602, 1603])
def test_perfect_predictions_are_accurate_at_any_failure(failure):
    """Records are every fifth operation: the one scored at 0.9 may be before it, or after."""
    data, _ = scored(life(0, failure=failure))
    np.testing.assert_array_equal(data.alpha_lambda, 1.0)


# ---- lives that are followed -----------------------------------------------------------------


class Rough:
    """Stands in for a trained posterior: the prior's medians, give or take."""

    def __init__(self, model):
        self.model, self.outputs = model, model.outputs

    def sample(self, measured, noise):
        assert noise.shape == (len(measured), 3, len(self.outputs))
        return self.model.destandardise(0.1 * noise)


@pytest.fixture(scope="module")
def rough(defaults):
    return {m: Rough(Model.from_settings({**defaults, "motion": m})) for m in MOTIONS}


@pytest.fixture(scope="module")
def short(defaults):
    lives = defaults["lives"] | {"operations": 300, "every": 5, "draws": 3, "ratio": [0.5, 2.0]}
    few = {"lines": 20, "baseline": 20, "settle": 20, "horizon": 600}
    return lives, defaults["wear_model"] | few | {"widening": WIDER[1]}


@pytest.fixture(scope="module")
def followed(rough, short):
    return follow_lives(rough, [5, 0], *short, seed=1, widenings=WIDER)


def test_two_lives_followed(followed, rough, short):
    models = {motion: each.model for motion, each in rough.items()}
    lives = [simulate_life(models, short[0], 1, number) for number in (5, 0)]
    assert followed.life.values.tolist() == [5, 0]
    assert followed.sizes["record"] >= 60
    sizes = {"quantile": 3, "motion": 2, "fraction": len(FRACTIONS)}
    assert {name: followed.sizes[name] for name in sizes} == sizes
    assert followed.horizon.values.tolist() == [600, 600]
    for name in ("change", "failure", "ratio", "changed"):
        assert followed[name].values.tolist() == [getattr(life, name) for life in lives]
    assert followed.words.values.tolist() == [life.limit.words for life in lives]
    for i, each in enumerate(lives):
        row, count = followed.isel(life=i), each.failure // 5
        numbers = row.operation.values
        np.testing.assert_array_equal(numbers[:count], 5 * np.arange(1, count + 1))
        per_record = [name for name in row.data_vars if "record" in row[name].dims]
        assert len(per_record) == 8
        for name in per_record:  # nothing after the failure, something before
            values = row[name].values
            assert np.isnan(values[count:]).all(), name
            assert not np.isnan(values[:count]).any(), name
        way = each.change + np.array(FRACTIONS) * (each.failure - each.change)
        assert np.all(np.abs(numbers[row.record_at.values] - way) <= 2.5)
    assert np.isnan(followed.operation.values[0, -1])  # a life that ends early is among them
    assert set(np.unique(followed.alarm.values[:, :50])) <= {0.0, 1.0}
    for name in ("change_probability", "toward"):
        values = followed[name].values[:, :50]
        assert np.all((values >= 0) & (values <= 1))
    assert np.all(followed.lives.values >= 0)
    assert np.all(followed.remaining.values[:, :50] >= 0)


def test_alarms_at_the_level_of_the_configuration_are_the_alarms(followed, short):
    assert short[1]["alarm_level"] in followed.level
    own = followed.alarm_at.sel(level=short[1]["alarm_level"], drop=True)
    np.testing.assert_array_equal(own, followed.alarm)
    counts = followed.alarm_at.sum("record")
    assert np.all(counts.isel(level=0) > 0)  # where any doubt will do
    first = followed.alarm_at.argmax("record").where(counts > 0)
    assert not np.any(first.diff("level") < 0)


def test_draws_and_remaining_are_of_the_same_prediction(followed):
    """At the record of each fraction the median is the middle one of the draws, of 20 the tenth."""
    for i in range(2):
        row = followed.isel(life=i)
        median = row.remaining.values[row.record_at.values, 1]
        np.testing.assert_array_equal(median, np.sort(row.lives.values, axis=1)[:, 9])


def test_what_covers_is_told_of_each_widening(followed, short):
    """That of ``wear_model`` as of the predictions themselves; four times as wide covers more."""
    assert followed.covered.dims == ("life", "fraction", "widening")
    for i in range(2):
        row = followed.isel(life=i)
        truth = int(row.failure) - row.operation.values[row.record_at.values]
        lower, _, upper = row.remaining.values[row.record_at.values].T
        covered = row.covered.sel(widening=WIDER[1]).values
        np.testing.assert_array_equal(covered, (lower <= truth) & (truth <= upper))
    assert followed.covered.sum(["life", "fraction"]).values[-1] >= 9


def test_a_trend_to_the_limit_is_seen_near_the_end(followed):
    """Not a score, a sign of life: with 90 % of the way gone, the end is in sight."""
    at_end = [followed.remaining.values[i, r, 1] for i, r in enumerate(followed.record_at[:, -1])]
    assert np.all(np.array(at_end) < 100)


def test_a_life_is_followed_alike_in_any_company(followed, rough, short):
    alone = follow_lives(rough, [0], *short, seed=1, widenings=WIDER)
    xr.testing.assert_identical(alone, followed.sel(life=[0]))


def test_lives_that_are_followed_can_be_scored(followed):
    data, table = score(followed, toward=0.95, settle=30)
    assert data.sizes["life"] == 2
    assert table.set_index("score").value["lives"] == 2
