"""Columns by their names or numbers, and the units that they state.

A name is found in these words, or else without regard to capitals and to a unit behind it.
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from breaker.files.guards import RejectedCurveError
from breaker.files.units import split_unit, unit_of

__all__ = ["BESIDE", "check_unit", "label_of", "place_of", "places_of", "wanted_columns"]

BESIDE = ("contact", "trigger")
"""Columns that a record may have beside time and travel, in any unit."""


def wanted_columns(
    rows: Iterable[Sequence[str]], settings: Mapping, channel: str
) -> dict[str, str | int]:
    """Return the columns that are wanted, by kind: ``"time"``, if there is one, ``"travel"``, and
    those of ``BESIDE`` that the settings name.

    Args:
        rows: Rows that may hold the names.
        settings: The section ``endurance.format``.
        channel: Column of the travel, where it is not that of the settings: a text also where it is
            a number, unless that is a name.
    """
    if channel.isdecimal() and not any(places_of(row, channel) for row in rows):
        channel = int(channel)
    wanted = {"time": settings["time_column"], "travel": channel or settings["travel_column"]}
    # A trigger at time 0 has no column.
    wanted |= {kind: settings[f"{kind}_column"] or None for kind in BESIDE}
    return {kind: column for kind, column in wanted.items() if column is not None}


def label_of(column: str | int) -> str:
    """Return what messages call a column."""
    return f"column {column}" if isinstance(column, int) else repr(column)


def places_of(row: Sequence[str], column: str | int) -> list[int]:
    """Return the places, from 0, of a column in a row of names: at best in these words.

    >>> places_of(["# Time [s]", "Travel 1 (mm)", "travel 2"], "travel 1")
    [1]
    """
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


def place_of(
    file: str | Path, row: Sequence[str], column: str | int, *, line: int | None = None
) -> int:
    """Return the one place of a column in a row of names.

    Raises:
        RejectedCurveError: If it is not there, or more than once.
    """
    found = places_of(row, column)
    if len(found) == 1:
        return found[0]
    listed = ", ".join(repr(cell.strip()[:40]) for cell in row[:20])
    if found:
        numbers = " or ".join(str(place + 1) for place in found)
        reason = f"more than one column {column!r}; give its number, {numbers}, for its name"
    else:
        reason = f"no column {column!r} among {listed}; see endurance.format, also its skip_rows"
    raise RejectedCurveError(file, reason, line=line)


def check_unit(
    file: str | Path,
    kind: str,
    label: str,
    text: str,
    settings: Mapping,
    *,
    line: int | None = None,
) -> tuple[str, ...]:
    """Return what is to be remarked on the unit of a column: that it is not known.

    Args:
        file: Named in messages.
        kind: "time" or "travel".
        label: What messages call the column.
        text: The unit as it stands in the file; nothing where there is none.
        settings: The section ``endurance.format``.
        line: Where it stands.

    Raises:
        RejectedCurveError: If it is another than that of the settings.
    """
    wanted, stated = settings[f"{kind}_unit"], unit_of(text)
    known = f"the unit of {label} is {text!r}"
    but = f"endurance.format.{kind}_unit is {wanted!r}"
    if stated and stated != wanted:
        raise RejectedCurveError(file, f"{known}, but {but}", line=line)
    return (f"{known}, which is not known; {but}",) if text and not stated else ()
