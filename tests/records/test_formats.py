"""Formats of curve files: each fulfils the contract, and opened files are kept in bounds."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from breaker.drive.simulation.dialects import DIALECTS
from breaker.records.files import Opened
from breaker.records.formats.registry import (
    ENDINGS,
    FORMATS,
    _named,
    format_of,
    kind_in,
    look_into,
    read_columns,
)
from breaker.records.settings import complete
from tests.records.format_contract import TIME, TRAVEL, Example, FormatContract
from tests.records.refused import told


def of_dialect(name):
    dialect = DIALECTS[name]
    write = partial(dialect.write, time=TIME, travel=TRAVEL, motion="closing", operation=1)
    return Example(dialect.file_name("closing", 1), dialect.settings, dialect.channels[0], write)


def name_of(format_):
    return format_.__name__.rpartition(".")[2]


# By the module of a format: each has one.
EXAMPLES = {
    "text": of_dialect("tab"),
    "excel": of_dialect("excel"),
    "comtrade": of_dialect("comtrade"),
    "netcdf": of_dialect("netcdf"),
}


class TestText(FormatContract):
    example = EXAMPLES["text"]


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
