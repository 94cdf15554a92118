"""Scores of predictions in closed form, by numeric integration, and on predictions that are off."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import binom, gamma, poisson

from breaker.model.randomness import generator
from breaker.synthetic.prognostics import (
    crps,
    detections,
    false_alarms_per,
    prognostic_horizon,
    share,
)

GRID = np.linspace(0.5, 1000.0, 2000)
LAW = gamma(4.0, scale=80.0)  # mean 320, some mass beyond the horizon


# ---- CRPS ------------------------------------------------------------------------------------


@pytest.mark.parametrize("mass", [1.0, 0.7])
@pytest.mark.parametrize("truth", [0.0, 123.4, 320.0, 999.9, 1000.0])
def test_crps_is_the_integral(truth, mass):
    below = quad(lambda x: (mass * LAW.cdf(x)) ** 2, 0, truth)[0]
    above = quad(lambda x: (mass * LAW.cdf(x) - 1) ** 2, truth, GRID[-1])[0]
    assert crps(GRID, mass * LAW.cdf(GRID), truth) == pytest.approx(below + above, abs=2e-3)


def test_crps_by_hand():
    # All mass at one operation: the distance. No crossing: what is left of the horizon.
    truth = np.array([300.0, 250.0, 800.0])
    at_once = np.tile([0.0, 1.0, 1.0], (3, 1))
    found = crps([300.0 - 1e-6, 300.0, 1000.0], at_once, truth)
    np.testing.assert_allclose(found, np.abs(truth - 300.0), atol=1e-5)
    np.testing.assert_allclose(crps(GRID, np.zeros((3, GRID.size)), truth), 1000.0 - truth)
    # Uniform from 0 to w, truth y: (y^3 + (w - y)^3) / (3 w^2), nodes or none in between.
    for nodes in ([1000.0], [200.0, 1000.0], GRID):
        cdf = np.asarray(nodes) / 1000
        expected = (300.0**3 + 700.0**3) / (3 * 1000.0**2)
        assert crps(nodes, cdf, 300.0) == pytest.approx(expected, rel=1e-12)
    # Truth in the second interval, by the formula of a line.
    value = crps([10.0, 20.0], [0.2, 0.6], 15.0)
    first, second, third = 10 * 0.04 / 3, 5 * (0.04 + 0.08 + 0.16) / 3, 5 * (0.36 + 0.24 + 0.16) / 3
    assert value == pytest.approx(first + second + third)


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


@pytest.mark.parametrize(
    ("grid", "cdf", "truth", "words"),
    [
        ([1.0, 2.0], [0.0, 0.5, 1.0], 0.5, "cdf must be"),
        ([1.0, 2.0], [0.0, 0.5], [0.5, 0.5], "cdf must be"),
        ([0.0, 1.0], [0.0, 0.5], 0.5, "the grid increase"),
        ([1.0, 2.0], [0.6, 0.5], 0.5, "falls"),
        ([1.0, 2.0], [0.0, 1.1], 0.5, "leaves 0 to 1"),
        ([1.0, 2.0], [0.0, np.nan], 0.5, "is NaN"),
        ([1.0, 2.0], [0.0, 0.5], 2.1, "truth must be from 0 to the last node of the grid, 2"),
        ([1.0, 2.0], [0.0, 0.5], np.nan, "truth must be from 0"),
    ],
)
def test_what_is_no_prediction_is_refused(grid, cdf, truth, words):
    with pytest.raises(ValueError, match=words):
        crps(grid, cdf, truth)
    assert crps([1.0, 2.0, 3.0], [0.2, 0.2 - 1e-12, 1 + 1e-12], 1.0) > 0  # round-off is forgiven


# ---- horizons --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("inside", "expected"),
    [
        ([0, 1, 0, 1, 1], 30.0),  # a hit before a miss is luck
        ([1, 1, 1, 1, 1], 90.0),
        ([1, 1, 1, 1, 0], 0.0),
        ([0, 0, 0, 0, 1], 5.0),
        ([], 0.0),
    ],
)
def test_prognostic_horizon(inside, expected):
    operations = np.array([10.0, 30.0, 50.0, 70.0, 95.0])[: len(inside)]
    assert prognostic_horizon(operations, np.array(inside, bool), 100.0) == expected


# ---- delays, shares, rates -------------------------------------------------------------------


def test_detections():
    alarms = [[30, 120, 110, 200], [100], [10, 99, 200, 300], []]  # at the change; too late
    found = detections(alarms, [100] * 4, [200] * 4)
    np.testing.assert_array_equal(found.delay, [10, 0, np.nan, np.nan])
    assert found.false_alarms == 3


def test_a_share_has_its_exact_interval():
    """At its bounds, a count as far off or further has the probability of one tail."""
    n = 20
    found = np.array([share(np.arange(n) < hits, level=0.9) for hits in range(n + 1)])
    hits, (value, lower, upper) = np.arange(n + 1), found.T
    np.testing.assert_allclose(value, hits / n)
    np.testing.assert_allclose(binom.sf(hits[1:] - 1, n, lower[1:]), 0.05)
    np.testing.assert_allclose(binom.cdf(hits[:-1], n, upper[:-1]), 0.05)
    assert (lower[0], upper[-1]) == (0.0, 1.0)
    assert np.isnan(share([])).all()


def test_false_alarms_per():
    rate, lower, upper = false_alarms_per(3, 20_000, level=0.9)
    assert rate == 1.5
    # As of the share: at the bounds a count as far off has the probability of one tail.
    assert poisson.sf(2, lower * 2) == pytest.approx(0.05)
    assert poisson.cdf(3, upper * 2) == pytest.approx(0.05)
    rate, lower, upper = false_alarms_per(0, 500, per=100)
    assert (rate, lower) == (0.0, 0.0)
    assert upper == pytest.approx(-np.log(0.025) / 5)
