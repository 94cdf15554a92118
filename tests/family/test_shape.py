"""Records without their size: the same numbers whatever size, rate, direction and zero."""

import numpy as np
import pytest

from breaker.common.compiling import compiled
from breaker.family.shape import SHAPE_TIMES, average, effective_noise, motion_of, shape_of


def motion(time: np.ndarray) -> np.ndarray:
    """Way of a motion that begins at 20 ms, overshoots and rests."""
    x = np.clip((time - 20.0) / 10.0, 0.0, None)
    return 14.0 * (1.0 - np.exp(-2.0 * x) * (np.cos(3.0 * x) + 2.0 / 3.0 * np.sin(3.0 * x)))


TIME = np.arange(0.0, 120.0, 0.1)


@pytest.mark.parametrize(
    ("lengths", "times", "zero", "more"), [(0.01, 4.3, 0.0, 0.0), (11.6, 0.2, -40.0, 300.0)]
)
def test_size_zero_and_rests_leave_the_shape(lengths, times, zero, more):
    """A record is cut to what networks have seen, so a long one and a short one are the same."""
    one = shape_of(motion(TIME), 0.1)
    time = np.arange(-more, 120.0 + more, 0.1)
    other = shape_of(lengths * motion(time) + zero, 0.1 * times)
    np.testing.assert_allclose(other.way, one.way, atol=1e-9)
    assert (other.present == one.present).all()
    assert other.stroke == pytest.approx(lengths * one.stroke)
    assert other.duration == pytest.approx(times * one.duration)
    assert other.origin == pytest.approx(times * (one.origin + more))


def test_the_way_is_the_mean_over_a_step_of_the_grid():
    result = shape_of(motion(TIME), 0.1)
    fine = np.linspace(-0.05, 0.05, 201)[:, None] + SHAPE_TIMES
    at = result.origin + result.duration * fine
    exact = motion(at).mean(axis=0) / result.stroke
    assert result.present[:-4].all()
    np.testing.assert_allclose(result.way[result.present], exact[result.present], atol=5e-4)


def test_like_another_record_a_record_keeps_its_own_change():
    one = shape_of(motion(TIME), 0.1)
    slower = shape_of(1.1 * motion((TIME - 20.0) / 1.2 + 20.0), 0.1, one)
    assert slower.way.max() == pytest.approx(1.1 * one.way.max(), rel=5e-3)
    assert slower.duration == pytest.approx(1.2 * one.duration, rel=1e-2)


def test_missing_samples_are_marked_and_bridged():
    travel = motion(TIME)
    gap = (TIME > 35.0) & (TIME < 60.0)
    result = shape_of(np.where(gap, np.nan, travel), 0.1)
    at = result.origin + result.duration * SHAPE_TIMES
    assert not result.present[(at > 36.0) & (at < 59.0)].any()
    assert result.present[(at > 62.0) & (at < 119.0)].all()
    assert not result.present[at > 121.0].any()
    assert np.isfinite(result.way).all()


@pytest.mark.parametrize("travel", [np.zeros(500), np.full(500, np.nan), TIME[:5]])
def test_a_record_without_a_motion_has_no_shape(travel):
    assert shape_of(travel, 0.1) is None


def test_noise_after_the_average_is_as_large_as_estimated():
    rng, sd, step = np.random.default_rng(1), 0.1, 0.05
    clean, time = shape_of(motion(TIME), 0.1), np.arange(0.0, 120.0, step)
    records = motion(time) + sd * rng.standard_normal((60, time.size))
    rest = slice(90, 115)  # of the grid, after the motion
    error = [shape_of(record, step).way[rest] - clean.way[rest] for record in records]
    expected = effective_noise(sd / clean.stroke, 0.0, step / clean.duration)
    # Of some 1,500 values: 6 % is three of its standard deviations.
    assert np.std(error) == pytest.approx(expected, rel=0.06)


def test_compiled_code_gives_the_same():
    """Training compiles what inference runs as it is; a sum in another order shows in no result."""
    record = motion(TIME) + 0.1 * np.random.default_rng(1).standard_normal(TIME.size)
    shape = shape_of(record, 0.1)
    numbers = compiled()(motion_of)(record, 0.1)
    np.testing.assert_allclose(numbers[:4], shape[2:], rtol=1e-12)
    way, present = np.empty(SHAPE_TIMES.size), np.empty(SHAPE_TIMES.size, dtype=np.bool_)
    compiled()(average)(record, 0.1, numbers, (numbers[1], numbers[3]), way, present)
    np.testing.assert_allclose(way, shape.way, atol=1e-12)
    assert (present == shape.present).all()
