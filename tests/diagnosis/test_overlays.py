"""Records over a good one."""

import numpy as np
import pytest

from breaker.diagnosis.curves import overlaid
from breaker.diagnosis.reading import read_operations
from breaker.family.curve_file import write_curve
from breaker.records.operations import Operation

DURATION = 20.0  # ms, of a good motion


def record(file, *, duration=DURATION, begins=30.0, step=0.1, top=14.0):
    """A closing, read as a command does."""
    time = step * np.arange(round(200.0 / step))
    share = np.clip((time - begins) / duration, 0.0, 1.0)
    noise = 0.01 * np.random.default_rng(1).standard_normal(time.size)
    travel = top * share**2 * (3.0 - 2.0 * share) + noise
    write_curve(file, time, travel, motion="closing", operation=1)
    return read_operations({"closing": [Operation(1, file)]}, {})


@pytest.fixture
def good(tmp_path):
    return record(tmp_path / "good.csv")


def test_a_record_over_one_like_it_stays_within(tmp_path, good):
    """Its place in the file, and its rate, do not matter."""
    (found,) = overlaid(record(tmp_path / "a.csv", begins=61.7, step=0.05), good)
    assert found.leaves is None
    assert abs(found.farthest[1]) < 0.25
    assert found.band == pytest.approx(0.05 * 14.0, rel=0.01)
    assert (found.words.code, found.words.values["share"]) == ("overlay-within", "5")


def test_where_a_slow_record_leaves_the_band_is_told(tmp_path, good):
    (found,) = overlaid(record(tmp_path / "slow.csv", duration=1.3 * DURATION), good, 0.1)
    at, by = found.leaves
    share = np.array([at / DURATION, at / (1.3 * DURATION)])
    way = 14.0 * share**2 * (3.0 - 2.0 * share)
    assert by == pytest.approx(-1.4, abs=0.1)
    assert way[1] - way[0] == pytest.approx(by, abs=0.25)
    assert found.words.code == "overlay-leaves"


def test_a_motion_without_a_good_one_is_left_out(tmp_path, good):
    time = 0.1 * np.arange(2000)
    travel = 14.0 * np.clip(1.0 - (time - 30.0) / 10.0, 0.0, 1.0)
    write_curve(tmp_path / "open.csv", time, travel, motion="opening", operation=1)
    opening = read_operations({"opening": [Operation(1, tmp_path / "open.csv")]}, {})
    assert overlaid(opening, good) == []
