"""Curve files that are Excel workbooks, by openpyxl (the extra ``excel``).

A visible sheet is read as a text with tabs between its cells; a row counts as a line. Hidden sheets
are not looked at. Where several sheets have the columns of a record, the setting ``travel_column``
names the sheet, too: ``Sheet!Column``.
"""

import io
import re
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from breaker.records.files import LARGEST, Opened, RejectedCurveError, check_size
from breaker.records.formats.text import sheet_of
from breaker.records.rejections import FEWEST
from breaker.records.sheet import Sheet
from breaker.records.words import places_of

ENDINGS = dict.fromkeys((".xlsx", ".xlsm"), "an Excel workbook")
SIGNATURES = (b"PK\3\4",)
EXTRA = "excel"

_MOST_ELEMENTS = 1_000_000  # of XML, which take 5 s; a row of n columns has 1 + 2 n
# A cell with a formula and without a value. The value of a formula may be an empty text.
_UNSTORED = re.compile(
    rb"<(?:\w+:)?c(?=[\s>])(?![^>]*t=.str)[^>]*>\s*<(?:\w+:)?f(?:\s[^>]*)?(?:/>|>[^<]*</[^>]*>)"
    rb"\s*(?:<(?:\w+:)?v\s*/>|<(?:\w+:)?v\s*>\s*</[^>]*>)?\s*</(?:\w+:)?c>"
)


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the visible sheet of a workbook that has the columns of a record, or where no columns
    are known all with numbers: see ``registry``. A remark names the other sheets.

    Raises:
        RejectedCurveError: If no visible sheet has the columns, or several have; or if formulas
            have no values, as some programs save them.
    """
    file, settings = opened.file, {"decimal": form.get("decimal", ".")}
    travel, sheets, others, errors = str(form.get("travel_column")), {}, [], []
    for title, text, formulas in _visible(opened, settings["decimal"]):
        if not text:
            continue
        column = travel.removeprefix(f"{title}!")
        try:
            if formulas:
                reason = f"has {formulas} formulas without stored values in its sheet {title!r}"
                remedy = "open it in Excel or LibreOffice and save it"
                raise RejectedCurveError(file, f"{reason}; {remedy}")
            wanted = form and {**form, "travel_column": column}
            sheet = sheet_of(file, text, {**settings, "delimiter": "\t"}, wanted)
        except RejectedCurveError as error:
            errors.append(error)
            if text.count("\n") >= FEWEST:  # fewer rows show no motion
                others.append(title)
            continue
        if column != travel:
            for place in places_of(sheet.names, column):
                sheet.names[place] = f"{title}!{sheet.names[place]}"
        sheets[title] = replace(sheet, settings=settings)
    if not sheets:
        raise errors[0] if errors else RejectedCurveError(file, "is empty")
    first = next(iter(sheets))
    if form and len(sheets) > 1:
        reason = f"has the same columns in its sheets {', '.join(map(repr, sheets))}"
        remedy = f"name the sheet: endurance.format.travel_column: {first}!{travel}"
        raise RejectedCurveError(file, f"{reason}; {remedy}")
    others += [title for title in sheets if title != first]
    remark = f"only the sheet {first!r} is read, not {', '.join(map(repr, others))}"
    named = replace(sheets.pop(first), remarks=(remark,) if others else ())
    return [named, *sheets.values()]


def _visible(opened: Opened, decimal: str) -> Iterator[tuple[str, str, int]]:
    """Yield title, text and number of formulas without values of each visible sheet.

    Raises:
        RejectedCurveError: If unpacked it is too large, or there is more than one workbook.
        ModuleNotFoundError: If openpyxl is not installed.
    """
    import openpyxl

    content, rows = io.BytesIO(opened.content), 0
    with zipfile.ZipFile(content) as parts:
        _check_parts(opened, parts)
        book = openpyxl.load_workbook(content, read_only=True, data_only=True, keep_links=False)
        for sheet in book.worksheets:
            if sheet.sheet_state == "visible":
                lines = _lines(opened.file, sheet, decimal, rows)
                rows += len(lines)
                formulas = len(_UNSTORED.findall(parts.read(sheet._worksheet_path)))
                yield sheet.title, "\n".join(lines), formulas


def _check_parts(opened: Opened, book: zipfile.ZipFile) -> None:
    """Reject two workbooks in one file, of which one would be read, and what is too large."""
    parts = book.infolist()
    if min((part.header_offset for part in parts), default=0):
        reason = "has something before the workbook, such as another one; save it again"
        raise RejectedCurveError(opened.file, reason)
    # Unpacking stops at the size that is stated, so a false one is no way around.
    size = sum(part.file_size for part in parts)
    texts = (book.read(part) for part in parts if size <= LARGEST)
    elements = sum(text.count(b"<") - text.count(b"</") for text in texts)
    if size > LARGEST or elements > _MOST_ELEMENTS:
        reason = f"has {size / 2**20:.0f} MiB with {elements:,} elements when unpacked"
        raise RejectedCurveError(opened.file, f"{reason}; export the record alone, or as CSV")


def _lines(file: str | Path, sheet, decimal: str, rows: int) -> list[str]:
    """The rows of a sheet as lines of text, up to the last one that is not blank. No cell has a tab
    or quotes another cell. Rows of sheets before count, too.
    """
    sheet.reset_dimensions()  # what a sheet states of its size is often wrong
    lines, last, size = [], 0, 0
    for number, values in enumerate(sheet.iter_rows(values_only=True), start=1):
        cells = [" ".join(_text(value, decimal).split()).replace('"', "″") for value in values]
        lines.append("\t".join(cells).rstrip("\t"))
        check_size(file, rows + number, lines[-1].count("\t") + 1, line=number)
        size += len(lines[-1])
        if size > LARGEST:  # a text that cells share counts for each
            raise RejectedCurveError(file, f"has too long texts in its sheet {sheet.title!r}")
        last = number if lines[-1] else last
    return lines[:last]


def _text(value: object, decimal: str) -> str:
    """A cell as a text file would have it; a number with all of its digits."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return repr(float(value)).replace(".", decimal)
    return "" if value is None else str(value).strip()
