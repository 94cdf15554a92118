"""Requests to the mechanism: blocks of rows, and faults named wherever they are."""

import numpy as np
import pytest

from breaker.mechanism import curves
from breaker.mechanism.curves import _contiguous as contiguous
from breaker.mechanism.curves import blocks, check
from breaker.mechanism.parameters import NAMES
from breaker.model.randomness import generator


@pytest.fixture
def small_blocks(monkeypatch):
    monkeypatch.setattr(curves, "_ROWS", 8)


def many(prior, n):
    return prior.sample(n, generator(1, "test", "arguments"))


@pytest.mark.parametrize("n", [0, 1, 7, 8, 9, 24, 25])
def test_blocks_are_all_rows_once(small_blocks, n):
    parts = list(blocks(n))
    assert [k for rows in parts for k in range(n)[rows]] == list(range(n))
    assert all(rows.stop - rows.start <= 8 for rows in parts)


def test_only_what_has_to_be_is_copied():
    array = np.arange(12.0).reshape(4, 3)
    same, turned, single = contiguous(array, array[::-1], array.astype(np.float32))
    assert same is array
    assert turned.flags.c_contiguous
    assert single.dtype == np.float64


def test_arguments_are_not_copied(prior, sensor):
    theta, onset = many(prior, 20), np.zeros(20)
    checked, _, onsets = check(theta, sensor.times, "closing", onset)
    assert checked is theta
    assert np.shares_memory(onsets, onset)
    one = check(theta, sensor.times, "closing", 0.5)[2]
    assert one.shape == (20,)
    assert one.strides == (0,)


def test_faults_are_counted_over_all_blocks(small_blocks, prior, sensor):
    theta = many(prior, 30)
    theta[[19, 29], NAMES.index("k_b")] = -1.0
    theta[29, NAMES.index("f")] = np.nan
    with pytest.raises(ValueError, match=r"2 of 30 rows .* the first is k_b = -1\.0 in row 19"):
        check(theta, sensor.times, "closing", 0.0)


def test_onsets_are_checked_in_all_blocks(small_blocks, prior, sensor):
    onset = np.zeros(30)
    onset[29] = np.inf
    with pytest.raises(ValueError, match=r"onset must be one finite time or one per row, \(30,\)"):
        check(many(prior, 30), sensor.times, "closing", onset)


@pytest.mark.parametrize("k_b", [1e20, 1e308])
def test_drives_that_are_too_fast_are_refused_by_row(small_blocks, prior, sensor, k_b):
    theta = many(prior, 30)
    theta[19, NAMES.index("k_b")] = k_b
    with pytest.raises(ValueError, match=r"row 19 is too fast to follow over 60 ms.*'k_b': 1e"):
        check(theta, sensor.times, "closing", 0.0)


def test_a_motion_long_before_the_record_counts_as_well(small_blocks, prior, sensor):
    theta, onset = many(prior, 30), np.zeros(30)
    check(theta, sensor.times, "closing", onset)
    onset[19] = -1e9
    with pytest.raises(ValueError, match=r"row 19 is too fast to follow over 1e\+09 ms"):
        check(theta, sensor.times, "closing", onset)
