"""A ripple of a reading: found where there is one, nowhere else, and counted as its error."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.configuration.definitions import family_of
from breaker.configuration.loading import load
from breaker.family.drive_family import Family
from breaker.family.inputs import normalise_record
from breaker.model.prior import Prior
from breaker.records.first_motion import first_motion
from breaker.records.measurements import measure_curve
from breaker.records.noise import ripple_of
from tests.raws import raw_of

STEP, STROKE = 0.1, 160.0
TIME = STEP * np.arange(900)
RISE = np.clip((TIME - 20.0) / 45.0, 0.0, 1.0)
WAY = STROKE * RISE**2 * (3.0 - 2.0 * RISE)
FAST = np.gradient(WAY) / np.gradient(WAY).max()


def rippled(amplitude, period, phase=1.0, noise=0.05, seed=1):
    swing = amplitude * FAST * np.sin(2.0 * np.pi * TIME / period + phase)
    return WAY + swing + noise * np.random.default_rng(seed).standard_normal(TIME.size)


@pytest.mark.parametrize("period", [2.0, 6.0])
@pytest.mark.parametrize("amplitude", [1.0, 3.0])
def test_its_size_is_found(period, amplitude):
    travel = rippled(amplitude, period)
    travel[300:330] = np.nan
    assert np.sqrt(2.0) * ripple_of(travel, STROKE) == pytest.approx(amplitude, rel=0.4)


def test_noise_bumps_kinks_and_drives_have_hardly_any():
    """Of 200 drives of the family at most 2 % swing as much themselves; of others none.

    Drives whose friction is complete only at some speed swing more often (23 of 1,000), and are
    left out: their swing is not an error of the reading.
    """
    ways = [rippled(0.0, 5.0, noise=1.0, seed=seed) for seed in range(50)]
    ways += [WAY + 4.0 * np.exp(-np.square((TIME - 45.0) / width)) for width in (0.7, 1, 2, 5)]
    ways += [np.minimum(WAY, 0.6 * STROKE + 0.5 * (WAY - 0.6 * STROKE)) / 0.8]
    ways += [WAY[::40], np.full(TIME.size, np.nan)]
    assert not any(ripple_of(way, STROKE) for way in ways)
    config, rng = load(), generator(4, "ripple")
    definition = family_of(config["family"]["name"])
    effects = {name: of for name, of in definition["effects"].items() if name != "friction_speed"}
    family = Family(Prior.from_settings(config["prior"]), definition | {"effects": effects})
    times = np.arange(-5.0, 100.0, 0.05)
    drives = [family.new(rng).travel("closing", times) for _ in range(200)]
    assert sum(ripple_of(way, way[-1]) > 0.0 for way in drives) <= 4


def test_a_ripple_is_an_error_of_times():
    """Of 60 times and first motions none is off by 5 sds (1e-4 for all); without the ripple in
    their errors most first motions are.
    """
    plain = measure_curve(TIME, WAY, "closing")["travel_time"].value
    times, first, alone = [], [], []
    for k in range(60):
        travel = rippled(2.0, 3.0 + 0.07 * k, phase=k, seed=k)
        found = measure_curve(TIME, travel, "closing")["travel_time"]
        times.append((found.value - plain) / found.sd)
        raw = raw_of(travel, STEP, 20.0)
        moves, sd = first_motion(raw.time, raw.left, "closing")
        first.append((moves - 20.0) / replace(raw, moves=moves, moves_sd=sd).first_motion_sd)
        alone.append((moves - 20.0) / sd)
    assert np.abs([*times, *first]).max() < 5.0
    assert np.mean(np.square(times)) > 0.15  # nor are the errors far too large
    assert np.abs(alone).max() > 5.0


def test_networks_see_a_ripple_as_noise():
    smooth, swinging = (
        normalise_record(raw_of(travel, STEP, 20.0))[1].noise[0] for travel in (WAY, rippled(2, 5))
    )
    assert swinging == pytest.approx(np.sqrt(2.0) / STROKE, rel=0.2)
    assert smooth < 0.1 * swinging
