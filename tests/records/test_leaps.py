"""Leaps of the travel: lost samples and slipping sensors are told from motions."""

import re

import numpy as np
import pytest

from breaker.mechanism.curves import travel
from breaker.mechanism.parameters import MOTIONS
from breaker.model.randomness import generator
from breaker.records.leaps import leap_remark

RATES = [2.5, 5.0, 10.0, 25.0, 100.0]


def curves(prior, motion, rate, n):
    """Times, ms, curves ``(n, t)``, mm, and their strokes."""
    rng = generator(1, "leaps", motion, str(rate))
    time = np.arange(0.0, 76.0, 1.0 / rate)
    exact = travel(prior.sample(n, rng), time, motion, onset=10.0 + rng.random(n)).travel
    return time, exact, np.abs(exact[:, -1] - exact[:, 0]), rng


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("motion", MOTIONS)
def test_no_motion_leaps(prior, motion, rate):
    """Curves of the model: with noise, with so little that only curvature is left, and rounded.

    A remark has a probability below 1e-5 each, so one of 1,000 has one below 1e-2.
    """
    time, exact, strokes, rng = curves(prior, motion, rate, 25)
    for x, stroke in zip(exact, strokes, strict=True):
        for noise, quantum in ((0.1, 0.0), (0.001, 0.0), (0.0, 0.3), (0.1, 0.1)):
            record = x + noise * rng.standard_normal(x.size)
            if quantum:
                record = quantum * np.round(record / quantum)
            sd = max(noise, quantum / np.sqrt(12.0))
            assert leap_remark(time, record, sd, quantum, stroke) == ""


@pytest.mark.parametrize("rate", [5.0, 10.0, 25.0])
@pytest.mark.parametrize("leap", [-0.8, 0.8])
def test_a_planted_leap_is_found_where_it_is(prior, rate, leap):
    """Of 0.8 mm, eight sd of the noise, at rest and in motion; nearly always."""
    time, exact, strokes, rng = curves(prior, "closing", rate, 40)
    found = 0
    for x, stroke in zip(exact, strokes, strict=True):
        at = rng.uniform(5.0, 60.0)
        record = x + 0.1 * rng.standard_normal(x.size) + leap * (time > at)
        words = leap_remark(time, record, 0.1, 0.0, stroke)
        if words:
            size, place = map(float, re.findall(r"leaps by (\S+) mm at (\S+) ms", words)[0])
            found += abs(size - leap) < 0.4 and abs(place - at) < 0.7
    assert found >= 34


def test_lost_samples_leave_a_leap(prior):
    """A ms of samples, of which nothing is left, in the middle of the motion."""
    time, exact, strokes, rng = curves(prior, "closing", 10.0, 40)
    found = 0
    for x, stroke in zip(exact, strokes, strict=True):
        lost = np.delete(x, np.s_[150:160])
        record = lost + 0.1 * rng.standard_normal(lost.size)
        found += leap_remark(time[: lost.size], record, 0.1, 0.0, stroke) != ""
    assert found >= 38


def test_a_record_without_noise_known_or_samples_has_no_remark():
    assert leap_remark(np.arange(5.0), np.zeros(5), 0.1, 0.0, 14.0) == ""
    time = np.arange(0.0, 40.0, 0.1)
    assert leap_remark(time, 10.0 * (time > 20), np.nan, 0.0, 10.0) == ""
    gaps = np.where(np.arange(400) % 10 == 0, np.nan, 0.0)
    assert leap_remark(time, gaps, 0.1, 0.0, 14.0) == ""
