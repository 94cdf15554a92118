"""Motions in records of files: a slip is in the stroke, a creep before in the first motion."""

import numpy as np
import pytest

from breaker.records.operations import Operation
from breaker.records.reader import Reader
from breaker.records.settings import complete

STROKE = 150.0


def read(folder, time, travel, motion):
    path = folder / "a.csv"
    np.savetxt(path, np.c_[time, travel], delimiter=",", header="time,travel", comments="")
    settings = complete({"time_unit": "ms", "travel_unit": "mm", "zero": "rest"})
    return Reader(settings).read(Operation(1, path), motion)


@pytest.mark.parametrize("slip", [-1.2, 0.0, 1.2])
def test_a_slip_in_a_motion_is_in_its_stroke(tmp_path, slip):
    """Of ten strokes and times each; 3.5 sds are exceeded with 1e-3 for each of both tests."""
    time = np.arange(0.0, 300.0, 0.2)
    way = STROKE * np.sin(0.5 * np.pi * np.clip((time - 40.0) / 50.0, 0.0, 1.0))
    exact = {"stroke": STROKE, "travel_time": 100.0 / np.pi * (np.arcsin(0.9) - np.arcsin(0.1))}
    for seed in range(10):
        travel = way + slip * (time > 85.0)
        travel += 0.1 * np.random.default_rng(seed).standard_normal(time.size)
        raw = read(tmp_path, time, travel, "closing")
        assert ("slip" in raw.doubts) == bool(slip)
        for name, result in raw.measured(()).items():
            if name in exact:
                assert abs(result.value - exact[name]) < 3.5 * result.sd
                assert slip or result.sd < 0.05


def test_a_first_motion_in_the_creep_of_the_motion_before_is_uncertain(tmp_path):
    """Of an opening soon after a closing that went too far and comes back, 0.1 mm/ms still."""
    time = np.arange(0.0, 350.0, 0.4)
    closing, opening = (np.clip((time - at) / 50.0, 0.0, 1.0) for at in (40.0, 160.0))
    back = 8.0 * np.exp(-np.maximum(time - 90.0, 0.0) / 60.0) * (time > 70.0)
    for creeps in (0.0, 1.0):
        way = STROKE * closing**2 * (3.0 - 2.0 * closing) + creeps * back * closing**4
        way *= 1.0 - opening**2 * (3.0 - 2.0 * opening)
        for seed in range(10):
            travel = way + 0.05 * np.random.default_rng(seed).standard_normal(time.size)
            raw = read(tmp_path, time, travel, "opening")
            assert abs(raw.moves - 160.0) < 2.5 * raw.reading.start_sd or raw.reading.start_hidden
