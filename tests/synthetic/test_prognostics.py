"""Scores of predictions in closed form, by summation, and on predictions that are off."""

import numpy as np
import pytest
from scipy.stats import binom, gamma, poisson

from breaker.model.randomness import generator
from breaker.synthetic.prognostics import (
    crps,
    detections,
    false_alarms_per,
    prognostic_horizon,
    share,
)

HORIZON = 1000.0
LAW = gamma(4.0, scale=80.0)  # mean 320, some mass beyond the horizon


# ---- CRPS ------------------------------------------------------------------------------------


@pytest.mark.parametrize("truth", [0.0, 123.4, 320.0, 1000.0])
def test_crps_is_the_integral(truth):
    """Of the empirical distribution, summed over its steps; draws beyond the horizon, too."""
    lives = LAW.rvs(60, random_state=generator(3, "test", "crps"))
    lives[:4] = np.inf, 0.0, 1e-3, 5000.0
    edges = np.unique([0.0, truth, HORIZON, *lives[lives < HORIZON]])
    share = np.mean(lives[:, None] <= edges[:-1], axis=0) - (edges[:-1] >= truth)
    assert crps(lives, truth, HORIZON) == pytest.approx(np.square(share) @ np.diff(edges))


def test_crps_by_hand():
    # All mass at one operation: the distance. No crossing: what is left of the horizon.
    truth = np.array([300.0, 250.0, 800.0])
    np.testing.assert_allclose(crps(np.full((3, 5), 300.0), truth, HORIZON), np.abs(truth - 300.0))
    np.testing.assert_allclose(crps(np.full((3, 5), np.inf), truth, HORIZON), HORIZON - truth)
    # Half at 200, half never, truth 500: (1/2)^2 from 200 to 500, and again to the horizon.
    assert crps([200.0, np.inf], 500.0, HORIZON) == pytest.approx(300 / 4 + 500 / 4)
    # Many draws of a uniform law from 0 to w: (y^3 + (w - y)^3) / (3 w^2).
    even = (np.arange(10_000) + 0.5) / 10
    expected = (300.0**3 + 700.0**3) / (3 * 1000.0**2)
    assert crps(even, 300.0, HORIZON) == pytest.approx(expected, rel=1e-6)


def test_crps_is_least_for_the_law_itself():
    """A proper score: the true law beats laws that are too narrow, too wide or shifted.

    500 lives; the differences are 4 standard errors or more, a failure has a chance below 1e-4.
    """
    truth = LAW.rvs(500, random_state=generator(5, "test", "crps"))
    truth = truth[truth < HORIZON]
    shares = (np.arange(400) + 0.5) / 400

    def score(law):
        return crps(np.broadcast_to(law.ppf(shares), (truth.size, 400)), truth, HORIZON)

    exact = score(LAW)
    for off in (gamma(12.0, scale=27.0), gamma(1.0, scale=320.0), gamma(4.0, scale=110.0)):
        worse = score(off) - exact
        assert worse.mean() > 4 * worse.std() / np.sqrt(truth.size)


@pytest.mark.parametrize(
    ("lives", "truth", "words"),
    [
        ([1.0, 2.0], [0.5], "draws for each truth"),
        ([], 0.5, "draws for each truth"),
        ([1.0, -1.0], 0.5, "below 0 or nan"),
        ([1.0, np.nan], 0.5, "below 0 or nan"),
        ([1.0, 2.0], 1000.1, "truth must be from 0 to the horizon, 1000"),
        ([1.0, 2.0], np.nan, "truth must be from 0"),
    ],
)
def test_what_is_no_prediction_is_refused(lives, truth, words):
    with pytest.raises(ValueError, match=words):
        crps(lives, truth, HORIZON)


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
