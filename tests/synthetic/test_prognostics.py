"""Scores of predictions in closed form, by numeric integration, and on predictions that are off."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import beta, binom, gamma, poisson

from breaker.model.randomness import generator
from breaker.synthetic.prognostics import (
    alpha_lambda,
    alpha_lambda_median,
    coverage_interval,
    covered,
    crps,
    detection,
    false_alarms_per,
    prognostic_horizon,
    quantile,
    relative_accuracy,
)

GRID = np.linspace(0.0, 1000.0, 2001)
LAW = gamma(4.0, scale=80.0)  # mean 320, some mass beyond the horizon
NONE = np.full(GRID.size, np.nan)


def step(at):
    """All mass within 1e-6 before ``at``."""
    grid = np.array([0.0, at - 1e-6, at, 1000.0])
    return grid, np.array([0.0, 0.0, 1.0, 1.0])


# ---- quantiles and CRPS ----------------------------------------------------------------------


def test_quantile_of_a_known_law():
    q = np.array([0.05, 0.5, 0.95])
    found = quantile(GRID, np.stack([LAW.cdf(GRID), 0.5 * LAW.cdf(GRID)]), q)
    np.testing.assert_allclose(found[0], LAW.ppf(q), atol=0.05)
    np.testing.assert_allclose(found[1], [LAW.ppf(0.1), np.inf, np.inf], atol=0.05)
    assert quantile(GRID, LAW.cdf(GRID), 0.5) == found[0, 1]


def test_quantile_on_the_lines_between_nodes():
    grid, cdf = [10.0, 20.0, 30.0, 40.0], [0.2, 0.6, 0.6, 0.8]  # 0 at 0, flat from 20 to 30
    found = quantile(grid, cdf, [0.1, 0.2, 0.3, 0.6, 0.7, 0.8, 0.81])
    np.testing.assert_allclose(found, [5.0, 10.0, 12.5, 20.0, 35.0, 40.0, np.inf])
    # Exceeded already with probability 0.3.
    np.testing.assert_allclose(quantile([0.0, 10.0], [0.3, 0.9], [0.3, 0.6, 1.0]), [0, 5, np.inf])
    assert np.isnan(quantile(GRID, NONE, 0.5))


@pytest.mark.parametrize("mass", [1.0, 0.7])
@pytest.mark.parametrize("truth", [0.0, 123.4, 320.0, 999.9, 1000.0])
def test_crps_is_the_integral(truth, mass):
    below = quad(lambda x: (mass * LAW.cdf(x)) ** 2, 0, truth)[0]
    above = quad(lambda x: (mass * LAW.cdf(x) - 1) ** 2, truth, GRID[-1])[0]
    assert crps(GRID, mass * LAW.cdf(GRID), truth) == pytest.approx(below + above, abs=2e-3)


def test_crps_by_hand():
    # All mass at one operation: the distance. No crossing: what is left of the horizon.
    for truth in (300.0, 250.0, 800.0):
        assert crps(*step(300.0), truth) == pytest.approx(abs(truth - 300.0), abs=1e-5)
        assert crps(GRID, np.zeros(GRID.size), truth) == pytest.approx(1000.0 - truth)
    # Uniform from 0 to w, truth y: (y^3 + (w - y)^3) / (3 w^2), nodes or none in between.
    for nodes in ([1000.0], [0.0, 1000.0], [0.0, 200.0, 1000.0], GRID):
        cdf = np.asarray(nodes) / 1000
        expected = (300.0**3 + 700.0**3) / (3 * 1000.0**2)
        assert crps(nodes, cdf, 300.0) == pytest.approx(expected, rel=1e-12)
    # Half at once and nothing after: 1/4 of the way, wherever the truth is.
    assert crps([0.0, 1000.0], [0.5, 0.5], 300.0) == pytest.approx(250.0)
    # (2 of 3 operations at 10 per node, truth in the second interval, by the formula of a line.)
    value = crps([10.0, 20.0], [0.2, 0.6], 15.0)
    first, second, third = 10 * 0.04 / 3, 5 * (0.04 + 0.08 + 0.16) / 3, 5 * (0.36 + 0.24 + 0.16) / 3
    assert value == pytest.approx(first + second + third)
    assert np.isnan(crps(GRID, NONE, 300.0))


def test_crps_is_least_for_the_law_itself():
    """A proper score: the true law beats laws that are too narrow, too wide or shifted.

    500 lives; the differences are 5 standard errors or more, a failure has a chance below 1e-4.
    """
    truth = LAW.rvs(500, random_state=generator(5, "test", "crps"))
    truth = truth[truth < GRID[-1]]

    def score(law):
        return crps(GRID, np.broadcast_to(law.cdf(GRID), (truth.size, GRID.size)), truth)

    exact = score(LAW)
    for off in (gamma(12.0, scale=27.0), gamma(1.0, scale=320.0), gamma(4.0, scale=110.0)):
        worse = score(off) - exact
        assert worse.mean() > 4 * worse.std() / np.sqrt(truth.size)


# ---- cones, intervals, horizons --------------------------------------------------------------


def test_alpha_lambda():
    cdf = LAW.cdf(GRID)
    inside = LAW.cdf(240.0) - LAW.cdf(160.0)  # 200 within 20 %
    for margin, expected in ((-1e-4, True), (1e-4, False)):
        assert alpha_lambda(GRID, cdf, 200.0, 0.2, inside + margin) == expected
    # Beyond the horizon nothing is inside, though the cone ends there.
    inside = LAW.cdf(1000.0) - LAW.cdf(720.0)
    for margin, expected in ((-1e-4, True), (1e-4, False)):
        assert alpha_lambda(GRID, cdf, 900.0, 0.2, inside + margin) == expected


def test_alpha_lambda_of_many():
    narrow = gamma(400.0, scale=0.8).cdf(GRID)  # 320, sd 16
    truth = np.array([320.0, 320.0, 320.0, 420.0, 320.0])
    cdf = np.stack([narrow, 0.4 * narrow, np.zeros(GRID.size), narrow, NONE])
    assert alpha_lambda(GRID, cdf, truth, 0.2).tolist() == [True, False, False, False, False]
    assert alpha_lambda(GRID, cdf, truth, 0.2, 0.35).tolist() == [True, True, False, False, False]
    median = quantile(GRID, cdf, 0.5)
    assert np.isinf(median[1:3]).all()
    found = alpha_lambda_median(median, truth, 0.2).tolist()
    assert found == [True, False, False, False, False]
    assert alpha_lambda_median([80.0, 79.0, 120.0, 121.0], 100.0, 0.2).tolist() == [1, 0, 1, 0]


def test_coverage_of_quantiles_is_their_probability():
    """1000 lives; the interval of probability 0.999 around the level, 5e-4 on either side. A law of
    half the width covers 90 % by its quantiles in about 58 % of lives."""
    n, level = 1000, 0.9
    truth = LAW.rvs(n, random_state=generator(5, "test", "covered"))
    cdf = np.stack([LAW.cdf(GRID), gamma(16.0, scale=20.0).cdf(GRID)])
    lower, _, upper = quantile(GRID, cdf, [0.05, 0.5, 0.95]).T
    hits = [covered(low, high, truth).sum() for low, high in zip(lower, upper, strict=True)]
    low, high = binom.interval(0.999, n, level)
    assert low <= hits[0] <= high
    assert hits[1] < low
    assert coverage_interval(hits[1], n, 0.999)[1] < level


def test_covered():
    assert covered(
        [1, 1, 3, 1, np.nan, 4], [2, np.inf, 4, 2, 9, np.inf], [2, 9, 2, 3, 5, 3]
    ).tolist() == [
        True,
        True,
        False,
        False,
        False,
        False,
    ]


def test_relative_accuracy():
    found = relative_accuracy([100.0, 80.0, 130.0, np.inf, np.nan], 100.0)
    np.testing.assert_allclose(found, [1.0, 0.8, 0.7, -np.inf, np.nan])


@pytest.mark.parametrize(
    ("inside", "expected"),
    [
        ([0, 1, 0, 1, 1], 30.0),  # a hit before a miss is luck
        ([1, 1, 1, 1, 1], 90.0),
        ([1, 1, 1, 1, 0], 0.0),
        ([0, 0, 0, 0, 0], 0.0),
        ([0, 0, 0, 0, 1], 5.0),
        ([], 0.0),
    ],
)
def test_prognostic_horizon(inside, expected):
    operations = np.array([10.0, 30.0, 50.0, 70.0, 95.0])[: len(inside)]
    assert prognostic_horizon(operations, np.array(inside, bool), 100.0) == expected


# ---- shares, rates, delays -------------------------------------------------------------------


def test_coverage_interval_is_exact():
    """At its bounds, a count as far off or further has the probability of one tail."""
    hits, n = np.arange(21), 20
    lower, upper = coverage_interval(hits, n, 0.9)
    np.testing.assert_allclose(binom.sf(hits[1:] - 1, n, lower[1:]), 0.05)
    np.testing.assert_allclose(binom.cdf(hits[:-1], n, upper[:-1]), 0.05)
    assert (lower[0], upper[-1]) == (0.0, 1.0)
    np.testing.assert_allclose(upper[0], 1 - 0.05 ** (1 / 20))
    np.testing.assert_allclose(lower[9], beta.ppf(0.05, 9, 12))


def test_false_alarms_per():
    rate, lower, upper = false_alarms_per(3, 20_000, level=0.9)
    assert rate == 1.5
    # As of the share: at the bounds a count as far off has the probability of one tail.
    assert poisson.sf(2, lower * 2) == pytest.approx(0.05)
    assert poisson.cdf(3, upper * 2) == pytest.approx(0.05)
    rate, lower, upper = false_alarms_per(0, 500, per=100)
    assert (rate, lower) == (0.0, 0.0)
    assert upper == pytest.approx(-np.log(0.025) / 5)


def test_false_alarms_per_holds_its_level():
    """Exact sum over all counts: the interval holds the rate with at least its probability."""
    for expected in (0.3, 2.0, 8.0):
        counts = np.arange(60)
        bounds = np.array([false_alarms_per(k, 1, per=1, level=0.9)[1:] for k in counts])
        holds = (bounds[:, 0] <= expected) & (expected <= bounds[:, 1])
        assert 0.9 <= poisson.pmf(counts, expected) @ holds < 1


def test_detection():
    assert detection([30, 120, 110, 200], 100, 200) == (10, 1)
    assert detection([100], 100, 200) == (0, 0)  # at the change
    delay, false = detection([10, 99, 200, 300], 100, 200)  # too late is not found
    assert (np.isnan(delay), false) == (True, 2)
    delay, false = detection([10, 99, 250], np.inf, 200)  # nothing to be found
    assert (np.isnan(delay), false) == (True, 2)
    assert detection([], 100, np.inf)[1] == 0


# ---- what is refused -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("grid", "cdf", "words"),
    [
        ([0.0, 1.0], [0.0, 0.5, 1.0], r"cdf must be \(\.\.\., 2\)"),
        ([0.0, 0.0], [0.0, 0.5], "the grid must"),
        ([-1.0, 1.0], [0.0, 0.5], "the grid must"),
        ([0.0], [0.5], "the grid must"),
        ([0.0, 1.0], [0.6, 0.5], "falls"),
        ([0.0, 1.0], [0.0, 1.1], "leaves 0 to 1"),
        ([0.0, 1.0], [0.0, np.nan], "NaN in part"),
    ],
)
def test_what_is_no_prediction_is_refused(grid, cdf, words):
    for score in (quantile, crps):
        with pytest.raises(ValueError, match=words):
            score(grid, cdf, 0.5)


def test_round_off_is_forgiven():
    cdf = np.array([0.2, 0.2 - 1e-12, 1 + 1e-12])
    assert quantile([1.0, 2.0, 3.0], cdf, 1.0) == 3.0


def test_unusable_arguments_are_refused():
    cdf = LAW.cdf(GRID)
    for call, words in (
        (
            lambda: crps(GRID, cdf, 1000.1),
            "truth must be from 0 to the last node of the grid, 1000",
        ),
        (lambda: crps(GRID, cdf, np.nan), "truth must be from 0"),
        (lambda: crps(GRID, cdf, [1.0, 2.0]), "one a prediction"),
        (lambda: quantile(GRID, cdf, 0.0), "q must be"),
        (lambda: alpha_lambda(GRID, cdf, 0.0, 0.2), "truth must be positive"),
        (lambda: alpha_lambda(GRID, cdf, 1.0, 1.2), "alpha must be between 0 and 1"),
        (lambda: alpha_lambda(GRID, cdf, 1.0, 0.2, 0.0), "beta must be"),
        (lambda: alpha_lambda_median(1.0, np.inf, 0.2), "truth must be positive"),
        (lambda: relative_accuracy(1.0, 0.0), "truth must be positive"),
        (lambda: covered(2.0, 1.0, 1.5), "above its upper"),
        (lambda: covered(1.0, 2.0, np.nan), "truth must not be NaN"),
        (lambda: prognostic_horizon([1, 2], [True], 9), "operations and inside"),
        (lambda: prognostic_horizon([1, 2], [1, 0], 9), "inside of bool"),
        (lambda: prognostic_horizon([2, 1], [True, True], 9), "must increase"),
        (lambda: prognostic_horizon([1, 10], [True, True], 9), "not pass the failure"),
        (lambda: coverage_interval(5, 4), "hits must be"),
        (lambda: coverage_interval(0.5, 4), "hits must be"),
        (lambda: false_alarms_per(-1, 10), "count must be"),
        (lambda: false_alarms_per(1, 0), "operations and per positive"),
        (lambda: detection([1.0], 9, 9), "the change must come before"),
        (lambda: detection([np.nan], 1, 9), "alarms must be finite"),
    ):
        with pytest.raises(ValueError, match=words):
            call()
