"""A store is opened as it was written, or not at all."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from breaker.common.zarr_store import StoreError, describe, open_store, save


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


def files(store: Path) -> list[Path]:
    """Every file of a store but its checksums."""
    return sorted(f for f in store.rglob("*") if f.is_file() and f.name != "checksums.json")


def test_values_and_attributes_come_back_and_any_program_can_read_them(store):
    ours, plain = open_store(store), xr.open_zarr(store)
    xr.testing.assert_identical(ours.load(), plain.load())
    assert ours.reason.values.tolist() == ["", "", "no motion", ""]
    assert json.loads(ours.attrs["settings"]) == {"seed": 1}


def test_equal_datasets_are_equal_bytes(store, tmp_path):
    save(open_store(store).load(), tmp_path / "again.zarr")
    for file in [*files(store), store / "checksums.json"]:
        assert (tmp_path / "again.zarr" / file.relative_to(store)).read_bytes() == file.read_bytes()


def test_every_lost_cut_or_flipped_file_is_named(store, tmp_path):
    """Zarr itself reads a lost chunk as fill values: accepted, and without a reason."""
    faults = {
        "is lost": lambda file: file.unlink(),
        "has changed": lambda file: file.write_bytes(file.read_bytes()[:-1]),
        "has changed since": lambda file: file.write_bytes(
            bytes([file.read_bytes()[0] ^ 1]) + file.read_bytes()[1:]
        ),
    }
    names = [file.relative_to(store) for file in files(store)]
    assert len(names) >= 13
    for words, damage in faults.items():
        for name in names:
            copy = shutil.copytree(store, tmp_path / "copy.zarr", dirs_exist_ok=True)
            damage(copy / name)
            with pytest.raises(StoreError) as caught:
                open_store(copy)
            for part in (str(copy), f"its file {name} {words}", f"rm -r {copy}"):
                assert part in str(caught.value)


def test_a_killed_writer_leaves_a_store_that_is_refused(store, monkeypatch):
    """Over an older store too, whose checksums do not stay; written again, it is complete."""

    def killed(_):
        raise KeyboardInterrupt

    short = xr.Dataset({"travel": ("time", [1.0])})
    with monkeypatch.context() as patch:
        patch.setattr("breaker.common.zarr_store._checksums", killed)
        with pytest.raises(KeyboardInterrupt):
            save(short, store)
    with pytest.raises(StoreError, match="interrupted"):
        open_store(store)
    save(short, store)
    assert open_store(store).sizes == {"time": 1}


def test_a_store_that_cannot_be_read_is_named(store, tmp_path):
    for text in ("", "{", "\xff"):
        (store / "checksums.json").write_text(text, encoding="latin-1")
        with pytest.raises(StoreError, match=r"checksums\.json"):
            open_store(store)
    (tmp_path / "file.zarr").write_text("")
    for name in ("none.zarr", "file.zarr"):
        with pytest.raises(StoreError, match=name):
            open_store(tmp_path / name)
