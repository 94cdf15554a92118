"""The list of a page: breakers, and their inspections below, as names and headers of files show."""

import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from breaker.common.numerals import natural
from breaker.page.choices import id_of, name_of
from breaker.records.dates import one_date
from breaker.records.file_names import phases_in_names
from breaker.records.folder import record_files
from breaker.records.formats.comtrade import lone_data
from breaker.records.operations import MANIFEST
from breaker.records.table_proposal import Description
from breaker.records.words import motions_in

MOST = 10_000
"""Files of a list: more are the records of a life, for which the workflow is made."""
_ISO = 10  # characters of a date that is clear

DROPPED = "Dropped files"
"""Folder and heading of files that were dropped on the page."""


class Inspection(NamedTuple):
    """Files of one breaker and one day.

    Attributes:
        files: Their identifiers.
        breaker, type, date: As the files state them, or their folder and names; else empty.
        phases, motions: Phases, or columns of travel without one, and motions.
        reason: Reason why the file is not a record; empty if it is.
        seen: Whether all its files have been described.
    """

    files: tuple[str, ...]
    breaker: str
    type: str
    date: str
    phases: tuple[str, ...]
    motions: tuple[str, ...]
    reason: str
    seen: bool

    @property
    def name(self) -> str:
        """Name of the first file."""
        return Path(name_of(self.files[0])).name


def find_files(folder: Path) -> dict[str, str]:
    """Return the paths of records in a folder and below by identifier; lone data are among them,
    so that the page says what they lack. A folder with a table of operations is one entry.
    """
    found: dict[str, str] = {}
    for place, folders, names in os.walk(folder):
        folders[:] = sorted(e for e in folders if not e.startswith("."))
        if MANIFEST in names:
            folders[:] = []
            found[id_of(os.path.relpath(place, folder))] = place
            continue
        paths = sorted([*record_files(place), *lone_data(place)], key=natural)
        found |= {id_of(os.path.relpath(path, folder)): str(path) for path in paths}
        if len(found) > MOST:
            break
    return dict([*found.items()][:MOST])


def inspections_of(
    files: Mapping[str, str], described: Mapping[str, Description]
) -> list[Inspection]:
    """Return the inspections of files: those of a breaker and a day, or, without a date, those
    whose names differ in the phase alone.
    """
    groups: dict[tuple, list[str]] = {}
    phases = _phases_of(files)
    for name, path in files.items():
        about = described.get(name, Description())
        breaker, date = _breaker_of(name, about), _date_of(path, about)
        undated = _without(Path(path).stem, phases.get(name, "")) if not date else ""
        if breaker == DROPPED:  # an inspection of its own, that the user finds again
            undated = os.path.dirname(path)
        reason = about.reason and name
        groups.setdefault((breaker, date, undated, reason), []).append(name)
    found = [
        _inspection(names, breaker, date, described, phases)
        for (breaker, date, *_), names in groups.items()
    ]
    found.sort(key=lambda one: natural(one.name))
    found.sort(key=lambda one: one.date, reverse=True)  # the newest first
    return sorted(
        found, key=lambda one: (one.breaker != DROPPED, not one.breaker, natural(one.breaker))
    )


def _inspection(
    names: list[str],
    breaker: str,
    date: str,
    described: Mapping[str, Description],
    phases: Mapping[str, str],
) -> Inspection:
    about = [described[name] for name in names if name in described]
    types = (each.preamble.type for each in about)
    stated = (part.phase or part.channel for each in about for part in each.parts)
    named = [phases[name] for name in names if phases.get(name)]
    motions = (part.motion for each in about for part in each.parts)
    return Inspection(
        tuple(names),
        breaker,
        next(filter(None, types), ""),
        date,
        tuple(dict.fromkeys(named or filter(None, stated))),
        tuple(sorted({*motions})),
        next((each.reason for each in about if each.reason), ""),
        len(about) == len(names),
    )


def _phases_of(files: Mapping[str, str]) -> dict[str, str]:
    """Return the phase in the name of each file, by folder."""
    folders: dict[str, list[tuple[str, Path]]] = {}
    for name, path in files.items():
        folders.setdefault(os.path.dirname(path), []).append((name, Path(path)))
    found: dict[str, str] = {}
    for some in folders.values():
        phases = phases_in_names([path for _, path in some])
        found |= {name: phases[path] for name, path in some if path in phases}
    return found


def _without(stem: str, phase: str) -> str:
    """Return a name without its phase."""
    return stem.replace(phase, "", 1) if phase else stem


def _breaker_of(name: str, about: Description) -> str:
    """Return station, bay and serial number as the file states them, or else its folder."""
    if name.startswith(id_of(f"{DROPPED}/")):
        return DROPPED
    stated = about.preamble
    parts = filter(None, (stated.station, stated.bay, stated.serial))
    return ", ".join(" ".join(part.split()) for part in parts) or " / ".join(_own_folders(name))


def _own_folders(name: str) -> Iterator[str]:
    """Yield the folders of a file that are not named after a motion."""
    return (part for part in Path(name).parent.parts if not motions_in(part))


def _date_of(path: str, about: Description) -> str:
    """Return the date of a file; both, where day and month may be either."""
    dates = about.preamble.dates
    return one_date("", dates, path)[:10] or " or ".join(each[:10] for each in dates)


def earlier_than(one: Inspection, same: Iterable[Inspection]) -> list[Inspection]:
    """Return the earlier inspections among those of the same breaker, the last first."""
    dated = [other for other in (*same, one) if other.seen and len(other.date) == _ISO]
    found = [other for other in dated if other.date < one.date] if one in dated else []
    return sorted(found, key=lambda other: other.date, reverse=True)
