"""Noise at rest and a ripple in the motion: their size, remarks, and what they do to errors."""

import numpy as np
import pytest
from scipy.signal import lfilter

from breaker.common.randomness import generator
from breaker.configuration.data_files import family_of
from breaker.family.drive_family import Family
from breaker.family.inputs import normalise_record
from breaker.records.measurements import measure_curve
from breaker.records.noise import noise_at_rest, noise_remarks, ripple_of
from tests.raws import raw_of, swinging


def rest(rng, count=80, sd=0.1, colour=0.0):
    noise = rng.standard_normal(count)
    noise[1:] *= np.sqrt(1.0 - colour**2)
    return sd * lfilter([1.0], [1.0, -colour], noise)


def remarks(x, step=0.1):
    return [remark.code for remark in noise_remarks(noise_at_rest(x, 0.0), 0.1, 0.4 / step)]


@pytest.mark.parametrize(("step", "count"), [(0.01, 800), (0.1, 20), (1.0, 12)])
def test_good_records_have_no_remark(step, count):
    """At a rate of 4e-4 of each, of 1,000 more than 3 have a remark with a probability of 7e-4."""
    rng = generator(1, "good rest", str(step), count)
    assert sum(bool(remarks(rest(rng, count), step)) for _ in range(1000)) <= 3


def test_noise_and_its_colour_are_estimated():
    """To 5 sd of 10,000 samples, also where some are missing."""
    x = rest(generator(2, "noise"), 10_000, 0.07, 0.8)
    noise = noise_at_rest(x, 0.0)
    assert noise.sd == pytest.approx(0.07, rel=0.08)
    assert noise.colour == pytest.approx(0.8, abs=0.04)
    x[generator(3, "noise").random(x.size) < 0.3] = np.nan
    assert noise_at_rest(x, 0.0).colour == pytest.approx(0.8, abs=0.05)
    counter = noise_at_rest(np.full(80, 0.64), 0.32)
    assert counter.sd == pytest.approx(0.32 / np.sqrt(12.0))
    assert [remark.code for remark in noise_remarks(counter, 0.05, 4.0)] == ["noisier"]


PLANTED = {
    "twice the noise": (lambda rng: rest(rng, sd=0.2), "noisier"),
    "a fifth of the noise": (lambda rng: rest(rng, 90, 0.02), "calmer"),
    "coloured": (lambda rng: rest(rng, 300, colour=0.85), "coloured"),
    "smoothed over 1 ms": (lambda rng: np.convolve(rest(rng, 89), np.full(10, 0.1)), "coloured"),
    "too little rest": (lambda rng: rest(rng, 5), "few-at-rest"),
    "no sample at rest": (lambda rng: rest(rng, 50, np.nan), "few-at-rest"),
}


@pytest.mark.parametrize(("make", "code"), PLANTED.values(), ids=PLANTED)
def test_planted_faults_are_remarked_on(make, code):
    rng = generator(4, "planted", code)
    assert sum(code in remarks(make(rng)) for _ in range(100)) >= 70
    assert remarks(np.zeros(50)) == []  # no noise is no error


# ---- a ripple while the drive moves ------------------------------------------------------------

STEP, STROKE = 0.1, 160.0
TIME = STEP * np.arange(900)
WAY = swinging(TIME - 20.0, STROKE, 45.0)
FAST = np.gradient(WAY) / np.gradient(WAY).max()


def rippled(amplitude, period, phase=1.0, noise=0.05, seed=1):
    swing = amplitude * FAST * np.sin(2.0 * np.pi * TIME / period + phase)
    return WAY + swing + noise * np.random.default_rng(seed).standard_normal(TIME.size)


@pytest.mark.parametrize(("amplitude", "period"), [(1.0, 2.0), (3.0, 6.0)])
def test_the_size_of_a_ripple(period, amplitude):
    reading = rippled(amplitude, period)
    reading[300:330] = np.nan
    assert np.sqrt(2.0) * STROKE * ripple_of(reading / STROKE) == pytest.approx(amplitude, rel=0.4)
    (still,), (swinging,) = (
        normalise_record(raw_of(way, STEP, 20.0))[1].noise for way in (WAY, reading)
    )
    assert swinging == pytest.approx(amplitude / np.sqrt(2.0) / STROKE, rel=0.4)
    assert still < 0.2 * swinging


def test_noise_bumps_kinks_and_drives_have_hardly_any_ripple(prior, defaults):
    """Of 200 drives of the family at most 2 % swing as much themselves; of others none.

    Drives whose friction is complete only at some speed swing more often (23 of 1,000), and are
    left out: their swing is not an error of the reading.
    """
    ways = [rippled(0.0, 5.0, noise=1.0, seed=seed) for seed in range(50)]
    ways += [WAY + 4.0 * np.exp(-np.square((TIME - 45.0) / width)) for width in (0.7, 1, 2, 5)]
    ways += [np.minimum(WAY, 0.6 * STROKE + 0.5 * (WAY - 0.6 * STROKE)) / 0.8]
    ways += [WAY[::40], np.full(TIME.size, np.nan)]
    assert not any(ripple_of(way / STROKE) for way in ways)
    definition, rng = family_of(defaults["family"]["name"]), generator(4, "ripple")
    effects = {name: of for name, of in definition["effects"].items() if name != "friction_speed"}
    family, times = Family(prior, definition | {"effects": effects}), np.arange(-5.0, 100.0, 0.05)
    drives = [family.new(rng).travel("closing", times) for _ in range(200)]
    assert sum(ripple_of(way / way[-1]) > 0.0 for way in drives) <= 4


def test_a_ripple_is_an_error_of_times():
    """Of 60 times none is off by 5 sds (1e-4 for all)."""
    plain = measure_curve(TIME, WAY, "closing")["travel_time"].value
    times = []
    for k in range(60):
        reading = rippled(2.0, 3.0 + 0.07 * k, phase=k, seed=k)
        value, sd, _ = measure_curve(TIME, reading, "closing")["travel_time"]
        times.append((value - plain) / sd)
    assert np.abs(times).max() < 5.0
    assert np.mean(np.square(times)) > 0.15  # nor are the errors far too large
