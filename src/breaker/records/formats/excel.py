"""Curve files that are Excel workbooks, by openpyxl (the extra ``excel``).

A visible sheet is read as a text with tabs between its cells; a row counts as a line. Hidden sheets
are not looked at. Where several sheets have the same columns, their names name the sheet, too:
``Sheet!Column``.
"""

import io
import re
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import replace

from breaker.records.files import Opened, RejectedCurveError, check_bytes, check_size
from breaker.records.formats.text import sheet_of
from breaker.records.rejections import FEWEST
from breaker.records.sheet import Sheet
from breaker.records.words import places_of, split_unit

_MOST_ELEMENTS = 1_000_000  # of XML, which take 5 s; a row of n columns has 1 + 2 n
# A cell with a formula and without a value. The value of a formula may be an empty text.
_UNSTORED = re.compile(
    rb"<(?:\w+:)?c(?=[\s>])(?![^>]*t=.str)[^>]*>\s*<(?:\w+:)?f(?:\s[^>]*)?(?:/>|>[^<]*</[^>]*>)"
    rb"\s*(?:<(?:\w+:)?v\s*/>|<(?:\w+:)?v\s*>\s*</[^>]*>)?\s*</(?:\w+:)?c>"
)


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the visible sheet that has the columns of a record, or where no columns are known all
    with numbers: see ``registry``. A remark names the other sheets.
    """
    decimal, travel = form.get("decimal", "."), str(form.get("travel_column"))
    signs, sheets, others, errors = {"delimiter": "\t", "decimal": decimal}, {}, [], []
    visible = opened.once(("visible", decimal), lambda: [*_visible(opened, decimal)])
    for title, rows, formulas in visible:
        own = {k: v.removeprefix(f"{title}!") if isinstance(v, str) else v for k, v in form.items()}
        try:
            if formulas:
                reason = f"has formulas without stored values in its sheet {title!r}"
                remedy = "open it in Excel or LibreOffice and save it"
                raise RejectedCurveError(opened.file, f"{reason}; {remedy}")
            sheet = sheet_of(opened, "\n".join(rows), signs, own, title)
        except RejectedCurveError as error:
            errors.append(error)
            others += [title] if len(rows) > FEWEST else []  # fewer rows show no motion
            continue
        for column in {own[key] for key in form if own[key] != form[key]}:
            for place in places_of(sheet.names, column):
                sheet.names[place] = f"{title}!{sheet.names[place]}"
        sheets[title] = replace(sheet, settings={"decimal": decimal})
    if not sheets:
        raise errors[0] if errors else RejectedCurveError(opened.file, "is empty")
    first, *more = sheets
    bare = {t: {split_unit(name)[0].lower() for name in e.names if name} for t, e in sheets.items()}
    for title, sheet in () if form else sheets.items():  # which have more than a time in common
        if any(len(bare[title] & bare[other]) > 1 for other in sheets if other != title):
            sheet.names[:] = [f"{title}!{name}" if name else "" for name in sheet.names]
    if form and more:
        reason = f"has the same columns in its sheets {', '.join(map(repr, sheets))}"
        remedy = f"name the sheet: endurance.format.travel_column: {first}!{travel}"
        raise RejectedCurveError(opened.file, f"{reason}; {remedy}")
    if others := [*others, *more]:
        remark = f"only the sheet {first!r} is read, not {', '.join(map(repr, others))}"
        sheets[first] = replace(sheets[first], remarks=(remark,))
    return [*sheets.values()]


def _visible(opened: Opened, decimal: str) -> Iterator[tuple[str, list[str], bool]]:
    """Yield title, rows, and whether there are formulas without values, of each visible sheet."""
    import openpyxl

    content, before = io.BytesIO(opened.content), 0
    with zipfile.ZipFile(content) as parts:
        # Unpacking stops at the size that is stated, so a false one is no way around.
        check_bytes(opened.file, sum(part.file_size for part in parts.infolist()))
        texts = map(parts.read, parts.infolist())
        if sum(text.count(b"<") - text.count(b"</") for text in texts) > _MOST_ELEMENTS:
            reason = f"has more than {_MOST_ELEMENTS:,} cells or other parts"
            raise RejectedCurveError(opened.file, f"{reason}; export the record alone, or as CSV")
        book = openpyxl.load_workbook(content, read_only=True, data_only=True, keep_links=False)
        for sheet in book.worksheets:
            if sheet.sheet_state != "visible":
                continue
            sheet.reset_dimensions()  # what a sheet states of its size is often wrong
            rows, last, size = [], 0, 0
            for number, values in enumerate(sheet.iter_rows(values_only=True), start=1):
                row = "\t".join(_text(value, decimal) for value in values).rstrip("\t")
                check_size(opened.file, before + number, row.count("\t") + 1, line=number)
                size += len(row)
                check_bytes(opened.file, size)  # a text that cells share counts for each
                rows.append(row)
                last = number if row else last
            before += last
            if last:
                unstored = _UNSTORED.search(parts.read(sheet._worksheet_path))
                yield sheet.title, rows[:last], unstored is not None


def _text(value: object, decimal: str) -> str:
    """A cell as a text file would have it, without a tab or a quotation mark; a number with all of
    its digits.
    """
    if isinstance(value, int | float) and not isinstance(value, bool):
        return repr(float(value)).replace(".", decimal)
    return "" if value is None else " ".join(str(value).split()).replace('"', "″")
