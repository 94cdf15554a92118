"""NetCDF, HDF5 and Zarr: variables are read as columns; no file hangs or fills memory."""

import json
import os
import struct

import h5py
import numpy as np
import pytest
import xarray as xr

from breaker.records.files import RejectedCurveError
from breaker.records.formats.registry import look_into, read_columns
from breaker.records.settings import complete
from tests.records.refused import told

TIME = np.round(0.1 * np.arange(60), 1)
TRAVEL = np.round(0.02 * np.arange(60) ** 1.5, 3)


def labelled(**units):
    units = {"travel": "mm", "time": "ms", **units}
    return xr.Dataset(
        {"travel": ("time", TRAVEL, {"units": units["travel"]}), "scalar": 1.0},
        coords={"time": ("time", TIME, {"units": units["time"]})},
        attrs={"station": "North"},
    )


WRITE = {
    "3.nc": lambda data, file: data.to_netcdf(file, engine="scipy"),
    "4.nc": lambda data, file: data.to_netcdf(file, engine="h5netcdf"),
    "2.zarr": lambda data, file: data.to_zarr(file, mode="w", zarr_format=2, consolidated=True),
    "3.zarr": lambda data, file: data.to_zarr(file, mode="w", zarr_format=3, consolidated=False),
}


def read(file, channel="", **settings):
    return read_columns(file, complete({"time_unit": "ms", **settings}), channel)


def rejection(file, channel="", **settings):
    return told(file, lambda: read(file, channel, **settings))


@pytest.mark.parametrize("name", WRITE)
def test_labelled_arrays_are_read(tmp_path, name):
    file = tmp_path / name
    packed = xr.DataArray(np.rint(TRAVEL / 0.5).astype("i2"), dims="time")
    packed = packed.assign_attrs(scale_factor=0.5, add_offset=1.0, _FillValue=np.int16(3))
    WRITE[name](labelled(time="milliseconds since 2024-11-20").assign(packed=packed), file)
    columns = read(file)
    np.testing.assert_array_equal(columns.travel, TRAVEL)
    np.testing.assert_array_equal(columns.time, TIME)
    expected = np.where(packed == 3, np.nan, 0.5 * packed + 1.0)
    np.testing.assert_array_equal(read(file, "packed").travel, expected)
    assert ["station :", "North"] in look_into(file).preamble
    assert "'scalar'" in rejection(file, "scalar")
    WRITE[name](labelled(travel="deg").rename(time="t").expand_dims(phase=1), file)
    seen = look_into(file)
    np.testing.assert_array_equal(seen.columns[seen.names.index("travel")], TRAVEL)
    assert "'deg'" in rejection(file)
    WRITE[name](xr.Dataset({"scalar": 1.0}), file)
    assert "no variable of numbers" in rejection(file)


def test_a_file_of_version_4_that_is_cut_is_refused(tmp_path):
    file = tmp_path / "a.nc"
    WRITE["4.nc"](labelled(), file)
    file.write_bytes(file.read_bytes()[:-2000])
    rejection(file)


# ---- what may do harm ----------------------------------------------------------------------------


def _link(file):
    file["travel"] = h5py.ExternalLink("other.nc", "travel")


def _store(file):
    file.create_dataset("travel", (60,), "f8", external=[("other.raw", 0, 480)])


def _view(file):
    layout = h5py.VirtualLayout((60,), "f8")
    layout[:] = h5py.VirtualSource("other.nc", "travel", (60,))
    file.create_virtual_dataset("travel", layout)


def _many_groups(file):
    for i in range(10_001):
        file.create_group(f"{i}")


def _deep(file):
    for _ in range(3_000):
        file = file.create_group("a")


def _many_variables(file):
    for i in range(301):
        file[f"{i}"] = TIME


def _wide_chunk(file):
    file.create_dataset("a", (9,), "f8", chunks=(2**27,), maxshape=(None,))


def _large(file):
    for i in range(7):
        file.create_dataset(f"{i}", (2_100_000,), "f4", compression="gzip")


@pytest.mark.parametrize(
    ("write", "reason"),
    [
        (_link, "has a link 'travel'"),
        (_store, "in another file"),
        (_view, "in another file"),
        (lambda file: file.create_dataset("a", (10**9,), "f8"), "bytes of numbers"),
        (_wide_chunk, "bytes of numbers"),
        (_many_groups, "more than 10000 parts"),
        (_deep, "no variable of numbers"),
        (_many_variables, "has 301 columns"),
        (_large, "has 2,100,000 samples"),
    ],
)
def test_a_file_of_version_4_that_may_do_harm_is_refused(tmp_path, write, reason):
    with h5py.File(tmp_path / "a.nc", "w") as content:
        write(content)
    with pytest.raises(RejectedCurveError, match=reason):
        look_into(tmp_path / "a.nc")


def test_a_text_of_a_damaged_size_does_not_hang(tmp_path):
    """Planted: HDF5 2.0 would read such a file without end."""
    file = tmp_path / "a.nc"
    WRITE["4.nc"](labelled(), file)
    content = file.read_bytes()
    first = content.index(b"GCOL") + 16
    damaged = content[: first + 8] + struct.pack("<q", -16) + content[first + 16 :]
    file.write_bytes(damaged)
    assert "damaged texts" in rejection(file)


@pytest.mark.parametrize(
    "change",
    [
        {"codecs": [{"name": "numcodecs.pickle"}]},
        {"shape": [10**9]},
        {"chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [10**9]}}},
        {
            "shape": [20_000],
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [1]}},
        },
        {"data_type": {"name": "null_terminated_bytes", "configuration": {"length_bytes": 10**9}}},
    ],
)
def test_a_store_that_states_what_may_do_harm_is_refused(tmp_path, change):
    file = tmp_path / "a.zarr"
    labelled().to_zarr(file, zarr_format=3, consolidated=False)
    part = file / "travel/zarr.json"
    part.write_text(json.dumps(json.loads(part.read_text()) | change))
    rejection(file)


def test_what_is_within_a_store_is_looked_at_before_it_is_opened(tmp_path):
    file = tmp_path / "a.zarr"
    labelled().to_zarr(file, consolidated=False)
    (file / "other").symlink_to(file / "travel")
    assert "its part other is a link" in rejection(file)
    (file / "other").unlink()
    os.mkfifo(file / "other")
    assert "its part other is a pipe" in rejection(file)
    (tmp_path / "b.zarr").write_bytes(b"")
    assert "is a file, not a folder" in rejection(tmp_path / "b.zarr")
