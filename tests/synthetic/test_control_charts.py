"""Recursive residuals and control charts against loops, laws and published tables."""

import numpy as np
import pytest
from scipy.stats import binom, norm
from scipy.stats import t as student

from breaker.model.randomness import generator
from breaker.synthetic import control_charts
from breaker.synthetic.control_charts import KINDS, level_for, watch

NEVER = np.inf  # a level


def line(n, rng, *, slope=0.02, noise=0.3):
    return 10 + slope * np.arange(n) + noise * rng.standard_normal(n)


def residuals(series, warm_up):
    return watch(series, "threshold", NEVER, warm_up=warm_up).residual


# ---- residuals -------------------------------------------------------------------------------


def naive_residuals(series, warm_up):
    """A line by least squares anew for every operation."""
    result = np.full(series.size, np.nan)
    position = np.arange(series.size)
    for i in np.flatnonzero(np.isfinite(series)):
        past = np.flatnonzero(np.isfinite(series[:i]))
        if past.size >= warm_up:
            design = np.stack([np.ones(past.size), position[past]], axis=1)
            row = np.array([1.0, i])
            coefficients, rest = np.linalg.lstsq(design, series[past])[:2]
            variance = rest[0] / (past.size - 2)
            variance *= 1 + row @ np.linalg.solve(design.T @ design, row)
            result[i] = (series[i] - row @ coefficients) / np.sqrt(variance)
    return result


@pytest.mark.parametrize("warm_up", [3, 12])
def test_residuals_against_fits_anew(warm_up):
    series = line(80, generator(4, "test", "residuals"))
    series[[0, 7, 8, 40]] = np.nan
    found = residuals(series, warm_up)
    assert np.isfinite(found).sum() == 76 - warm_up
    np.testing.assert_allclose(found, naive_residuals(series, warm_up), rtol=1e-8)


def test_residuals_far_from_zero_keep_their_digits():
    series = line(2000, generator(4, "test", "digits"))
    found, expected = residuals(1e6 + series, 10), residuals(series, 10)
    np.testing.assert_allclose(found[10:], expected[10:], rtol=1e-5, atol=1e-6)


def test_residuals_are_student():
    """The distribution functions of their laws are uniform and their neighbours uncorrelated:
    20,000 values, bounds of 3.9 standard errors for three figures, a false alarm below 1e-3.

    Residuals over their in-sample sd instead, without the line's own error, are seen.
    """
    rng = generator(4, "test", "student")
    n, warm_up, series = 14, 4, 2000
    found = np.stack([residuals(line(n, rng), warm_up) for _ in range(series)])
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
    found = residuals(np.r_[np.full(6, 9.5), 9.6, 9.4, 9.5, 9.6], 4)
    assert np.isnan(found[:7]).all()
    assert np.isfinite(found[7:]).all()


# ---- statistics ------------------------------------------------------------------------------


def naive_statistic(residual, kind):
    result, seen, up, down = np.full(residual.size, np.nan), [], 0.0, 0.0
    for i in np.flatnonzero(np.isfinite(residual)):
        seen.append(residual[i])
        if kind == "threshold":
            result[i] = abs(seen[-1])
        elif kind == "cusum":
            up, down = max(0, up + seen[-1] - 0.5), max(0, down - seen[-1] - 0.5)
            result[i] = max(up, down)
        else:
            weights = 0.2 * 0.8 ** np.arange(len(seen))
            result[i] = abs(weights @ seen[::-1]) / np.sqrt((weights**2).sum())
    return result


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("sign", [1, -1])
def test_statistics_and_restarts_against_loops(kind, sign):
    """After an alarm the fit and the statistic begin anew, with the operation of the alarm."""
    series = line(300, generator(4, "test", "monitor"))
    series[100:] += 2.0
    series[200:] += 0.1 * np.arange(100)
    series[[3, 50, 101, 102]] = np.nan
    series = sign * series
    level, start, expected = 2.5, 0, []
    statistic = np.full(300, np.nan)
    while True:
        values = naive_statistic(naive_residuals(series[start:], 8), kind)
        statistic[start + 1 :] = values[1:]  # that of the alarm itself stands
        above = np.flatnonzero(values > level)
        if not above.size:
            break
        start += above[0]
        expected.append(start)
    assert len(expected) > 1
    found = watch(series, kind, level, warm_up=8)
    assert np.flatnonzero(found.alarm).tolist() == expected
    np.testing.assert_allclose(found.statistic, statistic, rtol=1e-8, atol=1e-10)


# ---- rates of false alarms -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "level", "run_length"),
    [
        ("threshold", 3.0, 1 / (2 * norm.sf(3.0))),
        ("cusum", 5.0, 465.4),  # Siegmund 1985; Montgomery, Table 9.3: 465
        ("ewma", 2.962, 500.0),  # Lucas & Saccucci 1990, Table 1, for a weight of 0.2
    ],
)
def test_run_lengths_between_false_alarms(kind, level, run_length):
    """Published average run lengths on white noise, to 3.3 standard errors and 2 % for what the
    tables round (and the start of the EWMA, whose sd is exact here): a false alarm below 1e-3.
    """

    def alarms(values, level):
        state, count = np.zeros(3), 0
        for value in values:
            if control_charts._advance(state, value, KINDS.index(kind)) > level:
                count, state[:] = count + 1, 0.0
        return count

    values = generator(4, "test", "run lengths").standard_normal(400_000)
    expected = values.size / run_length
    margin = 3.3 * np.sqrt(expected) + 0.02 * expected
    assert abs(alarms(values, level) - expected) < margin
    assert alarms(values, 0.95 * level) > expected + margin  # a level that is 5 % off is seen


def test_false_alarms_around_a_line_are_as_many_as_expected():
    """Their residuals are independent: binomial bounds with 1e-3."""
    rng = generator(4, "test", "false alarms")
    n, warm_up, level = 200, 20, 3.0
    chance = 2 * student.sf(level, np.arange(warm_up, n) - 2)
    low, high = binom.interval(1 - 1e-3, 200 * chance.size, chance.mean())
    found = [residuals(line(n, rng, slope=0.003), warm_up) for _ in range(200)]
    assert low <= np.sum(np.abs(found) > level) <= high


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("allowed", [0, 3, 12])
def test_level_for_is_the_least(kind, allowed):
    rng = generator(4, "test", "levels")
    series = [line(int(n), rng) for n in rng.integers(100, 200, 20)]
    rate = allowed / sum(each.size for each in series)
    level = level_for(series, kind, rate, warm_up=15)

    def count(level):
        return sum(watch(each, kind, level, warm_up=15).alarm.sum() for each in series)

    assert count(level) <= allowed < count(np.nextafter(level, 0))
    assert max(count(factor * level) for factor in np.linspace(1, 1.5, 40)) <= allowed


def test_level_for_a_rate_that_nothing_reaches():
    series = [line(50, generator(4, "test", "levels"))]
    assert level_for(series, "threshold", 1.0, warm_up=5) == 0.0
    assert level_for([np.full(50, np.nan)], "cusum", 0.0, warm_up=5) == 0.0


# ---- changes ---------------------------------------------------------------------------------


STEP = {"threshold": 10.0, "cusum": 4.0, "ewma": 4.0}  # sd, found within so many operations:
WITHIN = {"threshold": 1, "cusum": 8, "ewma": 8}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("change", ["step up", "step down", "slope"])
def test_a_change_is_found(kind, change):
    """A step, or 0.15 sd an operation more, in each of 40 series; levels of 10 alarms in 10^4.

    It is missed where a false alarm within the warm-up before it leaves nothing to compare with:
    1.3 times expected, 7 times or more with a chance below 1e-3. Without the change there are only
    false alarms: of steps 0.3 expected, 5 or more with a chance below 1e-3, and of slopes, in 60
    operations, 2.4 expected, more than 10 with a chance below 1e-3.
    """
    rng = generator(4, "test", "changes")
    level = level_for([line(400, rng) for _ in range(100)], kind, 1e-3, warm_up=30)
    since = np.arange(260) - 200
    if change == "slope":
        shape, within, most = 0.15 * since, 60, 10
    else:
        shape, within, most = STEP[kind] * (1 if change == "step up" else -1), WITHIN[kind], 4
    found = {True: 0, False: 0}
    for _ in range(40):
        for changed in found:
            series = line(260, rng) + changed * 0.3 * np.where(since >= 0, shape, 0.0)
            marks = since[watch(series, kind, level, warm_up=30).alarm]
            found[changed] += np.any((marks >= 0) & (marks < within))
    assert found[True] >= 34
    assert found[False] <= most


def test_unusable_arguments_are_refused():
    series = np.arange(9.0)
    for call, words in (
        (lambda: watch(series, "cusum", 1.0, warm_up=2), "warm_up must be at least 3"),
        (lambda: watch(series, "cusum", -1.0, warm_up=3), "level must not be negative"),
        (lambda: watch(series, "cusum", np.nan, warm_up=3), "level must not be negative"),
        (lambda: watch(series[None], "ewma", 1.0, warm_up=3), "a series must be"),
        (lambda: watch([1.0, np.inf], "ewma", 1.0, warm_up=3), "a series must be"),
        (lambda: watch(series, "shewhart", 1.0, warm_up=3), "not in"),
        (lambda: level_for([], "cusum", 1e-3, warm_up=3), "there must be operations"),
        (lambda: level_for([series], "cusum", -1e-3, warm_up=3), "rate must not be negative"),
    ):
        with pytest.raises(ValueError, match=words):
            call()
