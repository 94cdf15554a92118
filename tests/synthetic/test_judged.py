"""Judged rigs: elements and sensors as stated, and no record of a drive that does not hold."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.synthetic.judged import Reading, family_of, record_of


@pytest.fixture(scope="module")
def judged(defaults):
    return defaults["judged"]


def test_only_foreign_rigs_have_what_the_family_lacks(prior, defaults, judged):
    rng = np.random.default_rng(1)
    for name, there in (("held_back", False), ("tuning", False), ("foreign", True)):
        elements = family_of(name, prior, defaults["rigs"], judged).new(rng).elements
        for element, (low, high) in judged["foreign"].items():
            value = getattr(elements, element)
            assert (low <= value <= high and value > 0.0) if there else value == 0.0


def test_sensors_round_and_colour(sensor, judged):
    """Correlation of neighbours from 15,100 samples: standard error 0.008."""
    rng = np.random.default_rng(2)
    zeroless = replace(sensor, zero_sd=0.0)
    read = np.array([Reading(0.0, 0.6).corrupt(np.zeros(151), zeroless, rng) for _ in range(100)])
    assert read.std() == pytest.approx(sensor.noise_sd, rel=0.05)
    assert (read[:, 1:] * read[:, :-1]).mean() / read.var() == pytest.approx(0.6, abs=0.04)
    rounded = Reading(0.25, 0.0).corrupt(np.linspace(0, 10, 151), sensor, rng)
    np.testing.assert_allclose(rounded / 0.25, np.round(rounded / 0.25), atol=1e-9)
    drawn = [Reading.draw(judged, rng) for _ in range(400)]
    # Shares of 400 within four standard errors: false-alarm probability 1e-4.
    assert np.mean([each.quantum > 0 for each in drawn]) == pytest.approx(0.5, abs=0.1)
    assert np.mean([each.colour > 0 for each in drawn]) == pytest.approx(0.25, abs=0.09)
    quanta = [each.quantum for each in drawn if each.quantum]
    assert judged["quantum"][0] <= min(quanta) < max(quanta) <= judged["quantum"][1]


def test_a_drive_that_does_not_hold_has_no_record(prior, defaults, judged, sensor):
    family = family_of("held_back", prior, defaults["rigs"], judged)
    drive = family.new(np.random.default_rng(3)).changed(f=0.1)
    read = record_of(drive, sensor, "closing", Reading(0.0, 0.0), np.random.default_rng(4))
    assert np.isnan(read).all()
