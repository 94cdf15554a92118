"""A store is opened as it was written, and an incomplete one is refused."""

import json

import numpy as np
import pytest
import xarray as xr

from breaker.common.zarr_store import describe, open_store, save


@pytest.fixture
def store(tmp_path):
    """A store of several chunks, some of them of fill values alone."""
    data = xr.Dataset(
        {
            "travel": (("curve", "time"), np.linspace(-1.0, 9.0, 40).reshape(4, 10)),
            "accepted": ("curve", np.array([True, True, False, True])),
            "reason": ("curve", np.array(["", "", "no motion", ""])),
            "missing": ("curve", np.zeros(4, int)),
        }
    )
    path = tmp_path / "curves.zarr"
    save(describe(data, "a test", seed=1), path)
    return path


def test_values_and_attributes_come_back_and_any_program_can_read_them(store):
    ours, plain = open_store(store), xr.open_zarr(store)
    xr.testing.assert_identical(ours.load(), plain.load())
    assert ours.reason.values.tolist() == ["", "", "no motion", ""]
    assert json.loads(ours.attrs["settings"]) == {"seed": 1}


def test_equal_datasets_are_equal_bytes(store, tmp_path):
    save(open_store(store).load(), tmp_path / "again.zarr")
    files = [file for file in store.rglob("*") if file.is_file()]
    assert len(files) >= 13
    for file in files:
        assert (tmp_path / "again.zarr" / file.relative_to(store)).read_bytes() == file.read_bytes()


def test_a_killed_writer_leaves_a_store_that_is_refused(store, monkeypatch):
    """Over an older store too; written again, it is complete."""
    short = xr.Dataset({"travel": ("time", [1.0])})
    with monkeypatch.context() as patch:
        patch.setattr("zarr.consolidate_metadata", lambda *_, **__: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            save(short, store)
    with pytest.raises(FileNotFoundError, match=f"interrupted. Delete it .rm -r {store}"):
        open_store(store)
    save(short, store)
    assert open_store(store).sizes == {"time": 1}
