"""Curve files that are no text: read as the same columns, or refused, whatever is wrong."""

import io
import json
import os
import re
import struct
import sys
import tomllib
import zipfile
from pathlib import Path

import h5py
import numcodecs
import numpy as np
import openpyxl
import pytest
import xarray as xr
from packaging.requirements import Requirement
from scipy.io import netcdf_file

from breaker.common.randomness import generator
from breaker.drive.simulation.dialects import DIALECTS
from breaker.records.files import LARGEST, RejectedCurveError
from breaker.records.formats import comtrade as recorders
from breaker.records.formats import excel as workbooks
from breaker.records.formats.registry import FORMATS, look_into, read_columns
from breaker.records.settings import complete
from tests.records.refused import told

TIME = np.round(0.1 * np.arange(60), 1)
TRAVEL = np.round(0.02 * np.arange(60) ** 1.5, 3)
PROJECT = Path(__file__).resolve().parents[2] / "pyproject.toml"


def written(folder, name):
    dialect = DIALECTS[name]
    file = folder / dialect.file_name("closing", 1)
    dialect.write(file, TIME, TRAVEL, motion="closing", operation=1)
    return file


def read(file, name, channel="", **settings):
    return read_columns(file, complete({**DIALECTS[name].settings, **settings}), channel)


def rejection(file, name, channel="", **settings):
    return told(file, lambda: read(file, name, channel, **settings))


# ---- workbooks --------------------------------------------------------------------------------


def workbook(file, sheets):
    book = openpyxl.Workbook()
    for title, rows in sheets.items():
        sheet = book.create_sheet(title)
        for row in rows:
            sheet.append(row)
    book.remove(book.worksheets[0])
    book.save(file)


def test_the_first_sheet_that_has_the_columns_is_read(tmp_path):
    file = tmp_path / "a.xlsx"
    samples = list(zip(TIME.tolist(), TRAVEL.tolist(), strict=True))
    samples[10] = (samples[10][0], None)
    sheets = {
        "cover": [["made by", "x"], ["travel"]],
        "record": [[], ["Zeit und Weg"], [], ["Time [ms]", "Travel 2"], *samples, [], []],
        "other": [["time", "travel 2"], *([t, 7] for t in TIME)],
    }
    workbook(file, sheets)
    columns = read(file, "excel")
    np.testing.assert_array_equal(columns.time, TIME)
    assert np.flatnonzero(np.isnan(columns.travel)).tolist() == [10]
    np.testing.assert_array_equal(np.delete(columns.travel, 10), np.delete(TRAVEL, 10))
    assert columns.lines[0] == 5
    # The decimal sign of texts does not matter to numbers; texts are held to it.
    np.testing.assert_array_equal(read(file, "excel", decimal=",").time, TIME)
    samples[20] = (samples[20][0], "0,25")
    workbook(file, {"record": [["time", "travel 2"], *samples]})
    assert read(file, "excel", decimal=",").travel[20] == 0.25
    assert ", line 22: 'travel 2' is '0,25', which is not a number" in rejection(file, "excel")


def test_a_workbook_without_the_columns_is_refused(tmp_path):
    file = tmp_path / "a.xlsx"
    workbook(file, {"a": [["t", "s"], [0.0, 1.0], [0.1, 1.0]], "b": []})
    assert ": no line has 'time' and 'travel 2'" in rejection(file, "excel")
    workbook(file, {"a": []})
    assert ": is empty" in rejection(file, "excel")


def test_a_bomb_and_endless_rows_are_refused(tmp_path):
    file = written(tmp_path, "excel")
    with zipfile.ZipFile(file, "a", zipfile.ZIP_DEFLATED) as parts:
        parts.writestr("xl/media/zeros", bytes(LARGEST))
    assert file.stat().st_size < 200_000
    assert "64 MiB when unpacked" in rejection(file, "excel")
    far = tmp_path / "far.xlsx"
    book = openpyxl.Workbook()
    book.active.cell(row=1_048_576, column=16_384, value=1.0)
    book.save(far)
    assert "is empty" in rejection(far, "excel")


def with_rows(file, rows):
    """Write a workbook of one sheet, the rows of which are as given."""
    plain = file.with_suffix(".plain")
    workbook(plain, {"a": [[1.0]]})
    with zipfile.ZipFile(plain) as parts, zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as odd:
        for name in parts.namelist():
            text = parts.read(name)
            if name.endswith("sheet1.xml"):
                text = re.sub(b"(<sheetData>).*(?=</sheetData>)", rb"\1" + rows, text)
            odd.writestr(name, text)


def test_of_a_formula_its_value_is_read_with_all_digits(tmp_path):
    names = b'<row><c t="str"><v>time</v></c><c t="str"><v>travel 2</v></c></row>'
    sample = b"<row><c><v>0</v></c><c><f>A2/3</f><v>0.123456789012</v></c></row>"
    with_rows(tmp_path / "a.xlsx", names + sample)
    assert read(tmp_path / "a.xlsx", "excel").travel == [0.123456789012]


ROW = b"<row><c><v>1</v></c></row>"


@pytest.mark.parametrize(
    ("sheet", "reason"),
    [
        (b"<row>" + 20_001 * b"<c/>" + b"</row>", "more than 20000 cells and other elements"),
        (b"<row>" + 2_001 * b"<b/>" + b"</row>", "more than 2000 formats and the like"),
        (150 * b'<row><c r="XFD1"><v>1</v></c></row>', "row 16 ends at column 16384"),
        (ROW.replace(b"<c", b'<c r="XFD1"') + 2000 * ROW, "too many cells or too long texts"),
        (
            30 * ROW.replace(b"><v>1", b' t="str"><v>' + 30_000 * b"x"),
            "too many cells or too long texts",
        ),
        (b"<!DOCTYPE x>" + ROW, "defines texts in its part xl/worksheets/sheet1.xml"),
    ],
)
@pytest.mark.parametrize("way", ["read", "inspected"])
def test_a_workbook_that_would_take_the_memory_is_refused(
    tmp_path, monkeypatch, sheet, reason, way
):
    monkeypatch.setattr(workbooks, "_LARGEST_SHEET", 2**18)
    monkeypatch.setattr(workbooks, "_MOST_ELEMENTS", 20_000)
    monkeypatch.setattr(workbooks, "_MOST_OTHERS", 2_000)
    file = tmp_path / "a.xlsx"
    with_rows(file, sheet)
    with pytest.raises(RejectedCurveError, match=f"{re.escape(str(file))}: .*{reason}"):
        read(file, "excel") if way == "read" else look_into(file)


@pytest.mark.parametrize("joined", [lambda x: x + x, lambda x: b"x" + x, lambda x: x + b"x"])
def test_a_workbook_beside_something_is_refused(tmp_path, joined):
    """Of two, the second would be read."""
    file = written(tmp_path, "excel")
    file.write_bytes(joined(file.read_bytes()))
    assert "something before or after the workbook" in rejection(file, "excel")


@pytest.mark.parametrize("name", ["a.XLS", "a.ods"])
def test_an_old_workbook_is_refused_with_the_remedy(tmp_path, name):
    file = tmp_path / name
    file.write_bytes(b"\xd0\xcf\x11\xe0")
    assert "save it as .xlsx" in rejection(file, "excel")


# ---- COMTRADE ---------------------------------------------------------------------------------


def recorded(file, *, kind="ASCII", rates=1, missing=(), unit="mm", sides="1,1,P", count=60):
    """Write a pair of files with two channels, the second of which is the travel, of no stated rate
    of sampling, one, or two.
    """
    steps = np.rint(TRAVEL / 0.001).astype(int)
    steps[[*missing]] = -32768
    channels = [f"{i},{n},,,{unit},0.001,0,0,-99999,99999,{sides}" for i, n in ((1, "I"), (2, "S"))]
    head = ["station,7,1999", "3,2A,1D", *channels, "1,trip,,,0", "50"]
    ends = [30, count] if rates > 1 else [count]
    head += [f"{rates}", *(f"{10_000 if rates else 0},{end}" for end in ends)]
    head += 2 * ["20/11/2024,15:13:07.000000"] + [kind, "1", ""]
    file.write_text("\n".join(head), encoding="utf-8")
    stamps = np.rint(1e3 * TIME).astype(int)
    rows = list(zip(range(1, 61), stamps.tolist(), steps.tolist(), strict=True))
    if kind == "ASCII":
        data = "".join(f"{n},{t},5,{x},0\n" for n, t, x in rows).encode()
    else:
        form = {"BINARY": "<IIhhH", "BINARY32": "<IIiiH"}[kind]
        data = b"".join(struct.pack(form, n, t, 5, x, 0) for n, t, x in rows)
    file.with_suffix(".dat").write_bytes(data)
    return data


@pytest.mark.parametrize("kind", ["ASCII", "BINARY", "BINARY32"])
@pytest.mark.parametrize("rates", [0, 1, 2])
def test_comtrade_is_read_by_name_and_number(tmp_path, kind, rates):
    file = tmp_path / "a.cfg"
    recorded(file, kind=kind, rates=rates)
    for channel in ("S", "s", "2"):
        columns = read(file, "comtrade", channel)
        np.testing.assert_allclose(columns.travel, TRAVEL, atol=1e-9)
        np.testing.assert_allclose(columns.time, 1e-3 * TIME, atol=1e-12)
    np.testing.assert_allclose(read(file, "comtrade", "S", time_unit="us").time, 1e3 * TIME)
    assert "no column 'Travel A' among 'I', 'S'" in rejection(file, "comtrade")
    if kind == "BINARY":
        recorded(file, kind=kind, rates=rates, missing=[20])
        assert np.flatnonzero(np.isnan(read(file, "comtrade", "S").travel)).tolist() == [20]


def test_comtrade_in_one_file_is_read(tmp_path):
    pair, single = tmp_path / "a.cfg", tmp_path / "b.CFF"
    for kind in ("ASCII", "BINARY"):
        data = recorded(pair, kind=kind)
        head = pair.read_bytes()
        parts = b"--- file type: CFG ---\r\n" + head + b"\r\n--- file type: INF ---\r\nx\r\n"
        stated = kind.encode() + b": %d" % len(data)
        single.write_bytes(parts + b"--- file type: DAT " + stated + b" ---\r\n" + data)
        np.testing.assert_allclose(read(single, "comtrade", "S").travel, TRAVEL, atol=1e-9)
    single.write_bytes(parts)
    assert "lacks its part CFG or DAT" in rejection(single, "comtrade", "S")


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"count": 61}, "says that there are 61 samples, but its data have 60; copy both again"),
        ({"count": 59}, "says that there are 59 samples, but its data have 60; copy both again"),
        ({"count": 10**12}, "says that there are 1000000000000 samples"),
        ({"unit": "deg"}, "the unit of 'S' is 'deg', but endurance.format.travel_unit is 'mm'"),
    ],
)
def test_comtrade_whose_parts_contradict_is_refused(tmp_path, change, reason):
    file = tmp_path / "a.cfg"
    for kind in ("ASCII", "BINARY"):
        recorded(file, kind=kind, **change)
        assert reason in rejection(file, "comtrade", "S")


def test_a_text_of_too_many_values_is_refused(tmp_path, monkeypatch):
    recorded(tmp_path / "a.cfg")
    monkeypatch.setattr(recorders, "_MOST_VALUES", 60 * 13 - 1)
    assert "60 samples; export it as BINARY" in rejection(tmp_path / "a.cfg", "comtrade", "S")
    recorded(tmp_path / "a.cfg", kind="BINARY")
    assert read(tmp_path / "a.cfg", "comtrade", "S").travel.size == 60
    monkeypatch.setattr(recorders, "_MOST_CHANNELS", 2)
    reason = ", line 2: counts more than 2 channels; export fewer"
    assert reason in rejection(tmp_path / "a.cfg", "comtrade", "S")


def test_damaged_comtrade_is_refused(tmp_path):
    file = tmp_path / "a.cfg"
    data = recorded(file)
    head = file.read_text(encoding="utf-8")
    file.write_text(head.replace("10000,60", "nan,60"), encoding="utf-8")
    assert "states a rate that is no number" in rejection(file, "comtrade", "S")
    file.write_text(head.replace("3,2A,1D", "999999999,999999998A,1D"), encoding="utf-8")
    assert "does not describe the channels that it counts" in rejection(file, "comtrade", "S")
    file.write_text(head.replace("ASCII", "OTHER"), encoding="utf-8")
    assert "unknown type 'OTHER'" in rejection(file, "comtrade", "S")
    file.write_text(head.replace("1,1,P", "100,1,S"), encoding="utf-8")
    remark = "'S' is of the secondary side, with a ratio of 100 : 1"
    assert read(file, "comtrade", "S").remarks == (remark,)
    file.write_text(head, encoding="utf-8")
    for cell in (b"1_000", b"x", b"1e246", "١".encode()):
        file.with_suffix(".dat").write_bytes(data.replace(b",5,20,", b",5," + cell + b",", 1))
        assert rejection(file, "comtrade", "S")
    file.with_suffix(".dat").unlink()
    assert "a.dat is not there; copy both files" in rejection(file, "comtrade", "S")


# ---- NetCDF and Zarr --------------------------------------------------------------------------


def labelled(**units):
    units = {"travel": "mm", "time": "ms", **units}
    return xr.Dataset(
        {"travel": ("time", TRAVEL, {"units": units["travel"]}), "scalar": 1.0},
        coords={"time": ("time", TIME, {"units": units["time"]})},
    )


WRITE = {
    "3.nc": lambda data, file: data.to_netcdf(file, engine="scipy"),
    "4.nc": lambda data, file: data.to_netcdf(file, engine="h5netcdf"),
    "a.zarr": lambda data, file: data.to_zarr(file, mode="w", consolidated=False),
}


@pytest.mark.parametrize("name", WRITE)
def test_labelled_arrays_are_read(tmp_path, name):
    file = tmp_path / name
    WRITE[name](labelled(time="milliseconds since 2024-11-20"), file)
    columns = read(file, "netcdf")
    np.testing.assert_array_equal(columns.travel, TRAVEL)
    np.testing.assert_array_equal(columns.time, TIME)
    WRITE[name](labelled(travel="deg"), file)
    assert rejection(file, "netcdf").startswith(": the unit of 'travel' is 'deg', but endurance.")


@pytest.mark.parametrize("name", ["3.nc", "a.zarr"])
def test_what_is_no_record_in_labelled_arrays_is_refused(tmp_path, name):
    file = tmp_path / name
    WRITE[name](labelled().rename(time="t").expand_dims(phase=1), file)
    np.testing.assert_array_equal(read(file, "netcdf").time, TIME)
    assert read(file, "netcdf", time_column=None, rate=10).time is None
    WRITE[name](labelled().rename_dims(time="sample").assign_coords(sample=1.0 + TIME), file)
    np.testing.assert_array_equal(read(file, "netcdf").time, TIME)
    WRITE[name](labelled(time="s"), file)
    assert "the unit of 'time' is 's'" in rejection(file, "netcdf")
    assert "no column 'position' among" in rejection(file, "netcdf", "position")
    assert "no column 'scalar'" in rejection(file, "netcdf", "scalar")
    WRITE[name](labelled().expand_dims(phase=2), file)
    assert "no column 'travel'" in rejection(file, "netcdf")
    WRITE[name](labelled().drop_vars("time"), file)
    assert "no column 'time' among" in rejection(file, "netcdf")


def test_a_file_of_version_4_that_is_cut_is_refused(tmp_path):
    file = tmp_path / "a.nc"
    WRITE["4.nc"](labelled(), file)
    file.write_bytes(file.read_bytes()[:-2000])
    assert "is a NetCDF file that cannot be read (OSError" in rejection(file, "netcdf")


def _link(file):
    file["travel"] = h5py.ExternalLink("other.nc", "travel")


def _store(file):
    file.create_dataset("travel", (60,), "f8", external=[("other.raw", 0, 480)])


def _view(file):
    layout = h5py.VirtualLayout((60,), "f8")
    layout[:] = h5py.VirtualSource("other.nc", "travel", (60,))
    file.create_virtual_dataset("travel", layout)


@pytest.mark.parametrize("place", ["/", "part"])
@pytest.mark.parametrize("write", [_link, _store, _view])
def test_values_in_another_file_are_refused(tmp_path, write, place):
    file = tmp_path / "a.nc"
    with h5py.File(file, "w") as content:
        write(content.require_group(place))
    for use in (lambda: read(file, "netcdf"), lambda: look_into(file)):
        with pytest.raises(RejectedCurveError, match="in another file"):
            use()


def test_a_chunk_that_needs_more_memory_than_a_record_is_refused(tmp_path):
    file = tmp_path / "a.nc"
    with h5py.File(file, "w") as content:
        content.create_dataset("travel", (60,), "f8", maxshape=(None,), chunks=(20_000_000,))
    assert "in chunks of 160000000 bytes" in rejection(file, "netcdf")


class Acting(numcodecs.abc.Codec):
    """A codec that acts as pickle does: on what stands in the chunks."""

    codec_id = "acting"
    acted = False

    def encode(self, buf):
        return buf

    def decode(self, buf, out=None):
        Acting.acted = True
        return buf


@pytest.mark.parametrize("consolidated", [False, True])
@pytest.mark.parametrize(
    ("place", "stated"), [("filters", [{"id": "acting"}]), ("compressor", {"id": "acting"})]
)
def test_no_codec_of_a_store_acts(tmp_path, place, stated, consolidated):
    """Metadata of one array and of all: whichever is used."""
    file, plain = tmp_path / "a.zarr", tmp_path / "plain.zarr"
    numcodecs.register_codec(Acting)
    for store in (file, plain):
        labelled().to_zarr(store, zarr_format=2, consolidated=consolidated)
    part = file / ".zmetadata" if consolidated else file / "travel/.zarray"
    found = json.loads(part.read_text())
    (found["metadata"]["travel/.zarray"] if consolidated else found)[place] = stated
    part.write_text(json.dumps(found))
    for use in (lambda: read(file, "netcdf"), lambda: look_into(file)):
        with pytest.raises(RejectedCurveError, match="codec 'acting', which is not known"):
            use()
    assert not Acting.acted
    read(plain, "netcdf")


SHARDS = {"name": "sharding_indexed", "configuration": {"chunk_shape": [1]}}


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"codecs": ["pickle"]}, "has the codec 'pickle'"),
        ({"codecs": [{"name": "numcodecs.pickle"}]}, "has the codec 'numcodecs.pickle'"),
        ({"codecs": [{"name": "sharding_indexed", "configuration": {"codecs": ["x"]}}]}, "'x'"),
        ({"codecs": [{"name": "bytes", "configuration": {"id": "x"}}]}, "has the codec 'x'"),
        ({"shape": [10**9]}, "chunks of 480 bytes, which with others are too many"),
        ({"shape": 10**9}, "chunks of 480 bytes, which with others are too many"),
        ({"chunk_grid": {"configuration": {"chunk_shape": [10**9]}}}, "of 8000000000 bytes"),
        ({"shape": [20_000], "codecs": [SHARDS]}, "has 20000 chunks"),
        ({"data_type": {"configuration": {"length_bytes": 10**7}}}, "chunks of 600000000 bytes"),
    ],
)
@pytest.mark.parametrize("inline", [False, True])
def test_a_store_that_states_what_may_do_harm_is_refused(tmp_path, change, reason, inline):
    file = tmp_path / "a.zarr"
    labelled().to_zarr(file, zarr_format=3, consolidated=False)
    array = json.loads((file / "travel/zarr.json").read_text()) | change
    part, found = file / "travel/zarr.json", array
    if inline:
        part = file / "zarr.json"
        found = json.loads(part.read_text())
        found["consolidated_metadata"] = {"metadata": {"shape": array}}
    part.write_text(json.dumps(found))
    assert reason in rejection(file, "netcdf")


@pytest.mark.parametrize(
    ("version", "encoding"),
    [(2, {"filters": [numcodecs.Delta("<f8")]}), (3, {"shards": (30,), "chunks": (10,)})],
)
def test_codecs_that_are_harmless_are_read(tmp_path, version, encoding):
    file = tmp_path / "a.zarr"
    names = xr.DataArray(
        np.array(["a", "bc"], dtype="<U2" if version == 2 else object), dims="name"
    )
    data = labelled().assign_coords(name=names)
    data.to_zarr(
        file, zarr_format=version, encoding={"travel": encoding}, consolidated=version == 2
    )
    np.testing.assert_allclose(read(file, "netcdf").travel, TRAVEL)


@pytest.mark.parametrize("name", ["3.nc", "4.nc"])
def test_more_values_than_a_record_has_are_refused(tmp_path, monkeypatch, name):
    file = tmp_path / name
    many = xr.Dataset({f"v{i}": ("time", np.zeros(2_100_000)) for i in range(10)})
    encoding = {name: {"compression": "gzip"} for name in many} if name == "4.nc" else None
    many = many.astype("float32" if name == "4.nc" else "int8")
    many.to_netcdf(file, engine="h5netcdf" if encoding else "scipy", encoding=encoding)
    for use in (lambda: read(file, "netcdf"), lambda: look_into(file)):
        with pytest.raises(RejectedCurveError, match=r": has 21000000 values, .*; export the rec"):
            use()


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
    assert "parts of it twice; export the record alone" in rejection(file, "netcdf")


def test_what_is_within_a_store_is_looked_at_before_it_is_opened(tmp_path):
    file = tmp_path / "a.zarr"
    labelled().to_zarr(file, consolidated=False)
    (file / "other").symlink_to(file / "travel")
    assert "its part other is a link" in rejection(file, "netcdf")
    (file / "other").unlink()
    os.mkfifo(file / "other")
    with pytest.raises(RejectedCurveError, match="its part other is a pipe"):
        look_into(file)
    (tmp_path / "b.zarr").write_bytes(b"")
    assert "is a file, not a folder" in rejection(tmp_path / "b.zarr", "netcdf")


# ---- damage, and what is not installed ---------------------------------------------------------


@pytest.mark.parametrize("name", ["excel", "comtrade", "netcdf"])
def test_damaged_files_are_read_or_refused(tmp_path, name):
    """Cut and with flipped bytes: never another error (NetCDF of version 3)."""
    file = written(tmp_path, name)
    whole, rng = file.read_bytes(), generator(1, "test damage", name)
    refused = 0
    for i in range(60):
        damaged = bytearray(whole)
        if i % 3 == 0:
            del damaged[rng.integers(len(whole)) :]
        for place in rng.integers(max(1, len(damaged)), size=i % 5):
            if damaged:
                damaged[place % len(damaged)] = rng.integers(256)
        file.write_bytes(damaged)
        try:
            read(file, name)
        except RejectedCurveError:
            refused += 1
    assert refused > 20


@pytest.mark.parametrize(
    ("name", "package", "extra"),
    [
        ("excel", "openpyxl", "excel"),
        ("comtrade", "comtrade", "comtrade"),
        ("netcdf", "h5netcdf", "netcdf"),
    ],
)
def test_a_missing_package_is_named_with_the_command(tmp_path, monkeypatch, name, package, extra):
    file = written(tmp_path, name)
    if name == "netcdf":
        WRITE["4.nc"](labelled(), file)
    monkeypatch.setitem(sys.modules, package, None)
    message = rejection(file, name)
    assert message.endswith(f'which needs {package}: pip install "breaker-drive[{extra}]"')


def test_extras_are_tested():
    extras = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    tested = {extra for each in extras["test"] for extra in Requirement(each).extras}
    assert {each.EXTRA for each in FORMATS} - {""} <= tested & {*extras}


def test_a_workbook_is_no_text(tmp_path):
    """Nor is any other packed file: nothing is read from it by accident."""
    file = tmp_path / "a.csv"
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as parts:
        parts.writestr("time,travel", "1,2")
    file.write_bytes(content.getvalue())
    for encoding in ("utf-8", "latin-1", "utf-16", "gbk"):
        with pytest.raises(RejectedCurveError):
            read_columns(file, complete({"encoding": encoding}))


# ---- columns beside the travel ----------------------------------------------------------------


def test_contact_and_trigger_of_any_kind_of_file(tmp_path):
    """By name or number; a status channel counts as well as an analog one."""
    contact, coil = np.where(TIME > 3, 4e-5, 9.9e37), (TIME > 1) * 2.5  # of resistance, in ohm
    text = tmp_path / "a.csv"
    rows = zip(TIME, TRAVEL, contact, coil, strict=True)
    cells = [[f"{t:.1f}", f"{x}", "" if t < 0.35 else f"{c}", f"{i}"] for t, x, c, i in rows]
    cells.insert(20, ["", "7", "7", "7"])  # no sample
    head = ["time [ms]", "travel [mm]", "Main contact", "Coil (A)"]
    text.write_text("\n".join(map(",".join, [head, *cells])))
    book = tmp_path / "a.xlsx"
    numbers = [[float(cell) if cell else None for cell in row] for row in cells]
    workbook(book, {"record": [head, *numbers]})
    named = {"contact_column": "main contact", "trigger_column": 4}
    expected = np.where(TIME < 0.35, np.nan, contact)
    settings = {"time_unit": "ms", **named}
    for file in (text, book):
        columns = read_columns(file, complete(settings))
        np.testing.assert_array_equal(columns.beside["contact"], expected)
        np.testing.assert_array_equal(columns.beside["trigger"], coil)
        np.testing.assert_array_equal(columns.travel, TRAVEL)
        zero = read_columns(file, complete({**settings, "trigger_column": 0}))
        assert zero.beside.keys() == {"contact"}
        with pytest.raises(RejectedCurveError, match="no line has 'mian'"):
            read_columns(file, complete({**settings, "contact_column": "mian"}))
        assert read_columns(file, complete({"time_unit": "ms"})).beside == {}
    unnamed = tmp_path / "b.csv"
    unnamed.write_text("\n".join(map(",".join, cells)))
    numbers = {"time_column": 1, "travel_column": 2, "contact_column": 3, "trigger_column": 4}
    columns = read_columns(unnamed, complete({"time_unit": "ms", **numbers}))
    np.testing.assert_array_equal(columns.beside["contact"], expected)
    grid = tmp_path / "3.nc"
    arrays = {"main": ("time", contact), "coil": ("time", coil, {"units": "A"})}
    WRITE["3.nc"](labelled().assign(arrays), grid)
    columns = read(grid, "netcdf", contact_column="main", trigger_column="coil")
    np.testing.assert_array_equal(columns.beside["contact"], contact)
    np.testing.assert_array_equal(columns.beside["trigger"], coil)
    assert "no column 'scalar'" in rejection(grid, "netcdf", contact_column="scalar")
    recorder = tmp_path / "a.cfg"
    recorded(recorder)
    columns = read(recorder, "comtrade", "S", contact_column="trip", trigger_column="I")
    np.testing.assert_array_equal(columns.beside["contact"], 0.0)
    np.testing.assert_allclose(columns.beside["trigger"], 0.005)
    reason = rejection(recorder, "comtrade", "S", contact_column="main")
    assert "no column 'main' among 'I', 'S', 'trip'" in reason
