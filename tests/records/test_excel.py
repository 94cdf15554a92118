"""Workbooks: the visible sheet of the record is read; what is unclear or too large is refused."""

import re
import zipfile

import numpy as np
import openpyxl
import pytest

from breaker.records.files import LARGEST
from breaker.records.formats.detection import look_into, read_columns
from breaker.records.settings import complete
from tests.records.format_contract import TIME, TRAVEL
from tests.records.refused import refusal

NAMES = ["Time [ms]", "Travel 2"]
SAMPLES = [*zip(TIME.tolist(), TRAVEL.tolist(), strict=True)]


def workbook(file, sheets, hidden=()):
    book = openpyxl.Workbook()
    for title, rows in sheets.items():
        sheet = book.create_sheet(title)
        sheet.sheet_state = "hidden" if title in hidden else "visible"
        for row in rows:
            sheet.append(row)
    book.remove(book.worksheets[0])
    book.save(file)


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


def read(file, **settings):
    return read_columns(file, complete({"time_unit": "ms", "travel_column": "travel 2"} | settings))


def refused(file, **settings):
    """What is said of a file that is neither read nor looked into."""
    refusal(file, lambda: look_into(file))
    return refusal(file, lambda: read(file, **settings))


@pytest.fixture
def file(tmp_path):
    return tmp_path / "a.xlsx"


def test_the_first_visible_sheet_with_the_columns_is_read_and_others_are_named(file):
    """Planted: a hidden sheet with the same columns stands first."""
    samples = [*SAMPLES[:10], (SAMPLES[10][0], None), *SAMPLES[11:]]
    sheets = {
        "old": [NAMES, *((t, 7.0) for t in TIME.tolist())],
        "results": [["No.", "speed"], *([i, 1.5] for i in range(30))],
        "record": [[], ["Zeit und Weg"], [], NAMES, *samples, [], []],
        "again": [NAMES, *SAMPLES[::-1]],  # of the same columns the first are read
        "blank": [],
        "cover": [["Station", "North"], ["Bay", 4]],  # fewer rows hold no motion
    }
    workbook(file, sheets, hidden=["old"])
    columns = read(file)
    assert len(look_into(file).remarks) == 1
    np.testing.assert_array_equal(columns.time, TIME)
    expected = np.where(np.arange(60) == 10, np.nan, TRAVEL)
    np.testing.assert_array_equal(columns.travel, expected)
    assert columns.lines[0] == 5
    (remark,) = columns.remarks
    assert [name for name in sheets if repr(name) in remark] == ["results", "record", "again"]
    workbook(file, {"a": [["t", "s"], [0.0, 1.0], [0.1, 1.0]], "b": []})
    refusal(file, lambda: read(file))


def test_a_text_in_place_of_a_number_is_refused_with_its_row(file):
    workbook(file, {"record": [NAMES, *SAMPLES[:20], (2.0, "0,25")]})
    assert ", line 22: " in refusal(file, lambda: read(file))


def test_of_a_formula_its_value_is_read_and_without_one_it_is_refused(file):
    """As programs save them that do not compute."""
    rows = [(t, f"=A{i}*2") for i, t in enumerate(TIME.tolist(), start=2)]
    workbook(file, {"record": [NAMES, *rows]})
    refusal(file, lambda: read(file))
    names = b'<row><c t="str"><v>time</v></c><c t="str"><v>travel 2</v></c></row>'
    with_rows(file, names + b"<row><c><v>0</v></c><c><f>A2/3</f><v>0.123456789012</v></c></row>")
    assert read(file).travel == [0.123456789012]


def test_a_bomb_is_refused(file):
    workbook(file, {"record": [NAMES, *SAMPLES]})
    with zipfile.ZipFile(file, "a", zipfile.ZIP_DEFLATED) as parts:
        parts.writestr("xl/media/zeros", bytes(LARGEST))
    assert file.stat().st_size < 200_000
    refused(file)


@pytest.mark.parametrize("places", [('r="XFD1"', ""), ("", 'r="99999999999"')])
def test_a_workbook_that_would_take_the_memory_is_refused(file, places):
    cell, row = places
    usual = "<row><c><v>1</v></c></row>"
    with_rows(file, f"{usual}<row {row}><c {cell}><v>1</v></c></row>".encode())
    refused(file, travel_column=1)
