"""Ends of curves, carried on to where they rest."""

import numpy as np
import pytest

from breaker.records.fits import running_median, settling

TIME = np.arange(0.0, 40.0, 0.1)
SWINGS = np.exp(-0.08 * TIME) * np.cos(0.2 * TIME + 0.5)
CREEPS = np.exp(-0.05 * TIME) + 0.5 * np.exp(-0.15 * TIME)
DECAYS = np.exp(-0.07 * TIME)


@pytest.mark.parametrize(("shape", "modes"), [(SWINGS, 2), (CREEPS, 2), (DECAYS, 1)])
def test_exact_ends(shape, modes):
    found = settling(TIME, 13.0 + 1.3 * shape, modes)
    assert found.rest == pytest.approx(13.0, abs=2e-3)
    assert found.weights.sum() == pytest.approx(1.0, abs=1e-6)


def test_the_rest_is_as_uncertain_as_its_weights_say():
    """Mean square of 300 errors over the stated one: sd 8 %, so 1.35 is 4 sd."""
    rng, errors = np.random.default_rng(1), []
    for _ in range(300):
        found = settling(TIME, SWINGS + 0.03 * rng.standard_normal(TIME.size), 2)
        errors.append(found.rest / (0.03 * np.linalg.norm(found.weights)))
    assert 0.7 < np.mean(np.square(errors)) < 1.35


@pytest.mark.parametrize("curve", [TIME, TIME**2, np.exp(0.05 * TIME)])
def test_curves_that_do_not_settle(curve):
    assert settling(TIME, curve, 2) is settling(TIME, curve, 1) is None


@pytest.mark.parametrize(("count", "window"), [(1, 3), (7, 5), (7, 21), (3000, 201)])
def test_running_medians_are_those_of_each_window(count, window):
    """Beyond its ends a record stands; the last is of several blocks."""
    values = np.random.default_rng(1).normal(size=count)
    around = np.arange(-(window // 2), window // 2 + 1)
    places = np.clip(np.arange(count)[:, None] + around, 0, count - 1)
    assert (running_median(values, window) == np.median(values[places], axis=1)).all()
