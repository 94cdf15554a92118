"""Curve files that are Excel workbooks, by openpyxl (the extra ``excel``).

A visible sheet is read as a text with tabs between its cells; a row counts as a line. Which sheet
is the record must be clear: the sheets that have the same columns are named, and the file is
refused. Hidden sheets are not looked at.
"""

import io
import re
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from breaker.records.files import (
    LARGEST,
    Opened,
    RejectedCurveError,
    TooLargeError,
    check_size,
)
from breaker.records.formats.text import sheet_of
from breaker.records.sheet import Sheet

# A row of n columns has 1 + 2 n elements. Those of formats take ten times as long to read as these.
_MOST_ELEMENTS, _MOST_OTHERS = 1_000_000, 100_000
_USUAL = re.compile(rb"<(?:\w+:)?(?:row|c|v|f|is|si|t|pt)[\s/>]")
_SHEET = re.compile(rb"<(?:\w+:)?sheet\s")
# A cell with a formula and no value. A text may be empty.
_UNSTORED = re.compile(
    rb"<(?:\w+:)?c(?=[\s>])(?![^>]*t=.str)[^>]*>\s*<(?:\w+:)?f(?:\s[^>]*)?(?:/>|>[^<]*</[^>]*>)"
    rb"\s*(?:<(?:\w+:)?v\s*/>|<(?:\w+:)?v\s*>\s*</[^>]*>)?\s*</(?:\w+:)?c>"
)
_REMEDY = "export the record alone, at a lower rate, or as CSV"

ENDINGS = dict.fromkeys((".xlsx", ".xlsm"), "an Excel workbook")
SIGNATURES = (b"PK\3\4",)
EXTRA = "excel"


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the visible sheet of a workbook that has the columns of a record: see ``registry``.
    Others with columns of numbers are named in a remark.

    Raises:
        RejectedCurveError: If no visible sheet has the columns, or several have; or if formulas
            have no values, as some programs save them.
    """
    file, settings = opened.file, {"decimal": form.get("decimal", ".")}
    signs, found, more, errors = {**settings, "delimiter": "\t"}, {}, [], []
    for title, text, formulas in _visible(opened, settings["decimal"]):
        if formulas:
            reason = (
                f"has {formulas} formulas without stored values in its sheet {title!r}; open it in "
                "Excel or LibreOffice and save it"
            )
            errors.insert(0, RejectedCurveError(file, reason))
            continue
        try:
            found[title] = sheet_of(file, text, signs, form)
        except RejectedCurveError as error:
            errors.append(error)
            with suppress(RejectedCurveError):
                more += [title] if form and sheet_of(file, text, signs, {}) else []
    if not found:
        raise errors[0] if errors else RejectedCurveError(file, "has no visible sheet")
    first, *others = found
    if same := [each for each in others if form or found[each].names == found[first].names]:
        reason = (
            f"has the same columns in its sheets {', '.join(map(repr, [first, *same]))}: which is "
            "the record? Save a copy for each of them, in which the others are hidden or deleted"
        )
        raise RejectedCurveError(file, reason)
    more += others
    remark = f"only the sheet {first!r} is read; {', '.join(map(repr, more))}: numbers, too"
    return [replace(found[first], settings=settings, remarks=(remark,) if more else ())]


def _visible(opened: Opened, decimal: str) -> Iterator[tuple[str, str, int]]:
    """Yield title, text and number of formulas without values of each visible sheet.

    Raises:
        RejectedCurveError: If unpacked it is too large, or there is more than one workbook.
        ModuleNotFoundError: If openpyxl is not installed.
    """
    import openpyxl

    file, content = opened.file, opened.content
    with zipfile.ZipFile(io.BytesIO(content)) as parts:
        _check_parts(file, content, parts)
        book = openpyxl.load_workbook(
            io.BytesIO(content), read_only=True, data_only=True, keep_links=False
        )
        for sheet in book.worksheets:
            if sheet.sheet_state == "visible":
                formulas = len(_UNSTORED.findall(parts.read(sheet._worksheet_path)))
                yield sheet.title, _text_of(file, sheet, decimal), formulas


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


def _text_of(file: str | Path, sheet, decimal: str) -> str:
    """The rows of a sheet as lines of text, in which no cell has a tab or quotes another cell.

    Raises:
        RejectedCurveError: If there are more rows or columns than a record has.
        TooLargeError: If there are more signs than a text file may have.
    """
    sheet.reset_dimensions()  # what a sheet states of its size is often wrong
    lines: list[str] = []
    size = last = 0
    for number, values in enumerate(sheet.iter_rows(values_only=True), start=1):
        cells = [" ".join(_text(value, decimal).split()).replace('"', "″") for value in values]
        line = "\t".join(cells).rstrip("\t")
        size += len(cells) + len(line)
        if size > LARGEST:
            raise TooLargeError(f"has too long texts in its sheet {sheet.title!r}; {_REMEDY}")
        check_size(file, number, line.count("\t") + 1, line=number)
        lines.append(line)
        last = number if line else last
    return "\n".join(lines[:last])


def _text(value: object, decimal: str) -> str:
    """A cell as a text file would have it; a number with all of its digits."""
    if value is None:
        return ""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return repr(float(value)).replace(".", decimal)
    return str(value).strip()
