"""Bends found offline: near a planted one, not in lines plus noise."""

import numpy as np
import pytest

from breaker.decisions.second_opinion import bends
from breaker.model.randomness import generator

OPERATIONS = np.arange(1, 1001)
NONE = np.array([])


def series(seed, *, bend=0.0, at=600, n=1000, columns=3):
    """Lines plus noise of sds 1, 2, ..., one of which bends; bend in its sds a 100 operations."""
    rng = generator(seed, "test", "bends")
    sds = np.arange(1.0, columns + 1)
    o = np.arange(1, n + 1)
    lines = 5.0 * rng.standard_normal(columns) + np.outer(o / 100.0, rng.standard_normal(columns))
    lines[:, 1] += sds[1] * bend * np.maximum(o - at, 0) / 100.0
    return lines + sds * rng.standard_normal((n, columns))


def test_none_in_lines_plus_noise():
    """The penalty of a bend, 6 times 3 log 120, is 86. A least-squares bend gains a chi-square of
    3 (or of 6, with a jump) at the best of 120 places: false alarm below 1e-9 in all."""
    steady = [bends(OPERATIONS, series(seed)).size for seed in range(20)]
    assert sum(steady) == 0


def test_none_where_blocks_change_their_size():
    """1000 operations in 120 blocks: a drift by ten noise sds in 100 operations stays a line."""
    drift = np.outer(OPERATIONS / 10.0, [1.0, 2.0, 3.0])
    near = [bends(OPERATIONS, series(seed) + drift) for seed in range(5)]
    assert not any(np.any(np.abs(found - 364) <= 10) for found in near)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("sign", [1, -1])
def test_a_planted_bend_is_found(seed, sign):
    """Of six noise sds in a hundred operations, in one of three parameters: within 80."""
    found = bends(OPERATIONS, series(seed, bend=6.0 * sign))
    assert found.dtype == float
    assert found.size >= 1
    assert np.all(np.diff(found) > 0)
    assert np.abs(found - 600).min() <= 80
    straight = bends(OPERATIONS, series(seed))
    assert not np.array_equal(found, straight)


def test_two_bends_in_order():
    medians = series(1, bend=8.0, at=300)
    medians[:, 0] -= 8.0 * np.maximum(OPERATIONS - 700, 0) / 100.0
    found = bends(OPERATIONS, medians)
    assert np.all(np.diff(found) > 0)
    assert np.abs(found[:, None] - [300, 700]).min(axis=0).max() <= 60


def test_the_unit_does_not_matter():
    medians = series(2, bend=6.0)
    found = bends(OPERATIONS, medians)
    assert found.size >= 1
    np.testing.assert_array_equal(bends(OPERATIONS, medians * [1 / 1024, 1.0, 64.0]), found)


def test_operations_without_a_median_are_left_out():
    """One missing parameter is enough; bends are named by the number of the operation."""
    medians = series(3, bend=6.0)
    gaps = generator(3, "test", "gaps").random(len(medians)) < 0.2
    medians[gaps, 1] = np.nan
    found = bends(OPERATIONS, medians)
    np.testing.assert_array_equal(found, bends(OPERATIONS[~gaps], medians[~gaps]))
    assert np.abs(found - 600).min() <= 60
    np.testing.assert_array_equal(bends(5000 + 3 * OPERATIONS, medians), 5000 + 3 * found)
    np.testing.assert_array_equal(bends(OPERATIONS, np.full_like(medians, np.nan)), NONE)


def test_a_gap_is_not_a_bend():
    drift = np.outer(OPERATIONS / 10.0, [1.0, 2.0, 3.0])
    for seed in range(3):
        medians = series(seed) + drift
        medians[400:600] = np.nan
        found = bends(OPERATIONS, medians)
        assert not np.any((found > 380) & (found < 620))


@pytest.mark.parametrize("n", [0, 1, 5, 19])
def test_too_short_a_series(n):
    found = bends(np.arange(n), series(4, bend=500.0, at=n // 2, n=n))
    np.testing.assert_array_equal(found, NONE)


@pytest.mark.parametrize("n", [20, 21, 60, 121])
def test_short_series(n):
    """With fewer operations than blocks each is a block of its own; a sharp bend is found."""
    found = bends(np.arange(1, n + 1), series(5, bend=2000.0, at=n // 2, n=n))
    assert found.size >= 1
    assert np.abs(found - n // 2).min() <= 3


def test_a_series_without_noise_has_no_scale():
    medians = series(6)
    medians[:, 2] = 1.0
    np.testing.assert_array_equal(bends(OPERATIONS, medians), NONE)
