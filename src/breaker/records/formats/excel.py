"""Curve files that are Excel workbooks, read by openpyxl (the extra ``excel``).

A visible sheet is read as a text with tabs between its cells; a row counts as a line. Hidden sheets
are ignored. The first sheet with the columns of a record is used, and a remark names it.
"""

import io
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import replace

from breaker.records.files import Opened, RejectedCurveError, check_bytes, check_size
from breaker.records.formats.text import sheet_of
from breaker.records.rejections import FEWEST
from breaker.records.sheet import Sheet


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the visible sheets that have a table, in their order; a remark names the others."""
    settings = {"delimiter": "\t", "decimal": "."}
    texts = opened.once("texts", lambda: [*_visible(opened)])
    sheets, errors = {}, [RejectedCurveError(opened.file, "is empty")]
    for title, text in texts:
        try:
            sheets[title] = sheet_of(opened, text, settings, title)
        except RejectedCurveError as error:
            errors.append(error)
    if not sheets:
        raise errors[-1]
    read_sheets = []
    for title, sheet in sheets.items():
        long = [other for other, text in texts if text.count("\n") >= FEWEST]  # possible records
        others = [repr(other) for other in long if other != title]
        remarks = (f"only the sheet {title!r} is read, not {', '.join(others)}",) if others else ()
        read_sheets.append(replace(sheet, remarks=remarks, settings={}))
    return read_sheets


def _visible(opened: Opened) -> Iterator[tuple[str, str]]:
    """Yield title and text of each visible sheet that is not empty."""
    import openpyxl

    content, before = io.BytesIO(opened.content), 0
    with zipfile.ZipFile(content) as parts:
        # Unpacking stops at the stated size, so a false size cannot evade the limit.
        check_bytes(opened.file, sum(part.file_size for part in parts.infolist()))
    book = openpyxl.load_workbook(content, read_only=True, data_only=True, keep_links=False)
    for sheet in book.worksheets:
        if sheet.sheet_state != "visible":
            continue
        sheet.reset_dimensions()  # the stated size of a sheet is often wrong
        rows, size = [], 0
        for number, values in enumerate(sheet.iter_rows(values_only=True), start=1):
            row = "\t".join(_text(value) for value in values).rstrip("\t")
            check_size(opened.file, before + number, row.count("\t") + 1, line=number)
            size += len(row)
            check_bytes(opened.file, size)  # a text shared by cells counts for each cell
            rows.append(row)
        before += len(rows)
        if text := "\n".join(rows).rstrip("\n"):
            yield sheet.title, text


def _text(value: object) -> str:
    """Return a cell as in a text file, without tabs and quotation marks; numbers in all digits."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return repr(float(value))
    return "" if value is None else " ".join(str(value).split()).replace('"', "″")
