"""NetCDF, HDF5 and Zarr: variables are read as columns; no file crashes, hangs or fills memory."""

import json
import os
import re
import signal
import struct
import sys

import h5py
import numcodecs
import numpy as np
import pytest
import xarray as xr
from scipy.io import netcdf_file

from breaker.records.files import Opened, RejectedCurveError
from breaker.records.formats import netcdf as labelled_arrays
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
    data = labelled(time="milliseconds since 2024-11-20").assign(packed=packed)
    WRITE[name](data, file)
    columns = read(file)
    np.testing.assert_array_equal(columns.travel, TRAVEL)
    np.testing.assert_array_equal(columns.time, TIME)
    expected = np.where(packed == 3, np.nan, 0.5 * packed + 1.0)
    np.testing.assert_array_equal(read(file, "packed").travel, expected)
    assert ["station :", "North"] in look_into(file).preamble
    WRITE[name](labelled(travel="deg"), file)
    assert rejection(file).startswith(": the unit of 'travel' is 'deg', but endurance.")


@pytest.mark.parametrize("name", ["3.nc", "4.nc", "3.zarr"])
def test_what_is_not_a_record_in_labelled_arrays_is_refused(tmp_path, name):
    file = tmp_path / name
    WRITE[name](labelled().rename(time="t").expand_dims(phase=1), file)
    np.testing.assert_array_equal(read(file).time, TIME)
    assert read(file, time_column=None, rate=10).time is None
    WRITE[name](labelled(time="s"), file)
    assert "the unit of 'time' is 's'" in rejection(file)
    assert "no column 'position' among" in rejection(file, "position")
    assert "no column 'scalar' among" in rejection(file, "scalar")
    WRITE[name](labelled().expand_dims(phase=2), file)
    assert "no column 'travel' among 'time'" in rejection(file)
    WRITE[name](labelled().drop_vars("time"), file)
    assert "no column 'time' among" in rejection(file)
    WRITE[name](xr.Dataset({"scalar": 1.0}), file)
    assert "has no variable of numbers along one dimension" in rejection(file)


def test_groups_of_a_plain_hdf5_file_are_read(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["pole A/travel"], file["pole A/time"] = TRAVEL, TIME
        file["notes"] = "none"
    columns = read(tmp_path / "a.h5", "pole A/travel", time_column="pole A/time")
    np.testing.assert_array_equal(columns.travel, TRAVEL)
    np.testing.assert_array_equal(columns.time, TIME)


def test_a_file_of_version_4_that_is_cut_is_refused(tmp_path):
    file = tmp_path / "a.nc"
    WRITE["4.nc"](labelled(), file)
    file.write_bytes(file.read_bytes()[:-2000])
    assert "cannot be read (OSError" in rejection(file)


# ---- what may do harm ----------------------------------------------------------------------------


def _link(file):
    file["travel"] = h5py.ExternalLink("other.nc", "travel")


def _store(file):
    file.create_dataset("travel", (60,), "f8", external=[("other.raw", 0, 480)])


def _view(file):
    layout = h5py.VirtualLayout((60,), "f8")
    layout[:] = h5py.VirtualSource("other.nc", "travel", (60,))
    file.create_virtual_dataset("travel", layout)


def _many(file):
    for i in range(10_001):
        file.create_group(f"{i}")


def _deep(file):
    for _ in range(3_000):
        file = file.create_group("a")


@pytest.mark.parametrize(
    ("write", "place", "reason"),
    [
        (_link, "/", "in another file"),
        (_link, "part", "in another file"),
        (_store, "part", "in another file"),
        (_view, "part", "in another file"),
        (lambda file: file.create_dataset("a", (10**9,), "f8"), "part", "bytes of numbers"),
        (_many, "/", "has 10001 parts"),
        (_deep, "/", r"no variable|cannot be read"),
    ],
)
def test_a_file_of_version_4_that_may_do_harm_is_refused(tmp_path, write, place, reason):
    with h5py.File(tmp_path / "a.nc", "w") as content:
        write(content.require_group(place))
    opened = Opened(tmp_path / "a.nc")
    for use in (read, look_into):
        with pytest.raises(RejectedCurveError, match=reason):
            use(opened)


@pytest.mark.parametrize(
    "end", ["while True: pass", f"import os; os.kill(os.getpid(), {int(signal.SIGSEGV)})"]
)
def test_a_library_that_hangs_or_crashes_ends_no_command(tmp_path, monkeypatch, end):
    """Planted: in the place of a file that makes HDF5 do so."""
    monkeypatch.setattr(labelled_arrays, "_SECONDS", 1)
    (tmp_path / "h5py.py").write_text(f"def __getattr__(name):\n    {end}\n")
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    WRITE["4.nc"](labelled(), tmp_path / "a.nc")
    assert "cannot be read in 1 s and" in rejection(tmp_path / "a.nc")


@pytest.mark.parametrize("name", ["3.nc", "4.nc"])
def test_more_values_than_a_record_has_are_refused(tmp_path, name):
    file = tmp_path / name
    many = xr.Dataset({f"v{i}": ("time", np.zeros(2_100_000, "f4")) for i in range(7)})
    encoding = {name: {"compression": "gzip"} for name in many} if name == "4.nc" else None
    many.to_netcdf(file, engine="h5netcdf" if encoding else "scipy", encoding=encoding)
    for use in (read, look_into):
        with pytest.raises(RejectedCurveError, match="has 2,100,000 samples, but"):
            use(file)


def test_the_same_bytes_are_not_read_as_many_variables(tmp_path):
    file, count = tmp_path / "a.nc", 20
    with netcdf_file(file, "w") as writer:
        writer.createDimension("time", 100_000)
        for i in range(count):
            writer.createVariable(f"v{i:02}", "f8", ("time",))
    content = file.read_bytes()
    begin = len(content) - 800_000 * count
    head = content[:begin]
    for i in range(count):
        head = head.replace(
            struct.pack(">ii", 800_000, begin + 800_000 * i), struct.pack(">ii", 800_000, begin)
        )
    file.write_bytes(head + content[begin : begin + 800_000])
    assert "parts of it twice; export the record alone" in rejection(file)


@pytest.mark.parametrize("consolidated", [False, True])
@pytest.mark.parametrize("place", ["filters", "compressor"])
def test_no_codec_of_a_store_runs_what_stands_in_it(tmp_path, monkeypatch, place, consolidated):
    """Metadata of one array and of all: whichever is used."""
    file, ran = tmp_path / "a.zarr", tmp_path / "ran"
    labelled().to_zarr(file, zarr_format=2, consolidated=consolidated)
    part = file / ".zmetadata" if consolidated else file / "travel/.zarray"
    found, codec = json.loads(part.read_text()), {"id": "pickle"}
    of_travel = found["metadata"]["travel/.zarray"] if consolidated else found
    of_travel |= {"filters": None, "compressor": None, "dtype": "|O", "fill_value": None}
    of_travel[place] = [codec] if place == "filters" else codec
    part.write_text(json.dumps(found))
    code = f"cos\nmkdir\n(V{ran}\ntR.".encode()  # as a pickle has it
    (file / "travel/0").write_bytes(code)
    monkeypatch.setenv("NUMCODECS_ALLOW_UNSAFE_PICKLE_DECODE", "1")
    with pytest.raises(ValueError, match=r"a\.zarr: "):
        read(file)
    assert not ran.exists()
    monkeypatch.setattr(numcodecs.pickles, "ALLOW_UNSAFE_PICKLE_DECODE", True)
    numcodecs.Pickle().decode(code)
    assert ran.exists(), "the planted code does nothing"


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
    assert re.search("Error|of numbers|among", rejection(file))


def test_what_is_within_a_store_is_looked_at_before_it_is_opened(tmp_path):
    file = tmp_path / "a.zarr"
    labelled().to_zarr(file, consolidated=False)
    (file / "other").symlink_to(file / "travel")
    assert "its part other is a link" in rejection(file)
    (file / "other").unlink()
    os.mkfifo(file / "other")
    with pytest.raises(RejectedCurveError, match="its part other is a pipe"):
        look_into(file)
    (tmp_path / "b.zarr").write_bytes(b"")
    assert "is a file, not a folder" in rejection(tmp_path / "b.zarr")
