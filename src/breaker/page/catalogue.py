"""The list of the page: breakers and inspections, from names and headers of files."""

import os
from collections.abc import Iterable, Mapping
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from breaker.common.numerals import natural
from breaker.page.choices import id_of, name_of
from breaker.records.dates import one_date
from breaker.records.description import Description
from breaker.records.folder import record_files
from breaker.records.formats.detection import UNREAD
from breaker.records.operations import MANIFEST
from breaker.records.words import motions_in, phases_in_names

MOST = 500
"""Most files of a list, whose headers are read in 10 s; the workflow is made for more."""
_ISO = 10  # characters of an unambiguous date


class Inspection(NamedTuple):
    """Files of one breaker and one day.

    Attributes:
        files: Their identifiers.
        breaker, type, date: As stated by the files, or by folder and file names; else empty.
        phases, motions: Phases, or columns of travel without a phase, and motions.
        reason: Reason why the file is not a record; empty if it is.
    """

    files: tuple[str, ...]
    breaker: str
    type: str
    date: str
    phases: tuple[str, ...]
    motions: tuple[str, ...]
    reason: str

    @property
    def name(self) -> str:
        """Name of the first file."""
        return Path(name_of(self.files[0])).name


def find_files(folder: Path) -> dict[str, str]:
    """Return the paths of records in a folder and its subfolders by identifier. A folder with a
    table of operations is one entry.
    """
    files: dict[str, str] = {}
    for place, folders, names in os.walk(folder):
        folders[:] = sorted(e for e in folders if not e.startswith("."))
        paths = sorted(record_files(place), key=natural)
        if MANIFEST in names:
            paths = [place]
            folders.clear()
        files |= {id_of(os.path.relpath(path, folder)): str(path) for path in paths}
        if len(files) > MOST:
            break
    return dict([*files.items()][:MOST])


def unread_files(folder: str) -> list[str]:
    """Return the names of files in a folder and its subfolders whose format is not read."""
    names = (name for _, _, names in islice(os.walk(folder), MOST) for name in names)
    return [name for name in names if Path(name).suffix.lower() in UNREAD]


def inspections_of(
    files: Mapping[str, str], described: Mapping[str, Description]
) -> list[Inspection]:
    """Group files into inspections: files of one breaker and day, or, without a date, files whose
    names differ only in the phase. Named breakers come first, and the newest inspection of a
    breaker first.
    """
    groups: dict[tuple, list[str]] = {}
    phases: dict[Path, str] = {}
    for folder in {Path(path).parent for path in files.values()}:
        phases |= phases_in_names(e for e in map(Path, files.values()) if e.parent == folder)
    for name, path in files.items():
        about, phase = described[name], phases.get(Path(path), "")
        breaker, date = _breaker_of(name, about), _date_of(path, about)
        undated = "" if date else name.replace(phase or "\0", "", 1)
        groups.setdefault((breaker, date, undated, about.reason and name), []).append(name)
    inspections = []
    for (breaker, date, *_), names in groups.items():
        abouts = [described[name] for name in names]
        parts = [part for about in abouts for part in about.parts]
        named = [phases.get(Path(files[name]), "") for name in names]
        stated = named if any(named) else [part.phase or str(part.column) for part in parts]
        inspection = Inspection(
            files=tuple(names),
            breaker=breaker,
            type=next((about.preamble.type for about in abouts if about.preamble.type), ""),
            date=date,
            phases=tuple(dict.fromkeys(filter(None, stated))),
            motions=tuple(sorted({part.motion for part in parts})),
            reason=abouts[0].reason,
        )
        inspections.append(inspection)
    inspections.sort(key=lambda one: natural(one.name))
    inspections.sort(key=lambda one: one.date, reverse=True)
    inspections.sort(key=lambda one: (not one.breaker, natural(one.breaker)))
    return inspections


def _breaker_of(name: str, about: Description) -> str:
    """Return station, bay and serial number stated by the file, or else the names of its folders
    without folders that are named after a motion.
    """
    stated = (about.preamble.station, about.preamble.bay, about.preamble.serial)
    folders = (part for part in Path(name).parent.parts if not motions_in(part))
    return ", ".join(" ".join(part.split()) for part in stated if part) or " / ".join(folders)


def _date_of(path: str, about: Description) -> str:
    """Return the date of a file, or both dates if day and month are ambiguous."""
    dates = about.preamble.dates
    return one_date("", dates, path)[:_ISO] or " or ".join(date[:_ISO] for date in dates)


def earlier_than(inspection: Inspection, others: Iterable[Inspection]) -> list[Inspection]:
    """Return the earlier inspections of the same breaker, the last first."""
    dated = [e for e in others if e.breaker == inspection.breaker and len(e.date) == _ISO]
    earlier = [e for e in dated if e.date < inspection.date and len(inspection.date) == _ISO]
    return sorted(earlier, key=lambda other: other.date, reverse=True)
