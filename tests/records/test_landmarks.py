"""When the motion starts, nearly unbiased, and how long it takes between two shares of its way."""

import numpy as np
import pytest

from breaker.mechanism.curves import travel
from breaker.mechanism.parameters import MOTIONS, NAMES
from breaker.model.randomness import generator
from breaker.records.landmarks import NoMotionError, first_motion, raw_time

CURVES = 500
DIRECTION = {"closing": 1.0, "opening": -1.0}
# Bias and sd over 4,000 curves of each motion are 0.042 and 0.097 ms. With 500 curves the bias has
# a standard error of 0.0043 ms and the sd one of 0.003 ms: false alarms below 1e-4 and 1e-9.
LARGEST_BIAS, LARGEST_SD = 0.06, 0.12


def by_threshold(time, record, direction):
    """The planted fault: the first of five samples in a row that are 0.5 mm from the rest."""
    risen = direction * (record - np.median(record[:5])) > 0.5
    return time[np.flatnonzero(np.convolve(risen, np.ones(5), mode="valid") == 5)[0]]


@pytest.fixture(scope="module", params=MOTIONS)
def records(request, prior, sensor):
    """Noisy curves of the prior at 10 kHz whose motion starts anywhere between 8 and 12 ms."""
    motion = request.param
    rng = generator(3, "test first motion", motion)
    time = 0.1 * np.arange(760)
    moves = rng.uniform(8.0, 12.0, CURVES)
    theta = prior.sample(CURVES, rng)
    exact = travel(theta, time, motion, onset=moves).travel
    return time, sensor.corrupt(exact, rng), moves, theta, DIRECTION[motion]


def errors(find, records):
    time, measured, moves, _, direction = records
    return np.array([find(time, record, direction) for record in measured]) - moves


def test_it_is_nearly_unbiased_and_precise(records):
    error = errors(first_motion, records)
    assert abs(error.mean()) <= LARGEST_BIAS
    assert error.std() <= LARGEST_SD
    assert np.abs(error).max() < 0.6


def test_a_threshold_would_fail_that(records):
    assert errors(by_threshold, records).mean() > 0.5


def test_it_is_no_later_for_a_weak_drive(records):
    # Difference of the means of two groups of 250, each of sd 0.1 ms: standard error 0.009 ms, so
    # that chance alone reaches 0.1 ms with a probability below 1e-10.
    theta = records[3]
    f, k_a, length = (theta[:, NAMES.index(name)] for name in ("f", "k_a", "L"))
    force = f - k_a * length if records[4] > 0 else k_a * length
    weak = force < np.median(force)
    error = errors(first_motion, records)
    assert abs(error[weak].mean() - error[~weak].mean()) < 0.1


@pytest.mark.parametrize("step", [0.02, 0.05, 0.1, 0.2, 0.4])
@pytest.mark.parametrize("start", [0.0, -7.3, 0.37, 1000.0])
def test_it_does_not_depend_on_the_grid(step, start):
    """Also where a start that is tried falls on the last sample, after which nothing has moved."""
    for moves in start + 11.0 + step * np.linspace(0.0, 1.0, 12):
        time = start + step * np.arange(round(30.0 / step))
        tau = np.maximum(time - moves, 0.0)
        record = 0.35 * tau**2 * (1.0 - 0.12 * np.minimum(tau, 5.0))
        assert first_motion(time, record, 1.0) == pytest.approx(moves, abs=0.1)


def test_shift_and_sign_and_rest_do_not_matter():
    rng = generator(1, "test shift")
    time = 0.1 * np.arange(400)
    rise = 0.35 * np.maximum(time - 12.34, 0.0) ** 2 + 0.05 * rng.standard_normal(time.size)
    found = first_motion(time, rise, 1.0)
    assert found == pytest.approx(12.34, abs=0.3)
    assert first_motion(time, 18.0 - rise, -1.0) == pytest.approx(found, abs=1e-9)
    # The starts that are tried lie on a grid of 0.01 ms, which moves with the samples.
    assert first_motion(time + 5000.0, rise, 1.0) - 5000.0 == pytest.approx(found, abs=0.011)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_record_at_rest_has_none(direction):
    rng = generator(2, "test rest")
    time = 0.1 * np.arange(700)
    with pytest.raises(NoMotionError, match=r"no motion: the travel rises by no more than 0\.\d+"):
        first_motion(time, 0.1 * rng.standard_normal(time.size), direction)


def test_a_motion_the_other_way_is_none():
    time = 0.1 * np.arange(700)
    with pytest.raises(NoMotionError, match="no motion"):
        first_motion(time, -0.15 * np.maximum(time - 10.0, 0.0) ** 2, 1.0)


@pytest.mark.parametrize("late", [2.0, 4.0, 6.0])
def test_a_record_that_begins_in_the_motion_is_refused(records, late):
    time, measured, moves, _, direction = records
    for record, start in zip(measured[:50], moves[:50], strict=True):
        inside = time > start + late
        with pytest.raises(NoMotionError, match="no rest before the motion"):
            first_motion(time[inside], record[inside], direction)


# ---- raw times -------------------------------------------------------------------------------


TIMES = np.linspace(-2.0, 58.0, 151)


def ramps(onset, speed, start=0.0, way=13.0):
    """At rest, then even: all that linear interpolation has to be exact for."""
    moved = np.clip(speed * (TIMES - np.reshape(onset, (-1, 1))), 0, abs(way))
    return start + np.sign(way) * moved


@pytest.mark.parametrize("way", [13.0, -13.0])
@pytest.mark.parametrize("start", [0.0, 13.5])
def test_raw_time_of_even_motion(way, start):
    """The time between two shares of the way, whatever the trigger, zero and direction."""
    onset = np.array([0.0, 0.17, 0.9, 3.3])
    records = ramps(onset, 0.7, start, way)
    np.testing.assert_allclose(raw_time(TIMES, records, share=0.75), 0.7 * 13.0 / 0.7)
    found = raw_time(TIMES, records, share=0.9, first=0.1)
    np.testing.assert_allclose(found, 0.8 * 13.0 / 0.7)


def test_raw_time_of_the_drive():
    """Independent of the onset to what interpolation leaves, and longer for a weaker drive."""
    theta = np.array([2.0, 0.05, 0.5, 0.15, 0.05, 0.9, 12.0])
    for motion in ("closing", "opening"):
        onsets = np.linspace(-0.3, 0.3, 7)
        records = travel(np.tile(theta, (7, 1)), TIMES, motion, onset=onsets).travel
        found = raw_time(TIMES, records, share=0.75)
        assert np.ptp(found) < 0.05
        # From time 0 instead, the trigger would enter in full.
        moved = records - records[:, :1]
        late = [np.interp(0.75, r / r[-1], TIMES[:60]) for r in moved[:, :60]]
        assert np.ptp(late) > 0.5
    weaker = theta * np.array([1, 1, 1, 1, 1, 0.9, 1])
    records = travel(np.stack([theta, weaker]), TIMES, "closing").travel
    assert np.diff(raw_time(TIMES, records, share=0.75)) > 0.2


def test_raw_time_in_noise(sensor):
    """Each crossing is off by about 0.1 mm of noise over 1.3 mm/ms, the early side of it."""
    rng = generator(4, "test", "raw times")
    records = sensor.corrupt(ramps(sensor.onset_sd * rng.standard_normal(400), 1.3), rng)
    found = raw_time(TIMES, records, share=0.75)
    assert abs(found.mean() - 7.0) < 0.05
    assert 0.07 < found.std() < 0.2


def test_raw_time_where_there_is_none():
    records = ramps(0.5, 0.7).repeat(5, axis=0)
    records[1, 30] = np.nan  # a missing sample
    records[2] = records[0] * 0.1  # no motion
    records[3, 0] = 13.0  # begins beyond both shares
    records[4] = np.nan
    found = raw_time(TIMES, records, share=0.75)
    assert np.isnan(found).tolist() == [False, True, True, True, True]


@pytest.mark.parametrize(
    ("times", "shares", "words"),
    [
        (TIMES[1:], {"share": 0.7}, "travel must be"),
        (TIMES[::-1], {"share": 0.7}, "times must increase"),
        (TIMES + 2, {"share": 0.7}, "begin before 0"),
        (TIMES, {"share": 1.0}, "shares must be"),
        (TIMES, {"share": 0.5, "first": 0.6}, "shares must be"),
    ],
)
def test_raw_time_of_unusable_arguments(times, shares, words):
    with pytest.raises(ValueError, match=words):
        raw_time(times, ramps(0.5, 0.7), **shares)
