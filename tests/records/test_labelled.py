"""NetCDF and HDF5: variables are read as columns; no file hangs or fills memory."""

from functools import partial

import h5py
import numpy as np
import pytest
import xarray as xr

from breaker.records.formats.registry import look_into, read_columns
from breaker.records.settings import complete
from tests.records.format_contract import TIME, TRAVEL
from tests.records.refused import refusal


def labelled(travel="mm", time="ms"):
    return xr.Dataset(
        {"travel": ("time", TRAVEL, {"units": travel}), "scalar": 1.0},
        coords={"time": ("time", TIME, {"units": time})},
        attrs={"station": "North"},
    )


@pytest.fixture
def file(tmp_path):
    return tmp_path / "a.nc"


def read(file, channel=""):
    return read_columns(file, complete({"time_unit": "ms"}), channel)


@pytest.mark.parametrize("engine", ["scipy", "h5netcdf"])  # versions 3 and 4
def test_labelled_arrays_are_read(file, engine):
    write = partial(xr.Dataset.to_netcdf, engine=engine)
    packed = xr.DataArray(np.rint(TRAVEL / 0.5).astype("i2"), dims="time")
    packed = packed.assign_attrs(scale_factor=0.5, add_offset=1.0, _FillValue=np.int16(3))
    whole = labelled(time="milliseconds since 2024-11-20").assign(packed=packed)
    write(whole, file)
    columns = read(file)
    np.testing.assert_array_equal(columns.travel, TRAVEL)
    np.testing.assert_array_equal(columns.time, TIME)
    expected = np.where(packed == 3, np.nan, 0.5 * packed + 1.0)
    np.testing.assert_array_equal(read(file, "packed").travel, expected)
    assert ["station :", "North"] in look_into(file).preamble
    assert "'scalar'" in refusal(file, lambda: read(file, "scalar"))
    write(labelled("deg").rename(time="t").expand_dims(phase=1), file)
    seen = look_into(file)
    np.testing.assert_array_equal(seen.columns[seen.names.index("travel")], TRAVEL)
    assert "'deg'" in refusal(file, lambda: read(file))
    write(xr.Dataset({"scalar": 1.0}), file)
    refusal(file, lambda: read(file))


LAYOUT = h5py.VirtualLayout((60,), "f8")
LAYOUT[:] = h5py.VirtualSource("other.nc", "travel", (60,))
HARM = {
    "a link": lambda file: file.update(other=h5py.ExternalLink("other.nc", "travel")),
    "a soft link": lambda file: file.update(other=h5py.SoftLink("/travel")),
    "another file": lambda file: file.create_dataset(
        "other", (60,), "f8", external=[("other.raw", 0, 480)]
    ),
    "a view": lambda file: file.create_virtual_dataset("other", LAYOUT),
    "groups": lambda file: [file.create_group(f"{i}") for i in range(301)],
    "a size": lambda file: file.create_dataset("other", (10**9,), "f8"),
    "a chunk": lambda file: file.create_dataset(
        "other", (9,), "f8", chunks=(2**27,), maxshape=(None,)
    ),
    "sizes": lambda file: [
        file.create_dataset(f"{i}", (2_100_000,), "f4", compression="gzip") for i in range(7)
    ],
}


@pytest.mark.parametrize("kind", HARM)
def test_what_is_elsewhere_or_may_do_harm_is_refused(file, kind):
    """What is elsewhere is not left out, and its name is stated."""
    labelled().to_netcdf(file, engine="h5netcdf")
    with h5py.File(file, "a") as content:
        HARM[kind](content)
    elsewhere = [*HARM].index(kind) < 4
    assert "'other'" in refusal(file, lambda: read(file)) or not elsewhere
    refusal(file, lambda: look_into(file))
