"""Raw times, recursive residuals and control charts against loops, closed forms and tables."""

import numpy as np
import pytest
from scipy.stats import binom, norm
from scipy.stats import t as student

from breaker.mechanism.curves import travel
from breaker.model.randomness import generator
from breaker.model.sensor import Sensor
from breaker.records.landmarks import raw_time
from breaker.synthetic.control_charts import (
    alarms,
    cusum,
    ewma,
    level_for,
    monitor,
    residuals,
    threshold,
)

TIMES = np.linspace(-2.0, 58.0, 151)
KINDS = [("threshold", {"run": 2}), ("cusum", {"slack": 0.4}), ("ewma", {"weight": 0.3})]


def line(n, rng, *, slope=0.02, noise=0.3):
    return 10 + slope * np.arange(n) + noise * rng.standard_normal(n)


# ---- times -----------------------------------------------------------------------------------


def ramps(onset, speed, start=0.0, way=13.0):
    """At rest, then even: all that linear interpolation has to be exact for."""
    moved = np.clip(speed * (TIMES - np.reshape(onset, (-1, 1))), 0, abs(way))
    return start + np.sign(way) * moved


@pytest.mark.parametrize("way", [13.0, -13.0])
@pytest.mark.parametrize("start", [0.0, 13.5])
def test_raw_time_of_even_motion(way, start):
    """The time between two shares of the way, whatever the trigger, zero and direction."""
    onset = np.array([0.0, 0.17, 0.9, 3.3])
    records = ramps(onset, 0.7, start, way)
    np.testing.assert_allclose(raw_time(TIMES, records, share=0.75), 0.7 * 13.0 / 0.7)
    found = raw_time(TIMES, records, share=0.9, first=0.1)
    np.testing.assert_allclose(found, 0.8 * 13.0 / 0.7)


def test_raw_time_of_the_drive():
    """Independent of the onset to what interpolation leaves, and longer for a weaker drive."""
    theta = np.array([2.0, 0.05, 0.5, 0.15, 0.05, 0.9, 12.0])
    for motion in ("closing", "opening"):
        onsets = np.linspace(-0.3, 0.3, 7)
        records = travel(np.tile(theta, (7, 1)), TIMES, motion, onset=onsets).travel
        found = raw_time(TIMES, records, share=0.75)
        assert np.ptp(found) < 0.05
        # From time 0 instead, the trigger would enter in full.
        moved = records - records[:, :1]
        late = [np.interp(0.75, r / r[-1], TIMES[:60]) for r in moved[:, :60]]
        assert np.ptp(late) > 0.5
    weaker = theta * np.array([1, 1, 1, 1, 1, 0.9, 1])
    records = travel(np.stack([theta, weaker]), TIMES, "closing").travel
    assert np.diff(raw_time(TIMES, records, share=0.75)) > 0.2


def test_raw_time_in_noise():
    """Each crossing is off by about 0.1 mm of noise over 1.3 mm/ms, the early side of it."""
    sensor = Sensor(-2.0, 58.0, 151, 0.1, 0.3, 0.1)
    rng = generator(4, "test", "raw times")
    records = sensor.corrupt(ramps(sensor.onset_sd * rng.standard_normal(400), 1.3), rng)
    found = raw_time(TIMES, records, share=0.75)
    assert abs(found.mean() - 7.0) < 0.05
    assert 0.07 < found.std() < 0.2


def test_raw_time_where_there_is_none():
    records = ramps(0.5, 0.7).repeat(5, axis=0)
    records[1, 30] = np.nan  # a missing sample
    records[2] = records[0] * 0.1  # no motion
    records[3, 0] = 13.0  # begins beyond both shares
    records[4] = np.nan
    found = raw_time(TIMES, records, share=0.75)
    assert np.isnan(found).tolist() == [False, True, True, True, True]


# ---- residuals -------------------------------------------------------------------------------


def naive_residuals(series, warm_up, detrend=True):
    """A fit by least squares anew for every operation."""
    result = np.full(series.size, np.nan)
    position = np.arange(series.size)
    reference = series[np.isfinite(series)][:warm_up]
    for i in np.flatnonzero(np.isfinite(series)):
        past = np.flatnonzero(np.isfinite(series[:i]))
        if past.size < warm_up:
            continue
        if detrend:
            design = np.stack([np.ones(past.size), position[past]], axis=1)
            row = np.array([1.0, i])
            coefficients, rest = np.linalg.lstsq(design, series[past])[:2]
            variance = rest[0] / (past.size - 2)
            variance *= 1 + row @ np.linalg.solve(design.T @ design, row)
            result[i] = (series[i] - row @ coefficients) / np.sqrt(variance)
        else:
            result[i] = (series[i] - reference.mean()) / reference.std(ddof=1)
    return result


@pytest.mark.parametrize("detrend", [True, False])
@pytest.mark.parametrize("warm_up", [3, 12])
def test_residuals_against_fits_anew(warm_up, detrend):
    series = line(80, generator(4, "test", "residuals"))
    series[[0, 7, 8, 40]] = np.nan
    found = residuals(series, warm_up=warm_up, detrend=detrend)
    expected = naive_residuals(series, warm_up, detrend)
    assert np.isfinite(found).sum() == 76 - warm_up
    np.testing.assert_allclose(found, expected, rtol=1e-8)


def test_residuals_far_from_zero_keep_their_digits():
    series = line(2000, generator(4, "test", "digits"))
    found = residuals(1e6 + series, warm_up=10)
    np.testing.assert_allclose(found[10:], residuals(series, warm_up=10)[10:], rtol=1e-5, atol=1e-6)


def test_residuals_are_student():
    """The distribution functions of their laws are uniform and their neighbours uncorrelated:
    20,000 values, bounds of 3.9 standard errors for three figures, a false alarm below 1e-3.

    Residuals over their in-sample sd instead, without the line's own error, are seen.
    """
    rng = generator(4, "test", "student")
    n, warm_up, series = 14, 4, 2000
    found = np.stack([residuals(line(n, rng), warm_up=warm_up) for _ in range(series)])
    ranks = student.cdf(found[:, warm_up:], np.arange(warm_up, n) - 2)
    error = 3.9 / np.sqrt(ranks.size)
    assert abs(ranks.mean() - 0.5) < error * np.sqrt(1 / 12)
    assert abs(ranks.var() - 1 / 12) < error * np.sqrt(1 / 180)
    neighbours = np.mean((ranks[:, 1:] - 0.5) * (ranks[:, :-1] - 0.5))
    assert abs(neighbours) < error / 12 * np.sqrt(10 / 9)

    count = np.arange(warm_up, n)
    leverage = 1 / count + (count - (count - 1) / 2) ** 2 * 12 / (count**3 - count)
    faulty = student.cdf(found[:, warm_up:] * np.sqrt(1 + leverage), count - 2)
    assert abs(faulty.var() - 1 / 12) > 3 * error * np.sqrt(1 / 180)


def test_a_warm_up_without_scatter_goes_on():
    series = np.r_[np.full(6, 9.5), 9.6, 9.4, 9.5, 9.6]
    for detrend in (True, False):
        found = residuals(series, warm_up=4, detrend=detrend)
        assert np.isnan(found[:7]).all()
        assert np.isfinite(found[7:]).all()


# ---- statistics ------------------------------------------------------------------------------


def naive_statistic(values, kind, setting):
    result, seen, up, down, mean = np.full(values.size, np.nan), [], 0.0, 0.0, 0.0
    for i, r in enumerate(values):
        if np.isnan(r):
            continue
        seen.append(r)
        if kind == "threshold":
            last = np.array(seen[-setting:])
            same = len(last) == setting and abs(np.sign(last).sum()) == setting
            result[i] = np.abs(last).min() if same else 0.0
        elif kind == "cusum":
            up, down = max(0, up + r - setting), max(0, down - r - setting)
            result[i] = max(up, down)
        else:
            weights = setting * (1 - setting) ** np.arange(len(seen))
            mean = weights @ seen[::-1]
            result[i] = abs(mean) / np.sqrt((weights**2).sum())
    return result


@pytest.mark.parametrize(
    ("kind", "function", "settings"),
    [
        ("threshold", threshold, {"run": 1}),
        ("threshold", threshold, {"run": 3}),
        ("cusum", cusum, {"slack": 0.4}),
        ("cusum", cusum, {"slack": 0.0}),
        ("ewma", ewma, {"weight": 0.3}),
        ("ewma", ewma, {"weight": 1.0}),
    ],
)
def test_statistics_against_loops(kind, function, settings):
    values = generator(4, "test", "statistics").standard_normal(200)
    values[[0, 30, 31, 199]] = np.nan
    (setting,) = settings.values()
    for signed in (values, -values):
        expected = naive_statistic(signed, kind, setting)
        np.testing.assert_allclose(function(signed, **settings), expected, rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize(("kind", "settings"), KINDS)
def test_alarms_restart_the_statistic(kind, settings):
    values = generator(4, "test", "alarms").standard_normal(300) + 0.5
    (setting,) = settings.values()
    level, start, expected = 1.5, 0, []
    while (above := np.flatnonzero(naive_statistic(values[start:], kind, setting) > level)).size:
        expected.append(start + above[0])
        start += above[0] + 1
    assert len(expected) > 3
    assert alarms(values, kind, level, **settings).tolist() == expected


@pytest.mark.parametrize("detrend", [True, False])
@pytest.mark.parametrize(("kind", "settings"), KINDS)
def test_monitor_restarts_everything(kind, settings, detrend):
    series = line(300, generator(4, "test", "monitor"))
    series[100:] += 2.0
    series[200:] += 0.1 * np.arange(100)
    series[[3, 50, 101, 102]] = np.nan
    (setting,) = settings.values()
    level, start, expected = 2.5, 0, []
    while True:
        values = naive_residuals(series[start:], 8, detrend)
        above = np.flatnonzero(naive_statistic(values, kind, setting) > level)
        if not above.size:
            break
        start += above[0]
        expected.append(start)
    assert len(expected) > 1
    found = monitor(series, kind, level, warm_up=8, detrend=detrend, **settings)
    assert found.tolist() == expected


# ---- rates of false alarms -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "level", "settings", "run_length"),
    [
        ("threshold", 3.0, {}, 1 / (2 * norm.sf(3.0))),
        ("threshold", 1.8, {"run": 2}, None),
        ("cusum", 5.0, {"slack": 0.5}, 465.4),  # Siegmund 1985; Montgomery, Table 9.3: 465
        ("ewma", 3.054, {"weight": 0.4}, 500.0),  # Lucas & Saccucci 1990, Table 1
    ],
)
def test_run_lengths_between_false_alarms(kind, level, settings, run_length):
    """Published average run lengths on white noise, to 3.3 standard errors and 2 % for what the
    tables round (and the start of the EWMA, whose sd is exact here): a false alarm below 1e-3.
    """
    if run_length is None:
        p = norm.sf(level)
        # Two in a row on one side, each with p: expected times n from no run, o from a run of one,
        # n = 1 + 2 p o + (1 - 2 p) n and o = 1 + p 0 + p o + (1 - 2 p) n.
        run_length = np.linalg.solve([[2 * p, -2 * p], [2 * p - 1, 1 - p]], [1.0, 1.0])[0]
    n = 400_000
    values = generator(4, "test", "run lengths").standard_normal(n)
    count, expected = alarms(values, kind, level, **settings).size, n / run_length
    assert abs(count - expected) < 3.3 * np.sqrt(expected) + 0.02 * expected
    # A level that is 5 % off is seen.
    off = alarms(values, kind, 0.95 * level, **settings).size
    assert off > expected + 3.3 * np.sqrt(expected) + 0.02 * expected


def test_false_alarms_around_a_line_are_as_many_as_expected():
    """Their residuals are independent: binomial bounds with 1e-3. Without the line it is seen."""
    rng = generator(4, "test", "false alarms")
    n, warm_up, level = 200, 20, 3.0
    series = [line(n, rng, slope=0.003) for _ in range(200)]
    chance = 2 * student.sf(level, np.arange(warm_up, n) - 2)
    low, high = binom.interval(1 - 1e-3, 200 * chance.size, chance.mean())

    def count(detrend):
        found = (residuals(each, warm_up=warm_up, detrend=detrend) for each in series)
        return sum(alarms(each, "threshold", level).size for each in found)

    assert low <= count(True) <= high
    assert count(False) > 2 * high


@pytest.mark.parametrize(("kind", "settings"), KINDS)
@pytest.mark.parametrize("allowed", [0, 3, 12])
def test_level_for_is_the_least(kind, settings, allowed):
    rng = generator(4, "test", "levels")
    series = [line(int(n), rng) for n in rng.integers(100, 200, 20)]
    rate = allowed / sum(each.size for each in series)
    level = level_for(series, kind, rate, warm_up=15, **settings)

    def count(level):
        return sum(monitor(each, kind, level, warm_up=15, **settings).size for each in series)

    assert count(level) <= allowed < count(np.nextafter(level, 0))
    assert max(count(factor * level) for factor in np.linspace(1, 1.5, 40)) <= allowed


def test_level_for_a_rate_that_nothing_reaches():
    series = [line(50, generator(4, "test", "levels"))]
    assert level_for(series, "threshold", 1.0, warm_up=5) == 0.0
    assert level_for([np.full(50, np.nan)], "cusum", 0.0, warm_up=5) == 0.0


# ---- changes ---------------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "within"), [("threshold", 1), ("cusum", 8), ("ewma", 8)])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_step_is_found(kind, within, sign):
    """A step of 10 sd (threshold) or 4 sd in each of 40 series; levels of 10 alarms in 10^4.

    It is missed where a false alarm within the warm-up before it leaves nothing to compare with:
    1.3 times expected, 7 times or more with a chance below 1e-3. Without the step nothing is found
    there but by false alarm: 0.3 times expected, 5 or more with a chance below 1e-3.
    """
    rng = generator(4, "test", "steps")
    level = level_for([line(400, rng) for _ in range(100)], kind, 1e-3, warm_up=30)
    found = [0, 0]
    for _ in range(40):
        series = line(160, rng)
        size = np.array([10 if kind == "threshold" else 4, 0.0])
        for i, step in enumerate(sign * 0.3 * size):
            marks = monitor(series + step * (np.arange(160) >= 120), kind, level, warm_up=30)
            found[i] += ((marks >= 120) & (marks < 120 + within)).any()
    assert found[0] >= 34
    assert found[1] < 5


@pytest.mark.parametrize("kind", ["threshold", "cusum", "ewma"])
def test_a_change_of_slope_is_found(kind):
    """0.15 sd an operation more, in 40 lives: missed or not as the step is. Such lives without it
    have 2.4 false alarms expected in these 60 operations, more than 10 with a chance below 1e-3."""
    rng = generator(4, "test", "slopes")
    level = level_for([line(400, rng) for _ in range(100)], kind, 1e-3, warm_up=30)
    found = []
    for extra in (0.15, 0.0):
        lives = [line(400, rng) for _ in range(40)]
        for series in lives:
            series[200:] += 0.3 * extra * np.arange(200)
        marks = [monitor(each, kind, level, warm_up=30) for each in lives]
        found.append(sum(((m >= 200) & (m < 260)).any() for m in marks))
    assert found[0] >= 34
    assert found[1] <= 10


# ---- what is refused -------------------------------------------------------------------------


def test_unusable_arguments_are_refused():
    series = np.arange(9.0)
    records = ramps(0.5, 0.7)
    for call, words in (
        (lambda: raw_time(TIMES[1:], records, share=0.7), "travel must be"),
        (lambda: raw_time(TIMES[::-1], records, share=0.7), "times must increase"),
        (lambda: raw_time(TIMES + 2, records, share=0.7), "begin before 0"),
        (lambda: raw_time(TIMES, records, share=1.0), "shares must be"),
        (lambda: raw_time(TIMES, records, share=0.5, first=0.6), "shares must be"),
        (lambda: residuals(series, warm_up=2), "warm_up must be"),
        (lambda: residuals(series[None], warm_up=3), "a series must be"),
        (lambda: residuals([1.0, np.inf], warm_up=3), "a series must be"),
        (lambda: threshold(series, run=0), "run is out of its range"),
        (lambda: threshold(series, run=1.5), "run is out of its range"),
        (lambda: cusum(series, slack=-1), "slack is out of its range"),
        (lambda: cusum(series, slack=np.inf), "slack is out of its range"),
        (lambda: ewma(series, weight=0), "weight is out of its range"),
        (lambda: alarms(series, "shewhart", 1.0), "no statistic 'shewhart'"),
        (lambda: alarms(series, "cusum", 1.0, weight=0.2), "cusum has the setting slack"),
        (lambda: alarms(series, "cusum", -1.0), "level must not be negative"),
        (lambda: monitor(series, "cusum", np.nan, warm_up=3), "level must not be negative"),
        (lambda: level_for([], "cusum", 1e-3, warm_up=3), "there must be operations"),
        (lambda: level_for([series], "cusum", -1e-3, warm_up=3), "rate must not be negative"),
    ):
        with pytest.raises(ValueError, match=words):
            call()
