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
        types = {name: str(array.dtype) for name, array in bank.data_vars.items()}
        double = dict.fromkeys(("parameters", "onset", "switching_time"), "float64")
        assert types == double | {"travel": "float32", "reopening": "bool"}
        assert bank.travel.dims == ("curve", "time")
        assert bank.parameters.dims == ("curve", "parameter")
        units = {name: bank[name].unit for name in ("travel", "time", "onset", "switching_time")}
        assert units == {"travel": "mm", "time": "ms", "onset": "ms", "switching_time": "ms"}
        assert bank.parameter.values.tolist() == list(NAMES)
        assert bank.parameter_unit.values.tolist() == [each.unit for each in PARAMETERS]
        about = (bank.attrs["motion"], bank.attrs["title"], bank.attrs["seed"])
        assert about == ("closing", "a bank", 1)
        assert bank.attrs["breaker_version"] == __version__
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


def test_shards_differ_and_keep_their_order(shard, tmp_path):
    shards = [shard(number) for number in range(3)]
    assert len(np.unique(np.concatenate([each.parameters[:, 0] for each in shards]))) == 3 * 64
    paths = [tmp_path / f"shard_{number:03d}.zarr" for number in range(3)]
    for each, path in zip(shards, paths, strict=True):
        save(each, path)
    for order in ([0, 1, 2], [2, 0]):
        bank = open_bank([paths[number] for number in order])
        for variable in ("travel", "parameters", "onset", "switching_time", "reopening"):
            expected = np.concatenate([shards[number][variable] for number in order])
            np.testing.assert_array_equal(bank[variable], expected)
        assert bank.parameter.values.tolist() == list(NAMES)
        assert bank.attrs["motion"] == "closing"


@pytest.mark.parametrize(
    ("other", "late", "message"),
    [
        ({"motion": "opening"}, 0.0, "second.*first.*motion"),
        ({"onset_sd": 0.1}, 0.0, "second.*first.*settings"),
        ({}, 0.1, "time"),  # another grid
    ],
)
def test_shards_that_do_not_fit_are_refused(shard, tmp_path, other, late, message):
    save(shard(0), tmp_path / "first")
    bank = shard(1, **other)
    save(bank.assign_coords(time=bank.time + late), tmp_path / "second")
    with pytest.raises(ValueError, match=message):
        open_bank([tmp_path / "first", tmp_path / "second"])


def test_curves_that_are_not_finite_are_counted(sensor):
    """A force and springs at the end of what a float can hold."""
    medians = np.array([2.0, 1e-3, 0.04, 0.3, 0.12, 1e308, 10.0])
    prior = Prior(medians=medians, log_sds=np.full(7, 1e-3))
    rng = generator(1, "test", "not finite")
    with (
        np.errstate(all="ignore"),
        pytest.raises(FloatingPointError, match="8 of 8 simulated closing curves are not finite"),
    ):
        simulate(Model(prior, replace(sensor, onset_sd=0.0), "closing"), 8, rng)
