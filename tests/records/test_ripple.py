"""A ripple of a reading: found where there is one, nowhere else, and counted as its error."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.configuration.definitions import family_of
from breaker.configuration.loading import load
from breaker.drive.family.record_inputs import normalise_record
from breaker.drive.simulation.drive_family import Family
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


@pytest.mark.parametrize("period", [2.0, 4.5, 7.0])
@pytest.mark.parametrize("amplitude", [1.0, 3.0])
def test_amplitude_and_period_are_found(period, amplitude):
    found = ripple_of(TIME, rippled(amplitude, period), STROKE)
    assert found.period == pytest.approx(period, rel=0.06)
    assert found.amplitude == pytest.approx(amplitude, rel=0.4)


@pytest.mark.parametrize("width", [0.7, 1.0, 2.0, 5.0])
def test_a_bump_and_a_kink_are_no_ripple(width):
    bump = 4.0 * np.exp(-np.square((TIME - 45.0) / width))
    kink = np.minimum(WAY, 0.6 * STROKE + 0.5 * (WAY - 0.6 * STROKE)) / 0.8
    for way in (WAY + bump, kink):
        assert ripple_of(TIME, way, STROKE).amplitude == 0.0


def test_noise_and_drives_have_hardly_any():
    """Of 200 drives of the family at most 2 % swing as much themselves; of noise none."""
    for seed in range(50):
        assert ripple_of(TIME, rippled(0.0, 5.0, noise=1.0, seed=seed), STROKE).amplitude == 0.0
    config, rng = load(), generator(4, "ripple")
    family, found = (
        Family(Prior.from_settings(config["prior"]), family_of(config["family"]["name"])),
        0,
    )
    times = np.arange(-5.0, 100.0, 0.05)
    for _ in range(200):
        way = family.new(rng).travel("closing", times)
        found += ripple_of(times, way, way[-1]).amplitude > 0.0
    assert found <= 4


def test_a_ripple_is_an_error_of_times_and_of_what_networks_see():
    """Times of 100 records are off by no more than 4.5 sds, as none in 1,000 is; without the ripple
    in their errors most are.
    """
    plain = measure_curve(TIME, WAY, "closing")["travel_time"].value
    off = []
    for k in range(100):
        travel = rippled(2.0, 3.0 + 0.05 * k, phase=k, seed=k)
        found = measure_curve(TIME, travel, "closing")["travel_time"]
        off.append(abs(found.value - plain) / found.sd)
    assert max(off) < 4.5
    assert np.mean(np.square(off)) > 0.15  # nor are they told at random
    smooth, swinging = (
        normalise_record(raw_of(travel, STEP, 20.0))[1].noise[0] for travel in (WAY, rippled(2, 5))
    )
    assert swinging == pytest.approx(np.sqrt(2.0) / STROKE, rel=0.2)
    assert smooth < 0.1 * swinging


def test_missing_samples_and_short_motions():
    travel = rippled(2.0, 5.0)
    travel[300:330] = np.nan
    assert ripple_of(TIME, travel, STROKE).amplitude == pytest.approx(2.0, rel=0.2)
    assert ripple_of(TIME[::40], WAY[::40], STROKE).amplitude == 0.0
    assert ripple_of(TIME, np.full(TIME.size, np.nan), STROKE).amplitude == 0.0


def test_a_first_motion_in_ripple_is_as_uncertain_as_that_makes_it():
    """Of 60 first motions none is off by 5 sds (1e-4 for all); without the ripple's part most are
    told far too surely.
    """
    off, alone = [], []
    for k in range(60):
        raw = raw_of(rippled(2.0, 3.0 + 0.07 * k, phase=k, seed=k), STEP, 20.0)
        moves, sd = first_motion(raw.time, raw.left, "closing")
        own = replace(raw, moves=moves, moves_sd=sd)
        off.append((moves - 20.0) / own.first_motion_sd)
        alone.append((moves - 20.0) / sd)
    assert np.abs(off).max() < 5.0
    assert np.abs(alone).max() > 5.0


def test_a_motion_before_does_not_make_a_first_motion_uncertain():
    """Its end is far from where the next one begins, and no part of the rise."""
    alone = raw_of(rippled(2.0, 5.0), STEP, 20.0)
    whole = np.where(np.arange(TIME.size) < 50, 0.5 * STROKE, alone.whole)
    assert alone.ripple.amplitude > 1.0
    assert replace(alone, whole=whole).first_motion_sd == pytest.approx(alone.first_motion_sd)
