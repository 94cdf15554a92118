"""Columns by their names or numbers, and the units that they state.

A name is found in these words, or else without regard to capitals and to a unit behind it. A unit
is bare, in brackets, or behind a name, in the usual languages; behind a blank only if the name is
of a time or a travel. `Grad` is a degree, as no transducer reads gons. A single letter counts in
its own case, and letters of phases are no units behind a name: `Travel (S)`.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from breaker.reading.files.guards import RejectedCurveError
from breaker.reading.files.lexicon import AMPERES, NO_UNITS, OTHER_UNITS, UNITS
from breaker.reading.files.word_lookup import holds

BESIDE = ("contact", "trigger", "motor")
"""Columns that a record may have beside time and travel, in any unit."""

_KNOWN = {each: unit for unit, spelt in UNITS.items() for each in spelt.split()}
_KNOWN |= {other: other for other in OTHER_UNITS.split()}
_FOLDED = {spelling.casefold(): unit for spelling, unit in _KNOWN.items() if len(spelling) > 1}
_BEHIND = re.compile(
    r"(.*?)\s*(?:\[(.*)\]|\((.*)\)|/\s*(\S+)|\sin\s+(\S+)|[,_]\s*(\w{2,}|m|°)|([°º˚])"
    r"|(?<=\s)(?P<bare>[^\W_]{2,}|[ms]))\s*"
)
_LONGEST = 200  # signs of a name
_AMPERES = re.compile(r"([\[(/,_ ])\s*(mA|A|[Aa]mp(?:ere)?s?)\s*[\])]?\s*")


def wanted_columns(
    rows: Iterable[Sequence[str]], settings: Mapping, channel: str
) -> dict[str, str | int]:
    """Return the columns that are wanted, by kind: ``"time"``, if there is one, ``"travel"``, and
    those of ``BESIDE`` that the settings name. A channel that is a number in words is a number,
    unless one of the rows has it for a name.
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
    if column not in names:
        names = [split_unit(name)[0] for name in names]
    if column not in names:
        names, column = [name.casefold() for name in names], column.casefold()
    return [i for i, name in enumerate(names) if name == column]


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
    reason = f"no column {column!r} among {listed(row)}; see endurance.format, also its skip_rows"
    if found:
        numbers = " or ".join(str(place + 1) for place in found)
        reason = f"more than one column {column!r}; give its number, {numbers}, for its name"
    raise RejectedCurveError(file, reason, line=line)


def listed(row: Sequence[str]) -> str:
    """Return what a message shows of a row of names."""
    return ", ".join(repr(cell.strip()[:40]) for cell in filter(str.strip, row[:40]))


def check_unit(
    file: str | Path,
    column: tuple[str, str],
    text: str,
    settings: Mapping,
    line: int | None = None,
) -> tuple[str, ...]:
    """Return what is to be remarked on the unit of a column: that it is not known.

    Args:
        file, line: Named in messages.
        column: Its kind, "time" or "travel", and what messages call it.
        text: The unit as it stands in the file, empty where none is stated.
        settings: The section ``endurance.format``, complete.

    Raises:
        RejectedCurveError: If it is another than that of the settings.
    """
    kind, label = column
    wanted, stated = settings[f"{kind}_unit"], unit_of(text)
    known = f"the unit of {label} is {text!r}"
    but = f"endurance.format.{kind}_unit is {wanted!r}"
    if stated and stated != wanted:
        raise RejectedCurveError(file, f"{known}, but {but}", line=line)
    return (f"{known}, which is not known; {but}",) if text and not stated else ()


def unit_of(text: str) -> str | None:
    """Return the unit that a text states, as the settings call it, or None if it is not known.

    >>> [unit_of(text) for text in ("[msec]", "Grad", "°", "(INCH)", "kA")]
    ['ms', 'deg', 'deg', 'inch', 'kA']
    """
    bare = text.strip().strip("[](){}<>").strip().removesuffix(".")
    return _KNOWN.get(bare) or _FOLDED.get(bare.casefold())


def amperes_of(name: str, unit: str = "") -> float:
    """Return how many amperes one of the unit of a column is; nan where that is no current.

    Args:
        name: Of the column. An `A` behind it is a phase, unless the name is of a current.
        unit: That is stated apart from the name.

    >>> [amperes_of(name) for name in ("I coil [A]", "Trip (mA)", "Coil Current (A)", "Coil (A)")]
    [1.0, 0.001, 1.0, nan]
    """
    if unit.strip():
        return AMPERES.get(unit_of(unit), float("nan"))
    ends = [each for each in _AMPERES.finditer(name[-_LONGEST:]) if each.end() == len(name)]
    if not ends:
        return float("nan")
    before, found = ends[-1].groups()
    if found == "A" and before != "[" and not holds(name, "current"):
        return float("nan")
    return AMPERES["mA" if found == "mA" else "A"]


def split_unit(name: str) -> tuple[str, str | None]:
    """Return the name of a column without its unit, and the unit; None where it has none.

    >>> [split_unit(name) for name in ("Travel [mm]", "t/ms", "Travel (A)", "weg cm")]
    [('Travel', 'mm'), ('t', 'ms'), ('Travel (A)', None), ('weg', 'cm')]
    """
    found = _BEHIND.fullmatch(name) if len(name) <= _LONGEST else None
    behind = next(filter(None, found.groups()[1:]), "") if found else ""
    inches = found and "in" in found.groups()[1:3] and is_travel_name(found[1])
    unit = None if behind.strip() in NO_UNITS and not inches else unit_of(behind)
    if found and found["bare"]:  # `Coil s` and `Travel min` have none
        timely = holds(found[1], "time") or is_travel_name(found[1])
        unit = unit if timely and unit in UNITS else None
    return (found[1], unit) if unit else (name, None)


def is_travel_name(name: str) -> bool:
    """Say whether the name of a column is that of a travel, in the usual languages."""
    return holds(name, "travel")
