"""Figures of health, change points, remaining life, verdict and prognostics."""

from itertools import combinations

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex
from scipy.stats import beta

from breaker.figures import style
from breaker.figures.changepoint import change_words, changepoint
from breaker.figures.health import health
from breaker.figures.prognostics import prognostics
from breaker.figures.remaining_life import remaining_life
from breaker.figures.style import edges, spans
from breaker.figures.verdict import STATES, verdict
from breaker.mechanism.parameters import NAMES
from breaker.model.randomness import generator
from tests.figures.test_figures import SIGHT, assert_nothing_overlaps, lab, words

QUANTILES = [0.05, 0.5, 0.95]
BOUNDS = ["lower", "upper"]
KINDS = [*NAMES, "all"]
WORDS = [
    "touch_time above 10 ms",
    "f below 0.77 mm/ms² and touch_time above 9.8 ms",
    "wipe below 3 mm",
    "opening_speed below 1.1 mm/ms",
    "gamma_a above 0.5 1/ms",
    "over_travel above 4 mm and k_a above 0.05 1/ms² and gamma_b above 0.3 1/ms",
    "L below 9 mm",
    "k_b below 0.03 1/ms²",
]
LIMITS = [
    "slow_closing",
    "tired_closing",
    "little_wipe",
    "slow_opening",
    "rough_drive",
    "a_region_of_three_parts",
    "eroded_contacts",
    "tired_contact_spring",
]


def logistic(x):
    return 1.0 / (1.0 + np.exp(-x))


def health_data(count=4, operations=300, step=1, alarms=True, unusable=0.04):
    """Limits of which the first two raise an alarm, the second of two parts."""
    rng = generator(31, "test", "health")
    operation = 1 + step * np.arange(operations)
    rise = np.array([14.0, 9.0, 4.0, *[1.0] * 5])[:count]
    if not alarms:
        rise = np.ones(count)
    logit = np.linspace(-6.0, -6.0 + rise, operations)
    trend = logistic(logit)
    single = logistic(logit + 0.9 * rng.standard_normal(logit.shape))
    single[rng.random(operations) < unusable] = np.nan
    marginal = single.copy()
    marginal[:, 1:2] **= 1.4
    on = trend >= 0.95
    first = [operation[each].min() if each.any() else np.nan for each in on.T]
    each = ("operation", "limit")
    return xr.Dataset(
        {
            "probability": (each, single),
            "marginal": (each, marginal),
            "trend_probability": (each, trend),
            "alarm": (each, on),
            "first_alarm": ("limit", first),
            "words": ("limit", WORDS[:count]),
            "source": ("limit", ["both"] * count),
        },
        {"operation": operation, "limit": LIMITS[:count]},
        {"raise": 0.95, "clear": 0.5, "after": 3},
    )


def trend_data(operations=2000, changes=(0.6,), step=1, count=4):
    """A drive of which some parameters bend at shares of life, and what a tracker says of it."""
    rng = generator(32, "test", "trend")
    operation = 1 + step * np.arange(operations)
    last = operation[-1]
    starts = np.array([round(share * last) for share in changes], dtype=float)
    bends = np.maximum(operation[:, None] - starts, 0.0).sum(axis=1) / last
    centre = np.array([2.0, 0.045, 0.04, 0.3, 0.12, 0.75, 10.0])
    speed = np.array([0.0, 0.02, -0.1, 0.8, 0.1, -0.2, -0.02])
    level = centre * np.exp(bends[:, None] * speed)
    width = centre * 0.04 / np.sqrt(1 + np.arange(operations)[:, None] / 30) + 0.003 * centre
    median = level + 0.05 * centre * rng.standard_normal(level.shape)
    median[rng.random(operations) < 0.03] = np.nan
    known = np.where(operation[:, None] >= starts + 0.03 * last, starts, -np.inf)
    began = known.max(axis=1, initial=1.0)
    age = operation - began + 1.0
    ages = np.geomspace(1.0, 1.2 * last, 48)
    middle = np.sqrt(ages[:-1] * ages[1:])
    held = np.exp(-0.5 * ((np.log(middle) - np.log(age)[:, None]) / 0.25) ** 2)
    held += 0.01 * held.max()
    held /= held.sum(axis=1, keepdims=True)
    alarms = [operation[operation >= start + 0.03 * last][0] for start in starts]
    probability = 0.03 + 0.02 * rng.random(operations)
    for start, alarm in zip(starts, alarms, strict=True):
        inside = (operation >= start) & (operation <= alarm)
        probability[inside] = np.linspace(0.03, 0.93, inside.sum())
    kinds = np.zeros((len(starts), len(KINDS)))
    kinds[:, [3, 5, 7, 0]] = [0.62, 0.3, 0.06, 0.02]
    limits = np.arange(count)
    failure = np.array([1.1, 1.6, 0.98, 1.3, 1.2, 2.0, 0.9, 1.4])[:count] * last
    left = np.maximum(failure - operation[:, None], 0.0)
    spread = 0.08 + 0.6 / (1 + age[:, None] / (0.05 * last))
    late = 0.4 * rng.standard_normal(operations).cumsum()[:, None] / np.sqrt(operations)
    errors = 1.7 * spread[..., None] * (np.array([-1.0, 0.0, 1.5]) + late[..., None])
    remaining = left[..., None] * np.exp(errors) + [0.0, 1.0, 4.0]
    horizon = 1.2 * last
    remaining[remaining > horizon] = np.inf
    toward = logistic((operation[:, None] - (starts.min(initial=2.0 * last) + 0.06 * last)) / 10)
    toward = toward * np.where(limits == 1, 0.2, 1.0)
    return xr.Dataset(
        {
            "level": (("operation", "parameter"), level),
            "level_interval": (
                ("operation", "parameter", "bound"),
                np.stack([level - width, level + width], axis=-1),
            ),
            "median": (("operation", "parameter"), median),
            "run_length_probability": (("operation", "age"), held),
            "change_probability": ("operation", probability),
            "alarm": ("operation", np.isin(operation, alarms)),
            "change_alarm": ("change", np.array(alarms, dtype=float)),
            "change_start": ("change", starts),
            "change_interval": (
                ("change", "bound"),
                (starts[:, None] + np.array([-0.01, 0.006]) * last).reshape(-1, 2),
            ),
            "change_kind": (("change", "kind"), kinds),
            "remaining": (("operation", "limit", "quantile"), remaining),
            "toward": (("operation", "limit"), toward),
            "words": ("limit", WORDS[:count]),
        },
        {
            "operation": operation,
            "parameter": list(NAMES),
            "bound": BOUNDS,
            "kind": KINDS,
            "limit": LIMITS[:count],
            "quantile": QUANTILES,
            "age_lower": ("age", ages[:-1]),
            "age_upper": ("age", ages[1:]),
        },
        {
            "alarm_level": 0.9,
            "horizon": horizon,
            "notice": 200,
            "toward_level": 0.9,
            "source": "both",
        },
    ), dict(zip(LIMITS, failure, strict=False))


def effective_values(last=2000):
    values = np.outer([1.0, 1.02, 1.2], [2.0, 0.045, 0.04, 0.3, 0.12, 0.75, 10.0])
    return xr.DataArray(
        values,
        dims=("stage", "output"),
        coords={"operation": ("stage", [1, last // 2, last]), "output": list(NAMES)},
    )


def verdict_data(count=4):
    """Healthy, wearing, in alarm, unknown, and then all of them again."""
    way = [[5, 12, 20], [35, 48, 60], [90, 104, 140], [np.nan] * 3]
    remaining = [[np.inf] * 3, [900, 2130, np.inf], [0, 0, 60], [np.nan] * 3]
    way += [[-40, -10, 5], [70, 78, 84], [99, 100, 101], [0, 15, 30]]
    remaining += [[4000, 9000, np.inf], [310, 421, 633], [0, 0, 0], [np.inf] * 3]
    trend = [False, True, True, False, True, True, True, False]
    state = ["healthy", "wearing", "alarm", "unknown"]
    state += ["healthy", "wearing", "alarm", "healthy"]
    return xr.Dataset(
        {
            "way": (("limit", "quantile"), np.array(way[:count], dtype=float)),
            "remaining": (("limit", "quantile"), np.array(remaining[:count], dtype=float)),
            "trend": ("limit", trend[:count]),
            "state": ("limit", state[:count]),
            "words": ("limit", WORDS[:count]),
        },
        {"limit": LIMITS[:count], "quantile": QUANTILES},
        {
            "healthy": "Not healthy: little wipe is in alarm since operation 1912.",
            "wearing": "Wearing: friction of the drive, plus 7.4 % in 1000 operations "
            "(5.9 to 9.1), since operation 1761 (1745 to 1772).",
            "left": "Left: 2,130 operations until tired closing (900 to beyond the horizon); "
            "no trend towards the others.",
        },
    )


def scores_data(lives=200, methods=("model", "closing time", "CUSUM", "EWMA")):
    rng = generator(33, "test", "scores")
    ratio = rng.lognormal(1.5, 0.7, lives)
    slower = np.array([0.12, 0.3, 0.24, 0.28, 0.3])[: len(methods)]
    delay = slower / ratio[:, None] * rng.lognormal(0, 0.5, (lives, len(methods)))
    delay[rng.random(delay.shape) < np.exp(-0.4 * ratio)[:, None]] = np.nan
    lower = np.array([0.0, 2.0, 3.0, 5.0, 8.0])
    upper = np.array([*lower[1:], np.inf])
    inside = (ratio[:, None] >= lower) & (ratio[:, None] < upper)
    found = [
        np.mean(delay[each] <= 0.03, axis=0) if each.any() else np.full(len(methods), np.nan)
        for each in inside.T
    ]
    fraction = np.array([0.1, 0.25, 0.5, 0.75, 0.9])
    hits = np.array([168, 174, 181, 179, 185])
    interval = [beta.ppf(0.05, hits, 201 - hits), beta.ppf(0.95, hits + 1, 200 - hits)]
    return xr.Dataset(
        {
            "ratio": ("life", ratio),
            "delay": (("life", "method"), delay),
            "found": (("bin", "method"), found),
            "bin_lower": ("bin", lower),
            "bin_upper": ("bin", upper),
            "coverage": ("fraction", hits / 200),
            "coverage_interval": (("fraction", "bound"), np.transpose(interval)),
            "alpha_lambda": ("fraction", [0.41, 0.58, 0.74, 0.83, 0.9]),
            "crps": ("fraction", [0.34, 0.21, 0.13, 0.1, 0.08]),
        },
        {"method": list(methods), "fraction": fraction, "bound": BOUNDS},
    )


def written(axis):
    return [text.get_text() for text in axis.texts]


def line_of(axis, colour, marker=None):
    """The first line of a colour, and of a marker where one is given."""
    lines = [line for line in axis.lines if line.get_color() == colour]
    return next(line for line in lines if marker is None or line.get_marker() == marker)


def boxes(axis, colour):
    """From where to where the spans of a colour reach."""
    found = [each for each in axis.patches if to_hex(each.get_facecolor()).upper() == colour]
    return [(box.x0, box.x1) for box in (each.get_bbox() for each in found)]


# ---- health ----------------------------------------------------------------------------------


def test_spans_end_halfway_to_the_neighbours():
    operation = np.array([1, 3, 5, 6, 7, 9])
    assert edges(operation).tolist() == [0, 2, 4, 5.5, 6.5, 8, 10]
    assert edges(np.array([4])).tolist() == [3.5, 4.5]
    inside = np.array([True, False, True, True, False, True])
    assert spans(operation, inside) == [(0, 2), (4, 6.5), (8, 10)]
    assert spans(operation, np.zeros(6, dtype=bool)) == []


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
        np.testing.assert_array_equal(trend.get_ydata(), one.trend_probability)
        missing = line_of(axis, style.REFERENCE, "|").get_xdata()
        np.testing.assert_array_equal(missing, one.operation[one.probability.isnull()])
        marginal = [line for line in axis.lines if line.get_marker() == "D"]
        assert len(marginal) == (limit == "tired_closing")
        for line in marginal:
            np.testing.assert_array_equal(line.get_ydata(), one.marginal)
        levels = {line.get_ydata()[0] for line in axis.lines if line.get_linestyle() == "--"}
        assert levels == {0.95, 0.5}
        first = one.first_alarm.item()
        told = f"first alarm: operation {first:.0f}" if np.isfinite(first) else "no alarm"
        assert written(axis) == [told, "from both motions"]
        expected = [(first - 0.5, 300.5)] if np.isfinite(first) else []
        assert boxes(axis, style.WARNING) == expected
        title = axis.get_title("left").replace("\n", " ")
        assert title == f"{limit.replace('_', ' ')}: {one.words.item()}"
    assert ("as if parts were independent" in words(figure)) == (count > 1)
    assert figure.get_suptitle().endswith(f"limits with an alarm: {min(count, 2)} of {count}")


def test_health_without_alarm_and_without_anything_usable():
    data = health_data(2, 30, 5, alarms=False, unusable=0.0)
    figure = health(data)
    assert figure.get_suptitle().endswith("no alarm at any limit")
    for word in ("alarm on", "first alarm", "not usable"):
        assert word not in words(figure)
    assert_nothing_overlaps(figure)
    data["trend_probability"][:] = np.nan
    data["probability"][:] = np.nan
    data["marginal"][:] = np.nan
    figure = health(data)
    assert "not usable" in words(figure)
    assert "as if parts" not in words(figure)
    assert_nothing_overlaps(figure)


def test_alarm_that_goes_off_and_on_again():
    data = health_data(1, 30)
    data["alarm"][:] = (np.isin(np.arange(30), [3, 4, 20]))[:, None]
    data["source"] = ("limit", ["closing"])
    figure = health(data)
    assert boxes(figure.axes[0], style.WARNING) == [(3.5, 5.5), (20.5, 21.5)]
    assert "from closing" in written(figure.axes[0])


# ---- change points ---------------------------------------------------------------------------


def starts_drawn(axis):
    return [line.get_xdata()[0] for line in axis.lines if line.get_color() == "#7A35D0"]


@pytest.mark.parametrize(
    ("changes", "title"),
    [((), "no change found"), ((0.6,), "1 change found"), ((0.25, 0.5, 0.8), "3 changes found")],
)
def test_changes_are_drawn_where_they_are_and_told(changes, title):
    data, _ = trend_data(200, changes)
    figure = changepoint(data, source="opening")
    assert figure.get_suptitle() == f"Opening: change points of the wear\n{title}"
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
    image = ages.collections[0]
    np.testing.assert_array_equal(image.get_array(), data.run_length_probability.T)
    likeliest = data.run_length_probability.values.argmax(axis=1)
    drawn = line_of(ages, style.WARNING).get_ydata()
    assert np.all(drawn > data.age_lower.values[likeliest])
    assert np.all(drawn < data.age_upper.values[likeliest])
    alarms = line_of(probability, style.WARNING, "v").get_xdata()
    np.testing.assert_array_equal(alarms, data.change_alarm)
    expected = ["No change found."] if not changes else []
    for i, alarm in enumerate(data.change_alarm.values):
        where, what = change_words(data.isel(change=i))
        expected += [where, f"   {what}; alarm at {alarm:.0f}"]
    assert written(told) == expected
    assert "stand-in" not in words(figure)


def test_words_of_a_change():
    change = xr.Dataset(
        {
            "change_start": 1761.2,
            "change_interval": ("bound", [1745.0, 1772.4]),
            "change_kind": ("kind", [0.02, 0.0, 0.0, 0.62, 0.0, 0.3, 0.0, 0.06]),
        },
        {"kind": KINDS},
    )
    expected = "operation 1761 (1745–1772)", r"$\gamma_a$ 0.62, $f$ 0.30, all 0.06"
    assert change_words(change) == expected


def test_many_changes_few_operations_and_the_stand_in():
    data, _ = trend_data(400, tuple(np.linspace(0.1, 0.9, 8)))
    figure = changepoint(data, source="closing")
    assert written(figure.axes[7])[-1] == "and 2 more"
    assert_nothing_overlaps(figure)
    data, _ = trend_data(30, (0.5,))
    effective = effective_values(30)
    figure = changepoint(data, source="both", effective=effective.sel(output=["f", "L"]))
    assert figure.get_suptitle().startswith("Both motions: ")
    drawn = [[line for line in axis.lines if line.get_marker() == "D"] for axis in figure.axes]
    assert [len(lines) for lines in drawn[:7]] == [0, 0, 0, 0, 0, 1, 1]
    np.testing.assert_array_equal(drawn[5][0].get_ydata(), effective.sel(output="f"))
    assert "stand-in" in words(figure)
    assert_nothing_overlaps(figure)
    with pytest.raises(ValueError, match="no source is called 'left'"):
        changepoint(data, source="left")


def test_ages_from_zero_to_infinity_and_operations_without_any():
    """A logarithmic axis holds neither; an operation without a posterior leaves a gap."""
    data, _ = trend_data(60, ())
    data.age_lower[0], data.age_upper[-1] = 0.0, np.inf
    data.run_length_probability[7] = np.nan
    axis = changepoint(data, source="closing").axes[8]
    assert 0 < axis.get_ylim()[0] < axis.get_ylim()[1] < np.inf
    assert 8 not in line_of(axis, style.WARNING).get_xdata()


# ---- remaining life --------------------------------------------------------------------------


def test_remaining_life_and_truth_are_drawn_where_they_are():
    data, truth = trend_data(300)
    truth["slow_opening"] = np.nan
    figure = remaining_life(data, truth=truth, alpha=0.1)
    assert_nothing_overlaps(figure)
    assert figure.get_suptitle().startswith("Both motions: remaining operations")
    for axis, limit in zip(figure.axes, LIMITS, strict=False):
        one = data.sel(limit=limit)
        line = line_of(axis, "#2166AC")
        trend = one.toward.values >= 0.9
        expected = one.remaining.sel(quantile=0.5).where(trend)
        np.testing.assert_array_equal(line.get_ydata(), expected)
        assert ("no trend" in written(axis)) == bool((~trend).mean() > 0.14)
        lines = [each for each in axis.lines if each.get_color() == style.MEASURED]
        assert len(lines) == (limit != "slow_opening")
        assert ("(in truth not reached)" in axis.get_title("left")) == (limit == "slow_opening")
        for each in lines:
            x, y = each.get_data()
            np.testing.assert_allclose(x + y, truth[limit])
            cone = axis.collections[0].get_paths()[0].vertices
            left = truth[limit] - cone[:, 0]
            share = cone[left > 0, 1] / left[left > 0]
            np.testing.assert_allclose(np.abs(share - 1), 0.1)
    assert "truth ± 10 %" in words(figure)
    assert "notice: 200 operations" in words(figure)


def test_what_is_beyond_the_horizon_is_open():
    data, _ = trend_data(30, count=1)
    data["toward"][:] = 1.0
    data["toward"][4] = np.nan
    data["remaining"][:, 0] = [10.0, 20.0, np.inf]
    data["remaining"][20:, 0] = [30.0, np.inf, np.inf]
    figure = remaining_life(data.assign_attrs(horizon=1000.0, source="closing"))
    axis = figure.axes[0]
    middle = line_of(axis, "#2166AC").get_ydata()
    assert np.flatnonzero(np.isnan(middle)).tolist() == [4]
    assert middle[:4].tolist() == [20.0] * 4
    assert np.all(middle[20:] > 1000.0)
    assert np.all(middle[20:] < axis.get_ylim()[1])
    first, second = (part.get_datalim(axis.transData) for part in axis.collections)
    assert (first.x0, first.x1, second.x0, second.x1) == (0.5, 4.5, 5.5, 30.5)
    assert (first.y0, second.y0) == (10.0, 10.0)
    assert first.y1 == second.y1 == axis.get_ylim()[1] > 1000.0
    assert [label.get_text() for label in axis.get_yticklabels()][-2:] == ["1,000", "beyond"]
    assert "truth" not in words(figure)
    assert_nothing_overlaps(figure)


def test_no_trend_at_all_invents_no_life():
    data, _ = trend_data(100, (), count=8)
    figure = remaining_life(data.assign_attrs(source="separate"))
    assert figure.get_suptitle().startswith("Each motion by itself: ")
    for axis in figure.axes:
        assert written(axis) == ["no trend"]
        assert not axis.collections
        assert np.isnan(line_of(axis, "#2166AC").get_ydata()).all()
    assert_nothing_overlaps(figure)


# ---- verdict ---------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [1, 8])
def test_verdict_says_it_in_three_sentences_and_rows(count):
    data = verdict_data(count)
    figure = verdict(data)
    assert_nothing_overlaps(figure)
    text, left, right = figure.axes
    assert figure.get_suptitle() == data.healthy
    said = " ".join(written(text)[0].split())
    assert said == f"{data.wearing} {data.left}"
    width = figure.bbox.width
    assert text.texts[0].get_window_extent().x1 < width
    assert figure._suptitle.get_window_extent().x1 < width
    by_row = [
        (each.xy[1], each.get_text(), each.get_color())
        for each in left.texts
        if each.get_text() in STATES
    ]
    expected = [
        (row, str(state), STATES[str(state)]) for row, state in enumerate(data.state.values)
    ]
    assert by_row == expected
    rights = ["no trend", "2,130  (900 to beyond)", "0  (0 to 60)", "not known"]
    rights += ["9,000  (4,000 to beyond)", "421  (310 to 633)", "now", "no trend"]
    assert written(right) == rights[:count]
    percents = [each for each in written(left) if each not in STATES]
    lefts = ["12 %", "48 %", "104 %", "not known", "−10 %", "78 %", "100 %", "15 %"]
    assert percents == lefts[:count]


def test_verdict_draws_intervals_and_arrows_where_they_are():
    data = verdict_data(8)
    _, left, right = verdict(data).axes

    def segments(axis):
        return {
            part.get_segments()[0][0, 1]: part.get_segments()[0][:, 0].tolist()
            for part in axis.collections
        }

    assert segments(left) == {
        0: [5, 20],
        1: [35, 60],
        2: [90, 130],
        4: [-18, 5],
        5: [70, 84],
        6: [99, 101],
        7: [0, 30],
    }
    assert segments(right) == {1: [900, 1e5], 2: [1, 60], 4: [4000, 1e5], 5: [310, 633], 6: [1, 1]}

    def marks(axis, kind):
        lines = [line for line in axis.lines if line.get_marker() == kind]
        return {line.get_ydata()[0]: line.get_xdata()[0] for line in lines}

    alarming = to_hex(STATES["alarm"])
    gone = [bar.get_width() for bar in left.patches if to_hex(bar.get_facecolor()) == alarming]
    assert gone[:2] == [104, 100]  # and the strip past the limit
    assert marks(left, "o") == {0: 12, 1: 48, 2: 104, 4: -10, 5: 78, 6: 100, 7: 15}
    assert marks(right, "o") == {1: 2130, 4: 9000, 5: 421}
    assert (marks(left, "<"), marks(left, ">")) == ({4: -18}, {2: 130})
    assert (marks(right, "<"), marks(right, ">")) == ({2: 1, 6: 1}, {1: 1e5, 4: 1e5})


def test_long_sentences_are_broken_and_strange_states_refused():
    data = verdict_data(2)
    data.attrs |= {name: f"{data.attrs[name]} " * 3 for name in ("healthy", "wearing", "left")}
    figure = verdict(data)
    assert_nothing_overlaps(figure)
    assert "\n" in figure.get_suptitle()
    box, below = figure.axes[0].texts[0].get_window_extent(), figure.axes[1].get_tightbbox()
    assert box.x1 < figure.bbox.width
    assert box.y0 > below.y1
    data["state"][1] = "tired"
    with pytest.raises(ValueError, match="no state is called 'tired'"):
        verdict(data)


@pytest.mark.parametrize("sight", SIGHT)
def test_states_stay_apart_in_colour(sight):
    """As the colours of the parameters: 15 CIELAB units."""
    seen = {name: lab(mark, SIGHT[sight]) for name, mark in STATES.items()}
    distances = {(a, b): np.linalg.norm(seen[a] - seen[b]) for a, b in combinations(STATES, 2)}
    assert {pair: distance for pair, distance in distances.items() if distance < 15} == {}


# ---- prognostics -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("lives", "methods"),
    [(200, ("model", "closing time", "CUSUM", "EWMA")), (20, ("model", "closing time"))],
)
def test_prognostics_shows_the_scores(lives, methods):
    data = scores_data(lives, methods)
    figure = prognostics(data)
    assert_nothing_overlaps(figure)
    assert figure.get_suptitle().endswith(f"{lives} simulated lives")
    assert [name for name in methods if name not in words(figure)] == []
    delays, found, coverage, accuracy, crps = figure.axes
    for i in range(len(methods)):
        delay = 100 * data.delay.values[:, i]
        points, medians = delays.lines[2 * i : 2 * i + 2]
        np.testing.assert_array_equal(points.get_xdata(), data.ratio)
        shown, missed = points.get_ydata(), np.isnan(delay)
        np.testing.assert_array_equal(shown[~missed], delay[~missed])
        assert np.all((shown[missed] > 100) & (shown[missed] < delays.get_ylim()[1]))
        expected = []
        for lower, upper in zip(data.bin_lower.values, data.bin_upper.values, strict=True):
            each = np.sort(delay[(data.ratio >= lower) & (data.ratio < upper)])  # nan at the end
            expected += [each[len(each) // 2]] if each.size else []
        drawn = np.where(np.array(medians.get_ydata()) > 100, np.nan, medians.get_ydata())
        np.testing.assert_allclose(drawn, expected)
        np.testing.assert_array_equal(found.lines[i].get_ydata(), 100 * data.found[:, i])
    labels = [label.get_text() for label in found.get_xticklabels()]
    assert labels == ["below 2", "2 to 3", "3 to 5", "5 to 8", "from 8"]
    targets = [(box.x0, box.x1, box.y0) for box in (each.get_bbox() for each in found.patches)]
    assert np.allclose(targets, [(0.6, 0.8, 90), (0.8, 1.0, 90)])  # from a ratio of 5 on
    np.testing.assert_allclose(coverage.lines[-1].get_ydata(), 100 * data.coverage)
    bars = np.array(coverage.collections[-1].get_segments())
    np.testing.assert_allclose(bars[..., 1], 100 * data.coverage_interval)
    band = coverage.patches[0].get_bbox()
    assert (band.y0, band.y1) == (85, 95)
    np.testing.assert_allclose(accuracy.lines[0].get_ydata(), 100 * data.alpha_lambda)
    np.testing.assert_allclose(crps.lines[0].get_ydata(), data.crps)


def test_poor_coverage_stays_in_sight_and_methods_have_markers():
    data = scores_data(20, ("model",))
    data.coverage_interval[0] = [0.02, 0.1]
    assert prognostics(data).axes[2].get_ylim()[0] < 2
    with pytest.raises(ValueError, match="markers for 7 methods, not 8"):
        prognostics(scores_data(20, ("a", "b")).isel(method=[0, 1] * 4))
