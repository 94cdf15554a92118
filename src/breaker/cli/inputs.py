"""What a command reads: its configuration, and the records in the files and folders that it names.

In a folder with a table ``operations.csv`` the operations are the rows of the table. In a folder
with a subfolder for each motion, the names of the files number them. All other files may hold any
motion, and are numbered in the natural order of their names.
"""

import argparse
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from breaker.configuration.loading import load, read
from breaker.shipped import DEFAULTS

if TYPE_CHECKING:
    from breaker.drive.answers.assessment import Assessment
    from breaker.drive.answers.evidence import DriveRecord
    from breaker.drive.answers.reference_curve import Overlay
    from breaker.reading.files.guards import Files, Opened
    from breaker.reading.files.operations_table import Operation

# ---- configuration -------------------------------------------------------------------------------

ADVANCED = Path("config/advanced.yaml")
PROJECT = Path("config/config.yaml")
"""Where the workflow's configuration is, from the project's folder; the second over the first."""


def settings_of(overlays: Sequence[str]) -> dict:
    """Return the configuration: overlays over that of the folder, or over the shipped defaults.

    The defaults alone are not checked: tests do that, and it takes a tenth of the first answer.
    """
    own = [ADVANCED if ADVANCED.exists() else DEFAULTS, PROJECT] if PROJECT.exists() else [DEFAULTS]
    files = [*own, *overlays]
    # Commands name the folders of records themselves.
    return load(files, curves=False) if len(files) > 1 else read(DEFAULTS)


def limits_of(config: Mapping, overlays: Sequence[str]) -> list:
    """Return the limits of the drive: the shipped ones are an example, and count only by name."""
    named = any("limits" in read(path) for path in overlays)
    return config["limits"] if named or config["limits"] != read(DEFAULTS)["limits"] else []


# ---- options -------------------------------------------------------------------------------------

MOTIONS = ("closing", "opening")
"""Motions of records; here, so that the options of a command are known before its imports."""

SEVERAL = {"nargs": "+", "action": "extend", "default": []}
"""Settings of an option that takes several values, and may be given several times."""


def a_path(text: str) -> str:
    """Return a path of a command: any text but "", which would be the current folder."""
    if not text:
        raise argparse.ArgumentTypeError("an empty text names no file or folder")
    return text


def percent(text: str) -> float:
    """Return a share, from percent."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < 100.0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a percentage above 0 and below 100")
    return value / 100.0


def add_path(command: argparse.ArgumentParser, name: str, kind: str, what: str, **more) -> None:
    """Add an argument or option that names a file or folder: its kind and help, and how many."""
    command.add_argument(name, type=a_path, metavar=kind, help=what, **more)


def add_choice(command: argparse.ArgumentParser) -> None:
    """Add the options that choose among the records of a command's files, called after it."""
    name = command.prog.split()[-1]
    command.add_argument("--motion", choices=MOTIONS, help=f"{name} this motion alone")
    command.add_argument("--channel", default="", metavar="NAME", help="the column of travel")
    command.add_argument("--breaker", metavar="NAME", help="which breaker of a folder's table")
    command.add_argument("--phase", metavar="NAME", help="which phase of a folder's table")


def add_reference(command: argparse.ArgumentParser) -> None:
    """Add the options that name a good record, and how far others may depart from it."""
    what = "a good record: draw the others over it, with differences"
    add_path(command, "--reference", "GOOD", what)
    what = "of the stroke, half of the band about the good record (default: 5)"
    command.add_argument("--tolerance", type=percent, metavar="PERCENT", help=what)


# ---- records -------------------------------------------------------------------------------------


def read_records(
    named: Sequence[str], options: argparse.Namespace, assessment: "Assessment"
) -> list["DriveRecord"]:
    """Read the records in files and folders that the options of ``add_choice`` choose.

    Without a breaker or phase among the options, those of the configuration choose in a table.

    Raises:
        FileNotFoundError: If a folder has no file of a record.
        ValueError: If a table is wrong or has several drives, or a choice cannot be made.
    """
    from breaker.reading.files.folder_listing import list_operations
    from breaker.reading.files.operations_table import MANIFEST, Operation

    settings, channel = assessment.config["endurance"], options.channel
    chosen = {key: getattr(options, key) or settings[key] for key in ("breaker", "phase")}
    motions = motions_of(options)
    rows, files = _found(named, motions, lambda *of: list_operations(*of, **chosen))
    if files and (options.breaker or options.phase):
        raise ValueError(
            f"--breaker and --phase choose in one folder with a table {MANIFEST}, and "
            f"{files[0]} is in none; leave them out"
        )
    if channel and any(each.channel for some in rows.values() for each in some):
        raise ValueError(
            "the table of a folder names the channels; leave --channel out, or choose by --phase"
        )
    rows = {m: [replace(e, channel=e.channel or channel) for e in some] for m, some in rows.items()}
    after = _last_number(rows)
    loose = [Operation(after + i, file, channel=channel) for i, file in enumerate(files, start=1)]
    both = dict.fromkeys(motions, loose)
    return [*assessment.read(rows), *assessment.read(both, loose=True)]


def motions_of(options: argparse.Namespace) -> Sequence[str]:
    """Return the motions that the options of ``add_choice`` choose."""
    return [options.motion] if options.motion else MOTIONS


def read_visit(
    named: Sequence[str],
    channels: Sequence[str],
    assessment: "Assessment",
    opened: "Files | None" = None,
) -> list["DriveRecord"]:
    """Read every channel and motion in files and folders of one breaker, for a report.

    A channel is the operation's phase. Files of poles of one operation share its number.

    Args:
        named: Files and folders.
        channels: Columns of travel; all that move where there are none.
        assessment: What reads them.
        opened: In which files are opened, once.

    Raises:
        FileNotFoundError: If a folder has no file of a record.
        ValueError: If a table names several breakers.
    """
    from breaker.reading.files.guards import Files
    from breaker.reading.files.operations_table import Operation

    opened = Files() if opened is None else opened
    rows, files = _found(named, MOTIONS, _every_phase)
    if len(names := {each.breaker for some in rows.values() for each in some}) > 1:
        raise ValueError(
            f"a report is of one breaker, and the tables name {', '.join(sorted(names))}; write a "
            "report of each"
        )
    after, form = _last_number(rows), assessment.config["endurance"]["format"]
    loose = [
        Operation(after + number, file, channel, phase=phase)
        for file, number, phases in _numbered(files, channels, form, opened)
        for channel, phase in phases.items()
    ]
    both = dict.fromkeys(MOTIONS, loose)
    return [*assessment.read(rows, files=opened), *assessment.read(both, loose=True, files=opened)]


def _found(
    named: Sequence[str],
    motions: Sequence[str],
    list_motion: Callable[[Path, str], Iterable["Operation"]],
) -> tuple[dict[str, list["Operation"]], list[Path]]:
    """Return operations of folders that state them, by motion, and all other files once each."""
    from breaker.reading.files.folder_listing import record_files
    from breaker.reading.files.operations_table import MANIFEST

    rows: dict[str, list[Operation]] = {}
    files: list[Path] = []
    for each in map(Path, named):
        stated = any((each / name).exists() for name in (MANIFEST, *motions))
        if not is_folder(each):
            files.append(each)
        elif stated:
            lacking = []
            for motion in motions:
                try:
                    rows.setdefault(motion, []).extend(list_motion(each, motion))
                except FileNotFoundError as error:
                    lacking.append(error)
            if len(lacking) == len(motions):
                raise lacking[0]
        elif inside := record_files(each):
            files += inside
        else:
            raise FileNotFoundError(f"{each} has no file of a record, and no table {MANIFEST}")
    return rows, each_once(files)


def _every_phase(folder: Path, motion: str) -> list["Operation"]:
    """Return the operations of a motion in a folder, of all breakers and phases of its table."""
    from breaker.reading.files.folder_listing import list_fleet, list_operations
    from breaker.reading.files.operations_table import MANIFEST

    if not (folder / MANIFEST).exists():
        return list_operations(folder, motion)
    rows = (row for some in list_fleet(folder).values() for row in some)
    return [operation for of, operation in rows if of == motion]


def _last_number(rows: Mapping[str, Sequence["Operation"]]) -> int:
    return max((each.number for some in rows.values() for each in some), default=0)


def each_once(paths: Iterable[str | Path]) -> list:
    """Return files or folders each once, under whatever names they are there twice.

    Their order is natural: that of a command must not matter, as draws depend on a record's number.
    """
    from breaker.common.numerals import natural

    found: dict[str, str | Path] = {}
    for path in sorted(paths, key=natural):
        found.setdefault(os.path.realpath(path), path)
    return list(found.values())


def is_folder(name: str | Path) -> bool:
    """Return whether a name is that of a folder that is not itself a record."""
    from breaker.reading.files.guards import is_store

    return os.path.isdir(name) and not is_store(name)


def _numbered(
    files: Sequence[Path], chosen: Sequence[str], form: Mapping, opened: "Files"
) -> list[tuple[Path, int, dict[str, str]]]:
    """Return each file, the number of its operation, and the phases of its channels."""
    from breaker.drive.answers.pole_files import PoleFile, operations_of_poles
    from breaker.reading.files.file_names import phases_in_names
    from breaker.reading.inspection.file_contents import stated_in

    channels = {file: _channels(opened[file], chosen) for file in files}
    in_names = phases_in_names(files)
    poles = {}
    for file, found in channels.items():
        if file in in_names and len(found) == 1:
            ((channel, phase),) = found.items()
            found[channel] = phase or in_names[file]
        phases = tuple(phase for channel, phase in found.items() if phase not in (channel, ""))
        known = phases if len(phases) == len(found) else ()
        poles[file] = PoleFile(known, stated_in(opened[file], form, next(iter(found))).date)
    numbers = operations_of_poles(poles)
    return [(file, numbers[file], found) for file, found in channels.items()]


def _channels(file: "Opened", chosen: Sequence[str]) -> dict[str, str]:
    """Return the phases or names of the channels of a file, by their columns of travel.

    A single channel for which the file states no phase has an empty one.
    """
    from breaker.reading.inspection.file_description import travel_channels

    found = {}
    with suppress(ValueError):  # to be read as configured, or rejected with the reason
        found = travel_channels(file)
    names = {each: found[each][0] if each in found else each for each in chosen or found or [""]}
    return {key: "" if len(names) == 1 and name == key else name for key, name in names.items()}


def overlays_of(
    records: Sequence["DriveRecord"],
    reference: str | None,
    tolerance: float | None,
    read_good: Callable[[Sequence[str]], Sequence["DriveRecord"]],
) -> list["Overlay"]:
    """Lay records over a good one; none where none is named.

    Args:
        records: Records of the command's files.
        reference, tolerance: Options of ``add_reference``.
        read_good: Reads the file of the good record.

    Raises:
        ValueError: If the good record cannot be read, or has no motion of the others; or if a
            tolerance is given without it.
    """
    if reference is None:
        if tolerance is not None:
            raise ValueError("--tolerance is of a --reference, which is not given; name a record")
        return []
    from breaker.drive.answers.reference_curve import TOLERANCE, overlaid

    good = read_good([reference])
    if good and all(each.reason for each in good):
        raise ValueError(f"the reference cannot be used: {good[0].reason}")
    if not (found := overlaid(records, good, tolerance or TOLERANCE)):
        motions = " or ".join(dict.fromkeys(each.motion for each in records))
        raise ValueError(f"the reference {reference} has no usable {motions}; name one that has")
    return found
