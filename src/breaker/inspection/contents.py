"""What is in a file of any kind, before anything is known of it: the columns and their names.

Workbooks, COMTRADE and labelled arrays say themselves what texts leave to guess.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from breaker.files import (
    FORMAT,
    OTHER_KINDS,
    RejectedCurveError,
    is_other_kind,
    open_comtrade,
    open_grid,
    open_workbook,
    rows_of,
    understood,
    unit_of,
)
from breaker.inspection.layouts import (
    Layout,
    LayoutError,
    check_size,
    layout_of_lines,
)
from breaker.inspection.texts import guess_layout

__all__ = ["look_into"]


def look_into(file: str | Path) -> Layout:
    """Return the layout of a file: guessed of a text, as it is said of other kinds.

    Raises:
        LayoutError: If there are no columns of numbers.
        RejectedCurveError: If the file cannot be read.
    """
    if not is_other_kind(file):
        return guess_layout(file)
    _, kind, extra = OTHER_KINDS[Path(file).suffix.lower()]
    with understood(file):
        return replace(_LOOK[extra](file), kind=kind)


def _workbook(file: str | Path) -> Layout:
    """That of the first sheet with numbers."""
    for sheet in open_workbook(file).worksheets:
        sheet.reset_dimensions()
        lines = [_line(cells) for _, cells in rows_of(sheet, ".")]
        with suppress(LayoutError):
            return layout_of_lines(file, lines, {"decimal": "."}, "\t")
    raise RejectedCurveError(file, "has no sheet with columns of numbers")


def _line(cells: Sequence[str]) -> str:
    """A row as a line of text, in which no cell has a delimiter or quotes another."""
    whole = "\t".join(" ".join(cell.split()).replace('"', "″") for cell in cells)
    return whole.rstrip("\t") + "\n"


def _comtrade(file: str | Path) -> Layout:
    try:
        record, settings = open_comtrade(file, "utf-8"), {}
    except RejectedCurveError:
        settings = {"encoding": "latin-1"}
        record = open_comtrade(file, **settings)
    channels = record.cfg.analog_channels
    check_size(file, len(record.time), 1 + len(channels))
    # Times are known whatever the settings: what they have by default.
    return Layout(
        settings=settings,
        preamble=[],
        names=[FORMAT["time_column"], *(each.name for each in channels)],
        units=[FORMAT["time_unit"], *(unit_of(each.uu) for each in channels)],
        columns=[np.asarray(record.time), *map(np.asarray, record.analog)],
    )


def _grid(file: str | Path) -> Layout:
    """The variables along the longest dimension."""
    with open_grid(file) as dataset:
        longest = max(dataset.sizes, key=dataset.sizes.get, default=None)
        found = {
            str(name): each
            for name, each in dataset.variables.items()
            if each.dims == (longest,) and each.dtype.kind in "iuf"
        }
        check_size(file, dataset.sizes.get(longest, 0), len(found))
        columns = [each.values.astype(float) for each in found.values()]
        said = [f"{name}: {value}" for name, value in dataset.attrs.items()]
    if not found:
        raise RejectedCurveError(file, "has no variable of numbers along one dimension")
    units = (str(each.attrs.get("units", "")).split(" since ")[0] for each in found.values())
    return Layout(
        settings={},
        preamble=said,
        names=list(found),
        units=list(map(unit_of, units)),
        columns=columns,
    )


_LOOK = {"excel": _workbook, "comtrade": _comtrade, "netcdf": _grid}
