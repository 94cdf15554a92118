"""What only a whole record shows: the range of the transducer ends within the stroke."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS
from breaker.records.checks import range_remark


@pytest.mark.parametrize("motion", MOTIONS)
def test_good_records_have_no_remark(prior, motion):
    """The rate is 1.3e-4: of 150 more than 1 have one at 2e-4."""
    rng, time = generator(6, "test consistency", motion), np.arange(0.0, 76.0, 0.1)
    moves = 8.0 + 4.0 * rng.random(150)
    exact = travel(prior.sample(150, rng), time, motion, onset=moves).travel
    measured = exact + 0.1 * rng.standard_normal(exact.shape)
    for quantum in (0.0, 0.08):
        records = quantum * np.rint(measured / quantum) if quantum else measured
        pairs = zip(records, moves, strict=True)
        assert sum(bool(range_remark(time, x, at, quantum)) for x, at in pairs) <= 1


def test_a_counter_that_rests_is_at_no_end_of_a_range():
    time = np.arange(0.0, 60.0, 0.1)
    counted = 0.32 * np.floor(0.3 * np.clip(time - 25.0, 0.0, 7.0) ** 2 / 0.32)
    assert range_remark(time, counted, 25.0, 0.32) == ""


@pytest.mark.parametrize("share", [0.7, 0.8, 0.9])
def test_a_range_that_ends_below_the_stroke_is_seen_through_noise(prior, share):
    """Of 100 closings that are cut so at least 80 are named, and of 100 whole ones none."""
    rng, time = generator(7, "range"), np.arange(0.0, 76.0, 0.1)
    exact = travel(prior.sample(100, rng), time, "closing", onset=10.0).travel
    noise = 0.01 * rng.standard_normal(exact.shape)
    cut = np.minimum(exact, share * exact[:, -1:])
    named = [sum(bool(range_remark(time, x, 10.0)) for x in each + noise) for each in (cut, exact)]
    assert named[0] >= 80
    assert named[1] == 0


@pytest.mark.parametrize("noise", [0.02, 0.1])
@pytest.mark.parametrize("motion", MOTIONS)
def test_a_flat_end_of_the_range_is_seen_where_noise_lies_on_it(prior, motion, noise):
    """Noise of the transducer is cut off there and that of the recorder is not: of 100 records that
    are cut at least 95 are named, and of 100 whole ones none, which noise hides as well.
    """
    rng, time = generator(8, "range", motion), np.arange(0.0, 76.0, 0.1)
    exact = travel(prior.sample(100, rng), time, motion, onset=20.0).travel
    measured = exact + noise * rng.standard_normal(exact.shape)
    low, high = measured.min(axis=1, keepdims=True), measured.max(axis=1, keepdims=True)
    cut = np.minimum(measured, low + 0.8 * (high - low))
    named = [
        sum(bool(range_remark(time, x, 20.0)) for x in each)
        for each in (cut + 0.5 * noise * rng.standard_normal(exact.shape), measured)
    ]
    assert named[0] >= 95
    assert named[1] == 0
