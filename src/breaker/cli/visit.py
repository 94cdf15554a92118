"""The records of a visit: every motion of every channel of files, poles in files of their own."""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from breaker.cli.operations_named import MOTIONS, each_once, is_folder, without_records

if TYPE_CHECKING:
    from breaker.drive.answers.assessment import Assessment
    from breaker.reading.files.opened_file import Files, Opened


def read_visit(named: Sequence[str], options: argparse.Namespace, assessment: "Assessment") -> list:
    """Read the records of files and folders.

    A channel is the operation's phase. Files of poles of one operation share its number. A folder's
    table says all of this itself; folders of motions in it say motions and numbers.

    Raises:
        FileNotFoundError: If a folder has no file of a record.
        ValueError: If a table names several breakers.
    """
    from breaker.reading.files.folder_listing import list_operations, record_files
    from breaker.reading.files.opened_file import Files
    from breaker.reading.files.operations_table import MANIFEST, Operation, read_manifest

    rows: dict[str, list] = {motion: [] for motion in MOTIONS}
    files, opened, form = [], Files(), assessment.config["endurance"]["format"]
    for each in map(Path, named):
        if not is_folder(str(each)):
            files.append(each)
        elif (each / MANIFEST).exists():
            for motion, operation in read_manifest(each / MANIFEST):
                rows[motion].append(operation)
        elif parts := [motion for motion in MOTIONS if (each / motion).is_dir()]:
            for motion in parts:
                rows[motion] += list_operations(each, motion)
        elif inside := record_files(each):
            files += inside
        else:
            raise without_records(each)
    listed = [each for some in rows.values() for each in some]
    if len(names := {each.breaker for each in listed}) > 1:
        raise ValueError(f"a report is of one breaker, and these are {', '.join(sorted(names))}")
    after = max((each.number for each in listed), default=0)
    whole: dict[str, list] = {motion: [] for motion in MOTIONS}
    for file, number, phases in _numbered([*each_once(files)], options.channel, form, opened):
        for channel, phase in phases.items():
            for each in whole.values():
                each.append(Operation(after + number, file, channel, phase=phase))
    return [
        *assessment.read(rows, files=opened),
        *assessment.read(whole, loose=True, files=opened),
    ]


def _numbered(
    files: Sequence[Path], chosen: Sequence[str], form: Mapping, opened: "Files"
) -> list[tuple]:
    """Each file, the number of its operation, and the phases of its channels."""
    from breaker.drive.answers.file_statements import date_in
    from breaker.drive.answers.pole_files import PoleFile, operations_of_poles, phases_in_names
    from breaker.reading.inspection.file_contents import stated_in

    channels = {file: _channels(opened[file], chosen) for file in files}
    in_names = phases_in_names(files)
    for file, found in channels.items():
        if file in in_names and len(found) == 1:
            ((channel, phase),) = found.items()
            found[channel] = phase or in_names[file]
    poles = {}
    for file, found in channels.items():
        phases = tuple(phase for channel, phase in found.items() if phase != channel)
        known = phases if all(phases) and len(phases) == len(found) else ()
        stated = stated_in(opened[file], form, next(iter(found)))
        poles[file] = PoleFile(known, date_in(file, stated))
    numbers = operations_of_poles(poles)
    return [(file, numbers[file], found) for file, found in channels.items()]


def _channels(file: "Opened", chosen: Sequence[str]) -> dict[str, str]:
    """Names of channels by columns of travel of a file; that of one alone is its phase, empty where
    the file states none.
    """
    from breaker.reading.files.guards import RejectedCurveError
    from breaker.reading.inspection.file_description import travel_channels

    try:
        found = travel_channels(file)
    except (ValueError, RejectedCurveError):
        found = {}  # to be read as configured, or rejected with the reason
    names = {each: found[each][0] if each in found else each for each in chosen or found or [""]}
    return {key: "" if len(names) == 1 and name == key else name for key, name in names.items()}
