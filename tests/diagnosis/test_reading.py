"""Every motion of a record, and records over a good one."""

import numpy as np
import pytest

from breaker.configuration.loading import merge
from breaker.diagnosis.curves import overlaid
from breaker.diagnosis.reading import read_operations
from breaker.diagnosis.session import Diagnosis
from breaker.family.endurance import write_curve
from breaker.records.named import ANY, Choice
from breaker.records.operations import Operation

DURATION = 20.0  # ms, of a good motion


def write(file, travel, *, step=0.1, motion="closing", number=1):
    """Write a record with noise; its operation."""
    time = step * np.arange(travel.size)
    noisy = travel + 0.01 * np.random.default_rng(1).standard_normal(travel.size)
    write_curve(file, time, noisy, motion=motion, operation=1)
    return Operation(number, file, phase="R")


def read(operation, motion=ANY):
    return read_operations({motion: [operation]}, {})


# ---- motions of a record -------------------------------------------------------------------------

TIME = 0.1 * np.arange(6000)  # ms
OPENS, CLOSES = (50.0, 400.0), 200.0


def ramp(begin, duration=10.0):
    return 14.0 * np.clip((TIME - begin) / duration, 0.0, 1.0)


def test_an_oco_has_three_motions_and_states_where_the_openings_are(tmp_path):
    travel = 14.0 - ramp(OPENS[0]) - ramp(OPENS[1]) + ramp(CLOSES)
    records = read(write(tmp_path / "oco.csv", travel, motion="opening", number=4))
    records.sort(key=lambda one: one.raw.moves)
    motions = [(one.motion, one.operation.number) for one in records]
    assert motions == [("opening", 4), ("closing", 4), ("opening", 5)]
    assert records[0].operation.end < OPENS[1]
    assert records[2].operation.begin > OPENS[0] + 10.0
    assert np.isnan(records[1].operation.begin)


def test_a_file_that_states_its_only_motion_has_no_other_one(tmp_path):
    """Planted fault: it states the motion that it does not contain."""
    file = tmp_path / "a.csv"
    operation = write(file, ramp(CLOSES))
    rows = file.read_text()
    for stated, rejected in {"Close": False, "Open": True}.items():
        file.write_text(f"Operation: {stated}\n{rows}")
        (one,) = read(operation)
        assert (one.motion, bool(one.reason)) == ("closing", rejected)


@pytest.mark.parametrize(("stated", "rejected"), [("C-O", ["opening"]), ("C", []), ("", [])])
def test_a_stated_motion_that_is_not_in_the_record_is_rejected(tmp_path, stated, rejected):
    operation = write(file := tmp_path / "a.csv", ramp(CLOSES))
    file.write_text(f"Operation: {stated}\n{file.read_text()}")
    records = read(operation)
    assert [e.motion for e in records if not e.reason] == ["closing"]
    missing = [e for e in records if getattr(e.reason, "code", "") == "stated-motion-missing"]
    assert [e.motion for e in missing] == rejected
    assert len(records) == 1 + len(rejected)


def test_a_pole_that_stands_still_is_a_rejected_record(tmp_path, defaults):
    file, way = tmp_path / "a.csv", ramp(50.0)
    rng = np.random.default_rng(2)
    travels = [share * way + 0.01 * rng.standard_normal(way.size) for share in (1.0, 0.0, 0.0)]
    rows = np.column_stack([TIME / 1e3, *travels, way > 7.0, way > 7.0, 0.0 * way])
    names = "Time (s),Travel R (mm),Travel S (mm),Travel T (mm),Contact R,Contact S,Contact T"
    np.savetxt(file, rows, "%.4f", ",", header=names, comments="")
    form = {"time_column": "Time", "travel_column": "Travel R"}
    limits = [{"name": "a", "motion": "closing", "lower": {"stroke": 13.0}}]
    config = merge(defaults, {"endurance": {"format": form, "draws": 60}})
    report = Diagnosis(config, limits).of_files([file], Choice(every=True)).result
    assert {(e.get("phase"), e["accepted"]) for e in report["records"]} == {("R", 1), ("S", 0)}
    assert report["verdict"] == "pass"
    assert [warning.code for warning in report["warnings"]] == ["rejected-not-judged"]
    (alone,) = Diagnosis(config).of_files([file], Choice(phase="S")).records
    assert str(file) in alone.reason


# ---- records over a good one ---------------------------------------------------------------------


def closing(file, *, duration=DURATION, begins=30.0, step=0.1):
    """A smooth closing of 14 mm, as a command reads it."""
    share = np.clip((step * np.arange(round(200.0 / step)) - begins) / duration, 0.0, 1.0)
    return read(write(file, 14.0 * share**2 * (3.0 - 2.0 * share), step=step), "closing")


@pytest.mark.parametrize(
    ("about", "leaves"),
    [
        ({"begins": 61.7, "step": 0.05}, None),  # place in the file and rate do not matter
        ({"duration": 1.3 * DURATION}, -0.7),
    ],
)
def test_a_record_stays_within_the_band_of_one_like_it(tmp_path, about, leaves):
    good, other = closing(tmp_path / "good.csv"), closing(tmp_path / "other.csv", **about)
    (over,), _ = overlaid(other, good)
    assert over.band == pytest.approx(0.05 * 14.0, rel=0.01)
    if leaves is None:
        assert over.leaves is None
        assert abs(over.farthest[1]) < 0.25
        assert over.words.code == "overlay-within"
        return
    at, by = over.leaves
    share = np.array([at / DURATION, at / about["duration"]])
    way = 14.0 * share**2 * (3.0 - 2.0 * share)
    assert by == pytest.approx(leaves, abs=0.1)
    assert way[1] - way[0] == pytest.approx(by, abs=0.25)
    assert over.words.code == "overlay-leaves"
