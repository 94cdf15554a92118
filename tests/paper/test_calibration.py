"""Ranks, their band and the judgement: right false-alarm rate, and faults are caught."""

from itertools import product
from math import factorial, prod

import numpy as np
import pytest
from scipy.stats import binom

from breaker.common.randomness import generator
from breaker.paper.calibration import (
    calibration_p_values,
    ecdf_difference,
    family_p_value,
    judge_ranks,
    simultaneous_band,
)


def uniform_ranks(n, draws, columns, purpose):
    return generator(1, "test", purpose).integers(0, draws + 1, (n, columns))


def leaves(ranks, draws, band):
    """Say which columns of ranks leave a band."""
    difference = ecdf_difference(ranks, draws)
    below, above = difference < band.lower[:, None], difference > band.upper[:, None]
    return np.any(below | above, axis=0)


def test_ecdf_difference_by_hand():
    # Ranks 0, 2, 2 among 3 draws: below 1, 2, 3 lie 1, 1, 3 of 3; the grid is 1/4, 1/2, 3/4.
    expected = np.array([[1 / 3 - 1 / 4], [1 / 3 - 1 / 2], [1 - 3 / 4]])
    np.testing.assert_allclose(ecdf_difference([[0], [2], [2]], 3), expected, atol=1e-15)
    assert family_p_value([0.5, 0.01, 0.2]) == pytest.approx(0.03)  # Bonferroni
    assert family_p_value([0.9, 0.8]) == 1.0


def test_p_values_are_exact():
    """All 210 histograms of 6 ranks among 4 draws: P(p <= x) = x at every p that can occur."""
    n, draws = 6, 4
    histograms = [h for h in product(range(n + 1), repeat=draws + 1) if sum(h) == n]
    weights = [factorial(n) / prod(map(factorial, h)) / (draws + 1) ** n for h in histograms]
    columns = np.stack([np.repeat(np.arange(draws + 1), h) for h in histograms], axis=1)
    p_values, weights = calibration_p_values(columns, draws), np.array(weights)
    assert weights.sum() == pytest.approx(1.0)
    for p in np.unique(p_values):
        reached = weights[p_values <= p * (1 + 1e-12)].sum()
        assert reached == pytest.approx(p, rel=1e-10)


@pytest.mark.parametrize(("n", "draws"), [(1000, 100), (200, 199)])
def test_band_has_the_false_alarm_rate_it_states(n, draws):
    band = simultaneous_band(n, draws, alpha=0.05, panels=1)
    assert 0.045 < band.false_alarm <= 0.05  # what one count is worth
    trials = 2000
    columns = uniform_ranks(n, draws, trials, f"rate {n} {draws}")
    alarms = leaves(columns, draws, band).sum()
    # Two-sided binomial bound: a right band fails this for one seed in a thousand.
    low, high = binom.ppf([5e-4, 1 - 5e-4], trials, band.false_alarm)
    assert low <= alarms <= high
    # Planted fault: a band of twice the alpha. Its 200 alarms are 5 sd above the bound of 133.
    assert leaves(columns, draws, simultaneous_band(n, draws, alpha=0.1, panels=1)).sum() > high


@pytest.mark.parametrize("alpha", [1e-3, 0.3])
def test_band_and_p_value_give_the_same_judge_ranks(alpha):
    draws, columns = 50, uniform_ranks(100, 50, 60, "agreement")
    columns[:, 30:] = columns[:, 30:] // (1 + np.arange(30) / 20)  # from none to a strong fault
    judged = judge_ranks(columns, draws, alpha=alpha)
    assert np.array_equal(judged.outside, judged.p_values <= alpha / 60)  # of all together
    assert np.array_equal(judged.outside, judged.excess > 0)
    assert np.array_equal(judged.outside, leaves(columns, draws, judged.band))
    assert judged.outside.any()
    assert not judged.outside.all()
