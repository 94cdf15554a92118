"""Curve files that are Excel workbooks, by openpyxl (the extra ``excel``)."""

import io
import zipfile
from collections.abc import Iterator, Mapping
from itertools import islice
from pathlib import Path

from breaker.files.columns import Columns, columns_of
from breaker.files.guards import LARGEST, RejectedCurveError, read_bytes

__all__ = ["open_workbook", "read_workbook", "rows_of"]

_BLOCK = 20_000  # rows at a time
_GAP = 1_000  # blank rows in a row that end a sheet


def read_workbook(file: str | Path, settings: Mapping, channel: str = "") -> Columns:
    """Read the columns of a workbook: of its first sheet that has them.

    Args:
        file: A workbook of one record. A row counts as a line.
        settings: The section ``endurance.format``, complete; encoding and delimiter do not matter.
        channel: Column of the travel, where it is not that of the settings.

    Raises:
        RejectedCurveError: If unpacked it is too large, or as ``columns_of`` says of the first
            sheet, if no sheet has the columns.
        ModuleNotFoundError: If openpyxl is not installed.
    """
    book = open_workbook(file)
    settings, first = {**settings, "delimiter": "\t"}, None
    for sheet in book.worksheets:
        sheet.reset_dimensions()  # what a sheet states of its size is often wrong
        try:
            return columns_of(file, _blocks(sheet, settings["decimal"]), settings, channel)
        except RejectedCurveError as error:
            first = first or error
    raise first or RejectedCurveError(file, "has no sheet")


def open_workbook(file: str | Path):
    """Return a workbook, to be read row by row.

    Raises:
        RejectedCurveError: If unpacked it is too large.
        ModuleNotFoundError: If openpyxl is not installed.
    """
    import openpyxl

    content = io.BytesIO(read_bytes(file))
    with zipfile.ZipFile(content) as parts:
        # Unpacking stops at the size that is stated, so a false one is no way around.
        if (size := sum(part.file_size for part in parts.infolist())) > LARGEST:
            reason = f"has {size / 2**20:.0f} MiB when unpacked; export the record alone"
            raise RejectedCurveError(file, reason)
    return openpyxl.load_workbook(content, read_only=True, data_only=True, keep_links=False)


def _blocks(sheet, decimal: str) -> Iterator[tuple[list[int], list[list[str]]]]:
    """Numbers and cells of the rows of a sheet that are not blank, block after block."""
    rows = rows_of(sheet, decimal)
    while block := list(islice(rows, _BLOCK)):
        yield [number for number, _ in block], [row for _, row in block]


def rows_of(sheet, decimal: str) -> Iterator[tuple[int, list[str]]]:
    """Yield number and cells, as texts, of the rows of a sheet that are not blank."""
    last = 0
    for number, values in enumerate(sheet.iter_rows(values_only=True), start=1):
        if number - last > _GAP:
            return
        cells = [_text(value, decimal) for value in values]
        if any(cells):
            last = number
            yield number, cells


def _text(value: object, decimal: str) -> str:
    """A cell as a text file would have it; a number with all of its digits."""
    if value is None:
        return ""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return repr(float(value)).replace(".", decimal)
    return str(value).strip()
