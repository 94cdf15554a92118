"""The reader of curve files: what it makes of good ones, and of bad ones."""

import logging
import os
import threading
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from breaker.common.randomness import generator
from breaker.common.zarr_store import describe, open_store, save
from breaker.family.endurance import write_curve
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS
from breaker.records.curves import Grid, open_curves, put_on_grid, read_curves
from breaker.records.files import LARGEST, RejectedCurveError
from breaker.records.operations import Operation
from breaker.records.reader import Reader
from breaker.records.settings import FORMAT

STEP, EVERY = 0.1, 4  # ms between samples of a file; samples for one of the model's grid
HEAD = 6  # lines before the first sample of what write_curve writes


def record(prior, motion, *, step=STEP, noise=0.05, seed=1):
    """Times, ms, and travel, mm, of the median breaker; the travel has three digits, as a file."""
    time = step * np.arange(round(76.0 / step) + 1)
    exact = travel(prior.medians[None], time, motion, onset=10.0).travel[0]
    rng = generator(seed, "test record", motion)
    return time, np.round(exact + noise * rng.standard_normal(time.size), 3)


@pytest.fixture
def times(sensor):
    return sensor.times


@pytest.fixture
def file(tmp_path):
    return tmp_path / "operation_0012.csv"


def written(file, prior, motion="closing", **more):
    """Write a good record; returns its times and travel."""
    time, x = record(prior, motion, **more)
    write_curve(file, time, x, motion=motion, operation=12)
    return time, x


def read_curve(file, settings, times, motion):
    """Travel on the grid, ``(t,)``, and the file's time that is 0 on it."""
    gridded = put_on_grid(Reader(settings).read(Operation(12, file), motion), Grid(times)).gridded
    return gridded.travel, gridded.start


def edit(file, at, text=None):
    """Put a text in place of the travel in a line, or delete the line; lines begin with 1."""
    lines = file.read_text(encoding="utf-8").split("\n")
    lines[at - 1 : at] = [] if text is None else [f"{lines[at - 1].split(',')[0]},{text}"]
    file.write_text("\n".join(lines), encoding="utf-8")


@pytest.mark.parametrize("gap", ["", None])
@pytest.mark.parametrize("motion", MOTIONS)
def test_what_is_written_is_read_back_and_missing_samples_are_read_as_such(
    file, prior, times, motion, gap
):
    """On the grid, between its samples, and a stretch; the rest is what it was, at its time."""
    time, x = written(file, prior, motion)
    whole, start = read_curve(file, FORMAT, times, motion)
    first = round((start + times[0]) / STEP)
    # Whole samples, equal to the last digit: neither averaged nor interpolated.
    np.testing.assert_array_equal(whole, x[first : first + EVERY * times.size : EVERY])
    assert time[first] - times[0] == pytest.approx(start, abs=1e-9)
    assert start == pytest.approx(10.0, abs=0.5)
    gone = [100, 61, 60, *range(25, 20, -1), 1]  # backwards, for lines may go
    for k in gone:
        edit(file, HEAD + 1 + first + EVERY * k, gap)
        edit(file, HEAD + first + EVERY * k, gap)
    read, again = read_curve(file, FORMAT, times, motion)
    assert again == pytest.approx(start, abs=1e-9)
    np.testing.assert_array_equal(read, np.where(np.isin(np.arange(151), gone), np.nan, whole))


@pytest.mark.parametrize(
    ("rate", "read"), [(10.0, True), (10.05, True), (9.6, False), (20.0, False)]
)
def test_a_rate_that_a_column_of_times_contradicts_is_refused(file, prior, rate, read):
    written(file, prior)
    settings = {"time_column": None, "rate": rate, "travel_column": 2}
    (results,) = Reader(settings).read_all([Operation(12, file)], "closing")
    assert bool(getattr(results[0], "reason", "")) != read
    assert read or f"10 kHz, but endurance.format.rate is {rate:g} kHz" in results[0].reason


@pytest.mark.parametrize(
    ("unit", "size", "wrong"),
    [("travel_unit", 1e-3, "mm"), ("travel_unit", 1.0, "inch"), ("time_unit", 1e-3, "ms")],
)
def test_a_wrong_unit_is_named_by_its_magnitude(file, prior, unit, size, wrong):
    columns = dict(zip(("time_unit", "travel_unit"), record(prior, "closing"), strict=True))
    columns[unit] = size * columns[unit]
    np.savetxt(file, np.column_stack([*columns.values()]), "%.10g", ",", header="time,travel")
    settings = FORMAT | {"time_unit": "ms"} | {unit: wrong}
    with pytest.raises(RejectedCurveError, match=rf"endurance\.format\.{unit}"):
        Reader(settings).read(Operation(12, file), "closing")


def test_rejected_operations_stay_and_the_rest_goes_on(tmp_path, prior, times, caplog):
    """1 is good, 2 has a text, 3 is an opening, 4 lacks a sample, 5 is not there, 6 is 1 again."""
    folder = [Operation(k, tmp_path / f"op_{k}.csv") for k in range(1, 7)]
    for item in folder[:4]:
        motion = "opening" if item.number == 3 else "closing"
        written(item.file, prior, motion, seed=item.number)
    folder[5].file.write_bytes(folder[0].file.read_bytes())
    edit(folder[1].file, 50, "?")
    for _ in range(EVERY):
        edit(folder[3].file, HEAD + 400)
    caplog.set_level(logging.WARNING, logger="breaker")  # a command before may have silenced it
    curves = read_curves(folder, FORMAT, Grid(times), "closing")
    assert curves.accepted.values.tolist() == [True, False, False, True, False, False]
    np.testing.assert_array_equal(np.isnan(curves.travel.values).all(axis=1), ~curves.accepted)
    assert curves.missing.values.tolist() == [0, 151, 151, 1, 151, 151]
    reasons = curves.reason.values.tolist()
    assert [bool(reason) for reason in reasons] == (~curves.accepted).values.tolist()
    assert reasons[1].startswith(f"{folder[1].file}, line 50: ")
    assert str(folder[0].file) in reasons[5]
    assert [r.getMessage() for r in caplog.records] == [f"rejected: {r}" for r in reasons if r]
    rejected = read_curves(folder[1:3], FORMAT, Grid(times), "closing")
    save(describe(rejected, "measured closing curves", format=FORMAT), tmp_path / "curves.zarr")
    with pytest.raises(RejectedCurveError, match=r"op_2\.csv, line 50: "):
        open_curves([tmp_path / "curves.zarr"])


# ---- what is not a record of curves: nothing waits, and its reason can be printed ----------------

MADE = {
    "pipe.csv": os.mkfifo,
    "pipe.cfg": os.mkfifo,
    "folder.csv": Path.mkdir,
    "device.csv": lambda file: file.symlink_to("/dev/zero"),
    "loop.csv": lambda file: file.symlink_to(file.name),
    "broken link.csv": lambda file: file.symlink_to("nowhere.csv"),
    "large.csv": lambda file: [file.touch(), os.truncate(file, LARGEST + 1)],
    "none.csv": lambda file: None,
    "empty.csv": Path.touch,
    "binary.csv": lambda file: file.write_bytes(bytes(range(256)) * 40),
    "binary.xlsx": lambda file: file.write_bytes(b"PK\3\4" + bytes(100)),
    "x" * 300 + ".csv": lambda file: None,
    "no\0name.csv": lambda file: None,
    "a\n\t\x1b[2J.csv": Path.mkdir,
}


def test_whatever_cannot_be_read_is_one_row_that_can_be_stored(tmp_path):
    """In a thread, for a reader may wait for a pipe that nobody writes to."""
    for name, make in MADE.items():
        make(tmp_path / name)
    time = np.arange(0.0, 100.0, 0.1)
    odd = Path(os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9.csv"))
    fine = odd.with_name("fine" + odd.name)
    odd.write_bytes(b"?")
    write_curve(fine, time, 14.0 / (1.0 + np.exp(25.0 - time)), motion="closing", operation=1)
    files, result = [*(tmp_path / name for name in MADE), odd, fine], []
    operations = [Operation(i, file) for i, file in enumerate(files, start=1)]
    grid = Grid(np.arange(-2.0, 58.0, 0.4))
    thread = threading.Thread(
        target=lambda: result.append(read_curves(operations, {}, grid, "closing")), daemon=True
    )
    thread.start()
    thread.join(timeout=60.0)
    (curves,) = result
    assert curves.accepted.values.tolist() == [False] * (len(files) - 1) + [True]
    for file, reason in zip(files, curves.reason.values[:-4], strict=False):
        assert reason.startswith(str(file))
    save(curves, tmp_path / "curves.zarr")
    read = open_store(tmp_path / "curves.zarr").load()
    xr.testing.assert_identical(read.drop_attrs(), curves.drop_attrs())
    assert curves.file.values[-1].endswith(r"finecaf\udce9.csv")
    for text in (*curves.reason.values, *curves.file.values):
        assert text.isprintable()
        text.encode("utf-8")
