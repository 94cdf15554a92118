"""The reader of curve files: what it makes of good ones, and of bad ones."""

import logging

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.common.zarr_store import describe, save
from breaker.family.curve_file import write_curve
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS
from breaker.records.curves import Grid, open_curves, put_on_grid, read_curves
from breaker.records.files import RejectedCurveError
from breaker.records.operations import Operation
from breaker.records.reader import Reader
from breaker.records.settings import FORMAT

STEP, EVERY = 0.1, 4  # ms between samples of a file; samples for one of the model's grid
HEAD = 6  # lines before the first sample of what write_curve writes
TO_MS = {"s": 1e3, "ms": 1.0, "us": 1e-3}
TO_MM = {"mm": 1.0, "cm": 10.0, "m": 1e3, "um": 1e-3, "inch": 25.4}


def record(prior, motion, *, moves=10.0, stop=76.0, step=STEP, noise=0.05, seed=1):
    """Times, ms, and travel, mm, of the median breaker; the travel has three digits, as a file."""
    time = step * np.arange(round(stop / step) + 1)
    exact = travel(prior.medians[None], time, motion, onset=moves).travel[0]
    rng = generator(seed, "test record", motion)
    return time, np.round(exact + noise * rng.standard_normal(time.size), 3)


def export(file, settings, time, x):
    """Write a record as the settings describe it."""
    reading = settings["sign"] * x / TO_MM[settings["travel_unit"]] + settings["zero"]
    rows = np.stack([time / TO_MS[settings["time_unit"]], reading], axis=1)
    head = f"{settings['time_column']},{settings['travel_column']}"
    np.savetxt(file, rows, "%.10g", ",", header=head, comments="", encoding="utf-8")


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


def rejection(file, settings, times, motion="closing"):
    with pytest.raises(RejectedCurveError) as caught:
        read_curve(file, settings, times, motion)
    return str(caught.value)


@pytest.mark.parametrize("motion", MOTIONS)
def test_what_is_written_is_read_back_sample_by_sample(file, prior, times, motion):
    time, x = written(file, prior, motion)
    read, start = read_curve(file, FORMAT, times, motion)
    first = round((start + times[0]) / STEP)
    # Whole samples, equal to the last digit: neither averaged nor interpolated.
    np.testing.assert_array_equal(read, x[first : first + EVERY * times.size : EVERY])
    assert time[first] - times[0] == pytest.approx(start, abs=1e-9)
    assert start == pytest.approx(10.0, abs=0.5)


def cell(column, text):
    """A change of a line: one of its two cells."""
    return lambda line: ",".join(np.where(np.arange(2) == column, text, line.split(",")))


def edit(file, change, at):
    """Change a line of a file, or delete it for None; lines are counted as a text editor does."""
    lines = file.read_text(encoding="utf-8").split("\n")
    line = change(lines[at - 1])
    lines[at - 1 : at] = [] if line is None else [line]
    file.write_text("\n".join(lines), encoding="utf-8")


GAPS = {
    "empty travel": cell(1, ""),
    "nan": cell(1, " NaN"),
    "no time": cell(0, ""),
    "no line": lambda line: None,
}


@pytest.mark.parametrize("name", GAPS)
@pytest.mark.parametrize("motion", MOTIONS)
def test_missing_samples_are_read_as_such(file, prior, times, name, motion):
    """On the grid, between its samples, and a stretch; the rest is what it was, at its time."""
    written(file, prior, motion)
    whole, start = read_curve(file, FORMAT, times, motion)
    at = HEAD + 1 + round((start + times[0]) / STEP)
    # Backwards, for lines may go.
    gone = [100, 61, 60, *range(25, 20, -1), 1]
    for k in gone:
        edit(file, GAPS[name], at + EVERY * k)
        edit(file, GAPS[name], at + EVERY * k - 1)
    read, again = read_curve(file, FORMAT, times, motion)
    assert again == pytest.approx(start, abs=1e-9)
    expected = whole.copy()
    expected[gone] = np.nan
    np.testing.assert_array_equal(read, expected)


@pytest.mark.parametrize(
    ("unit", "written", "wrong"),
    [
        *(("travel_unit", *units) for units in (("m", "mm"), ("mm", "inch"))),
        *(("time_unit", *units) for units in (("s", "ms"), ("ms", "s"))),
    ],
)
def test_a_wrong_unit_is_told_by_its_magnitude(file, prior, times, unit, written, wrong):
    export(file, FORMAT | {unit: written}, *record(prior, "closing"))
    read_curve(file, FORMAT | {unit: written}, times, "closing")
    message = rejection(file, FORMAT | {unit: wrong}, times)
    assert f"endurance.format.{unit}" in message
    assert repr(written) in message


@pytest.mark.parametrize("rate", [1.0, 2.2, 4.0, 7.3, 100.0])
@pytest.mark.parametrize("motion", MOTIONS)
def test_any_rate_is_read(file, prior, times, rate, motion):
    """Close to the exact curve, and a slow record lacks the samples that its rate cannot give."""
    time, exact = record(prior, motion, step=1.0 / rate, noise=0.0)
    noisy = exact + 0.05 * generator(3, "any rate").standard_normal(exact.size)
    write_curve(file, time, noisy, motion=motion, operation=1)
    curves = read_curves([Operation(1, file)], FORMAT | {"rate": rate}, Grid(times), motion)
    assert curves.accepted.item(), curves.reason.item()
    assert curves.rate.item() == pytest.approx(rate, rel=1e-3)
    there = ~np.isnan(curves.travel.values[0])
    assert there.sum() == pytest.approx(min(151, 60 * rate + 1), abs=1.5)
    fine = travel(prior.medians[None], times[there] + curves.first_motion.item(), motion, onset=10)
    # 4.5 sd of the noise, for 151 samples of 10 records; and 0.05 mm at the impact at 1 kHz.
    off = np.abs(curves.travel.values[0][there] - fine.travel[0])
    assert off.max() < 4.5 * 0.05 + 0.05


@pytest.fixture
def folder(tmp_path, prior):
    """Five files: 1 is good, 4 lacks a sample, 2 has a text, 3 is an opening, 5 is not there."""
    files = [Operation(k, tmp_path / f"op_{k}.csv") for k in (1, 2, 3, 4, 5)]
    for each in files[:4]:
        motion = "opening" if each.number == 3 else "closing"
        written(each.file, prior, motion, seed=each.number)
    edit(files[1].file, cell(1, "?"), 50)
    for _ in range(EVERY):
        edit(files[3].file, GAPS["no line"], HEAD + 400)
    return files


def test_rejected_operations_stay_and_the_rest_goes_on(folder, times, caplog):
    caplog.set_level(logging.WARNING, logger="breaker")  # a command before may have silenced it
    curves = read_curves(folder, FORMAT, Grid(times), "closing")
    assert curves.accepted.values.tolist() == [True, False, False, True, False]
    np.testing.assert_array_equal(np.isnan(curves.travel.values).all(axis=1), ~curves.accepted)
    assert curves.missing.values.tolist() == [0, times.size, times.size, 1, times.size]
    reasons = curves.reason.values.tolist()
    assert [bool(reason) for reason in reasons] == (~curves.accepted).values.tolist()
    assert reasons[1].startswith(f"{folder[1].file}, line 50: ")
    assert [r.getMessage() for r in caplog.records] == [f"rejected: {r}" for r in reasons if r]


def stored(operations, times, store):
    """Read files and keep what is read."""
    curves = read_curves(operations, FORMAT, Grid(times), "closing")
    save(describe(curves, "measured closing curves", format=FORMAT), store)
    return store


def test_if_all_are_rejected_it_is_an_error_with_the_first_reasons(folder, tmp_path, times):
    store = stored(folder[1:3] + folder[4:], times, tmp_path / "curves.zarr")
    with pytest.raises(RejectedCurveError) as caught:
        open_curves([store])
    assert "op_2.csv, line 50: " in str(caught.value)


def test_a_record_of_two_operations_counts_once(tmp_path, prior, times):
    """As a table has it that names one file in all rows, or copies of it."""
    files = [tmp_path / f"{n}.csv" for n in (1, 2, 3)]
    for file in files[:2]:
        written(file, prior)
    files[2].write_bytes(files[1].read_bytes())
    some = [Operation(n, file) for n, file in enumerate([*files, files[0]], start=1)]
    curves = read_curves(some, {}, Grid(times), "closing")
    assert curves.accepted.values.tolist() == [True, False, False, False]
    assert str(files[0]) in str(curves.reason.values[1])
