"""Records of fault recorders: every revision and type of data is read, damage is refused."""

import struct

import numpy as np
import pytest

from breaker.records.formats.detection import look_into, read_columns
from breaker.records.settings import complete
from tests.records.format_contract import TIME, TRAVEL
from tests.records.refused import refusal

CLOSED = np.arange(60) > 40
FORMS = {"BINARY": "<IIhhH", "BINARY32": "<IIiiH", "FLOAT32": "<IIffH"}
_CHANNELS = ((1, "I", "A"), (2, "S", "mm"))


def recorded(file, *, kind="ASCII", change=(), rates=((10_000, 60),), stamp=1.0, missing=()):
    """Write a pair of files with a current, the travel and a contact; return the data."""
    described = [f"{i},{n},,,{u},0.001,0,0,-99999,99999,1,1,P" for i, n, u in _CHANNELS]
    start = "20/11/2024,15:13:07.000000"
    head = ["station,7,1999", "3,2A,1D", *described, "1,contact,,,0", "50", f"{len(rates)}"]
    head += [f"{rate},{end}" for rate, end in rates] + [start, start, kind, "1", ""]
    text = "\n".join(head)
    for old, new in dict(change).items():
        assert old in text
        text = text.replace(old, new)
    file.write_bytes(text.encode())
    steps = np.rint(1e3 * TRAVEL).astype(int)
    steps[[*missing]] = {"ASCII": 99999, "BINARY": -(2**15), "BINARY32": -(2**31)}.get(kind, 0)
    stamps = np.rint(1e3 * TIME * stamp).astype(int)
    rows = zip(range(1, 61), stamps.tolist(), steps.tolist(), CLOSED.tolist(), strict=True)
    if kind == "ASCII":
        data = "".join(f"{n},{t},5,{x},{int(c)}\r\n" for n, t, x, c in rows).encode()
    else:
        data = b"".join(struct.pack(FORMS[kind], n, t, 5, x, c) for n, t, x, c in rows)
    file.with_suffix(".dat").write_bytes(data)
    return data


@pytest.fixture
def file(tmp_path):
    return tmp_path / "a.cfg"


def read(file, channel="S", **settings):
    return read_columns(file, complete({"contact_column": "contact", **settings}), channel)


@pytest.mark.parametrize("kind", ["ASCII", *FORMS])
@pytest.mark.parametrize("rates", [((10_000, 60),), ((10_000, 30), (10_000, 60)), ((0, 60),)])
def test_every_type_of_data_is_read_with_its_status_channels(file, kind, rates):
    missing = [] if kind == "FLOAT32" else [20]
    recorded(file, kind=kind, rates=rates, missing=missing)
    expected = np.where(np.isin(np.arange(60), missing), np.nan, TRAVEL)
    for channel in ("S", "s", "2"):
        columns = read(file, channel)
        np.testing.assert_allclose(columns.travel, expected, atol=1e-6)
        np.testing.assert_allclose(columns.time, 1e-3 * TIME, atol=1e-12)
        np.testing.assert_array_equal(columns.paired["contact"], CLOSED)
    np.testing.assert_allclose(read(file, time_unit="us").time, 1e3 * TIME)
    np.testing.assert_array_equal(look_into(file).columns[2], CLOSED)


@pytest.mark.parametrize(
    "change",
    [
        {"0.001,0,0,-99999,99999,1,1,P\n2": ",,,,,,,\n2"},  # a channel that is not in use
        {"-99999,99999,1,1": ",,,", "20/11/2024,15:13:07.000000": ","},
        {"\n50\n": "\n\n"},
        {"station,7,1999": "station,7", "ASCII\n1": "ASCII\n"},  # of 1991
    ],
)
def test_what_recorders_leave_empty_hides_no_record(file, change):
    recorded(file, change=change)
    np.testing.assert_allclose(read(file).travel, TRAVEL, atol=1e-9)


@pytest.mark.parametrize(("stamp", "rate"), [(1.0, 10_000), (1e3, 10_000), (1e3, 0)])
def test_stamps_in_nanoseconds_are_read(file, stamp, rate):
    """Also those in microseconds of a recorder whose clock shows nanoseconds."""
    change = {"07.000000": "07.000000000", "1999": "2013"}
    recorded(file, change=change, stamp=stamp, rates=((rate, 60),))
    np.testing.assert_allclose(read(file).time, 1e-3 * TIME)


@pytest.mark.parametrize("kind", ["ASCII", "BINARY"])
@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("10000,60", "10000,61"),
        ("10000,60", "5000,60"),  # the stamps are those of 10 kHz
        ("10000,60", "nan,60"),
        ("2,S,", "2,S,of,a,"),
        ("3,2A,1D", "99999,99998A,1D"),
        ("mm", "deg"),
        ("\n1\n10000", "\n9\n10000"),
    ],
)
def test_what_contradicts_or_is_damaged_is_refused(file, kind, old, new):
    recorded(file, kind=kind, change={old: new})
    refusal(file, lambda: read(file))


def test_data_that_are_no_numbers_or_not_there_are_refused(file):
    content = recorded(file)
    data = file.with_suffix(".dat")
    for cell in (b"1_000", b"x", b"1e246", "١".encode(), b"\0"):
        data.write_bytes(content.replace(b",5,20,", b",5," + cell + b",", 1))
        with pytest.raises(ValueError, match=r"a\.(dat|cfg)"):
            read(file)
    assert ".cfg" in refusal(data, lambda: read(data))
    data.unlink()
    refusal(data, lambda: read(file))
