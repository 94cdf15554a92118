"""A reading that jumps: the stroke is that of the rests beside the motion, or its sd holds it."""

import numpy as np
import pytest

from breaker.records.checks import doubtful_samples
from breaker.records.measurements import measure_curve

KINDS = {
    "behind": lambda time, at, size: size * (time > 135.0 + at),
    "before": lambda time, at, size: size * (time < 30.0 - 0.2 * at),
    "returns": lambda time, at, size: size * ((time > 140.0 + at) & (time < 155.0 + at)),
    "one sample": lambda time, at, size: size * (np.abs(time - 140.0 - at) < 0.6 * time[1]),
}


def record(rate, stroke=178.0, over=0.06):
    """A motion from 55 ms on of 60 ms, that swings at its end."""
    time = np.arange(0.0, 400.0, 1.0 / rate)
    share = np.clip((time - 55.0) / 60.0, 0.0, 1.0)
    late = np.clip((time - 110.0) / 60.0, 0.0, None)
    swing = over * np.sin(7.0 * late) * np.exp(-late / 0.3)
    noise = 0.1 * np.random.default_rng(3).standard_normal(time.size)
    return time, stroke * (share**2 * (3.0 - 2.0 * share) + swing) + noise


@pytest.mark.parametrize("rate", [2.0, 5.0, 10.0, 20.0])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("size", [-5.0, -1.7, 2.2, 3.4])
def test_a_jump_at_rest_leaves_the_stroke(rate, kind, size):
    for at in (0.0, 40.0):
        time, travel = record(rate)
        jumped = travel + KINDS[kind](time, at, size)
        found = measure_curve(time, jumped, "closing")["stroke"]
        assert abs(found.value - 178.0) < max(3.0 * found.sd, 0.1)
        seen = {0.0: 4.0, 40.0: 2.0}[at] if kind == "behind" else 0.6  # short before it, it swings
        assert found.sd < seen
        # Nothing is left out but what jumped; where it still swings, the rest behind a slip is one.
        masked = doubtful_samples(jumped, 1.0 / rate, 0.0)
        if kind == "behind" and not at:
            assert masked[masked != ""].tolist() == ["slip"]
            continue
        masked = masked != ""
        assert abs(masked.sum() - (np.abs(jumped - travel) > 0.0).sum()) <= 2 + 0.5 * rate


@pytest.mark.parametrize("rate", [5.0, 10.0, 20.0])
@pytest.mark.parametrize("at", [70.0, 85.0, 100.0])
def test_a_slip_within_a_motion_is_in_the_uncertainty(rate, at):
    time, travel = record(rate, 150.0)
    kinds = doubtful_samples(travel + 2.0 * (time > at), 1.0 / rate, 0.0)
    assert kinds[kinds != ""].tolist() == ["slip"]
    assert time[kinds == "slip"] == pytest.approx(at, abs=1.0)
    found = measure_curve(time, travel + 2.0 * (time > at), "closing")
    assert abs(found["stroke"].value - 150.0) < 2.0 * found["stroke"].sd < 4.0
    assert found["over_travel"].sd < 0.1


def test_a_jump_between_two_motions_costs_neither():
    time, travel = record(10.0, over=0.0)
    back = np.clip((time - 300.0) / 40.0, 0.0, 1.0)
    travel += 3.4 * (time > 200.0) - 178.0 * back**2 * (3.0 - 2.0 * back)
    for motion in ("closing", "opening"):
        found = measure_curve(time, travel, motion)["stroke"]
        assert abs(found.value - 178.0) < 2.0 * found.sd < 8.0
