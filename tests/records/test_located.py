"""A record that goes there and back ends where it began, or its transducer slipped."""

import numpy as np
import pytest

from breaker.records.operations import Operation
from breaker.records.reader import Reader
from breaker.records.settings import complete

STROKE = 150.0


def raws(tmp_path, *, slip=0.0, noise=0.05, creeps=0.0, swings=0.0, ends=400.0, rate=5.0, seed=1):
    """Closing and opening of one record, or why there is none; with a slip in the closing."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, ends, 1.0 / rate)

    def done(at, lasts):
        share = np.clip((time - at) / lasts, 0.0, 1.0)
        return share**2 * (3.0 - 2.0 * share)

    travel = STROKE * (done(40.0, 50.0) - done(200.0, 30.0)) + slip * (time > 85.0)
    travel += creeps * np.exp(-(time - 230.0) / 60.0) * (time > 215.0) * done(200.0, 30.0)
    late = np.maximum(time - 230.0, 0.0)
    travel -= swings * np.sin(late / 20.0) * np.exp(-late / 50.0)
    travel += noise * rng.standard_normal(time.size)
    path = tmp_path / "a.csv"
    np.savetxt(path, np.c_[time, travel], delimiter=",", header="time,travel", comments="")
    settings = complete({"time_unit": "ms", "travel_unit": "mm", "zero": "rest"})
    return [
        each for (each,) in Reader(settings).read_all([Operation(1, path)], "closing", "opening")
    ]


@pytest.mark.parametrize("slip", [-3.0, 2.0])
def test_a_slip_that_no_sample_shows_is_in_the_stroke(tmp_path, slip):
    for raw in raws(tmp_path, slip=slip, noise=0.3):
        assert raw.unreturned == pytest.approx(abs(slip), abs=0.5)
        stroke = raw.measured(())["stroke"]
        assert abs(stroke.value - STROKE) < 2.5 * stroke.sd
        assert "the transducer slipped" in " ".join(raw.remarks_on())


@pytest.mark.parametrize(
    "case", [{}, {"noise": 0.5}, {"creeps": 3.0}, {"swings": 15.0}, {"ends": 150.0}]
)
def test_a_record_that_returns_creeps_or_ends_before_has_none(tmp_path, case):
    """In 20 records of each; that noise looks like a slip has a probability of 1e-9 in each."""
    for seed in range(20):
        found = raws(tmp_path, **case, seed=seed)
        assert isinstance(found[1], Exception) == (case.get("ends") == 150.0)
        for raw in found[: 1 if "ends" in case else 2]:
            assert raw.unreturned == 0.0


def test_a_slip_of_the_first_of_three_motions_is_seen_by_the_rests_of_one_position(tmp_path):
    """Of open, close, open the record ends elsewhere than it begins, and was closed twice."""
    rng, time = np.random.default_rng(2), np.arange(0.0, 700.0, 0.2)

    def done(at, lasts):
        share = np.clip((time - at) / lasts, 0.0, 1.0)
        return share**2 * (3.0 - 2.0 * share)

    way = STROKE * (1.0 - done(40.0, 30.0) + done(250.0, 50.0) - done(450.0, 30.0))
    for slip in (0.0, 2.5):
        travel = way + slip * (time > 68.0) + 0.1 * rng.standard_normal(time.size)
        np.savetxt(tmp_path / "a.csv", np.c_[time, travel], delimiter=",", header="time,travel")
        (tmp_path / "a.csv").write_text((tmp_path / "a.csv").read_text().removeprefix("# "))
        settings = complete({"time_unit": "ms", "travel_unit": "mm", "zero": "rest"})
        operation = Operation(1, tmp_path / "a.csv", begin=200.0, end=420.0)
        raw = Reader(settings).read(operation, "closing")
        assert raw.unreturned == pytest.approx(slip, abs=0.2)


@pytest.mark.parametrize("slip", [-1.2, 0.0, 1.2])
def test_a_slip_within_the_noise_of_one_motion_is_in_its_stroke(tmp_path, slip):
    """No rest contradicts it: single samples show it in some records, those about it in all."""
    time, settings = np.arange(0.0, 300.0, 0.2), complete({"travel_unit": "mm", "zero": "rest"})
    way = STROKE * np.sin(0.5 * np.pi * np.clip((time - 40.0) / 50.0, 0.0, 1.0))
    exact = {"stroke": STROKE, "travel_time": 100.0 / np.pi * (np.arcsin(0.9) - np.arcsin(0.1))}
    for seed in range(10):
        travel = way + slip * (time > 85.0)
        travel += 0.1 * np.random.default_rng(seed).standard_normal(time.size)
        path = tmp_path / "a.csv"
        np.savetxt(path, np.c_[time, travel], delimiter=",", header="time,travel", comments="")
        raw = Reader(settings | {"time_unit": "ms"}).read(Operation(1, path), "closing")
        remarks = " ".join(raw.remarks_on())
        assert ("slip at" in remarks) + ("the transducer slipped" in remarks) == bool(slip)
        for name, found in raw.measured(()).items():
            if name in exact:
                assert abs(found.value - exact[name]) < 3.5 * found.sd
                assert slip or found.sd < 0.05


def test_a_first_motion_in_the_creep_of_the_motion_before_is_uncertain(tmp_path):
    """Of an opening soon after a closing that went too far and comes back, 0.1 mm/ms still."""
    time, settings = np.arange(0.0, 350.0, 0.4), complete({"travel_unit": "mm", "zero": "rest"})
    closing, opening = (np.clip((time - at) / 50.0, 0.0, 1.0) for at in (40.0, 160.0))
    back = 8.0 * np.exp(-np.maximum(time - 90.0, 0.0) / 60.0) * (time > 70.0)
    for creeps in (0.0, 1.0):
        way = STROKE * closing**2 * (3.0 - 2.0 * closing) + creeps * back * closing**4
        way *= 1.0 - opening**2 * (3.0 - 2.0 * opening)
        for seed in range(10):
            travel = way + 0.05 * np.random.default_rng(seed).standard_normal(time.size)
            path = tmp_path / "a.csv"
            np.savetxt(path, np.c_[time, travel], delimiter=",", header="time,travel", comments="")
            raw = Reader(settings | {"time_unit": "ms"}).read(Operation(1, path), "opening")
            assert abs(raw.moves - 160.0) < 2.5 * raw.start_sd or raw.start_hidden
