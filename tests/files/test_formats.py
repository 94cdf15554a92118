"""Formats of curve files: each fulfils the contract, and opened files are kept in bounds."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from breaker.reading.files.format_settings import complete
from breaker.reading.files.formats import ENDINGS, FORMATS, _named, format_of, kind_in, read_columns
from breaker.reading.files.guards import Files, Opened, RejectedCurveError
from breaker.reading.inspection.file_contents import look_into
from breaker.reading.inspection.format_contract import TIME, TRAVEL, Example, FormatContract
from breaker.reading.instruments.dialects import DIALECTS
from tests.files.refused import told


def of_dialect(name):
    dialect = DIALECTS[name]
    write = partial(dialect.write, time=TIME, travel=TRAVEL, motion="closing", operation=1)
    return Example(dialect.file_name("closing", 1), dialect.settings, dialect.channels[0], write)


def name_of(format_):
    return format_.__name__.rpartition(".")[2]


# By the module of a format: each has one.
EXAMPLES = {
    "delimited_text": of_dialect("tab"),
    "excel": of_dialect("excel"),
    "comtrade": of_dialect("comtrade"),
    "netcdf": of_dialect("netcdf"),
}


class TestText(FormatContract):
    example = EXAMPLES["delimited_text"]


class TestExcel(FormatContract):
    example = EXAMPLES["excel"]


class TestComtrade(FormatContract):
    example = EXAMPLES["comtrade"]


class TestNetcdf(FormatContract):
    example = EXAMPLES["netcdf"]


def test_every_format_has_an_example():
    assert {*map(name_of, FORMATS)} == set(EXAMPLES)
    tested = {each.example.name for each in FormatContract.__subclasses__()}
    assert tested == {each.name for each in EXAMPLES.values()}


@pytest.mark.parametrize("ending", ENDINGS)
def test_one_format_claims_an_ending_in_any_case(ending):
    for name in (f"a{ending}", f"A 1.b{ending.upper()}"):
        claiming = [each for each in FORMATS if Path(name).suffix.lower() in each.ENDINGS]
        assert claiming == [_named(name)]


def test_what_is_of_no_known_ending_or_signature_is_a_text(tmp_path):
    (tmp_path / "a.log").write_text("time,travel")
    assert format_of(Opened(tmp_path / "a.log")) is FORMATS[0]


def test_one_format_has_a_signature():
    every = [each for one in FORMATS for each in one.SIGNATURES]
    assert not [(a, b) for a in every for b in every if a is not b and a.startswith(b)]


@pytest.mark.parametrize("format_", FORMATS, ids=name_of)
@pytest.mark.parametrize("ending", [".csv", ".log", ".xlsx", ".nc"])
def test_content_proves_a_format_whatever_the_ending(ending, format_, tmp_path):
    """Planted: a workbook that was renamed to .csv, a text to .xlsx."""
    example = EXAMPLES[name_of(format_)]
    settings = complete(example.settings)
    example.write(tmp_path / example.name)
    other = (tmp_path / example.name).rename(tmp_path / f"renamed{ending}")
    if format_.SIGNATURES:
        columns = read_columns(other, settings)
        assert np.allclose(columns.travel, TRAVEL, atol=1e-3)
        assert look_into(other).kind == kind_in(Opened(other))
        renamed = ending not in format_.ENDINGS
        assert [e for e in columns.remarks if "whatever its name" in e] == renamed * [
            f"is {kind_in(Opened(other))} by its content, whatever its name ends in"
        ]
    elif ending in (".xlsx", ".nc"):
        reason = told(other, lambda: read_columns(other, settings))
        assert "but does not begin as one; is it whole?" in reason


def test_columns_of_zarr_stores_are_not_kept_without_end(tmp_path, monkeypatch):
    monkeypatch.setattr("breaker.reading.files.guards._KEPT", 3000)
    example, files = of_dialect("netcdf"), Files()
    example.write(tmp_path / example.name)
    with xr.open_dataset(tmp_path / example.name, decode_times=False) as dataset:
        for k in range(5):
            dataset.to_zarr(tmp_path / f"{k}.zarr", consolidated=False)
            read_columns(files[tmp_path / f"{k}.zarr"], complete(example.settings))
    assert [*files._opened] == [str(tmp_path / f"{k}.zarr") for k in (2, 3, 4)]


def test_a_refusal_is_found_once(tmp_path):
    opened, asked = Opened(tmp_path / "a.csv"), []

    def find():
        asked.append(1)
        raise RejectedCurveError(opened.file, "is empty")

    for _ in range(2):
        with pytest.raises(RejectedCurveError, match="is empty"):
            opened.once("anything", find)
    assert asked == [1]


def test_of_very_many_files_the_last_are_kept(tmp_path, monkeypatch):
    monkeypatch.setattr("breaker.reading.files.guards._KEPT", 25)
    files, names = Files(), [tmp_path / f"{k}.csv" for k in range(5)]
    for name in names:
        name.write_bytes(b"ten signs.")
        assert files[name].content == b"ten signs."
        assert files[name] is files[str(name)]
    kept = [each for each in map(str, names) if each in files._opened]
    assert kept == [str(name) for name in names[2:]]
