"""Figures over the operations: evolution, health, change points, remaining life."""

import numpy as np
import pytest
import xarray as xr

from breaker.figures import style
from breaker.figures.changepoint import changepoint
from breaker.figures.evolution import FLAGS, evolution
from breaker.figures.health import health
from breaker.figures.remaining_life import remaining_life
from breaker.figures.truth import TRUTH
from breaker.figures.words import symbolic
from breaker.mechanism.parameters import NAMES
from breaker.model.randomness import generator
from tests.figures.drawn import (
    assert_nothing_overlaps,
    bands,
    boxes,
    line_of,
    segments,
    words,
    written,
)

QUANTILES = [0.05, 0.5, 0.95]
BOUNDS = ["lower", "upper"]
LIMITS = {
    "slow_closing": "touch_time above 10 ms",
    "tired_closing": "f below 0.77 mm/ms² and touch_time above 9.8 ms",
    "little_wipe": "wipe below 3 mm",
    "slow_opening": "opening_speed below 1.1 mm/ms",
    "rough_drive": "gamma_a above 0.5 1/ms",
    "three_parts": "over_travel above 4 mm and k_a above 0.05 1/ms² and gamma_b above 0.3 1/ms",
    "eroded_contacts": "L below 9 mm",
    "tired_contact_spring": "k_b below 0.03 1/ms²",
}
STEPPED = "closing: the end of the stroke changed at operation 1,204 (0.42 mm)"


def limits(count):
    return list(LIMITS)[:count], ("limit", list(LIMITS.values())[:count])


def health_data(count=4, operations=200, *, alarms=True, unusable=0.04):
    """Limits of which the first two raise an alarm, the second of two parts."""
    rng, operation = generator(31, "test", "health"), np.arange(1, operations + 1)
    names, words_of = limits(count)
    trend = np.linspace(0.0, np.array([1.0, 0.98, *[0.3] * 6])[:count] * alarms, operations)
    single = np.clip(trend + 0.1 * rng.standard_normal(trend.shape), 0.0, 1.0)
    single[rng.random(operations) < unusable] = np.nan
    marginal = single.copy()
    marginal[:, 1:2] **= 1.4
    on = trend >= 0.95
    each = ("operation", "limit")
    return xr.Dataset(
        {
            "probability": (each, single),
            "marginal": (each, marginal),
            "level_probability": (each, trend),
            "exceeded": (each, on),
            "since": ("limit", [operation[o].min() if o.any() else np.nan for o in on.T]),
            "words": words_of,
            "source": ("limit", ["both"] * count),
        },
        {"operation": operation, "limit": names},
        {"raise": 0.95, "clear": 0.5, "after": 3},
    )


def trend_data(operations=200, changes=(0.6,), count=4, steps=()):
    """Seven tracked parameters, their changes, and limits of which the second has no trend."""
    rng, operation = generator(32, "test", "trend"), np.arange(1, operations + 1)
    names, words_of = limits(count)
    starts = np.round(np.array(changes) * operations)
    level = rng.uniform(1.0, 2.0, (operations, 7))
    latest = np.full(operations, np.nan)
    for start in starts:
        latest[operation >= start + 4] = start
    failure = np.array([1.1, 1.6, 0.98, 1.3, 1.2, 2.0, 0.9, 1.4])[:count] * operations
    left = np.maximum(failure - operation[:, None], 0.0)[..., None]
    toward = (operation[:, None] > starts.min(initial=operations)) & (np.arange(count) != 1)
    each, bounds = ("operation", "parameter"), [-0.1, 0.2]
    data = xr.Dataset(
        {
            "level": (each, level),
            "level_interval": ((*each, "bound"), level[..., None] + bounds),
            "median": (each, level + 0.3 * rng.standard_normal(level.shape)),
            "start_interval": (("operation", "quantile"), latest[:, None] + [-3.0, 0.0, 2.0]),
            "change_probability": ("operation", rng.random(operations)),
            "alarm": ("operation", np.isin(operation, starts + 4)),
            "change_alarm": ("change", starts + 4),
            "change_start": ("change", starts),
            "change_interval": (("change", "bound"), starts[:, None] + [-3.0, 2.0]),
            "change_parameters": ("change", ["gamma_a, f"] * len(starts)),
            "jump_noticed": ("jump", np.array(steps, dtype=int) + 1),
            "jump_from": ("jump", np.array(steps, dtype=int)),
            "jump_words": ("jump", np.array([STEPPED] * len(steps), dtype=str)),
            "told": (
                ("operation", "limit", "quantile"),
                np.where(toward[..., None], left * [0.7, 0.9, 1.3] + [0, 1, 4], np.nan),
            ),
            "words": words_of,
        },
        {
            "operation": operation,
            "parameter": list(NAMES),
            "bound": BOUNDS,
            "limit": names,
            "quantile": QUANTILES,
        },
        {"alarm_level": 0.9, "horizon": 1.2 * operations, "notice": 20},
    )
    return data.assign_attrs(source="both"), dict(zip(names, failure, strict=True))


def true_values(last):
    values = np.outer(np.linspace(1.0, 1.2, last), [2.0, 0.045, 0.04, 0.3, 0.12, 0.75, 10.0])
    return xr.DataArray(
        values,
        dims=("operation", "parameter"),
        coords={"operation": np.arange(1, last + 1), "parameter": list(NAMES)},
    )


def drawn_truth(axis):
    """Values of the marks of the stand-in's truth, if there are any."""
    return [line.get_ydata() for line in axis.lines if line.get_gid() == TRUTH]


@pytest.mark.parametrize("count", [1, 8])
def test_health_shows_each_limit_as_it_is(count):
    data = health_data(count)
    figure = health(data)
    assert len(figure.axes) == count
    assert_nothing_overlaps(figure)
    for axis, limit in zip(figure.axes, LIMITS, strict=False):
        one = data.sel(limit=limit)
        dots = line_of(axis, style.MODEL, "o")
        np.testing.assert_array_equal(dots.get_ydata(), one.probability)
        trend = line_of(axis, style.MODEL, ".")
        np.testing.assert_array_equal(trend.get_xdata(), one.operation)
        np.testing.assert_array_equal(trend.get_ydata(), one.level_probability)
        missing = line_of(axis, style.REFERENCE, "|").get_xdata()
        np.testing.assert_array_equal(missing, one.operation[one.probability.isnull()])
        marginal = [line for line in axis.lines if line.get_marker() == "D"]
        assert len(marginal) == (limit == "tired_closing")
        for line in marginal:
            np.testing.assert_array_equal(line.get_ydata(), one.marginal)
        levels = {line.get_ydata()[0] for line in axis.lines if line.get_linestyle() == "--"}
        assert levels == {0.95, 0.5}
        first = one.since.item()
        told = f"exceeded since {first:,.0f}" if np.isfinite(first) else "not exceeded"
        assert written(axis) == [told, "from both motions"]
        expected = [(first - 0.5, 200.5)] if np.isfinite(first) else []
        assert boxes(axis, style.WARNING) == expected
        title = axis.get_title("left").replace("\n", " ")
        assert title == f"{limit}: {symbolic(one.words.item())}"
    assert ("as if parts were independent" in words(figure)) == (count > 1)
    assert f"limits exceeded: {min(count, 2)} of {count}" in figure.get_suptitle()


def test_health_without_alarm_and_without_anything_usable():
    data = health_data(2, 30, alarms=False, unusable=0.0)
    figure = health(data)
    assert figure.get_suptitle().endswith("no limit is exceeded")
    for word in ("exceeded since", "not usable"):
        assert word not in words(figure)
    assert_nothing_overlaps(figure)
    data["level_probability"][:] = np.nan
    data["probability"][:] = np.nan
    data["marginal"][:] = np.nan
    figure = health(data)
    assert "not usable" in words(figure)
    assert "as if parts" not in words(figure)
    assert_nothing_overlaps(figure)


def test_health_begins_shortly_before_something_happens():
    """Limits that stay where they are do not count, wherever that is; nor what is known first."""
    data = health_data(3, 200, unusable=0.0)
    level = np.tile([0.0, 0.4, 0.1], (200, 1))
    level[170:, 0], level[:3] = 0.6, 0.5
    data = data.assign(level_probability=(("operation", "limit"), level))
    data["exceeded"][:] = False
    data["since"][:] = np.nan
    figure = health(data)
    assert "shown from operation 156, nothing happened before" in figure.get_suptitle()
    for axis in figure.axes:
        assert line_of(axis, style.MODEL, ".").get_xdata().tolist() == [*range(156, 201)]
    data["exceeded"][1] = True  # from the start, at least for once
    assert line_of(health(data).axes[0], style.MODEL, ".").get_xdata()[0] == 1
    assert_nothing_overlaps(health(data.isel(operation=[0])))


def test_alarm_that_goes_off_and_on_again():
    data = health_data(1, 30)
    data["exceeded"][:] = (np.isin(np.arange(30), [3, 4, 20]))[:, None]
    data["source"] = ("limit", ["closing"])
    figure = health(data)
    assert boxes(figure.axes[0], style.WARNING) == [(3.5, 5.5), (20.5, 21.5)]
    assert "from closing" in written(figure.axes[0])
    data["source"] = ("limit", ["record"])
    assert "as measured" in written(health(data).axes[0])


def starts_drawn(axis):
    return [line.get_xdata()[0] for line in axis.lines if line.get_color() == "#7A35D0"]


@pytest.mark.parametrize(
    ("changes", "title"), [((), "no change found"), ((0.25, 0.5, 0.8), "3 changes found")]
)
def test_changes_are_drawn_where_they_are_and_told(changes, title):
    data, _ = trend_data(200, changes)
    figure = changepoint(data, source="opening")
    assert figure.get_suptitle().startswith("Opening: change points of the wear\nfollowed: ")
    assert figure.get_suptitle().endswith(f"\n{title}")
    assert_nothing_overlaps(figure)
    *series, told, ages, probability = figure.axes
    assert len(series) == len(NAMES)
    for axis, name in zip(series, NAMES, strict=True):
        one, mark = data.sel(parameter=name), style.COLOURS[name]
        np.testing.assert_array_equal(line_of(axis, mark, "o").get_ydata(), one["median"])
        np.testing.assert_array_equal(line_of(axis, mark, "None").get_ydata(), one.level)
        low, high = axis.collections[0].get_datalim(axis.transData).intervaly
        assert (low, high) == pytest.approx(
            (one.level_interval.values.min(), one.level_interval.values.max())
        )
    for axis in (*series, ages, probability):
        assert starts_drawn(axis) == data.change_start.values.tolist()
        np.testing.assert_allclose(
            np.reshape(boxes(axis, "#7A35D0"), (-1, 2)), data.change_interval
        )
    known = data.start_interval.sel(quantile=0.5).fillna(1.0)  # from the first operation before
    drawn = line_of(ages, style.WARNING).get_ydata()
    np.testing.assert_array_equal(drawn, data.operation - known)
    alarms = line_of(probability, style.WARNING, "v").get_xdata()
    np.testing.assert_array_equal(alarms, data.change_alarm)
    expected = ["No change found."] if not changes else []
    for start, alarm in zip(data.change_start.values, data.change_alarm.values, strict=True):
        expected.append(f"operation {start:.0f} ({start - 3:.0f} to {start + 2:.0f})")
        expected.append(rf"   $\gamma_a$, $f$; alarm at {alarm:.0f}")
    assert written(told) == expected
    assert "stand-in" not in words(figure)


def test_many_changes_and_the_stand_in():
    data, _ = trend_data(30, tuple(np.linspace(0.1, 0.9, 8)))
    truth = true_values(30)
    figure = changepoint(data, source="both", truth=truth.sel(parameter=["f", "L"]))
    assert written(figure.axes[7])[-1] == "and 2 more"
    assert figure.get_suptitle().startswith("Both motions: ")
    drawn = [drawn_truth(axis) for axis in figure.axes]
    assert [len(lines) for lines in drawn[:7]] == [0, 0, 0, 0, 0, 1, 1]
    np.testing.assert_array_equal(drawn[5][0], truth.sel(parameter="f"))
    assert "stand-in" in words(figure)
    assert_nothing_overlaps(figure)


def test_steps_are_drawn_where_they_are_and_told_first():
    data, _ = trend_data(200, (0.25, 0.5), steps=(120,))
    figure = changepoint(data, source="both")
    assert figure.get_suptitle().endswith("\n2 changes found, 1 step")
    assert_nothing_overlaps(figure)
    *series, told, ages, probability = figure.axes
    for axis in (*series, ages, probability):
        drawn = [line.get_xdata()[0] for line in axis.lines if line.get_linestyle() == ":"]
        assert drawn == [120]
    assert line_of(probability, style.MEASURED, "D").get_xdata().tolist() == [121]
    said = written(told)
    assert " ".join(said[:2]).split() == STEPPED.split()
    assert len(said) == 2 + 2 * 2
    right = max(text.get_window_extent().x1 for text in told.texts)
    assert right < figure.bbox.width
    assert "step noticed" in words(figure)
    assert "step" not in words(changepoint(trend_data(200)[0], source="both"))


def test_ages_that_are_not_known_any_more_are_a_gap():
    data, _ = trend_data(60, (0.5,))
    data.start_interval[50] = np.nan
    drawn = line_of(changepoint(data, source="closing").axes[8], style.WARNING).get_ydata()
    assert np.flatnonzero(np.isnan(drawn)).tolist() == [50]


def test_dots_and_the_first_band_do_not_dwarf_the_level():
    """A dot far away, and a prior a hundred times as wide as what is known later, are cut off."""
    data, _ = trend_data(200)
    data.level_interval[0] += np.array([-100.0, 100.0])
    data["median"][7] = 50.0
    truth = true_values(200).sel(parameter=["L"])
    figure = changepoint(data, source="opening", truth=truth)
    for axis, name in zip(figure.axes, NAMES, strict=False):
        low, high = axis.get_ylim()
        assert low < data.level.sel(parameter=name).min()
        assert high > data.level.sel(parameter=name).max()
        assert low > -1.0
        assert high < (14.0 if name == "L" else 4.0)  # the truth of L is never cut off
    assert figure.axes[6].get_ylim()[1] > truth.max()


def test_a_single_operation_has_a_figure():
    data, _ = trend_data(1, ())
    assert_nothing_overlaps(changepoint(data, source="closing", truth=true_values(1)))


def life_data(operations=200, count=4, *, truth=True):
    """Limits told from 60 % of the life on, the second never; the third is exceeded near the end.

    In truth the fourth limit is never reached; with the change of the wear, the others are sooner.
    """
    data, failure = trend_data(operations, count=count)
    told = data.told.values
    told[operations - 8 :, 2:3] = 0.0
    data = data.assign(told=(data.told.dims, told))
    if not truth:
        return data
    failure = np.array([*failure.values()])
    failure[3:4] = np.nan
    without = np.where(np.arange(count) == 1, np.nan, failure + 50.0)
    true = {"failure": ("limit", failure), "failure_without": ("limit", without)}
    return data.assign(true | {"changed": 0.6 * operations})


def test_operations_left_and_both_truths_are_drawn_where_they_are():
    data = life_data()
    figure = remaining_life(data)
    assert_nothing_overlaps(figure)
    assert figure.get_suptitle() == "Both motions: operations left until a limit is exceeded"
    for axis, limit in zip(figure.axes, data.limit.values, strict=False):
        one = data.sel(limit=limit)
        assert axis.get_yscale() == "linear"
        assert axis.get_ylim()[1] > one.failure_without.fillna(one.failure).fillna(0.0)  # its own
        middle = one.told.sel(quantile=0.5).values
        expected = np.where(one.told.sel(quantile=0.95) > 0, middle, np.nan)
        np.testing.assert_array_equal(line_of(axis, "#2166AC").get_ydata(), expected)
        drawn = {
            line.get_linestyle(): line.get_data()
            for line in axis.lines
            if line.get_color() == style.MEASURED
        }
        for kind, name in (("--", "failure"), (":", "failure_without")):
            assert (kind in drawn) == bool(one[name].notnull())
            if kind in drawn:
                np.testing.assert_allclose(np.sum(drawn[kind], axis=0), one[name])
        if ":" in drawn:
            assert drawn[":"][0].max() < 120 <= drawn["--"][0].max()  # until the change
        assert ("(in truth not reached)" in axis.get_title("left")) == (limit == "slow_opening")
        assert bool(boxes(axis, style.WARNING)) == (limit == "little_wipe")
        assert bool(boxes(axis, style.PRIOR)) == bool(one.told.isnull().any())
    text = words(figure)
    for word in ("notice: 20 operations", "truth without the change", "exceeded", "no trend"):
        assert word in text


def test_what_happens_near_a_limit_is_shown_once_more():
    data = life_data()
    *whole, first, third = remaining_life(data).axes  # both have few left, the others many
    assert len(whole) == 4
    assert first.get_xlim() == (180, 200)
    low, high = third.get_xlim()  # in truth at 196
    assert low < 192 < high <= 200
    assert first.get_ylim() == third.get_ylim() == (0.0, 30.0)
    few = remaining_life(life_data(20))
    assert len(few.axes) == 4
    assert_nothing_overlaps(few)


def test_what_is_beyond_the_horizon_leaves_the_panel():
    data = life_data(30, 1, truth=False)
    data["told"][:, 0] = [10.0, 20.0, np.inf]
    data["told"][4] = np.nan
    data["told"][20:, 0] = np.inf
    figure = remaining_life(data.assign_attrs(horizon=1000.0, source="closing"))
    axis = figure.axes[0]
    middle = line_of(axis, "#2166AC").get_ydata()
    assert np.flatnonzero(np.isnan(middle)).tolist() == [4]
    assert middle[:4].tolist() == [20.0] * 4
    assert np.all(middle[20:] > axis.get_ylim()[1])
    low, high = axis.collections[0].get_datalim(axis.transData).intervaly
    assert low == 10.0
    assert high > axis.get_ylim()[1] > 20.0
    assert boxes(axis, style.PRIOR) == [(4.5, 5.5)]
    assert "truth" not in words(figure)
    assert_nothing_overlaps(figure)


@pytest.mark.parametrize(("count", "operations"), [(8, 100), (1, 1), (2, 3)])
def test_no_trend_at_all_and_limits_exceeded_from_the_start(count, operations):
    data = life_data(operations, count, truth=False).assign_attrs(source="separate")
    data["told"][:] = np.nan
    figure = remaining_life(data)
    assert figure.get_suptitle().startswith("Each motion by itself: ")
    for axis in figure.axes:
        assert boxes(axis, style.PRIOR) == [(0.5, operations + 0.5)]
        assert np.isnan(line_of(axis, "#2166AC").get_ydata()).all()
    assert_nothing_overlaps(figure)
    data["told"][:] = 0.0
    figure = remaining_life(data)
    assert [boxes(axis, style.WARNING) for axis in figure.axes] == [
        [(0.5, operations + 0.5)]
    ] * count
    assert_nothing_overlaps(figure)


# ---- evolution -------------------------------------------------------------------------------


@pytest.mark.parametrize("corrected", [True, False])
def test_evolution_draws_medians_bands_and_flags(corrected):
    """Of 60 operations 9 are rejected, one in five is not resolved and all others do not fit."""
    names, operation = ["mu", "f", "onset"], np.arange(1, 61)
    accepted = operation % 7 != 4
    middle = generator(34, "test", "evolution").uniform(1, 2, (60, 3))
    middle[~accepted] = np.nan
    dims = ("operation", "output", "bound")
    data = xr.Dataset(
        {
            "median": (dims[:2], middle),
            "interval_50": (dims, middle[..., None] + [-0.1, 0.1]),
            "interval_95": (dims, middle[..., None] + [-0.3, 0.4]),
            "accepted": ("operation", accepted),
            "misfit": ("operation", accepted),
            "outside_prior": ("operation", operation > 56),
        },
        {"operation": operation, "output": names, "bound": BOUNDS},
    )
    if corrected:
        data = data.assign(resolved=("operation", operation % 5 != 1))
    truth = true_values(60) if corrected else None
    figure = evolution(data, motion="closing", truth=truth)
    flagged = {
        "misfit": accepted,
        "outside_prior": operation > 56,
        "unresolved": corrected & accepted & (operation % 5 == 1),
        "rejected": ~accepted,
    }
    for axis, name in zip(figure.axes, names, strict=True):
        one = data.sel(output=name)
        dots = line_of(axis, style.COLOURS[name])
        np.testing.assert_array_equal(dots.get_ydata(), one["median"])
        wide, narrow = bands(axis)
        for drawn, interval in ((wide, one.interval_95), (narrow, one.interval_50)):
            np.testing.assert_allclose(drawn, (interval.min(), interval.max()))
        low, high = axis.get_ylim()
        for flag, (colour, _) in FLAGS.items():
            strips = segments(axis, colour) if flagged[flag].any() else []
            for strip in strips:
                np.testing.assert_array_equal(strip[:, 0, 0], operation[flagged[flag]])
                assert 0.0 < strip[..., 1].max() < (wide[0] - low) / (high - low)
        lines = drawn_truth(axis)
        assert len(lines) == (corrected and name != "onset")
        for line in lines:
            np.testing.assert_array_equal(line, truth.sel(parameter=name))
        assert axis.get_ylabel() == style.parameter(name).label
    text = words(figure)
    assert "does not fit the model: 51 of 60" in text
    assert "rejected by the reader: 9 of 60" in text
    assert ("not resolved" in text) == corrected
    assert_nothing_overlaps(figure)
