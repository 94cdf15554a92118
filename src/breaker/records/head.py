"""Where the samples of a table begin, which columns they are in, and the units that it states.

Preambles differ from file to file, so the line with the names is found by the names: in these
words, or else without regard to capitals and to a unit behind them. A table without names is found
by its numbers. An explicit ``skip_rows`` is taken at its word.
"""

from bisect import bisect_left
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from breaker.records.files import RejectedCurveError
from breaker.records.numbers import MISSING, is_number
from breaker.records.units import split_unit, unit_of

__all__ = ["Head", "find_head", "is_remark"]

Row = Sequence[str]

_LONGEST = 10_000  # rows in which names are looked for
_RUN = 20  # rows of which most are numbers, where a table without names begins


@dataclass(frozen=True)
class Head:
    """What stands above the samples.

    Attributes:
        first: Row of the first sample.
        places: Place of each column in a row, from 0, by ``"time"`` and ``"travel"``.
        labels: What messages call these columns.
        width: Cells that a row may have.
        remarks: What is doubtful, in words.
    """

    first: int
    places: Mapping[str, int]
    labels: Mapping[str, str]
    width: int
    remarks: tuple[str, ...]


def find_head(
    file: str | Path, lines: Sequence[int], rows: Sequence[Row], settings: Mapping, channel: str
) -> Head:
    """Find the head of a table.

    Args:
        file: Named in messages.
        lines: Line of each row in the file.
        rows: Cells of the first rows, without blank ones.
        settings: The section ``endurance.format``, complete.
        channel: Column of the travel, where it is not that of the settings.

    Raises:
        RejectedCurveError: If a column is not there, or states another unit than the settings.
    """
    wanted = _wanted(rows, settings, channel)
    unnamed = all(isinstance(column, int) for column in wanted.values())
    names = None if unnamed else _names_row(file, lines, rows, wanted, settings)
    if settings["skip_rows"] is not None:
        names = _explicit_row(file, lines, settings["skip_rows"])
        if unnamed and _numeric(rows[names], _numbered(wanted), settings):
            names = None
    if names is None:
        places = _numbered(wanted)
        first = _first_run(file, lines, rows, places, settings)
        names, units = _above(rows, first, places, settings)
        width = max(map(len, rows[first : first + _RUN]))
    else:
        places = {
            kind: _place(file, lines[names], rows[names], column) for kind, column in wanted.items()
        }
        first, units = _after_names(rows, names, places, settings)
        width = max(len(rows[names]), len(rows[units]) if units else 0)
    if first >= len(rows):
        raise RejectedCurveError(file, f"ends before its first sample, with line {lines[-1]}")
    labels = {k: f"column {c}" if isinstance(c, int) else repr(c) for k, c in wanted.items()}
    remarks = _check_units(file, lines, rows, (names, units), places, labels, settings)
    return Head(first, places, labels, width, remarks)


def is_remark(row: Row) -> bool:
    """Say whether a row is a remark: it begins with `#`, `!`, `//` or, not for a unit, `%`."""
    cell = row[0].lstrip()
    return cell.startswith(("#", "!", "//")) or (cell.startswith("%") and cell.strip() != "%")


def _wanted(rows: Sequence[Row], settings: Mapping, channel: str) -> dict[str, str | int]:
    """Columns by kind. A channel is a text also where it is a number, unless that is a name."""
    if channel.isdecimal() and not any(_find(row, channel) for row in rows[:_LONGEST]):
        channel = int(channel)
    wanted = {"time": settings["time_column"], "travel": channel or settings["travel_column"]}
    return {kind: column for kind, column in wanted.items() if column is not None}


def _numbered(wanted: Mapping[str, int]) -> dict[str, int]:
    return {kind: column - 1 for kind, column in wanted.items()}


def _find(row: Row, column: str | int) -> list[int]:
    """Places of a column in a row of names: at best in these words, else nearly in these."""
    if isinstance(column, int):
        return [column - 1] if column <= len(row) else []
    if column.casefold() not in "\n".join(row).casefold():
        return []
    names = [cell.strip() for cell in row]
    names[0] = names[0].lstrip("#%! ") or names[0]
    if column in names:
        return [i for i, name in enumerate(names) if name == column]
    bare = [split_unit(name)[0] for name in names]
    if column in bare:
        return [i for i, name in enumerate(bare) if name == column]
    return [i for i, name in enumerate(bare) if name.casefold() == column.casefold()]


def _place(file: str | Path, line: int, row: Row, column: str | int) -> int:
    """The one place of a column in a row of names."""
    found = _find(row, column)
    if len(found) == 1:
        return found[0]
    listed = ", ".join(repr(cell.strip()[:40]) for cell in row[:20])
    if found:
        numbers = " or ".join(str(place + 1) for place in found)
        reason = f"more than one column {column!r}; give its number, {numbers}, for its name"
    else:
        reason = f"no column {column!r} among {listed}; see endurance.format, also its skip_rows"
    raise RejectedCurveError(file, reason, line=line)


def _names_row(
    file: str | Path, lines: Sequence[int], rows: Sequence[Row], wanted: Mapping, settings: Mapping
) -> int | None:
    """The first row that has the names, if possible with numbers below it."""
    if settings["skip_rows"] is not None:
        return None
    candidates = []
    for i, row in enumerate(rows[:_LONGEST]):
        found = {kind: _find(row, column) for kind, column in wanted.items()}
        if all(found.values()):
            places = {kind: where[0] for kind, where in found.items()}
            if any(_numeric(below, places, settings) for below in rows[i + 1 : i + 4]):
                return i
            candidates.append(i)
    if not candidates:
        raise RejectedCurveError(file, _no_names(lines, rows, wanted, settings))
    return candidates[0]


def _no_names(lines: Sequence[int], rows: Sequence[Row], wanted: Mapping, settings: Mapping) -> str:
    """Why no row has the names."""
    if not rows:
        return "is empty"
    rows = rows[:_LONGEST]
    lacking = [c for c in wanted.values() if not any(_find(row, c) for row in rows)]
    columns = " and ".join(map(repr, lacking or wanted.values()))
    reason = f"no line has the column {columns}"
    for sign in ",;\t| ":
        if sign != settings["delimiter"] and any(
            all(_find(settings["delimiter"].join(row).split(sign), c) for c in wanted.values())
            for row in rows
        ):
            return f"{reason}; is endurance.format.delimiter {sign!r}?"
    for i, row in enumerate(rows[1:]):
        if sum(is_number(cell, settings["decimal"]) for cell in row) > len(row) / 2:
            above = max(rows[max(0, i - 1) : i + 1], key=len)
            listed = ", ".join(repr(cell.strip()[:40]) for cell in above[:20])
            reason += f"; before the numbers, which begin in line {lines[i + 1]}, is {listed}"
            break
    return reason + "; see endurance.format, also its encoding, or give numbers of columns"


def _explicit_row(file: str | Path, lines: Sequence[int], skip: int) -> int:
    """The row of the line after those that are skipped."""
    row = bisect_left(lines, skip + 1)
    if row == len(lines):
        where = f"ends before line {skip + 1}, where endurance.format.skip_rows puts the names"
        raise RejectedCurveError(file, where if lines else "is empty")
    if lines[row] != skip + 1:
        reason = "is blank, but endurance.format.skip_rows puts the names there"
        raise RejectedCurveError(file, reason, line=skip + 1)
    return row


def _numeric(row: Row, places: Mapping[str, int], settings: Mapping) -> bool:
    """Whether a row has numbers in all of these places."""
    cells = [row[place] if place < len(row) else "" for place in places.values()]
    return all(is_number(cell, settings["decimal"]) for cell in cells)


def _first_run(
    file: str | Path, lines: Sequence[int], rows: Sequence[Row], places: Mapping, settings: Mapping
) -> int:
    """The first of rows that mostly have numbers in these places; the one skipped to, if given."""
    if settings["skip_rows"] is not None:
        return _explicit_row(file, lines, settings["skip_rows"])
    for i, row in enumerate(rows[:_LONGEST]):
        if not _numeric(row, places, settings):
            continue
        run = rows[i : i + _RUN]
        usual = Counter(map(len, run)).most_common(1)[0][0]
        numeric = sum(_numeric(below, places, settings) for below in run)
        if len(row) == usual and numeric >= 0.75 * len(run):
            return i
    columns = " and ".join(str(place + 1) for place in places.values())
    reason = f"has no numbers in column {columns}; see endurance.format, also delimiter and decimal"
    raise RejectedCurveError(file, reason if rows else "is empty")


def _above(
    rows: Sequence[Row], first: int, places: Mapping[str, int], settings: Mapping
) -> tuple[int | None, int | None]:
    """Rows of names and units above the first sample, where there are such."""
    if first == 0 or settings["units_row"] is False:
        return (first - 1 if first else None), None
    cells = [rows[first - 1][place : place + 1] for place in places.values()]
    if settings["units_row"] or all(cell and unit_of(cell[0]) for cell in cells):
        return (first - 2 if first > 1 else None), first - 1
    return first - 1, None


def _after_names(
    rows: Sequence[Row], names: int, places: Mapping[str, int], settings: Mapping
) -> tuple[int, int | None]:
    """Rows of the first sample and of the units, if there is one, below a row of names."""
    below = (i for i in range(names + 1, len(rows)) if not is_remark(rows[i]))
    first = next(below, len(rows))
    units = settings["units_row"]
    if units is None and first < len(rows):
        units = _are_units(rows[first], places, settings)
    return (next(below, len(rows)), first) if units and first < len(rows) else (first, None)


def _are_units(row: Row, places: Mapping[str, int], settings: Mapping) -> bool:
    """Whether a row below the names is none of samples: it has a text, and no number."""
    cells = [row[place].strip() for place in places.values() if place < len(row)]
    if not any(cell.lower() not in MISSING for cell in cells):  # blank: the others decide
        cells = [cell.strip() for cell in row]
    texts = any(cell.lower() not in MISSING for cell in cells)
    return texts and not any(is_number(cell, settings["decimal"]) for cell in cells)


def _check_units(
    file: str | Path,
    lines: Sequence[int],
    rows: Sequence[Row],
    above: tuple[int | None, int | None],
    places: Mapping[str, int],
    labels: Mapping[str, str],
    settings: Mapping,
) -> tuple[str, ...]:
    """Reject a column that states another unit than the settings; remark on an unknown one."""
    names, units = above
    remarks = []
    for kind, place in places.items():
        wanted = settings[f"{kind}_unit"]
        name = "".join(rows[names][place : place + 1]) if names is not None else ""
        text = "".join(rows[units][place : place + 1]).strip() if units is not None else ""
        stated = unit_of(text) or split_unit(name.strip())[1]
        known = f"the unit of {labels[kind]} is {text or name.strip()!r}"
        but = f"endurance.format.{kind}_unit is {wanted!r}"
        nothing = units is not None and settings["units_row"] and not text
        if (stated and stated != wanted) or nothing or is_number(text, settings["decimal"]):
            line = lines[units if units is not None else names]
            raise RejectedCurveError(file, f"{known}, but {but}", line=line)
        if text and not stated:
            remarks.append(f"{known}, which is not known; {but}")
    return tuple(remarks)
