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


def scores(records, mean, weights):
    return (records - mean) @ weights


def covariances(curves, sensor):
    """Of the signal over the bank, and of a record's errors, ``(t, t)`` each."""
    return np.cov(curves, rowvar=False, bias=True), covariance(sensor)


def test_scores_are_uncorrelated_with_unit_variance(curves, sensor):
    """Over the bank and all noise, in matrices: nothing statistical is left."""
    mean, weights = principal_components(curves, sensor, COUNT)
    np.testing.assert_allclose(mean, curves.mean(axis=0), rtol=1e-13, atol=1e-13)
    assert weights.shape == (sensor.samples, COUNT)
    signal, errors = covariances(curves, sensor)
    np.testing.assert_allclose(weights.T @ (signal + errors) @ weights, np.eye(COUNT), atol=1e-9)
    # The signal alone has less: the noise counts, and more so in the last component.
    alone = np.diag(weights.T @ signal @ weights)
    assert alone[0] > 0.999
    assert alone[-1] < 0.9


def test_components_are_ranked_by_signal_over_noise(curves, sensor):
    """They are the first of the generalised eigenvalue problem, largest first."""
    _, weights = principal_components(curves, sensor, COUNT)
    signal, errors = covariances(curves, sensor)
    ratio = np.diag(weights.T @ signal @ weights) / np.diag(weights.T @ errors @ weights)
    assert np.all(np.diff(ratio) < 0)
    best = eigh(signal, errors, eigvals_only=True)[::-1][:COUNT]
    np.testing.assert_allclose(ratio, best, rtol=1e-6)


@pytest.mark.parametrize(
    "strange",
    [
        lambda curve: 3.0 * curve,  # another breaker
        lambda curve: 10.0 * curve,  # a wrong unit
        lambda curve: -curve,  # a wrong sign
        lambda curve: curve[::-1],  # the other motion
        lambda curve: np.roll(curve, 40),  # 16 ms late
    ],
    ids=["thrice", "unit", "negative", "backwards", "late"],
)
def test_far_curves_are_far(curves, sensor, strange):
    """Farther than every record of the bank."""
    mean, weights = principal_components(curves, sensor, COUNT)
    rng = generator(1, "test", "far")
    farthest = distance(sensor.corrupt(curves, rng), mean, weights).max()
    records = sensor.corrupt(np.array([strange(curve) for curve in curves[:20]]), rng)
    assert distance(records, mean, weights).min() > farthest


def test_distance_and_excess_in_numbers():
    """The largest score of any sign; how far a record leaves the envelope, on either side."""
    records = np.array([[1.0, -4.0], [2.0, 1.0], [0.5, 0.5]])
    assert distance(records, np.zeros(2), np.eye(2)).tolist() == [4.0, 2.0, 0.5]
    low, high = np.array([-1.0, -1.0]), np.array([1.0, 2.0])
    assert excess(records, low, high).tolist() == [3.0, 1.0, -0.5]
