"""Formats of curve files: each fulfils the contract, and opened files are kept in bounds."""

import ast
import sys
from functools import partial

import numpy as np
import pytest

from breaker.records.files import Opened
from breaker.records.formats import detection, example_format
from breaker.records.formats.detection import FORMATS, Format, format_of, read_columns
from breaker.records.settings import complete
from studies.layouts import LAYOUTS
from tests.records.format_contract import TIME, TRAVEL, Example, FormatContract
from tests.records.refused import refusal


def of_layout(name):
    layout = LAYOUTS[name]
    write = partial(layout.write, time=TIME, travel=TRAVEL, motion="closing", operation=1)
    return Example(f"closing_00001{layout.ending}", layout.settings, layout.channel, write)


def write_line(file):
    values = ",".join(f"{value:.3f}" for value in TRAVEL)
    line = f"ID:7;Date:2024-11-20;Interval (ms):0.1;Travel (mm):{values}\n"
    file.write_text(line, encoding="utf-8")


def write_example(file):
    file.write_bytes(b"EXAMPLE1" + (10_000).to_bytes(4, "little") + TRAVEL.astype("<f4").tobytes())


# By the module of a format, in the order of ``FORMATS``: every one has an example.
EXAMPLES = {
    "text": of_layout("tab"),
    "excel": of_layout("excel"),
    "comtrade": of_layout("comtrade"),
    "lines": Example("a.txt", {"time_unit": "ms", "travel_column": "Travel"}, "Travel", write_line),
}


class TestFormats(FormatContract):
    @pytest.fixture(params=EXAMPLES)
    def example(self, request):
        return EXAMPLES[request.param]


class TestExample(FormatContract):
    """The module to copy, which is a format only where a test adds it."""

    @pytest.fixture
    def example(self, monkeypatch):
        line = example_format.__doc__.rpartition("Format(__name__, ")[2].strip().removesuffix(")")
        form = Format(example_format.__name__, *ast.literal_eval(f"({line})"))
        monkeypatch.setattr(detection, "FORMATS", (*FORMATS, form))
        return Example("a.example-record", {"time_unit": "ms"}, "travel", write_example)

    def test_it_is_one_of_the_formats(self, curve_file):
        assert format_of(Opened(curve_file)).module == example_format.__name__


@pytest.mark.parametrize(("format_", "name"), [*zip(FORMATS, EXAMPLES, strict=True)])
@pytest.mark.parametrize("ending", [".csv", ".xlsx"])
def test_content_proves_a_format_whatever_the_ending(ending, format_, name, tmp_path):
    """Planted: a workbook that was renamed to .csv, a text to .xlsx."""
    example, other = EXAMPLES[name], tmp_path / f"renamed{ending}"
    example.write(tmp_path / example.name)
    (tmp_path / example.name).rename(other)
    if format_.signatures:
        columns = read_columns(other, complete(example.settings))
        assert np.allclose(columns.travel, TRAVEL, atol=1e-3)
    elif ending == ".xlsx":
        refusal(other, lambda: read_columns(other, complete(example.settings)))


@pytest.mark.parametrize(
    ("ending", "remedy"),
    [(".xls", ".xlsx"), (".ods", ".xlsx"), (".yaml", "--config"), (".png", "")],
)
def test_a_file_of_another_kind_is_refused_with_the_remedy(tmp_path, ending, remedy):
    """Planted: .ods is read as a text."""
    file = tmp_path / f"a{ending}"
    file.write_bytes(b"time,travel\ns,mm\n0.1,1\n0.2,2\n")
    assert remedy in refusal(file, lambda: read_columns(file, complete({})))


def test_a_missing_package_is_named_with_the_command(tmp_path, monkeypatch):
    example = EXAMPLES["excel"]
    file = tmp_path / example.name
    example.write(file)
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    reason = refusal(file, lambda: read_columns(file, complete(example.settings)))
    assert "openpyxl" in reason
    assert "[excel]" in reason
