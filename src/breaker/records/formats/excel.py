"""Curve files that are Excel workbooks, by openpyxl (the extra ``excel``)."""

import io
import re
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from breaker.records.files import LARGEST, Opened, RejectedCurveError, TooLargeError
from breaker.records.formats.text import sheet_of
from breaker.records.sheet import Sheet

_GAP = 1_000  # blank rows in a row that end a sheet
_LARGEST_SHEET = 2**24  # cells and signs

# A row of n columns has 1 + 2 n elements. Those of formats take ten times as long to read as these.
_MOST_ELEMENTS, _MOST_OTHERS = 1_000_000, 100_000
_USUAL = re.compile(rb"<(?:\w+:)?(?:row|c|v|f|is|si|t|pt)[\s/>]")
_SHEET = re.compile(rb"<(?:\w+:)?sheet\s")
_ENTITIES = re.compile(rb"<\0?!\0?D\0?O\0?C\0?T")  # of UTF-16, too
_REMEDY = "export the record alone, at a lower rate, or as CSV"


ENDINGS = dict.fromkeys((".xlsx", ".xlsm"), "an Excel workbook")
SIGNATURES = (b"PK\3\4",)
EXTRA = "excel"


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the sheets of a workbook that have columns of samples: see ``registry``. A row counts
    as a line; encoding and delimiter do not matter.

    Raises:
        RejectedCurveError: Of the first sheet, if no sheet has columns.
    """
    settings, found, first = {"decimal": form.get("decimal", ".")}, [], None
    for sheet in _open(opened).worksheets:
        lines: list[str] = []
        for number, cells in _rows_of(sheet, settings["decimal"]):
            lines += [""] * (number - 1 - len(lines)) + [_line(cells)]
        signs = {**settings, "delimiter": "\t"}
        try:
            found.append(sheet_of(opened.file, "\n".join(lines), signs, form))
        except RejectedCurveError as error:
            first = first or error
    if not found:
        raise first or RejectedCurveError(opened.file, "has no sheet")
    return [replace(each, settings=settings) for each in found]


def _line(cells: Sequence[str]) -> str:
    """A row as a line of text, in which no cell has a tab or quotes another."""
    whole = "\t".join(" ".join(cell.split()).replace('"', "″") for cell in cells)
    return whole.rstrip("\t")


def _open(opened: Opened):
    """Return a workbook, to be read row by row.

    Raises:
        RejectedCurveError: If unpacked it is too large, or there is more than one.
        ModuleNotFoundError: If openpyxl is not installed.
    """
    import openpyxl

    file, content = opened.file, opened.content
    with zipfile.ZipFile(io.BytesIO(content)) as book:
        _check_parts(file, content, book)
    return openpyxl.load_workbook(
        io.BytesIO(content), read_only=True, data_only=True, keep_links=False
    )


def _check_parts(file: str | Path, content: bytes, book: zipfile.ZipFile) -> None:
    """Reject what is joined, and what takes much memory or time to read: mostly bytes do not."""
    parts = book.infolist()
    # Offsets are counted from where the last workbook begins; the end of each has 22 bytes.
    end = content.rfind(b"PK\5\6") + 22 + len(book.comment)
    if min((part.header_offset for part in parts), default=0) or end != len(content):
        reason = "has something before or after the workbook, such as another one; save it again"
        raise RejectedCurveError(file, reason)
    # Unpacking stops at the size that is stated, so a false one is no way around.
    if (size := sum(part.file_size for part in parts)) > LARGEST:
        reason = f"has {size / 2**20:.0f} MiB when unpacked; export the record alone"
        raise RejectedCurveError(file, reason)
    elements = others = largest = sheets = 0
    for part in parts:
        text = book.read(part)
        count = text.count(b"<") - text.count(b"</")
        elements, largest = elements + count, max(largest, count)
        sheets += len(_SHEET.findall(text))
        # Several sheets may be the same part, which is read for each of them.
        if elements > _MOST_ELEMENTS or sheets * largest > 3 * _MOST_ELEMENTS:
            reason = f"has more than {_MOST_ELEMENTS} cells and other elements; {_REMEDY}"
            raise RejectedCurveError(file, reason)
        others += count - len(_USUAL.findall(text))
        if others > _MOST_OTHERS:
            reason = f"has more than {_MOST_OTHERS} formats and the like; copy the values alone"
            raise RejectedCurveError(file, f"{reason} into a new workbook")
        if _ENTITIES.search(text):
            raise RejectedCurveError(file, f"defines texts in its part {part.filename}; {_REMEDY}")


def _rows_of(sheet, decimal: str) -> Iterator[tuple[int, list[str]]]:
    """Yield number and cells, as texts, of the rows of a sheet that are not blank.

    Raises:
        TooLargeError: If there are too many cells or signs; a row has all cells up to its last one.
    """
    sheet.reset_dimensions()  # what a sheet states of its size is often wrong
    last = size = rows = widest = 0
    for number, values in enumerate(sheet.iter_rows(values_only=True), start=1):
        if number - last > _GAP:
            return
        cells = [_text(value, decimal) for value in values]
        size += len(cells) + sum(map(len, cells))
        while cells and not cells[-1]:
            cells.pop()
        if cells:
            last, rows, widest = number, rows + 1, max(widest, len(cells))
        # As columns, all rows are as wide as the widest.
        if max(size, rows * widest) > _LARGEST_SHEET:
            reason = f"has too many cells or too long texts in its sheet {sheet.title!r}: row "
            raise TooLargeError(f"{reason}{number} ends at column {len(cells)}; {_REMEDY}")
        if cells:
            yield number, cells


def _text(value: object, decimal: str) -> str:
    """A cell as a text file would have it; a number with all of its digits."""
    if value is None:
        return ""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return repr(float(value)).replace(".", decimal)
    return str(value).strip()
