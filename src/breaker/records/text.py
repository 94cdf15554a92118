"""The text of a curve file: its columns of time and travel as numbers, or why there are none.

The settings are those of ``endurance.format``; numbers are in the file's own units.
"""

import csv
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from breaker.records.files import RejectedCurveError, read_bytes

__all__ = ["RejectedCurveError", "head_lines", "read_columns"]


def read_columns(file: str | Path, settings: Mapping) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Read the columns of time and travel.

    Returns:
        Time ``(t,)``, without the lines that have none; travel ``(t,)``, NaN where the cell is
        empty or NaN; and the line of each sample in the file, ``(t,)``.

    Raises:
        RejectedCurveError: If the file cannot be read, lacks a column, states another unit, or
            has a cell that is no number.
    """
    settings = {**settings, **_head(file, settings)}
    table = _cells(Path(file), settings)
    kinds = ("time", "travel")
    places = [_place(file, table[0], settings[f"{kind}_column"], settings) for kind in kinds]
    if settings["units_row"]:
        for kind, place in zip(kinds, places, strict=True):
            _check_unit(file, table[1], place, kind, settings)
    _check_widths(file, table, settings)
    time, travel = (_numbers(file, table, place, settings) for place in places)
    timed = np.flatnonzero(~np.isnan(time))
    return time[timed], travel[timed], timed + head_lines(settings) + 1


def _head(file: str | Path, settings: Mapping) -> dict:
    """Where the names are, and whether units follow them, as far as the settings leave it open."""
    skip, units = settings["skip_rows"], settings["units_row"]
    table = _cells(Path(file), {**settings, "skip_rows": skip or 0, "units_row": False})
    if skip is None:
        wanted = {settings["time_column"], settings["travel_column"]}
        skip = next((i for i, row in enumerate(table) if wanted <= set(row)), 0)
        table = table[skip:]
    if units is None:
        place = _place(file, table[0], settings["travel_column"], {**settings, "skip_rows": skip})
        units = len(table) > 1 and np.isnan(_number("".join(table[1][place : place + 1]), "."))
    return {"skip_rows": skip, "units_row": bool(units)}


def head_lines(settings: Mapping) -> int:
    """Return the number of lines before the first sample."""
    return settings["skip_rows"] + 1 + settings["units_row"]


def _cells(file: Path, settings: Mapping) -> list[list[str]]:
    """Cells of each line, from the one with the names on; empty lines at the end are left out."""
    try:
        text = read_bytes(file).decode(settings["encoding"])
        lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
        # Each line for itself: an odd quotation mark must not join lines, or their numbers shift.
        table = [_split(line, settings["delimiter"]) for line in lines[settings["skip_rows"] :]]
    except UnicodeError as error:
        reason = f"cannot be read: {error}; is it a text file, endurance.format.encoding right?"
        raise RejectedCurveError(file, reason) from error
    except csv.Error as error:
        raise RejectedCurveError(file, f"cannot be read: {error}") from error
    while table and not any(table[-1]):
        table.pop()
    head = head_lines(settings)
    if len(table) <= head - settings["skip_rows"]:
        short = f"ends before line {head + 1}, where endurance.format puts the first sample"
        raise RejectedCurveError(file, short if any(lines) else "is empty")
    return table


def _split(line: str, delimiter: str) -> list[str]:
    """Cells of a line, without quotation marks and blanks around them."""
    # The reader of csv is slow to start, and few files quote anything.
    quoted = '"' in line
    cells = next(csv.reader([line], delimiter=delimiter)) if quoted else line.split(delimiter)
    return [cell.strip() for cell in cells]


def _place(file: str | Path, names: list[str], column: str, settings: Mapping) -> int:
    """Where a column stands among the names."""
    if names.count(column) == 1:
        return names.index(column)
    count = "more than one" if column in names else "no"
    listed = ", ".join(map(repr, names))
    see = "encoding, which is utf-8-sig here" if names[0].startswith("\ufeff") else "skip_rows"
    raise RejectedCurveError(
        file,
        f"{count} column {column!r} among {listed}; see endurance.format, also its {see}",
        line=settings["skip_rows"] + 1,
    )


def _check_unit(
    file: str | Path, units: list[str], place: int, kind: str, settings: Mapping
) -> None:
    """Reject a column whose unit, bare or in brackets, is not the one of the settings."""
    found, wanted = "".join(units[place : place + 1]), settings[f"{kind}_unit"]
    if found.strip("[]() ") != wanted:
        raise RejectedCurveError(
            file,
            f"the unit of {settings[f'{kind}_column']!r} is {found!r}, but "
            f"endurance.format.{kind}_unit is {wanted!r}",
            line=head_lines(settings),
        )


def _check_widths(file: str | Path, table: list[list[str]], settings: Mapping) -> None:
    """Reject a line with more cells than names, as decimal commas make where commas separate."""
    names = len(table[0])
    for i, row in enumerate(table):
        if any(row[names:]):
            raise RejectedCurveError(
                file,
                f"{len(row)} cells where {names} columns have names; see "
                "endurance.format.delimiter and endurance.format.decimal",
                line=settings["skip_rows"] + i + 1,
            )


def _numbers(file: str | Path, table: list[list[str]], place: int, settings: Mapping) -> np.ndarray:
    """One column as numbers, NaN where empty or NaN; all else is rejected with its line."""
    column, rows = table[0][place], table[1 + settings["units_row"] :]
    cells = ["".join(row[place : place + 1]) for row in rows]
    numbers = np.array([_number(cell, settings["decimal"]) for cell in cells])
    odd = np.flatnonzero(~np.isfinite(numbers))
    bad = [i for i in odd if cells[i].lower() not in ("", "nan")]
    if bad:
        cell = cells[bad[0]]
        see = "; see endurance.format.decimal" if {",", "."} & set(cell) else ""
        more = f" ({len(bad)} such samples)" if len(bad) > 1 else ""
        raise RejectedCurveError(
            file,
            f"{column!r} is {cell!r}, which is not a number{see}{more}",
            line=head_lines(settings) + int(bad[0]) + 1,
        )
    return numbers


def _number(cell: str, decimal: str) -> float:
    """A cell as a number, NaN if it is none. A point that is not the decimal sign makes it none:
    it may separate thousands."""
    if decimal != "." and "." in cell:
        return np.nan
    try:
        return float(cell.replace(decimal, "."))
    except ValueError:
        return np.nan
