"""Steps: a false alarm as rare as stated, a step at once, no step from a drift or an outlier."""

import numpy as np
import pytest
from scipy.stats import binom

from breaker.model.randomness import generator
from breaker.wear.steps import Watch

K = 8
LEVEL = 1e-4


def watched(said, level=LEVEL):
    """p-values of operations ``(o, k)``, and which complete a step."""
    watch, p_values, steps = Watch.begin(said.shape[1]), [], []
    for i, each in enumerate(said):
        watch, p_value, change = watch.learn(float(i), each, level)
        p_values.append(p_value)
        if change is not None:
            steps.append(i)
    return np.array(p_values), steps


def quiet(n, rng, spread=1.0):
    """What operations of a drive say that scatters along one direction and drifts along another."""
    scatter = 3.0 * spread * rng.standard_normal((n, 1)) * np.linspace(0.0, 1.0, K)
    drift = 0.004 * np.arange(n)[:, None] * np.linspace(1.0, 0.0, K)
    return rng.standard_normal((n, K)) + scatter + drift


def test_p_values_are_those_of_a_drive_that_does_not_change():
    """Of 3,000 operations after the first 200: 1 % below 0.01, false alarm 1e-3."""
    p_values = watched(quiet(3200, generator(1, "test steps")))[0][200:]
    law = binom(len(p_values), 0.01)
    below = np.sum(p_values < 0.01)
    assert law.ppf(5e-4) <= below <= law.ppf(1 - 5e-4)


@pytest.mark.parametrize("seed", range(3))
def test_a_step_is_reported_by_its_third_operation_and_once(seed):
    said = quiet(400, generator(seed, "test steps"))
    said[250:] += 8.0 * (np.arange(K) == 2)
    assert watched(said)[1] == [252]


def test_neither_a_drift_nor_an_outlier_is_a_step():
    said = quiet(600, generator(5, "test steps"))
    said[300] += 30.0
    said += 0.02 * np.arange(600)[:, None]
    p_values, steps = watched(said)
    assert p_values[300] < 1e-10
    assert steps == []


def test_after_a_step_the_watch_goes_on():
    said = quiet(500, generator(6, "test steps"))
    said[200:] += 10.0
    said[400:] -= 10.0
    assert watched(said)[1] == [202, 402]


def test_outliers_in_a_row_that_differ_are_no_step():
    """As a start of the motion that is read wrongly makes them, now early and now late."""
    said = quiet(400, generator(7, "test steps"))
    said[300:304] += np.array([12.0, -12.0, 15.0, -9.0])[:, None] * (np.arange(K) == 1)
    assert watched(said)[1] == []


def test_a_drive_that_does_not_come_to_rest_is_another_one():
    said = quiet(400, generator(8, "test steps"))
    said[300:] += 30.0 * generator(9, "test steps").standard_normal((100, K))
    assert watched(said)[1][0] == 311
