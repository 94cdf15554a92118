"""Components ranked by signal over noise, scores of unit variance, and curves far from the bank."""

import numpy as np
import pytest
from scipy.linalg import eigh

from breaker.common.randomness import generator
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS
from breaker.paper.bank import distance, excess, principal_components
from tests.model.laws import covariance

COUNT = 16


@pytest.fixture(scope="module", params=MOTIONS)
def curves(request, prior, sensor):
    """Noise-free curves (n, t) of the prior, of one motion."""
    rng = generator(1, "test", "plausibility")
    onset = 0.3 * rng.standard_normal(2000)
    return travel(prior.sample(2000, rng), sensor.times, request.param, onset=onset).travel


def test_scores_are_uncorrelated_with_unit_variance(curves, sensor):
    """Over the bank and all noise, in matrices: nothing statistical is left."""
    mean, weights = principal_components(curves, sensor, COUNT)
    np.testing.assert_allclose(mean, curves.mean(axis=0), rtol=1e-13, atol=1e-13)
    assert weights.shape == (sensor.samples, COUNT)
    signal, errors = np.cov(curves, rowvar=False, bias=True), covariance(sensor)
    np.testing.assert_allclose(weights.T @ (signal + errors) @ weights, np.eye(COUNT), atol=1e-9)
    # They are the first of the generalised eigenvalue problem, largest first.
    ratio = np.diag(weights.T @ signal @ weights) / np.diag(weights.T @ errors @ weights)
    best = eigh(signal, errors, eigvals_only=True)[::-1][:COUNT]
    np.testing.assert_allclose(ratio, best, rtol=1e-6)


def test_distance_and_excess_in_numbers():
    """The largest score of any sign; how far a record leaves the envelope, on either side."""
    records = np.array([[1.0, -4.0], [2.0, 1.0], [0.5, 0.5]])
    assert distance(records, np.zeros(2), np.eye(2)).tolist() == [4.0, 2.0, 0.5]
    low, high = np.array([-1.0, -1.0]), np.array([1.0, 2.0])
    assert excess(records, low, high).tolist() == [3.0, 1.0, -0.5]
