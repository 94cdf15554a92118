"""Workbooks: the visible sheet of the record is read; what is unclear or too large is refused."""

import re
import zipfile

import numpy as np
import openpyxl
import pytest

from breaker.records.files import LARGEST, RejectedCurveError
from breaker.records.formats import excel as workbooks
from breaker.records.formats.registry import look_into, read_columns
from breaker.records.settings import complete
from tests.records.refused import told

TIME = np.round(0.1 * np.arange(60), 1)
TRAVEL = np.round(0.02 * np.arange(60) ** 1.5, 3)
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


def read(file, **settings):
    default = {"time_unit": "ms", "travel_column": "travel 2"}
    return read_columns(file, complete({**default, **settings}))


def refusals(file):
    """What is said of a file that is read, and of one that is looked into."""
    return [told(file, lambda: read(file)), told(file, lambda: look_into(file))]


@pytest.fixture
def file(tmp_path):
    return tmp_path / "a.xlsx"


def test_the_sheet_that_has_the_columns_is_read_and_others_are_named(file):
    samples = [*SAMPLES]
    samples[10] = (samples[10][0], None)
    sheets = {
        "results": [["No.", "speed"], *([i, 1.5] for i in range(30))],
        "record": [[], ["Zeit und Weg"], [], NAMES, *samples, [], []],
        "blank": [],
        "cover": [["Station", "North"], ["Bay", 4]],  # fewer rows hold no motion
    }
    workbook(file, sheets)
    columns = read(file)
    np.testing.assert_array_equal(columns.time, TIME)
    assert np.flatnonzero(np.isnan(columns.travel)).tolist() == [10]
    np.testing.assert_array_equal(np.delete(columns.travel, 10), np.delete(TRAVEL, 10))
    assert columns.lines[0] == 5
    (remark,) = columns.remarks
    assert "'results'" in remark
    assert "'blank'" not in remark
    assert "'cover'" not in remark


def test_texts_are_held_to_the_decimal_sign_and_numbers_are_not(file):
    samples = [*SAMPLES]
    samples[20] = (samples[20][0], "0,25")
    workbook(file, {"record": [NAMES, *samples]})
    columns = read(file, decimal=",")
    np.testing.assert_array_equal(columns.time, TIME)
    assert columns.travel[20] == 0.25
    assert ", line 22: 'travel 2' is '0,25', which is not a number" in told(
        file, lambda: read(file)
    )


def test_hidden_sheets_are_not_looked_at(file):
    """Planted: a hidden sheet with the same columns stands first."""
    other = [(t, 7.0) for t in TIME.tolist()]
    workbook(file, {"old": [NAMES, *other], "new": [NAMES, *SAMPLES]}, hidden=["old"])
    np.testing.assert_array_equal(read(file).travel, TRAVEL)
    np.testing.assert_array_equal(look_into(file).columns[1], TRAVEL)
    assert read(file).remarks == ()


def test_of_sheets_with_the_same_columns_one_is_named_by_the_column(file):
    workbook(file, {"Close": [NAMES, *SAMPLES], "Open": [["Time [ms]", "Travel 2 (cm)"], *SAMPLES]})
    reason = told(file, lambda: read(file))
    assert "'Close', 'Open'" in reason
    assert "endurance.format.travel_column: Close!travel 2" in reason
    np.testing.assert_array_equal(read(file, travel_column="Close!travel 2").travel, TRAVEL)
    for channel in ("Open!Travel 2", "Open!travel 2"):
        assert "'cm'" in told(file, lambda channel=channel: read(file, travel_column=channel))
        columns = read(file, travel_column=channel, travel_unit="cm")
        np.testing.assert_array_equal(columns.time, TIME)
        assert "'Close'" in columns.remarks[0]
    assert "'Open'" in look_into(file).remarks[0]


def test_formulas_without_values_are_refused_with_the_remedy(file):
    """As programs save them that do not compute."""
    rows = [(t, f"=A{i}*2") for i, t in enumerate(TIME.tolist(), start=2)]
    workbook(file, {"record": [NAMES, *rows]})
    for reason in refusals(file):
        assert "60 formulas without stored values in its sheet 'record'" in reason
        assert "save it" in reason


def test_of_a_formula_its_value_is_read_with_all_digits(file):
    names = b'<row><c t="str"><v>time</v></c><c t="str"><v>travel 2</v></c></row>'
    empty = b'<c t="str"><f>IF(1,"","")</f><v></v></c>'
    sample = b"<row><c><v>0</v></c><c><f>A2/3</f><v>0.123456789012</v></c>" + empty + b"</row>"
    with_rows(file, names + sample)
    assert read(file).travel == [0.123456789012]


def test_a_workbook_without_the_columns_is_refused(file):
    workbook(file, {"a": [["t", "s"], [0.0, 1.0], [0.1, 1.0]], "b": []})
    assert "'travel 2'" in refusals(file)[0]
    workbook(file, {"a": []})
    assert ": is empty" in refusals(file)[0]


# ---- bounds --------------------------------------------------------------------------------------


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


def test_a_bomb_is_refused(file):
    workbook(file, {"record": [NAMES, *SAMPLES]})
    with zipfile.ZipFile(file, "a", zipfile.ZIP_DEFLATED) as parts:
        parts.writestr("xl/media/zeros", bytes(LARGEST))
    assert file.stat().st_size < 200_000
    assert "has 64 MiB" in refusals(file)[0]


ROW = b"<row><c><v>1</v></c></row>"


@pytest.mark.parametrize(
    ("sheet", "reason"),
    [
        (b"<row>" + 20_001 * b"<c/>" + b"</row>", "elements"),
        (ROW.replace(b"<c", b'<c r="XFD1"') + ROW, "line 1: has 16,384 columns"),
        (ROW + ROW.replace(b"<row", b'<row r="99999999999"'), "samples"),
    ],
)
def test_a_workbook_that_would_take_the_memory_is_refused(file, monkeypatch, sheet, reason):
    monkeypatch.setattr(workbooks, "_MOST_ELEMENTS", 20_000)
    with_rows(file, sheet)
    for use in (read, look_into):
        with pytest.raises(RejectedCurveError, match=reason):
            use(file)


def test_a_workbook_behind_another_one_is_refused(file):
    """Of two, the second would be read."""
    workbook(file, {"record": [NAMES, *SAMPLES]})
    file.write_bytes(2 * file.read_bytes())
    assert "before the workbook" in refusals(file)[0]


@pytest.mark.parametrize("name", ["a.XLS", "a.ods"])
def test_an_old_workbook_is_refused_with_the_remedy(tmp_path, name):
    (tmp_path / name).write_bytes(b"\xd0\xcf\x11\xe0")
    assert "save it as .xlsx" in refusals(tmp_path / name)[0]
