"""Readings that no drive makes: hum, rests that move, repeated stretches, the end of a range."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS
from breaker.records.checks import ends_of_range, repeats_remark, unsteady_remark
from breaker.records.motion import find_segment
from breaker.records.noise import hum_of

TIME = np.arange(0.0, 76.0, 0.1)
MOVES = 10.0


def records(prior, motion, count=100):
    """Yield travels with white noise of 0.05 mm, in steps of 0.01 mm."""
    rng = generator(3, "unsteady", motion)
    for curve in travel(prior.sample(count, rng), TIME, motion, onset=MOVES).travel:
        yield np.round(curve + 0.05 * rng.standard_normal(TIME.size), 2)


def codes(reading, motion):
    segment = find_segment(TIME, reading, motion)
    found = {
        "hum": hum_of(TIME, reading, MOVES)[0],
        "range-ends": np.isfinite(ends_of_range(TIME, reading, MOVES)).any(),
        "repeats": repeats_remark(TIME, reading),
        "unsteady": unsteady_remark(TIME, reading, MOVES, segment),
    }
    return {code for code, shown in found.items() if shown}


@pytest.mark.parametrize("motion", MOTIONS)
def test_good_records_have_no_remark(prior, motion):
    # Hum is tried twice at 1.25e-4, a repeat once: of 100 records 2 have a remark at 7e-4.
    assert sum(bool(codes(reading, motion)) for reading in records(prior, motion)) <= 1


def bump(at):
    return np.exp(-(((TIME - at) / 2.0) ** 2))


def cut_at_rest(reading):
    """Return a reading whose range ends 0.3 mm within the stroke, at the rest before the motion."""
    sign = np.sign(reading[-1] - reading[0])
    return sign * np.maximum(sign * reading, sign * reading[0] + 0.3)


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize(
    ("code", "change"),
    [
        ("hum", lambda x: x + 0.5 * np.sin(0.1 * np.pi * TIME + 1.0)),
        ("hum", lambda x: x + 0.5 * np.cos(0.12 * np.pi * TIME)),
        ("unsteady", lambda x: x + 0.4 * bump(4.0)),
        ("unsteady", lambda x: x + 1.5 * bump(66.0)),
        ("repeats", lambda x: np.insert(x, 150, x[120:150])[: x.size]),
        ("repeats", lambda x: np.where((TIME > 60.0) & (TIME < 64.0), x[600], x)),
        ("range-ends", cut_at_rest),
    ],
)
def test_planted_faults_have_a_remark(prior, motion, code, change):
    assert all(code in codes(change(reading), motion) for reading in records(prior, motion, 5))
