"""Banks: their content, shards that fit together, components and the distance from them."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy.linalg import eigh

from breaker.common.randomness import generator
from breaker.common.zarr_store import describe, save
from breaker.model import curves
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS, NAMES
from breaker.model.prior import Prior
from breaker.paper.bank import distance, excess, open_bank, principal_components, simulate
from breaker.paper.joint_model import Model
from tests.model.laws import covariance


@pytest.fixture
def shard(prior, sensor):
    """Make a shard of a bank."""

    def make(number=0, *, motion="closing", seed=1, onset_sd=0.3):
        rng = generator(seed, "bank", motion, number)
        bank = simulate(Model(prior, replace(sensor, onset_sd=onset_sd), motion), 64, rng)
        return describe(bank, "a bank", onset_sd=onset_sd)

    return make


@pytest.mark.parametrize("motion", MOTIONS)
def test_content(shard, sensor, motion, monkeypatch):
    """Also where it is made in several blocks."""
    monkeypatch.setattr(curves, "_ROWS", 20)
    bank = shard(motion=motion)
    assert bank.parameter.values.tolist() == list(NAMES)
    theta, onset = bank.parameters.values, bank.onset.values
    expected = travel(theta, sensor.times, motion, onset=onset)
    np.testing.assert_array_equal(bank.travel, expected.travel.astype(np.float32))
    assert np.all(Prior.supported(theta))


def test_a_bank_follows_from_its_seed(shard):
    one, again, other = shard(), shard(), shard(seed=2)
    xr.testing.assert_identical(one, again)
    assert not np.any(one.travel[:, -1] == other.travel[:, -1])


def test_shards_keep_their_order_and_have_to_fit(shard, tmp_path):
    shards = [shard(number) for number in range(3)]
    paths = [tmp_path / f"shard_{number}.zarr" for number in range(3)]
    for item, path in zip(shards, paths, strict=True):
        save(item, path)
    bank = open_bank([paths[2], paths[0], paths[1]])
    for variable in ("travel", "parameters", "onset"):
        expected = np.concatenate([shards[number][variable] for number in (2, 0, 1)])
        np.testing.assert_array_equal(bank[variable], expected)
    assert len(np.unique(bank.parameters[:, 0])) == 3 * 64
    for other in (shard(1, motion="opening"), shard(1, onset_sd=0.1)):
        save(other, tmp_path / "other")
        with pytest.raises(ValueError, match="of different banks"):
            open_bank([paths[0], tmp_path / "other"])


@pytest.mark.parametrize("motion", MOTIONS)
def test_scores_are_uncorrelated_with_unit_variance(prior, sensor, motion):
    """Over the bank and all noise, in matrices: nothing statistical is left."""
    theta, onset = Model(prior, sensor, motion).sample(2000, generator(1, "test", "components"))
    bank = travel(theta, sensor.times, motion, onset=onset).travel
    mean, weights = principal_components(bank, sensor, 16)
    np.testing.assert_allclose(mean, bank.mean(axis=0), rtol=1e-13, atol=1e-13)
    signal, errors = np.cov(bank, rowvar=False, bias=True), covariance(sensor)
    np.testing.assert_allclose(weights.T @ (signal + errors) @ weights, np.eye(16), atol=1e-9)
    # They are the first of the generalised eigenvalue problem, largest first.
    ratio = np.diag(weights.T @ signal @ weights) / np.diag(weights.T @ errors @ weights)
    best = eigh(signal, errors, eigvals_only=True)[::-1][:16]
    np.testing.assert_allclose(ratio, best, rtol=1e-6)


def test_distance_and_excess_in_numbers():
    """The largest score of any sign; how far a record leaves the envelope, on either side."""
    records = np.array([[1.0, -4.0], [2.0, 1.0], [0.5, 0.5]])
    assert distance(records, np.zeros(2), np.eye(2)).tolist() == [4.0, 2.0, 0.5]
    low, high = np.array([-1.0, -1.0]), np.array([1.0, 2.0])
    assert excess(records, low, high).tolist() == [3.0, 1.0, -0.5]
