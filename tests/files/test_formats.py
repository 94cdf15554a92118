"""What every format of curve files fulfils: see ``breaker.reading.files.formats``."""

import shutil
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import xarray as xr

from breaker.reading.files import guards
from breaker.reading.files.column_names import split_unit
from breaker.reading.files.file_look import Labelled, Tables
from breaker.reading.files.format_settings import TO_MS, complete
from breaker.reading.files.formats import ENDINGS, FORMATS, _named, format_of, kind_in, read_columns
from breaker.reading.files.guards import RejectedCurveError
from breaker.reading.files.opened_file import Files, Opened
from breaker.reading.inspection.file_contents import look_into
from breaker.reading.instruments.dialects import DIALECTS
from tests.files.refused import told

TIME = np.round(0.1 * np.arange(60), 1)
TRAVEL = np.round(0.02 * np.arange(60) ** 1.5, 3)


class Example(NamedTuple):
    """A file of a format: its name, the settings that read it, its column of travel in mm, and
    what writes ``TIME`` (ms) and ``TRAVEL`` there.
    """

    name: str
    settings: Mapping
    channel: str
    write: Callable[[Path], None]


def of_dialect(name):
    dialect = DIALECTS[name]
    write = partial(dialect.write, time=TIME, travel=TRAVEL, motion="closing", operation=1)
    return Example(dialect.file_name("closing", 1), dialect.settings, dialect.channels[0], write)


# By the module of a format: each has one.
EXAMPLES = {
    "delimited_text": of_dialect("tab"),
    "excel": of_dialect("excel"),
    "comtrade": of_dialect("comtrade"),
    "netcdf": of_dialect("netcdf"),
}


@pytest.fixture(params=FORMATS, ids=lambda each: each.__name__.rpartition(".")[2])
def format_(request):
    return request.param


@pytest.fixture
def example(format_):
    return EXAMPLES[format_.__name__.rpartition(".")[2]]


@pytest.fixture
def file(example, tmp_path):
    example.write(tmp_path / example.name)
    return tmp_path / example.name


@pytest.fixture
def settings(example):
    return complete(example.settings)


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


@pytest.mark.parametrize("ending", [".csv", ".log", ".xlsx", ".nc"])
def test_content_proves_a_format_whatever_the_ending(ending, format_, example, file, settings):
    """Planted: a workbook that was renamed to .csv, a text to .xlsx."""
    other = file.with_name(f"renamed{ending}")
    file.rename(other)
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


def test_a_file_is_claimed_and_read(format_, file, settings):
    assert format_of(Opened(file)) is format_
    columns = format_.read(Opened(file), settings)
    assert np.allclose(columns.time * TO_MS[settings["time_unit"]], TIME)
    assert np.allclose(columns.travel, TRAVEL, atol=1e-3)
    assert columns.lines.shape == columns.time.shape == columns.travel.shape


def test_what_it_shows_holds_what_is_read(format_, example, file, settings):
    shown = format_.look(Opened(file))
    assert shown is None or isinstance(shown, Labelled | Tables)
    layout = look_into(file)
    place = [split_unit(name)[0] for name in layout.names].index(example.channel)
    assert layout.kind == format_.ENDINGS[file.suffix]
    assert np.allclose(layout.columns[place], read_columns(file, settings).travel)
    assert layout.units[place] == "mm"


def test_another_column_is_refused_by_name(format_, file, settings):
    reason = told(file, lambda: format_.read(Opened(file), settings, "no such"))
    assert "'no such'" in reason


@pytest.mark.parametrize("content", [b"", b"\0\1\2" * 99, b"no record"])
def test_what_is_no_record_is_refused_in_one_line(file, settings, content):
    file.write_bytes(content)
    for use in (lambda: read_columns(file, settings), lambda: look_into(file)):
        with pytest.raises(ValueError, match=file.stem) as refused:
            use()
        assert str(refused.value).startswith(str(file))
        assert str(refused.value).isprintable()


def test_what_is_not_there_is_refused(file, settings):
    file.unlink()
    assert "is not there" in told(file, lambda: read_columns(file, settings))


def test_it_is_opened_once(file, settings, monkeypatch):
    """However often it is read; each part of it that is a file of its own, too."""
    read, real = [], guards.read_bytes
    monkeypatch.setattr(
        "breaker.reading.files.opened_file.read_bytes", lambda f: read.append(f) or real(f)
    )
    opened = Opened(file)
    for _ in range(2):
        read_columns(opened, settings)
        look_into(opened)
    parts = [file, *(each for each in file.parent.iterdir() if each != file)]
    assert [str(each) for each in read] == [str(each) for each in parts]


def test_what_is_kept_of_an_opened_file_counts(file, settings):
    """Or files of which few bytes are read, such as Zarr stores, are kept without end."""
    opened = Opened(file)
    read = read_columns(opened, settings)
    least = sum(each.nbytes for each in (read.time, read.travel, read.lines))
    columns = opened.size
    assert columns >= least
    layout = look_into(opened)
    assert opened.size == columns + sum(each.nbytes for each in layout.columns)


def test_columns_of_zarr_stores_are_not_kept_without_end(tmp_path, monkeypatch):
    monkeypatch.setattr("breaker.reading.files.opened_file._KEPT", 3000)
    example, files = of_dialect("netcdf"), Files()
    example.write(tmp_path / example.name)
    with xr.open_dataset(tmp_path / example.name, decode_times=False) as dataset:
        for k in range(5):
            dataset.to_zarr(tmp_path / f"{k}.zarr", consolidated=False)
            read_columns(files[tmp_path / f"{k}.zarr"], complete(example.settings))
    assert [*files._opened] == [str(tmp_path / f"{k}.zarr") for k in (2, 3, 4)]


def test_an_opened_file_stays_what_it_was(file, settings):
    opened = Opened(file)
    before = read_columns(opened, settings).travel
    for each in file.parent.iterdir():
        shutil.rmtree(each) if each.is_dir() else each.unlink()
    assert np.array_equal(read_columns(opened, settings).travel, before)


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
    monkeypatch.setattr("breaker.reading.files.opened_file._KEPT", 25)
    files, names = Files(), [tmp_path / f"{k}.csv" for k in range(5)]
    for name in names:
        name.write_bytes(b"ten signs.")
        assert files[name].content == b"ten signs."
        assert files[name] is files[str(name)]
    kept = [each for each in map(str, names) if each in files._opened]
    assert kept == [str(name) for name in names[2:]]
