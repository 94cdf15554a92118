"""The trend of a drive: what it is for, its state between runs, changes, and what is missing."""

import numpy as np
import pytest
import xarray as xr
from scipy.stats import chi2, norm

from breaker.mechanism.limits import from_list
from breaker.mechanism.parameters import MOTIONS, NAMES
from breaker.model.fisher import climb
from breaker.model.randomness import generator
from breaker.stores import describe, save
from breaker.wear.changepoint import KINDS
from breaker.wear.rows import age_bins
from breaker.wear.series import likelihood, series_of
from breaker.wear.state import State
from breaker.wear.trend import Follower
from tests.wear.parts import part, recorded

P = len(NAMES)
MU, GAMMA_A, GAP = (NAMES.index(name) for name in ("mu", "gamma_a", "L"))
LIMITS = [
    {"name": "wide", "motion": "closing", "upper": {"L": 11.5}},
    {"name": "rough", "motion": "closing", "upper": {"gamma_a": 0.5}, "lower": {"f": 0.9}},
]
NONE = [{"name": "far", "motion": "closing", "upper": {"L": 30.0}}]
SCATTER = 0.001  # share of a parameter; one of the model's candidates


def one(index, value):
    return value * (np.arange(P) == index)


@pytest.fixture(scope="module")
def settings(defaults):
    """A baseline of 20 operations, and fewer lines, for speed."""
    return defaults["wear_model"] | {"baseline": 20, "settle": 20, "lines": 30}


@pytest.fixture(scope="module")
def without_changes(settings):
    """The same for a wear that is known never to change its rate: exact but for the scatter."""
    return settings | {"operations_between_changes": np.inf}


def follower_of(models, settings, motions=("closing",), limits=NONE):
    used = {motion: models[motion] for motion in motions}
    return Follower.from_settings(used, from_list(limits, motions), settings, 1)


def live(models, operations, level, slope, rng, motions=("closing",), bend=None):
    """Records of a drive with a trend: standardised level at first, slope in 1,000 operations.

    ``bend`` is the operation of a change, and by how much the slope changes, ``(p,)``.
    """
    z = level + slope * (operations - operations[0])[:, None] / 1000
    if bend:
        z = z + bend[1] * np.maximum(operations - bend[0], 0)[:, None] / 1000
    used = {motion: models[motion] for motion in motions}
    return recorded(used, operations, z, rng, scatter=SCATTER), z


def run(follower, series):
    return follower.follow(follower.begin(series), series)


# ---- what it is for --------------------------------------------------------------------------

OPERATIONS = 1 + 10 * np.arange(150)
LEVEL = one(MU, -1.5) + one(GAP, 1.5)
SLOPE = one(MU, 0.6) + one(GAP, -1.0)


@pytest.fixture(scope="module")
def weak(models):
    """Closings, which hardly tell mass ratio and gap, of a drive off the prior in both."""
    return live(models, OPERATIONS, LEVEL, SLOPE, generator(1, "test trend"))


def scores(follower, state, z, slope):
    """Errors of level and slope in their own sds, ``(2 p,)``."""
    mean, cov = state.hypotheses.level()
    return (mean - np.concatenate([z[-1], slope])) / np.sqrt(np.diag(cov))


def test_a_weak_parameter_is_followed_not_its_prior(weak, models, settings):
    """Level and slope of mass ratio and gap, by the stated 90 % intervals: false alarm 1e-3."""
    series, z = weak
    state, found = run(follower_of(models, settings), series)
    prior, last = models["closing"].prior, found.isel(operation=-1)
    np.testing.assert_allclose(last.slope, 100 * prior.log_sds * state.hypotheses.level()[0][P:])
    bound = norm.isf(0.5e-3 / 4) / 1.6449  # of four errors, in half widths of the interval
    for i in (MU, GAP):
        ends = np.log(last.level_interval.values[i])
        error = np.log(last.level.values[i]) - np.log(prior.destandardise(z[-1])[i])
        assert abs(error) < bound * (ends[1] - ends[0]) / 2
        ends = last.slope_interval.values[i]
        error = last.slope.values[i] - 100 * prior.log_sds[i] * SLOPE[i]
        assert abs(error) < bound * (ends[1] - ends[0]) / 2
        # Narrower than one operation, whose sd is above 0.7 of the prior's, could ever be.
        assert np.ptp(np.log(last.level_interval.values[i])) < 2 * 1.6449 * 0.65 * prior.log_sds[i]


def test_means_of_single_posteriors_are_pulled_to_the_prior(weak, models):
    """The fault: a line through the modes of 150 posteriors, each of which counts the prior."""
    series, z = weak
    used, begin = {"closing": models["closing"]}, series.outputs["closing"]
    onsets = {"closing": begin[:, P]}
    prior = np.zeros(P), np.eye(P)
    found, _, _ = climb(used, series.records, begin[:, :P], onsets, *prior, moves=3)
    design = np.column_stack([np.ones(150), (OPERATIONS - OPERATIONS[-1]) / 1000])
    line, *_ = np.linalg.lstsq(design, found, rcond=None)
    variance = np.square(found - design @ line).sum(axis=0) / 148
    errors = np.sqrt(np.diag(np.linalg.inv(design.T @ design))[:, None] * variance)
    off = (found.mean(axis=0) - z.mean(axis=0)) / np.sqrt(variance / 150)
    assert off[MU] > 10  # both towards the prior
    assert off[GAP] < -8
    assert (line[1] - SLOPE)[GAP] / errors[1, GAP] > 5  # and so is a slope


def squares(models, settings, motions, drives=8, count=40):
    """Squared distance of level and slope from the truth, of drives from the model of wear.

    Levels are drawn within 0.7 sds of the prior, where nothing ends: the sum is smaller by a few
    per cent than by a prior that is believed to be wider.
    """
    follower = follower_of(models, settings | {"slope_sd": 0.2, "lines": 2}, motions)
    square, operations = 0.0, 1 + 10 * np.arange(count)
    for i in range(drives):
        rng = generator(2, "test trend", i)
        level, slope = 0.7 * rng.standard_normal(P), 0.2 * rng.standard_normal(P)
        series, z = live(models, operations, level, slope, rng, motions=motions)
        state, _ = run(follower, series)
        mean, cov = state.hypotheses.level()
        off = mean - np.concatenate([z[-1], slope])
        square += off @ np.linalg.solve(cov, off)
    return square, chi2(2 * P * drives)


def test_trends_are_calibrated(models, without_changes):
    """Of both motions, chi-square of 14 a drive: false alarm 1e-3."""
    square, law = squares(models, without_changes, MOTIONS)
    assert law.sf(square) > 0.5e-3
    assert law.cdf(1.2 * square) > 0.5e-3


def test_trends_of_one_motion_are_calibrated_as_widened(models, without_changes):
    """What closings alone say bends, which linear likelihoods leave out: predictions are widened.

    Chi-square by the factor of the configuration, false alarm 1e-3.
    """
    square, law = squares(models, without_changes, ("closing",), 5, 30)
    assert law.sf(square / without_changes["widening"] ** 2) > 0.5e-3
    assert law.cdf(1.2 * square) > 0.5e-3


def test_counting_the_prior_once_an_operation_is_caught(models, without_changes, monkeypatch):
    """The fault: what an operation adds to the trend is its posterior."""

    def posterior(*args):
        matrix, slope, centre = likelihood(*args)
        return matrix + np.eye(P), slope - centre, centre

    monkeypatch.setattr("breaker.wear.trend.likelihood", posterior)
    square, law = squares(models, without_changes, MOTIONS)
    assert law.sf(square) < 1e-5


# ---- a change, and a run that is interrupted -------------------------------------------------

CHANGE = 401  # operation, the 40th of 100
WEAR = one(GAMMA_A, 2.5)  # standardised in 1,000 operations: 50 %


@pytest.fixture(scope="module")
def bent(models):
    """Operations of which the friction of the drive begins to rise; every 17th has no record."""
    operations = 1 + 10 * np.arange(100)
    series, z = live(
        models,
        operations,
        one(GAP, 0.5),
        np.zeros(P),
        generator(4, "test trend"),
        bend=(CHANGE, WEAR),
    )
    series.records["closing"][5::17] = np.nan
    series.outputs["closing"][5::34] = np.nan
    return series, z


CHANGE_LIMITS = [
    {"name": "rough", "motion": "closing", "upper": {"gamma_a": 0.48}},
    {"name": "smooth", "motion": "closing", "lower": {"gamma_a": 0.25}},
    {"name": "region", "motion": "closing", "upper": {"gamma_a": 0.45, "L": 9.0}},
]


@pytest.fixture(scope="module")
def whole(bent, models, settings):
    return run(follower_of(models, settings, limits=CHANGE_LIMITS), bent[0])


def test_a_change_is_noticed(whole):
    """Once, soon, in the right parameter, and when. The interval holds the change with 90 %; one of
    its width on each side with more than 0.999."""
    state, found = whole
    alarms = found.operation.values[found.alarm.values]
    assert len(alarms) == 1
    assert CHANGE < alarms[0] < CHANGE + 200
    assert state.alarms == (alarms[0],)
    assert state.since == alarms[0]
    last = found.isel(operation=-1)
    assert last.kind.values[last.kind_probability.values.argmax()] == "gamma_a"
    assert last.kind_probability.max() > 0.9
    low, middle, high = last.start_interval.values
    assert low <= middle <= high
    width = max(high - low, 10)
    assert low - width < CHANGE < high + width
    assert width < 400
    before = found.sel(operation=slice(0, CHANGE))
    assert before.change_probability.max() < 0.95
    assert np.isnan(before.start_interval).all()
    np.testing.assert_allclose(found.run_length_probability.sum("age"), 1.0, atol=1e-6)
    middles = (last.age_lower.values[:-1] + last.age_upper.values[:-1]) / 2
    ages = last.run_length_probability.values[:-1] @ middles
    assert abs(ages - (last.operation - CHANGE)) < 150


def test_a_change_is_not_told_to_begin_after_its_alarm(whole):
    state, found = whole
    assert found.start_interval.values[-1, 2] <= state.since


def test_remaining_life_after_a_change(whole, bent, models):
    """To what the trend leads, in the operations that are left: of 0.48 / 0.3, in logs. To within
    four times the half width on either side; what the trend leads away from is never reached."""
    _, found = whole
    last, before = found.isel(operation=-1), found.sel(operation=CHANGE)
    prior = models["closing"].prior
    end = np.log(0.48 / prior.destandardise(bent[1][-1])[GAMMA_A]) / (0.5 / 1000)
    low, middle, high = last.remaining.sel(limit="rough").values
    assert 0 < low < middle < high < np.inf
    assert middle - 4 * (middle - low) < end < middle + 4 * (high - middle)
    assert last.toward.sel(limit="rough") > 0.9
    assert last.toward.sel(limit="smooth") < 0.1
    assert np.all(last.remaining.sel(limit="smooth") == np.inf)
    assert last.remaining.sel(limit="region", quantile=0.5) < middle
    assert before.toward.sel(limit="rough") < 0.9
    assert found.beyond.values.max() <= 1.0
    assert last.beyond.sel(limit="rough") < 0.01
    value = last.value.values[found.part_quantity.values == "gamma_a"][0]
    truth = prior.destandardise(bent[1][-1])[GAMMA_A]
    assert value[0] - 2 * np.ptp(value) < truth < value[2] + 2 * np.ptp(value)


def test_operations_that_cannot_be_used_are_passed_over(whole, bent):
    """They have a row, from what came before, that says less; and no outlier probability."""
    _, found = whole
    missing = np.isnan(bent[0].records["closing"]).any(axis=1)
    assert missing.sum() == 6
    np.testing.assert_array_equal(np.isnan(found.outlier.values), missing)
    assert found.sizes["operation"] == 100
    for name in ("level", "slope", "level_interval", "scatter", "remaining", "toward", "beyond"):
        assert np.isfinite(np.minimum(found[name].values, 1e9)).all(), name
    # Parameters are a little less sure after them, by the drift.
    width = np.log(found.level_interval.values) @ [-1, 1]
    assert np.all(width[missing] > width[np.flatnonzero(missing) - 1] * 0.9999)


@pytest.mark.parametrize("split", [30, 75])
def test_a_stored_state_goes_on_as_if_never_interrupted(
    split, bent, whole, models, settings, tmp_path
):
    """Bit by bit, before and after the alarm, through a store and a new process's objects."""
    series, _ = bent
    follower = follower_of(models, settings, limits=CHANGE_LIMITS)
    begun = follower.begin(series)
    state, first = follower.follow(begun, part(series, slice(0, split)))
    save(describe(state.to_dataset(), "state"), tmp_path / "state.zarr")
    save(describe(first, "trend"), tmp_path / "first.zarr")
    again = State.from_dataset(xr.open_zarr(tmp_path / "state.zarr"))
    assert again.reference.agreement == state.reference.agreement
    other = follower_of(models, settings, limits=CHANGE_LIMITS)
    end, second = other.follow(again, part(series, slice(split, None)))
    joined = xr.concat(
        [xr.open_zarr(tmp_path / "first.zarr").load(), second],
        dim="operation",
        data_vars="minimal",
        combine_attrs="drop",
    )
    xr.testing.assert_identical(joined, whole[1])
    xr.testing.assert_identical(end.to_dataset(), whole[0].to_dataset())


def test_an_outlier_teaches_nothing(models, without_changes):
    """One record of another drive: known as one, and the trend is what it was without it."""
    operations = 1 + 10 * np.arange(40)
    series, _ = live(models, operations, LEVEL, SLOPE, generator(5, "test trend"))
    foreign, _ = live(models, operations, one(GAMMA_A, 3.0), SLOPE, generator(6, "test trend"))
    mixed = part(series, np.arange(40))
    mixed.records["closing"][30] = foreign.records["closing"][30]
    lost = part(series, np.arange(40))
    lost.records["closing"][30] = np.nan
    follower, known = follower_of(models, without_changes), follower_of(models, without_changes)
    _, found = run(follower, mixed)
    _, expected = run(known, lost)
    assert found.outlier.values[30] > 0.999
    assert np.delete(found.outlier.values, 30).max() < 0.2
    np.testing.assert_allclose(found.level.values[-1], expected.level.values[-1], rtol=1e-3)


# ---- its ends --------------------------------------------------------------------------------


def test_motions_that_differ_are_not_followed_together(models, settings, tmp_path):
    """An empty trend with all its variables, also in later operations, after a stored state."""
    limits = [*CHANGE_LIMITS, {"name": "open", "motion": "opening", "upper": {"L": 11.0}}]
    follower = follower_of(models, settings, MOTIONS, limits)
    operations, rng = 1 + np.arange(6), generator(7, "test trend")
    series, _ = live(models, operations, LEVEL, SLOPE, rng, motions=MOTIONS)
    agreeing, followed = run(follower, series)
    assert follower.together(agreeing)
    assert followed.operation.values.tolist() == operations.tolist()
    other, _ = live(models, operations, LEVEL + one(GAMMA_A, 1.0), SLOPE, rng, motions=MOTIONS)
    series.records["closing"], series.outputs["closing"] = (
        other.records["closing"],
        other.outputs["closing"],
    )
    state, found = run(follower, series)
    assert not follower.together(state)
    assert state.seen == 0
    assert found.sizes["operation"] == 0
    assert found.limit.values.tolist() == ["rough", "smooth", "region", "open"]
    assert set(found.data_vars) == set(followed.data_vars)
    for name, each in followed.data_vars.items():
        assert (found[name].dims, found[name].dtype) == (each.dims, each.dtype)
    save(describe(found, "trend of both"), tmp_path / "trend.zarr")
    save(describe(state.to_dataset(), "state"), tmp_path / "state.zarr")
    again = State.from_dataset(xr.open_zarr(tmp_path / "state.zarr"))
    xr.testing.assert_identical(again.to_dataset(), state.to_dataset())
    _, later = follower.follow(again, series)
    assert later.sizes["operation"] == 0
    # Nor are they as long as there is no operation of both.
    series.outputs["opening"][:] = np.nan
    state, found = run(follower, series)
    assert state.reference is None
    assert found.sizes["operation"] == 0


def test_records_with_missing_samples_count(models, settings):
    """Only those without any sample do not; the others tell as finite a value as whole ones."""
    operations = 5 + np.arange(4)
    series, _ = live(models, operations, LEVEL, SLOPE, generator(8, "test trend"))
    series.records["closing"][1:3, ::5] = np.nan
    series.records["closing"][3] = np.nan
    assert series.usable("closing").tolist() == [True, True, True, False]
    follower = follower_of(models, settings)
    state, data = follower.follow(follower.begin(series), series)
    assert state.reference is not None
    assert np.isfinite(data["value"].values).all()


def test_no_alarm_before_the_trend_has_settled(models, settings):
    series, _ = live(models, 1 + np.arange(4), LEVEL, SLOPE, generator(12, "test trend"))
    eager = settings | {"alarm_level": 0.0, "settle": 3}
    _, found = run(follower_of(models, eager), series)
    assert found.alarm.values.tolist() == [False, False, True, True]


def test_no_trend_without_a_record(models, settings):
    operations = 5 + np.arange(3)
    series, _ = live(models, operations, LEVEL, SLOPE, generator(8, "test trend"))
    series.records["closing"][:] = np.nan
    follower = follower_of(models, settings)
    state, data = follower.follow(follower.begin(series), series)
    assert state.reference is None
    assert data.operation.values.tolist() == operations.tolist()
    for name in ("remaining", "toward", "beyond", "value"):
        assert np.isnan(data[name]).all()
    assert not data.alarm.any()
    # It begins with the first record that can be used, also after the state was stored.
    later, _ = live(models, operations + 3, LEVEL, SLOPE, generator(9, "test trend"))
    state, data = follower.follow(State.from_dataset(state.to_dataset()), later)
    assert state.reference is not None
    assert state.first == operations[0]
    assert np.isfinite(data.level).all()


def test_words_and_coordinates(whole):
    _, found = whole
    assert found.parameter.values.tolist() == list(NAMES)
    assert found.kind.values.tolist() == list(KINDS)
    assert found.words.values.tolist()[2] == "gamma_a above 0.45 1/ms and L above 9 mm"
    assert found.part_limit.values.tolist() == ["rough", "smooth", "region", "region"]
    assert found.part_quantity.values.tolist() == ["gamma_a", "gamma_a", "gamma_a", "L"]
    assert found.part_bound.values.tolist() == [0.48, 0.25, 0.45, 9.0]
    np.testing.assert_array_equal(found.age_lower.values[1:], found.age_upper.values[:-1])
    assert age_bins(50)[[0, 1, -2, -1]].tolist() == [0.0, 1.0, pytest.approx(50.0), np.inf]


def test_series_of_measured_operations(models, sensor):
    """Means of standardised draws; nothing of what cannot be used, whatever is stored of it."""
    rng, model = generator(10, "test trend"), models["closing"]
    z = 0.1 * rng.standard_normal((3, 50, P + 1))
    data = xr.Dataset(
        {
            "travel": (("operation", "time"), np.ones((3, sensor.samples), dtype=np.float32)),
            "draws": (("operation", "draw", "output"), model.destandardise(z).astype(np.float32)),
        },
        {"operation": [4, 5, 9]},
    )
    used = {"closing": model}
    series = series_of(used, {"closing": data}, {"closing": np.array([True, False, True])})
    assert series.operations.tolist() == [4, 5, 9]
    assert series.usable("closing").tolist() == [True, False, True]
    np.testing.assert_allclose(series.outputs["closing"][[0, 2]], z[[0, 2]].mean(axis=1), atol=1e-5)
    assert np.isnan(series.records["closing"][1]).all()
    assert np.isnan(series.outputs["closing"][1]).all()
