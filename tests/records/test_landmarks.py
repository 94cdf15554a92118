"""When the motion starts, nearly unbiased."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS
from breaker.records.checks import doubtful_samples
from breaker.records.first_motion import first_motion
from breaker.records.rejections import UnusableError


def start_of(time, travel, motion):
    return first_motion(time, travel, motion)[0]


CURVES = 500
# Bias and sd over 3,000 curves of each motion are at most 0.056 and 0.123 ms. With 500 curves the
# bias has a standard error of 0.0055 ms and the sd one of 0.004 ms: false alarms below 1e-4.
LARGEST_BIAS, LARGEST_SD = 0.08, 0.14


@pytest.fixture(scope="module", params=MOTIONS)
def records(request, prior, sensor):
    """Noisy curves of the prior at 10 kHz whose motion starts anywhere between 8 and 12 ms."""
    motion = request.param
    rng = generator(3, "test first motion", motion)
    time = 0.1 * np.arange(760)
    moves = rng.uniform(8.0, 12.0, CURVES)
    theta = prior.sample(CURVES, rng)
    exact = travel(theta, time, motion, onset=moves).travel
    return time, sensor.corrupt(exact, rng), moves, theta, motion


def changed(records, change, n=CURVES):
    """Errors of records after a change of ``(time, record, start)``, ms; nan where refused."""
    time, measured, moves, _, motion = records
    found = []
    for record, start in zip(measured[:n], moves[:n], strict=True):
        try:
            found.append(start_of(*change(time, record.copy(), start), motion) - start)
        except UnusableError:
            found.append(np.nan)
    return np.array(found)


def test_it_is_nearly_unbiased_and_precise(records):
    error = changed(records, lambda time, record, start: (time, record))
    assert abs(error.mean()) <= LARGEST_BIAS
    assert error.std() <= LARGEST_SD
    assert np.abs(error).max() < 0.8


@pytest.mark.parametrize("step", [0.01, 0.1, 1.0])
@pytest.mark.parametrize("start", [-7.3, 1000.0])
def test_it_does_not_depend_on_the_grid(prior, step, start):
    """From 1 to 100 kHz, wherever the samples fall."""
    for moves in 11.0 + step * np.linspace(0.0, 1.0, 4):
        time = step * np.arange(round(60.0 / step))
        record = travel(prior.medians[None], time, "closing", onset=np.array([moves])).travel[0]
        found = start_of(start + time, record, "closing")
        assert found - start == pytest.approx(moves, abs=0.15 + 0.15 * step)


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_record_at_rest_or_of_the_other_way_has_none(motion):
    time, sign = 0.1 * np.arange(700), 1.0 if motion == "closing" else -1.0
    rest = 0.1 * generator(2, "test rest").standard_normal(time.size)
    with pytest.raises(UnusableError):
        start_of(time, rest, motion)
    with pytest.raises(UnusableError):
        start_of(time, -0.15 * sign * np.maximum(time - 10.0, 0.0) ** 2, motion)


@pytest.mark.parametrize("late", [2.0, 4.0, 6.0])
def test_a_record_that_begins_in_the_motion_is_refused(records, late):
    def change(time, record, start):
        return time[time > start + late], record[time > start + late]

    assert np.isnan(changed(records, change, 50)).all()


# ---- any drive, any record ---------------------------------------------------------------------

FEW = 30  # records


@pytest.mark.parametrize("after", [-5.0, -0.5, 0.5, 1.5])
@pytest.mark.parametrize(("height", "samples"), [(8.0, 1), (8.0, 8), (-2.0, 8)])
def test_wrong_samples_do_not_move_it(records, after, height, samples):
    def change(time, record, start):
        first = np.searchsorted(time, start + after)
        record[first : first + samples] += height
        return time, np.where(doubtful_samples(record, 0.1, 0.0) == "", record, np.nan)

    wrong = changed(records, change, FEW)
    assert np.isnan(wrong).mean() <= (1.0 if samples > 1 else 0.0)
    assert np.nanmax(np.abs(np.append(wrong, 0.0))) < 0.8


@pytest.mark.parametrize(("far", "slow"), [(11.0, 4.8), (1.0, 0.4), (70.0, 50.0)])
def test_it_is_as_good_for_any_stroke_and_speed(records, far, slow):
    time, measured, moves, _, motion = records
    found = [start_of(slow * time, far * each, motion) for each in measured[:FEW]]
    error = np.array(found) / slow - moves[:FEW]
    assert abs(error.mean()) < 0.1
    assert np.abs(error).max() < 0.8


@pytest.mark.parametrize(("power", "late"), [(2.0, 0.3), (2.5, 0.9), (3.0, 1.4), (4.0, 2.2)])
def test_a_gradual_start_is_found(power, late):
    """Of 13 mm in 12 ms with 0.1 mm of noise."""
    rng = generator(5, "test gradual")
    time = 0.1 * np.arange(800)
    rise = 13.0 * np.clip((time - 30.0) / 12.0, 0.0, 1.0) ** power
    found = [start_of(time, rise + 0.1 * rng.standard_normal(800), "closing") for _ in range(FEW)]
    assert abs(np.mean(found) - 30.0) < late


@pytest.mark.parametrize("quantum", [0.02, 0.32])
@pytest.mark.parametrize("every", [1, 4])
def test_a_counter_at_any_rate(records, quantum, every):
    """Its noise at rest has no spread."""
    time, _, moves, theta, motion = records
    exact = travel(theta[:FEW], time, motion, onset=moves[:FEW]).travel[:, ::every]
    counted = quantum * np.round(exact / quantum)
    error = [start_of(time[::every], each, motion) for each in counted] - moves[:FEW]
    assert abs(error.mean()) < 0.25
    assert np.abs(error).max() < 1.2


@pytest.mark.parametrize("gap", [(0.0, 5.0), (-1.0, 1.4), (0.5, 3.0), (-100.0, 0.5)])
def test_a_start_in_a_gap_is_refused(records, gap):
    def change(time, record, start):
        inside = (time > start + gap[0]) & (time < start + gap[1])
        return time, np.where(inside, np.nan, record)

    error = changed(records, change, FEW)
    assert np.isnan(error).mean() > 0.95
    assert np.nanmax(np.abs(np.append(error, 0.0))) < 0.7


@pytest.mark.parametrize("phase", np.arange(0.0, 6.3, 1.4))
@pytest.mark.parametrize("period", [4.0, 7.0])
def test_a_linkage_that_ripples_does_not_move_it_by_much(period, phase):
    """Ripple of 2 mm in 150, that grows with the speed: a low rise alone is up to 5 ms early."""
    rng = generator(6, "test ripple")
    time = 0.1 * np.arange(2000)
    share = np.clip((time - 60.0) / 60.0, 0.0, 1.0)
    way, speed = 150.0 * share**2 * (3.0 - 2.0 * share), 4.0 * share * (1.0 - share)
    way += 2.0 * speed * np.sin(2.0 * np.pi * time / period + phase)
    found, sd = first_motion(time, way + 0.05 * rng.standard_normal(time.size), "closing")
    assert abs(found - 60.0) < max(2.5, 3.0 * sd)
