"""Each kind of damage to a record or a file is damage, and writes into no array that it is given.

``test_faults`` repeats a seed.
"""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.family.endurance import write_curve
from studies.faults.files import TEXT
from studies.faults.records import PHYSICAL

TIME = np.arange(0.0, 70.0, 0.1)
TRAVEL = 16.0 / (1.0 + np.exp(22.0 - TIME))
TRAVEL += 0.1 * generator(1, "test damage").standard_normal(TIME.size)
DRAWS = 12  # of each kind


@pytest.mark.parametrize("kind", PHYSICAL)
def test_a_record_is_damaged(kind):
    before, changed = (TIME.tobytes(), TRAVEL.tobytes()), 0
    for number in range(DRAWS):
        time, damaged = PHYSICAL[kind](TIME, TRAVEL, generator(2, kind, number))
        assert time.shape == damaged.shape
        assert time.size >= 2
        changed += (time.tobytes(), damaged.tobytes()) != before
    assert (TIME.tobytes(), TRAVEL.tobytes()) == before
    assert changed == 0 if kind == "nothing" else changed > DRAWS / 2


@pytest.mark.parametrize("kind", TEXT)
def test_a_file_is_damaged(kind, tmp_path):
    write_curve(tmp_path / "a.csv", TIME, TRAVEL, motion="closing", operation=1)
    content = (tmp_path / "a.csv").read_bytes()
    damaged = [TEXT[kind](content, generator(2, kind, number)) for number in range(DRAWS)]
    assert sum(item != content for item in damaged) >= DRAWS / 2
