"""Motions of high-voltage breakers, with what their records have: they are accepted and right."""

import numpy as np
import pytest

from breaker.records.curves import Grid, read_curves
from breaker.records.measurements import measure_curve
from breaker.records.motion import find_segment
from breaker.records.operations import Operation
from tests.raws import swinging

STROKE = 170.0


def record(kind, seed):
    """Times, ms, and travel, mm, of a closing, with one thing that records of the field have."""
    rng, rate = np.random.default_rng(seed), 5.0 if kind == "noise of the motion" else 10.0
    begin = 25.0 if kind == "short rest" else 60.0
    end = 100.0 + begin if kind == "short end" else 260.0 + begin
    time = np.arange(0.0, end, 1.0 / rate)
    way = swinging(time - begin, STROKE, 50.0, 0.15 if kind == "over-travel" else 0.0)
    speed = np.abs(np.gradient(way, time))
    noise = 0.1 * rng.standard_normal(time.size)
    if kind == "slow start":
        way = np.maximum(way, 0.02 * STROKE * np.clip((time - begin + 15.0) / 25.0, 0.0, 1.0) ** 2)
    if kind == "hum":
        way += 0.3 * np.sin(0.1 * np.pi * time)
    if kind in ("ripple", "noise of the motion"):
        way += 1.5 * speed / speed.max() * np.sin(2.0 * np.pi * time / 6.0)
    if kind == "noise of the motion":
        noise = 0.07 * np.rint(0.5 * rng.standard_normal(time.size) * (speed > 0.02) / 0.07)
        way = 0.07 * np.rint(way / 0.07)
    if kind in ("steps of 0.32 mm", "steps of 0.01 mm"):
        step, noise = float(kind.split()[2]), 0.0
        way = step * np.rint(way / step)
    if kind == "drift":
        way += 0.01 * time
    if kind == "spikes":
        noise[rng.choice(time.size, 5, replace=False)] += 30.0
    return time, way + noise


KINDS = (
    *("hum", "ripple", "noise of the motion", "steps of 0.32 mm", "steps of 0.01 mm"),
    *("slow start", "short rest", "short end", "over-travel", "drift", "spikes"),
)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [1, 2])
def test_records_of_the_field_are_accepted(tmp_path, kind, seed):
    time, travel = record(kind, seed)
    rows, settings = np.column_stack([time, travel]), {"time_unit": "ms", "zero": "rest"}
    file = tmp_path / "1.csv"
    np.savetxt(file, rows, delimiter=",", header="time,travel", comments="")
    grid = Grid(np.arange(-2.0, 98.0, 0.5))
    curves = read_curves([Operation(1, file)], settings, grid, "closing").isel(operation=0)
    assert curves.accepted, curves.reason.item()
    assert curves.masked < 0.02 * time.size
    stroke = curves.sel(quantity="stroke")
    assert abs(stroke.measured - STROKE) < 2.5 + 3.0 * stroke.measured_sd


def test_a_motion_behind_another_one_begins_at_rest():
    """The time from 90 % of a closing to its rest is no rest of the opening."""
    time = np.arange(0.0, 400.0, 0.1)
    travel = swinging(time - 40.0, STROKE, 50.0) - swinging(time - 240.0, STROKE, 30.0)
    travel += 0.1 * np.random.default_rng(1).standard_normal(time.size)
    segment = find_segment(time, travel, "opening")
    assert time[segment.begin] > 85.0
    found = measure_curve(time, travel, "opening")["stroke"]
    assert abs(found.value - STROKE) < 0.2
    assert found.sd < 0.2
