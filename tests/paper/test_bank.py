"""Banks: what is in them, the same for the same seed, and shards that fit together."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from breaker.common.randomness import generator
from breaker.common.zarr_store import describe, save
from breaker.model import curves
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS, NAMES, PARAMETERS
from breaker.model.prior import Prior
from breaker.paper.bank import open_bank, simulate
from breaker.paper.joint_model import Model


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
    assert bank.sizes == {"curve": 64, "time": 151, "parameter": 7}
    theta, onset = bank.parameters.values, bank.onset.values
    expected = travel(theta, sensor.times, motion, onset=onset)
    np.testing.assert_array_equal(bank.travel, expected.travel.astype(np.float32))
    np.testing.assert_array_equal(bank.switching_time, expected.switching)
    np.testing.assert_array_equal(bank.reopening, expected.reopening)
    assert np.all(Prior.supported(theta))


def test_a_bank_follows_from_its_seed_and_names_its_units(shard):
    one, again, other = shard(), shard(), shard(seed=2)
    xr.testing.assert_identical(one, again)
    assert not np.any(one.travel[:, -1] == other.travel[:, -1])
    assert (one.travel.dtype, one.parameters.dtype) == (np.float32, np.float64)
    units = {name: one[name].unit for name in ("travel", "time", "onset", "switching_time")}
    assert units == {"travel": "mm", "time": "ms", "onset": "ms", "switching_time": "ms"}
    assert one.parameter.values.tolist() == list(NAMES)
    assert one.parameter_unit.values.tolist() == [item.unit for item in PARAMETERS]


def test_shards_keep_their_order_and_have_to_fit(shard, tmp_path):
    shards = [shard(number) for number in range(3)]
    paths = [tmp_path / f"shard_{number}.zarr" for number in range(3)]
    for item, path in zip(shards, paths, strict=True):
        save(item, path)
    bank = open_bank([paths[2], paths[0], paths[1]])
    for variable in ("travel", "parameters", "onset", "switching_time", "reopening"):
        expected = np.concatenate([shards[number][variable] for number in (2, 0, 1)])
        np.testing.assert_array_equal(bank[variable], expected)
    assert len(np.unique(bank.parameters[:, 0])) == 3 * 64
    late = shards[1].assign_coords(time=shards[1].time + 0.1)
    for other, words in (
        (shard(1, motion="opening"), "of different banks"),
        (shard(1, onset_sd=0.1), "of different banks"),
        (late, "time"),
    ):
        save(other, tmp_path / "other")
        with pytest.raises(ValueError, match=words):
            open_bank([paths[0], tmp_path / "other"])


def test_curves_that_are_not_finite_are_counted(sensor):
    """A force and springs at the end of what a float can hold."""
    medians = np.array([2.0, 1e-3, 0.04, 0.3, 0.12, 1e308, 10.0])
    prior = Prior(medians=medians, log_sds=np.full(7, 1e-3))
    model = Model(prior, replace(sensor, onset_sd=0.0), "closing")
    with np.errstate(all="ignore"), pytest.raises(FloatingPointError, match="8 of 8"):
        simulate(model, 8, generator(1, "test", "not finite"))
