"""Posterior predictive p-values and bands, at parameters that are known."""

import numpy as np
import pytest
import xarray as xr
from scipy.stats import chi2, kstest

from breaker.common.randomness import generator
from breaker.paper.inference import predict, predictive_p_value
from tests.model.laws import covariance
from tests.networks_fixtures import certain_of, frozen, simulated


@pytest.fixture(scope="module")
def posterior():
    return frozen()


# ---- predictive p-value -------------------------------------------------------------------------


def squares_of(residual, whole):
    """Squared Mahalanobis distances of residuals ``(n, t)``, ``(n,)``."""
    return np.einsum("nt,nt->n", residual, np.linalg.solve(whole, residual.T).T)


@pytest.mark.parametrize("every", [1, 3])
@pytest.mark.parametrize(("motion", "onset"), [("closing", True), ("opening", False)])
def test_p_value_at_the_truth_is_uniform_and_in_closed_form(motion, onset, every):
    """Of the samples that are there. Kolmogorov-Smirnov, false alarm 1e-3."""
    posterior = frozen(motion=motion, onset=onset)
    values, exact, records = simulated(posterior, 400)
    there = np.arange(records.shape[1]) % every == 0
    records[:, ~there] = np.nan
    found = np.array(
        [
            predictive_p_value(posterior.model, record, row[None])
            for record, row in zip(records[:40], values[:40], strict=True)
        ]
    )
    left = covariance(posterior.sensor)[np.ix_(there, there)]
    squares = squares_of((records - exact)[:, there], left)
    closed_form = chi2.sf(squares, there.sum())
    np.testing.assert_allclose(found, closed_form[:40], rtol=1e-9, atol=1e-12)
    assert kstest(closed_form, "uniform").pvalue > 1e-3


def test_p_value_is_the_mean_over_draws(posterior):
    values, _, records = simulated(posterior, 3)
    alone = [predictive_p_value(posterior.model, records[0], values[k : k + 1]) for k in range(3)]
    together = predictive_p_value(posterior.model, records[0], values)
    assert together == pytest.approx(np.mean(alone), rel=1e-12)
    assert alone[0] > 1e-3 > max(alone[1:])


def test_p_value_of_a_misfit_is_tiny(posterior):
    """A bump of nine noise sds over 6 ms, which no draw around the truth makes."""
    values, _, records = simulated(posterior, 5)
    bump = 0.9 * np.exp(-np.square((posterior.sensor.times - 30) / 6))
    draws = values[:, None] * np.exp(1e-4 * generator(3, "test draws").standard_normal((5, 20, 8)))
    for record, around in zip(records, draws, strict=True):
        assert predictive_p_value(posterior.model, record, around) > 1e-3
        assert predictive_p_value(posterior.model, record + bump, around) < 1e-9


# ---- predictions --------------------------------------------------------------------------------


def test_band_width_is_that_of_noise_and_zero(posterior):
    """By its own moments: half width 1.96 sd, with the zero's part that the record leaves open."""
    values, exact, records = simulated(posterior, 3)
    band = predict(posterior.model, records, certain_of(values, 2000), seed=1)
    sensor, t = posterior.sensor, exact.shape[1]
    prior_precision, data_precision = sensor.zero_sd**-2, t * sensor.noise_sd**-2
    variance = 1 / (prior_precision + data_precision)
    zero = variance * data_precision * (records - exact).mean(axis=1, keepdims=True)
    half_width = 1.959964 * np.sqrt(sensor.noise_sd**2 + variance)
    # A quantile of 2,000 replicates has a standard error of 2.7 sd / sqrt(2000), a median 1.25:
    # 3 x 31 numbers each within 4.4 of them is a false-alarm probability of 1e-3 each.
    unit = np.sqrt((sensor.noise_sd**2 + variance) / 2000)
    for name, expected, error in (
        ("median", exact + zero, 1.25),
        ("lower", exact + zero - half_width, 2.7),
        ("upper", exact + zero + half_width, 2.7),
    ):
        assert np.abs(band[name].values - expected).max() < 4.4 * error * unit, name
    assert band.attrs == {"motion": "closing", "noise_sd": sensor.noise_sd}
    np.testing.assert_array_equal(band.measured.values, records)


def test_prediction_follows_its_seed(posterior):
    values, _, records = simulated(posterior, 2)
    draws = certain_of(values, 30)
    one, again, other = (predict(posterior.model, records, draws, seed=seed) for seed in (1, 1, 2))
    xr.testing.assert_identical(one, again)
    assert not np.any(one["median"].values == other["median"].values)
