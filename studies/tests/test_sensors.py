"""Sensors of other drives: readings rounded and noise coloured as stated."""

from dataclasses import replace

import numpy as np
import pytest

from studies.sensors import Reading


def test_sensors_round_and_colour(sensor):
    """Correlation of neighbours from 15,100 samples: standard error 0.008."""
    rng = np.random.default_rng(2)
    zeroless = replace(sensor, zero_sd=0.0)
    read = np.array([Reading(0.0, 0.6).corrupt(np.zeros(151), zeroless, rng) for _ in range(100)])
    assert read.std() == pytest.approx(sensor.noise_sd, rel=0.05)
    assert (read[:, 1:] * read[:, :-1]).mean() / read.var() == pytest.approx(0.6, abs=0.04)
    rounded = Reading(0.25, 0.0).corrupt(np.linspace(0, 10, 151), sensor, rng)
    np.testing.assert_allclose(rounded / 0.25, np.round(rounded / 0.25), atol=1e-9)
