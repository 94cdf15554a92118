"""The sensor's errors against its covariance, in matrices written out."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import sqrtm
from scipy.stats import multivariate_normal

from breaker.common.randomness import generator
from breaker.model.sensor import Sensor
from tests.model.laws import covariance, covariance_p_value

SAMPLES = 12


@pytest.fixture(scope="module")
def small():
    """Few samples, so that matrices are small and the zero's prior matters."""
    return Sensor(start=-1.0, stop=10.0, samples=SAMPLES, noise_sd=0.2, onset_sd=0.3, zero_sd=0.1)


@pytest.fixture(scope="module")
def records(small):
    """Exact curves and what the sensor makes of them, ``(n, t)``."""
    rng = generator(1, "test", "records")
    exact = rng.normal(5.0, 3.0, (4000, SAMPLES))
    return exact, small.corrupt(exact, rng)


def test_corrupted_records_have_the_covariance(small, records):
    """False alarm 1e-3 over the 13 tests together."""
    exact, measured = records
    assert covariance_p_value(measured - exact, covariance(small)) > 1e-3


@pytest.mark.parametrize("zero_sd", [0.1, 0.0])
def test_density_and_whitening_are_those_of_the_covariance(small, records, zero_sd):
    small = replace(small, zero_sd=zero_sd)
    errors = covariance(small)
    root = np.linalg.inv(sqrtm(errors))
    np.testing.assert_allclose(small.whiten(np.eye(SAMPLES)), root, atol=1e-12)
    exact, measured = (values[:50] for values in records)
    batch = (measured - exact).reshape(5, 10, SAMPLES)
    np.testing.assert_allclose(small.whiten(batch), batch @ root, atol=1e-12)
    expected = multivariate_normal(np.zeros(SAMPLES), errors).logpdf(measured - exact)
    np.testing.assert_allclose(small.log_likelihood(measured, exact), expected, rtol=1e-12)
    expected = np.square((measured - exact) @ root).sum(axis=1)
    np.testing.assert_allclose(small.chi_square(measured, exact), expected, rtol=1e-11)


GIVEN = SimpleNamespace(standard_normal=np.ones)  # generator whose numbers are all 1


@pytest.mark.parametrize("zero_sd", [0.1, 0.0])
def test_zero_given_a_record(small, records, zero_sd):
    """The normal conditional in matrices, one sd above its mean."""
    exact, measured = records
    small = replace(small, zero_sd=zero_sd)
    cross = zero_sd**2 * np.linalg.solve(covariance(small), np.ones(SAMPLES))
    expected = (measured - exact) @ cross + np.sqrt(zero_sd**2 * (1 - cross.sum()))
    drawn = small.sample_shared(measured, exact, GIVEN)
    np.testing.assert_allclose(drawn[:, 0], expected, rtol=1e-9)


def test_missing_samples_are_left_out(small, records):
    """All of it is that of records which have just the samples that are there."""
    exact, measured = (values[:7].copy() for values in records)
    rng = generator(1, "test", "missing")
    measured[rng.random(measured.shape) < 0.3] = np.nan
    density, square = small.log_likelihood(measured, exact), small.chi_square(measured, exact)
    zeros = small.sample_shared(measured, exact, GIVEN)
    for i, record in enumerate(measured):
        there = ~np.isnan(record)
        shorter = record[there], exact[i][there]
        assert density[i] == pytest.approx(small.log_likelihood(*shorter), rel=1e-12)
        assert square[i] == pytest.approx(small.chi_square(*shorter), rel=1e-12)
        assert zeros[i] == pytest.approx(small.sample_shared(*shorter, GIVEN), rel=1e-12)


def test_wrong_settings_are_refused(sensor):
    for change, words in (
        ({"start": 0.0}, "before 0"),
        ({"stop": 0.0}, "before 0"),
        ({"samples": 1}, "grid"),
        ({"noise_sd": 0.0}, "noise_sd must be positive"),
        ({"onset_sd": -0.1}, "onset_sd"),
        ({"zero_sd": np.nan}, "zero_sd"),
    ):
        with pytest.raises(ValueError, match=words):
            replace(sensor, **change)
