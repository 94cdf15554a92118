"""The widening that is enough: its guarantee on made-up lives, and what few of them promise."""

import numpy as np
import pytest

from breaker.model.randomness import generator
from breaker.synthetic.calibration import MISSED, WIDENINGS, calibrate


def covered_by(needed):
    """Predictions ``(life, prediction)`` that need a widening, covered by each or not."""
    return needed[..., None] <= WIDENINGS


def drawn(rng, lives):
    """Widenings needed by five predictions of a life, which depend on each other."""
    return 0.9 + 0.25 * rng.exponential(size=(lives, 1)) * rng.uniform(0.3, 1.0, size=(lives, 5))


def misses(choose, lives, repeats=400):
    """Expected share that another life misses, over many calibrations, and its error."""
    truth = drawn(generator(1, "test", "truth"), 20_000)
    found = []
    for i in range(repeats):
        widening = choose(covered_by(drawn(generator(2, "test", "calibration", i), lives)))
        found.append(np.mean(truth > widening))
    return np.mean(found), np.std(found) / np.sqrt(repeats)


@pytest.mark.parametrize("lives", [12, 49])
def test_no_more_is_missed_than_is_promised(lives):
    """Four standard errors: false alarm below 1e-4. Of the plain share of few lives it is not
    true, so that share is a fault that is seen."""

    def plain(covered):
        return WIDENINGS[np.argmax(1.0 - covered.mean(axis=(0, 1)) <= MISSED)]

    share, error = misses(lambda covered: calibrate(covered)[1], lives)
    assert share + 4 * error < MISSED
    assert share > 0.5 * MISSED  # and not by far more than is needed
    if lives == 12:
        share, error = misses(plain, lives)
        assert share - 4 * error > MISSED


def test_too_few_lives_promise_nothing():
    """Nine perfect lives, and one that misses everything: one in ten."""
    assert calibrate(covered_by(np.ones((9, 5))))[1] == 1.0
    assert np.isnan(calibrate(covered_by(np.ones((8, 5))))[1])
    assert np.isnan(calibrate(covered_by(np.full((100, 5), 3.0)))[1])


def test_what_a_wider_interval_loses_is_missed():
    """Intervals that slide away: 1.0 covers all, 1.2 a half, so up to 1.2 half counts as missed."""
    covered = np.ones((100, 2, len(WIDENINGS)), dtype=bool)
    covered[:, 0, WIDENINGS == 1.2] = False
    table, enough = calibrate(covered)
    assert enough == 1.25
    assert table.covered[0] == 1.0
    assert table.missed_at_most[0] == pytest.approx((50 + 1) / 101)
