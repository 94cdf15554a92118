"""Banks: what is in them, the same bytes for the same seed, and shards that fit together."""

import json
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from breaker import __version__
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

    def make(number=0, *, n=64, motion="closing", seed=1, onset_sd=0.3, **settings):
        rng = generator(seed, "bank", motion, number)
        bank = simulate(Model(prior, replace(sensor, onset_sd=onset_sd), motion), n, rng)
        return describe(bank, "a bank", **{"onset_sd": onset_sd, **settings}).assign_attrs(
            seed=seed
        )

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


def test_labels(shard, tmp_path):
    """One ``xr.open_zarr`` gives everything: types, coordinates, units, settings, seed, version."""
    save(shard(noise="none"), tmp_path / "bank.zarr")
    with xr.open_zarr(tmp_path / "bank.zarr") as bank:
        assert (bank.travel.dtype, bank.parameters.dtype) == (np.float32, np.float64)
        units = {name: bank[name].unit for name in ("travel", "time", "onset", "switching_time")}
        assert units == {"travel": "mm", "time": "ms", "onset": "ms", "switching_time": "ms"}
        assert bank.parameter.values.tolist() == list(NAMES)
        assert bank.parameter_unit.values.tolist() == [item.unit for item in PARAMETERS]
        names = ("motion", "title", "seed", "breaker_version")
        about = [bank.attrs[name] for name in names]
        assert about == ["closing", "a bank", 1, __version__]
        assert json.loads(bank.attrs["settings"]) == {"onset_sd": 0.3, "noise": "none"}


def test_same_seed_same_bytes(shard, tmp_path):
    for name, seed in (("one", 1), ("two", 1), ("other", 2)):
        save(shard(seed=seed), tmp_path / name)
    one, two, other = (
        {
            file.relative_to(tmp_path / name): file.read_bytes()
            for file in (tmp_path / name).rglob("*")
            if file.is_file()
        }
        for name in ("one", "two", "other")
    )
    assert one == two != other
    assert len(one) > 10


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
    assert (bank.parameter.values.tolist(), bank.attrs["motion"]) == (list(NAMES), "closing")
    late = shards[1].assign_coords(time=shards[1].time + 0.1)
    for other, words in (
        (shard(1, motion="opening"), "other.*shard_0.*motion"),
        (shard(1, onset_sd=0.1), "other.*shard_0.*settings"),
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
