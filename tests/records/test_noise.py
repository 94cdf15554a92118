"""Noise at rest: what is estimated, and what is remarked on."""

import numpy as np
import pytest
from scipy.signal import lfilter

from breaker.common.randomness import generator
from breaker.records.noise import noise_at_rest, noise_remarks

TIMES = np.linspace(-2.0, 58.0, 151)


def rest(rng, count=80, sd=0.1, colour=0.0):
    noise = rng.standard_normal(count)
    noise[1:] *= np.sqrt(1.0 - colour**2)
    return sd * lfilter([1.0], [1.0, -colour], noise)


def remarks(x, step=0.1):
    return noise_remarks(noise_at_rest(x, step, 0.4, 0.0), 0.1, step, TIMES)


@pytest.mark.parametrize(
    ("step", "count"), [(0.01, 800), (0.1, 80), (0.1, 20), (0.4, 40), (1.0, 12)]
)
def test_good_records_have_no_remark(step, count):
    """At a rate of 4e-4 of each, of 1,000 more than 3 have a remark with a probability of 7e-4."""
    rng = generator(1, "good rest", str(step), count)
    assert sum(bool(remarks(rest(rng, count), step)) for _ in range(1000)) <= 3


def test_noise_and_its_colour_are_estimated():
    """To 5 sd of 10,000 samples; the colour at the model's step, four samples on."""
    x = rest(generator(2, "noise"), 10_000, 0.07, 0.8)
    noise = noise_at_rest(x, 0.1, 0.4, 0.0)
    assert noise.sd == pytest.approx(0.07, rel=0.08)
    assert noise.next == pytest.approx(0.8, abs=0.04)
    assert noise.colour == pytest.approx(0.8**4, abs=0.1)
    x[generator(3, "noise").random(x.size) < 0.3] = np.nan
    assert noise_at_rest(x, 0.1, 0.4, 0.0).colour == pytest.approx(0.8**4, abs=0.1)


def test_an_encoder_at_rest_has_the_noise_of_its_quantum():
    noise = noise_at_rest(np.full(80, 0.64), 0.1, 0.4, 0.32)
    assert noise.sd == pytest.approx(0.32 / np.sqrt(12.0))
    assert np.isnan(noise.colour)
    assert noise_remarks(noise, 0.1, 0.1, TIMES) == []
    assert [each.code for each in noise_remarks(noise, 0.05, 0.1, TIMES)] == ["noisier"]


PLANTED = {
    "twice the noise": (lambda rng: rest(rng, sd=0.2), "noisier"),
    "a fifth of the noise": (lambda rng: rest(rng, 90, 0.02), "calmer"),
    "coloured": (lambda rng: rest(rng, 300, colour=0.85), "coloured"),
    "smoothed over 1 ms": (
        lambda rng: np.convolve(rest(rng, 89), np.full(10, 0.1), mode="valid"),
        "coloured",
    ),
}


@pytest.mark.parametrize("name", PLANTED)
def test_planted_faults_are_remarked_on(name):
    """Mostly."""
    make, code = PLANTED[name]
    rng = generator(4, "planted", name)
    planted = [[each.code for each in remarks(make(rng))] for _ in range(100)]
    assert sum(code in each for each in planted) >= 70


def test_too_little_rest_is_said():
    noise = noise_at_rest(np.zeros(5), 0.1, 0.4, 0.0)
    assert np.isnan([noise.sd, noise.colour]).all()
    assert [each.code for each in remarks(np.zeros(0))] == ["few-at-rest"]
    assert np.isnan(noise_at_rest(np.full(50, np.nan), 0.1, 0.4, 0.0).sd)
    # One without any noise is no error.
    assert noise_at_rest(np.zeros(50), 0.1, 0.4, 0.0).sd == 0.0
    assert remarks(np.zeros(50)) == []
