"""Recursive residuals and detectors against loops, laws and published tables."""

from functools import partial

import numpy as np
import pytest
from scipy.stats import binom, chi2, norm
from scipy.stats import t as student

from breaker.model.randomness import generator
from breaker.synthetic import control_charts
from breaker.synthetic.control_charts import KINDS, chart, directed, mewma, slope_test
from breaker.synthetic.watching import Watch, level_for


def line(n, rng, *, slope=0.02, noise=0.3):
    return 10 + slope * np.arange(n) + noise * rng.standard_normal(n)


def charted(series, kind, warm_up):
    return Watch(series, partial(chart, kind=kind, warm_up=warm_up))


def residuals(series, warm_up):
    """Residuals in their sd; NaN in the warm-up and where the series is."""
    there = np.flatnonzero(np.isfinite(series))
    found, variance, known = control_charts._learnt(there * 1.0, series[there, None], warm_up)
    result = np.full(len(series), np.nan)
    result[there[known]] = found[known, 0] / np.sqrt(variance[known, 0, 0])
    return result


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
    found = charted(series, kind, 8).at(level)
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
        return int(Watch(values, afresh).at(level).alarm.sum())

    def afresh(_, seen):  # the first is that of the alarm before
        return np.append(0.0, control_charts._charted(seen[1:, 0], kind))

    values = generator(4, "test", "run lengths").standard_normal((100, 4_000))
    expected = values.size / run_length
    margin = 3.3 * np.sqrt(expected) + 0.02 * expected
    assert abs(sum(alarms(each, level) for each in values) - expected) < margin
    # A level that is 5 % off is seen.
    assert sum(alarms(each, 0.95 * level) for each in values) > expected + margin


def test_false_alarms_around_a_line_are_as_many_as_expected():
    """Their residuals are independent: binomial bounds with 1e-3."""
    rng = generator(4, "test", "false alarms")
    n, warm_up, level = 200, 20, 3.0
    chance = 2 * student.sf(level, np.arange(warm_up, n) - 2)
    low, high = binom.interval(1 - 1e-3, 200 * chance.size, chance.mean())
    found = [residuals(line(n, rng, slope=0.003), warm_up) for _ in range(200)]
    assert low <= np.sum(np.abs(found) > level) <= high


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
    level = level_for([charted(line(400, rng), kind, 30) for _ in range(100)], 1e-3)
    since = np.arange(260) - 200
    if change == "slope":
        shape, within, most = 0.15 * since, 60, 10
    else:
        shape, within, most = STEP[kind] * (1 if change == "step up" else -1), WITHIN[kind], 4
    found = {True: 0, False: 0}
    for _ in range(40):
        for changed in found:
            series = line(260, rng) + changed * 0.3 * np.where(since >= 0, shape, 0.0)
            marks = since[charted(series, kind, 30).at(level).alarm]
            found[changed] += np.any((marks >= 0) & (marks < within))
    assert found[True] >= 34
    assert found[False] <= most


def test_unusable_arguments_are_refused():
    position, values = np.arange(9.0), np.arange(9.0)[:, None] % 2
    with pytest.raises(ValueError, match="warm_up must be at least 3"):
        chart(position, values, kind="cusum", warm_up=2)
    with pytest.raises(ValueError, match="one of threshold, cusum, ewma, not shewhart"):
        chart(position, values, kind="shewhart", warm_up=3)


# ---- several series --------------------------------------------------------------------------


MIXED = np.array(
    [[1.0, 0.0, 0.0, 0.0], [0.8, 0.6, 0.0, 0.0], [0.2, -0.5, 0.7, 0.0], [0, 0.4, 0, 2]]
)
GROUPS = ((0, 2), (1, 3))
DETECTORS = {
    "mewma": partial(mewma, weight=0.1, warm_up=40),
    "slope test": partial(slope_test, groups=GROUPS, ages=(3, 6, 12, 24), warm_up=40),
}


def together(n, rng):
    """Four lines with correlated noise, ``(n, 4)``."""
    return np.arange(n)[:, None] * [0.0, 0.1, -0.2, 0.3] + rng.standard_normal((n, 4)) @ MIXED.T


def test_slope_test_against_fits_anew():
    """Rao's likelihood ratio of a bend, its covariance from before it, without recursion."""
    rng, n, ages = generator(4, "test", "fits"), 60, (4, 9)
    position = np.sort(rng.choice(90, n, replace=False)).astype(float)
    values = together(90, rng)[position.astype(int)]
    found = slope_test(position, values, groups=GROUPS, ages=ages, warm_up=40)
    assert np.isnan(found[:40]).all()
    for i in (40, 59):
        best = 0.0
        for age in ages:
            since = i - age
            early = np.stack([np.ones(since + 1), position[: since + 1]], axis=1)
            rest = values[: since + 1] - early @ np.linalg.lstsq(early, values[: since + 1])[0]
            scatter = rest.T @ rest
            design = np.stack([np.ones(i + 1), position[: i + 1]], axis=1)
            bend = np.maximum(position[: i + 1] - position[since], 0.0)
            bend = bend - design @ np.linalg.lstsq(design, bend)[0]
            shift = bend @ values[: i + 1] / np.linalg.norm(bend)
            both = scatter + np.outer(shift, shift)
            for group in GROUPS:
                rest = [k for k in range(4) if k not in group]
                # Wilks: all four over those that the group leaves to be explained
                whole = np.linalg.slogdet(both)[1] - np.linalg.slogdet(scatter)[1]
                part = [np.linalg.slogdet(each[np.ix_(rest, rest)])[1] for each in (both, scatter)]
                best = max(best, 0.5 * (since - 1 - 4 + 1) * (whole - part[0] + part[1]))
        assert found[i] == pytest.approx(best, rel=1e-8)


def test_slope_test_raises_as_many_false_alarms_as_designed():
    """One age, one group of two: the tail is e^-x, exactly, though the covariance is estimated.

    2,000 independent series, one value each: binomial bounds with 1e-3 at three levels. With the
    covariance taken for known, as in a table of chi-squared, there are too many.
    """
    rng, n = generator(4, "test", "slope test"), 41
    position = np.arange(n) * 1.0
    test = partial(slope_test, groups=(GROUPS[0],), ages=(8,), warm_up=40)
    found = np.array([test(position, together(n, rng))[-1] for _ in range(2000)])
    for level in (1.0, 3.0, 5.0):
        low, high = binom.interval(1 - 1e-3 / 3, found.size, np.exp(-level))
        assert low <= np.sum(found > level) <= high
    degrees = n - 1 - 8 - 1
    taken_for_known = degrees / 2 * np.expm1(2 * found / (degrees - 3))  # at least, of chi-squared
    assert np.sum(taken_for_known > 5.0) > binom.isf(1e-3, found.size, np.exp(-5.0))


def test_run_lengths_of_a_multivariate_ewma():
    """Rigdon 1995, Table 1: four series, weight 0.25, level 16.38, a false alarm in 500; to 3.3
    standard errors and 2 %, of a start whose covariance is exact here: a false alarm below 1e-3.
    """

    def alarms(values, level):
        return int(Watch(values, afresh).at(level).alarm.sum())

    def afresh(_, seen):
        return np.append(0.0, np.square(control_charts._smooth(seen[1:], 0.25)).sum(axis=1))

    values = generator(4, "test", "run lengths").standard_normal((100, 4_000, 4))
    margin = 3.3 * np.sqrt(800) + 0.02 * 800
    assert abs(sum(alarms(each, 16.38) for each in values) - 800) < margin
    assert sum(alarms(each, 0.95 * 16.38) for each in values) > 800 + margin


@pytest.mark.parametrize("weight", [1.0, 0.1])
def test_mewma_raises_as_many_false_alarms_as_designed(weight):
    """With a long warm-up its square is chi-squared of four at every operation: binomial bounds
    with 1e-3 at two levels, 2,000 independent series, one value each.

    Residuals that are not freed of their correlation are seen.
    """
    rng, n = generator(4, "test", "mewma"), 420
    position = np.arange(n) * 1.0
    series = [together(n, rng) for _ in range(2000)]
    test = partial(mewma, weight=weight, warm_up=400)
    found = np.array([test(position, each)[-1] for each in series])
    for level in (7.78, 13.28):  # chi-squared of four: 10 % and 1 %
        low, high = binom.interval(1 - 1e-3 / 2, found.size, chi2.sf(level, 4))
        assert low <= np.sum(found > level) <= high
    alone = sum(np.array([test(position, e[:, [k]])[-1] for e in series]) for k in range(4))
    assert np.sum(alone > 13.28) > binom.isf(1e-3, 2000, chi2.sf(13.28, 4))


@pytest.mark.parametrize("name", DETECTORS)
def test_what_is_seen_does_not_depend_on_scale_or_order(name):
    rng = generator(4, "test", "invariance")
    values = together(120, rng)
    position, detector = np.arange(120) * 1.0, DETECTORS[name]
    expected = detector(position, values)
    assert np.isfinite(expected[40:]).all()
    scaled = detector(3.0 * position + 7.0, values * [1e3, -2.0, 0.1, 5.0] + [9.0, 0, 1e4, 0])
    np.testing.assert_allclose(scaled, expected, rtol=1e-6)
    swapped = detector(position, values[:, [2, 3, 0, 1]])  # within each group
    np.testing.assert_allclose(swapped, expected, rtol=1e-9)
    sloped = detector(
        position, values + np.outer(position, [0.4, 0.0, -1.0, 2.0])
    )  # and not on wear
    np.testing.assert_allclose(sloped, expected, rtol=1e-6)


def test_directed_residuals_are_what_the_others_do_not_explain():
    """Regression of each on the others over a long warm-up, and an sd of 1 in 20 values of each of
    200 series: 4,000 of each, bounds of 4 standard errors, for four a false alarm below 1e-3."""
    rng = generator(4, "test", "directed")
    values = together(420, rng)
    position = np.arange(420) * 1.0
    found = directed(position, values, warm_up=400)
    assert np.isnan(found[:400]).all()
    residual, _, _ = control_charts._learnt(position, values, 400)
    early, last = residual[2:419], residual[419]
    for k in range(4):
        others = np.delete(np.arange(4), k)
        shared = np.linalg.lstsq(early[:, others], early[:, k])[0]
        left = early[:, k] - early[:, others] @ shared
        expected = (last[k] - last[others] @ shared) / np.sqrt(left @ left / 417)
        assert found[419, k] == pytest.approx(expected, rel=1e-6)
    many = np.concatenate(
        [directed(position, together(420, rng), warm_up=400)[400:] for _ in range(200)]
    )
    assert np.all(np.abs(many.std(axis=0) - 1) < 4 / np.sqrt(2 * 4000) + 0.01)


@pytest.mark.parametrize("name", DETECTORS)
def test_nothing_later_is_used(name):
    values = together(120, generator(4, "test", "online"))
    position, detector = np.arange(120) * 1.0, DETECTORS[name]
    np.testing.assert_allclose(
        detector(position[:80], values[:80]), detector(position, values)[:80], rtol=1e-9
    )


@pytest.mark.parametrize("name", DETECTORS)
def test_a_bend_is_found(name):
    """Of one series in four, 0.25 sd an operation more, in 40 lives each; levels of 10 alarms in
    10^4. Found within 25 operations in 34 or more; without it, in 25 operations, 1.0 false alarms
    are expected, more than 6 with a chance below 1e-3.
    """
    rng, detector = generator(4, "test", "bends"), DETECTORS[name]
    quiet = [Watch(together(300, rng), detector) for _ in range(100)]
    level = level_for(quiet, 1e-3)
    since = np.arange(260) - 200
    found = {True: 0, False: 0}
    for k in range(40):
        for changed in found:
            values = together(260, rng)
            values[:, k % 4] += changed * 0.25 * np.maximum(since, 0) * np.linalg.norm(MIXED[k % 4])
            marks = since[Watch(values, detector).at(level).alarm]
            found[changed] += np.any((marks >= 0) & (marks < 25))
    assert found[True] >= 34
    assert found[False] <= 6
