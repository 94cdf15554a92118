"""Damage to records and to files: what is drawn, that it is damage, and that a seed repeats it."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.family.curve_file import write_curve
from studies.faults.files import TEXT
from studies.faults.records import PHYSICAL

TIME = np.arange(0.0, 70.0, 0.1)
DRAWS = 12  # of each kind


@pytest.fixture(scope="module")
def travel():
    noise = 0.1 * generator(1, "test damage").standard_normal(TIME.size)
    return 16.0 / (1.0 + np.exp(22.0 - TIME)) + noise


@pytest.fixture(scope="module")
def content(travel, tmp_path_factory):
    file = tmp_path_factory.mktemp("good") / "operation_1.csv"
    write_curve(file, TIME, travel, motion="closing", operation=1)
    return file.read_bytes()


@pytest.mark.parametrize("kind", PHYSICAL)
def test_a_record_is_damaged(kind, travel):
    before = TIME.tobytes(), travel.tobytes()
    changed = 0
    for number in range(DRAWS):
        once, again = (PHYSICAL[kind](TIME, travel, generator(2, kind, number)) for _ in range(2))
        for one, other in zip(once, again, strict=True):
            assert one.tobytes() == other.tobytes()
        time, damaged = once
        assert time.shape == damaged.shape
        assert time.size >= 2
        same = time.size == TIME.size and np.array_equal(once, (TIME, travel))
        changed += not same
    assert (TIME.tobytes(), travel.tobytes()) == before
    assert changed == 0 if kind == "nothing" else changed > DRAWS / 2


@pytest.mark.parametrize("kind", TEXT)
def test_a_file_is_damaged(kind, content):
    damaged = [TEXT[kind](content, generator(2, kind, number)) for number in range(DRAWS)]
    assert damaged == [TEXT[kind](content, generator(2, kind, i)) for i in range(DRAWS)]
    assert sum(item != content for item in damaged) >= DRAWS / 2


def test_severity_is_spread(travel):
    heights = [
        np.abs(PHYSICAL["spikes"](TIME, travel, generator(4, i))[1] - travel).max()
        for i in range(200)
    ]
    # Log-uniform from 0.05 to 100 mm: 24 % below 0.3 mm, 40 % above 5 mm; 4.5 standard errors.
    assert 0.1 < np.mean(np.array(heights) < 0.3) < 0.38
    assert 0.24 < np.mean(np.array(heights) > 5.0) < 0.56
