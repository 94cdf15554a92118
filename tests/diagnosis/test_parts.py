"""Every motion of a record."""

import numpy as np

from breaker.diagnosis.reading import read_operations
from breaker.family.curve_file import write_curve
from breaker.records.named import ANY
from breaker.records.operations import Operation

TIME = 0.1 * np.arange(6000)  # ms
BEGINS = {"opening": (50.0, 400.0), "closing": (200.0,)}


def written(file, *, still=False):
    way = [14.0 * np.clip((TIME - at) / 10.0, 0.0, 1.0) for each in BEGINS.values() for at in each]
    travel = 14.0 - way[0] - way[1] + way[2]
    travel = np.full_like(TIME, 14.0) if still else travel
    travel = travel + 0.01 * np.random.default_rng(1).standard_normal(TIME.size)
    write_curve(file, TIME, travel, motion="opening", operation=1)
    return Operation(4, file, phase="R")


def read(operation):
    return read_operations({ANY: [operation]}, {})


def test_an_oco_has_three_motions_and_says_where_the_openings_are(tmp_path):
    found = read(written(tmp_path / "oco.csv"))
    found.sort(key=lambda each: each.raw.moves)
    assert [(each.motion, each.operation.number) for each in found] == [
        ("opening", 4),
        ("closing", 4),
        ("opening", 5),
    ]
    for each, begin in zip(found[::2], BEGINS["opening"], strict=True):
        assert not each.operation.begin >= begin
        assert not each.operation.end <= begin + 10.0
        assert each.operation.phase == "R"
    assert found[0].operation.end < BEGINS["opening"][1]
    assert found[2].operation.begin > BEGINS["opening"][0] + 10.0
    assert np.isnan(found[1].operation.begin)


def test_where_nothing_moves_there_is_a_reason(tmp_path):
    (found,) = read(written(tmp_path / "still.csv", still=True))
    assert "nothing moves" in found.reason


def test_a_file_that_states_its_only_motion_has_no_other_one(tmp_path):
    """Planted: it states the one that it does not hold."""
    travel = 14.0 * np.clip((TIME - 200.0) / 10.0, 0.0, 1.0)
    travel += 0.01 * np.random.default_rng(1).standard_normal(TIME.size)
    file = tmp_path / "a.csv"
    write_curve(file, TIME, travel, motion="closing", operation=1)
    rows = file.read_text()
    for stated, rejected in {"Close": False, "Open": True}.items():
        file.write_text(f"Operation: {stated}\n{rows}")
        (found,) = read(Operation(1, file))
        assert (found.motion, bool(found.reason)) == ("closing", rejected)
