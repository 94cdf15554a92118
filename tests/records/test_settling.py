"""Levels about which a reading moves, and running medians."""

import numpy as np
import pytest

from breaker.records.fits import level, running_median, settlings

LATE = np.linspace(0.5, 4.0, 64)
SHAPES = {
    "rests": 0.0 * LATE,
    "swings": np.exp(-0.8 * LATE) * np.cos(2.0 * LATE + 0.5),
    "creeps": np.exp(-0.5 * LATE),
}
NOISE = 3e-3


@pytest.mark.parametrize("shape", SHAPES)
def test_a_rest_is_as_uncertain_as_stated(shape):
    """Of 200 rests about a level of 1, sds of errors in stated sds have an sd of 5 %; the stated
    ones hold what noise may hide, so that drives at rest are nearer.
    """
    rng, errors = np.random.default_rng(1), []
    ways = settlings(LATE, -1.0)
    for _ in range(200):
        travel = 1.0 + 0.05 * SHAPES[shape] + NOISE * rng.standard_normal(LATE.size)
        value, weights, hidden, _ = level(travel, *ways, NOISE**2)
        errors.append((value - 1.0) / np.hypot(NOISE * np.linalg.norm(weights), hidden))
    assert np.sqrt(np.mean(np.square(errors))) < 1.25


@pytest.mark.parametrize(("count", "window"), [(1, 3), (7, 5), (7, 21), (3000, 201)])
def test_running_medians_are_those_of_each_window(count, window):
    """Beyond its ends a record stands; the last is of several blocks."""
    values = np.random.default_rng(1).normal(size=count)
    around = np.arange(-(window // 2), window // 2 + 1)
    places = np.clip(np.arange(count)[:, None] + around, 0, count - 1)
    assert (running_median(values, window) == np.median(values[places], axis=1)).all()
