"""What a command reads: its configuration, and the files and folders that it names.

These are operations, or records. Records of a visit are those of every motion of every channel, and
poles may have files of their own. A good record is one that others are laid over.
"""

import argparse
import json
import os
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from breaker.common.visible_text import say
from breaker.configuration.loading import load, read
from breaker.shipped import DEFAULTS

if TYPE_CHECKING:
    from breaker.drive.answers.assessment import Assessment
    from breaker.reading.files.guards import Files, Opened

# ---- configuration -------------------------------------------------------------------------------

ADVANCED = Path("config/advanced.yaml")
PROJECT = Path("config/config.yaml")
"""Where the workflow's configuration is, from the project's folder; the second over the first."""

_LONGEST = 60  # signs of a value in a message


def settings_of(overlays: Sequence[str], more: Sequence[str] = ()) -> dict:
    """The configuration: overlays, and more, over that of the folder, or over the defaults that
    ship. What one of them sets and a later one changes is printed; of overlays alone, without more.

    The defaults alone are not checked: tests do that, and it takes a tenth of the first answer.
    """
    own = [ADVANCED if ADVANCED.exists() else DEFAULTS, PROJECT] if PROJECT.exists() else [DEFAULTS]
    files = [*own, *overlays, *more]
    # Commands name the folders of records themselves.
    config = load(files, curves=False) if len(files) > 1 else read(DEFAULTS)
    stated: dict[str, tuple[str, str]] = {}
    for place, file in enumerate([*overlays, *more]):
        for key, value in _values(read(file)):
            before, old = stated.get(key, (file, value))
            if old != value and (place >= len(overlays) or not more):
                new, old = (textwrap.shorten(each, _LONGEST) for each in (value, old))
                said = f"note: {file}: {key} is {new}, in place of {old} of {before}"
                say(said, beside=True)
            stated[key] = (file, value)
    return config


def _values(section: Mapping, above: str = "") -> Iterator[tuple[str, str]]:
    """Keys of a section and of those in it, with points between, and their values as texts."""
    for key, value in section.items():
        if isinstance(value, Mapping):
            yield from _values(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", json.dumps(value, default=str, ensure_ascii=False)


def limits_of(config: Mapping, overlays: Sequence[str]) -> list:
    """The limits of the drive: those that ship are an example, and none unless they are asked for.

    They are where the configuration changes them, or an overlay names them.
    """
    named = any("limits" in read(path) for path in overlays)
    return config["limits"] if named or config["limits"] != read(DEFAULTS)["limits"] else []


# ---- files and folders ---------------------------------------------------------------------------

MOTIONS = ("closing", "opening")
"""Those that records may be of; here, so that a command's options are known before its imports."""

SEVERAL = {"nargs": "+", "action": "extend", "default": []}
"""Settings of an option that takes several values, and may be given several times."""


def a_path(text: str) -> str:
    """A path in a command: any text but none, which would be the current folder."""
    if not text:
        raise argparse.ArgumentTypeError("an empty text names no file or folder")
    return text


def percent(text: str) -> float:
    """A share, from percent."""
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


def operations_of(
    named: Sequence[str], options: argparse.Namespace, config: Mapping
) -> tuple[dict[str, list], bool]:
    """Return the operations in files and folders, by motion, and whether each file may hold either.

    A file may hold any motion, and so may those of a folder, which count from 1 on. Where a single
    folder has a table of operations, or a folder for each motion, these give motions and numbers.

    Args:
        named: Files and folders.
        options: Those of ``add_choice``; in a table, without a breaker or phase, those of the
            configuration.

    Raises:
        FileNotFoundError: If a folder has no file of a record.
        ValueError: If a table is wrong or has several drives, or a choice cannot be made.
    """
    from breaker.reading.files.folder_listing import record_files
    from breaker.reading.files.operations_table import MANIFEST, Operation

    motions, channel = [options.motion] if options.motion else MOTIONS, options.channel
    settings = config["endurance"]
    chosen = {key: getattr(options, key) or settings[key] for key in ("breaker", "phase")}
    folders = [Path(each) for each in named if is_folder(each)]
    if len(named) == len(folders) == 1:
        folder = folders[0]
        parts = [motion for motion in motions if (folder / motion).is_dir()]
        if os.path.lexists(folder / MANIFEST) or parts:
            return _listed(folder, motions, chosen, channel), False
    if wrong := [f"--{key}" for key in chosen if getattr(options, key)]:
        raise ValueError(
            f"{' and '.join(wrong)} can be chosen in one folder with a table {MANIFEST} only"
        )
    files: list[Path] = []
    for each in named:
        inside = record_files(each) if is_folder(each) else [Path(each)]
        if not inside and len(named) == 1:
            raise without_records(each)
        files += inside or [Path(each)]  # beside others it is rejected, and does not stop them
    files = each_once(files)
    loose = [Operation(i, file, channel=channel) for i, file in enumerate(files, start=1)]
    return dict.fromkeys(motions, loose), True


def without_records(folder: str | Path) -> FileNotFoundError:
    """The error of a folder in which there is nothing to read."""
    from breaker.reading.files.operations_table import MANIFEST

    return FileNotFoundError(f"{folder} has no file of a record, and no table {MANIFEST}")


def each_once(paths: Sequence[str | Path]) -> list:
    """Return files or folders each once, under whatever names it is there twice, and in one order:
    that of a command must not matter, as draws depend on the number of a record.
    """
    from breaker.common.numerals import natural

    found: dict[str, str | Path] = {}
    for path in sorted(paths, key=natural):
        found.setdefault(os.path.realpath(path), path)
    return list(found.values())


def is_folder(name: str) -> bool:
    """Whether a name is that of a folder that is no record."""
    from breaker.reading.files.guards import is_store

    return os.path.isdir(name) and not is_store(name)


def _listed(
    folder: Path, motions: Sequence[str], chosen: Mapping[str, str | None], channel: str
) -> dict[str, list]:
    """Operations of a folder by its table, or its folders of motions; of those that are there."""
    from breaker.reading.files.folder_listing import list_operations

    found, missing = {}, []
    for motion in motions:
        try:
            found[motion] = list_operations(folder, motion, **chosen)
        except FileNotFoundError as error:
            missing.append(error)
        except ValueError as error:
            text = str(error)
            for key in chosen:
                text = text.replace(f"choose one by endurance.{key}", f"choose one by --{key} NAME")
            raise ValueError(text) from error
    if not found:
        raise missing[0]
    if channel and any(each.channel for rows in found.values() for each in rows):
        raise ValueError(
            f"the table of {folder} names the channels; leave --channel out, or choose by --phase"
        )
    return {
        motion: [replace(each, channel=each.channel or channel) for each in rows]
        for motion, rows in found.items()
    }


def read_visit(
    named: Sequence[str],
    options: argparse.Namespace,
    assessment: "Assessment",
    opened: "Files | None" = None,
) -> list:
    """Read the records of files and folders.

    A channel is the operation's phase. Files of poles of one operation share its number. A folder's
    table says all of this itself; folders of motions in it say motions and numbers. Files are
    opened once, in those that are given.

    Raises:
        FileNotFoundError: If a folder has no file of a record.
        ValueError: If a table names several breakers.
    """
    from breaker.reading.files.folder_listing import list_operations, record_files
    from breaker.reading.files.guards import Files
    from breaker.reading.files.operations_table import MANIFEST, Operation, read_manifest

    rows: dict[str, list] = {motion: [] for motion in MOTIONS}
    opened = Files() if opened is None else opened
    files, form = [], assessment.config["endurance"]["format"]
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
    loose = [
        Operation(after + number, file, channel, phase=phase)
        for file, number, phases in _numbered(each_once(files), options.channel, form, opened)
        for channel, phase in phases.items()
    ]
    both = dict.fromkeys(MOTIONS, loose)
    return [*assessment.read(rows, files=opened), *assessment.read(both, loose=True, files=opened)]


def _numbered(
    files: Sequence[Path], chosen: Sequence[str], form: Mapping, opened: "Files"
) -> list[tuple]:
    """Each file, the number of its operation, and the phases of its channels."""
    from breaker.drive.answers.pole_files import PoleFile, operations_of_poles
    from breaker.reading.files.file_names import phases_in_names
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
        poles[file] = PoleFile(known, stated.date)
    numbers = operations_of_poles(poles)
    return [(file, numbers[file], found) for file, found in channels.items()]


def _channels(file: "Opened", chosen: Sequence[str]) -> dict[str, str]:
    """Names of channels by columns of travel of a file; that of one alone is its phase, empty where
    the file states none.
    """
    from breaker.reading.inspection.file_description import travel_channels

    found = {}
    with suppress(ValueError):  # to be read as configured, or rejected with the reason
        found = travel_channels(file)
    names = {each: found[each][0] if each in found else each for each in chosen or found or [""]}
    return {key: "" if len(names) == 1 and name == key else name for key, name in names.items()}


def add_reference(command: argparse.ArgumentParser) -> None:
    """Add the options that name a good record, and how far others may depart from it."""
    add_path(
        command, "--reference", "GOOD", "a good record: draw the others over it, with differences"
    )
    command.add_argument(
        "--tolerance",
        type=percent,
        metavar="PERCENT",
        help="of the stroke, half of the band about the good record (default: 5)",
    )


def overlays_of(records: Sequence, good: Sequence, options: argparse.Namespace) -> list:
    """Lay records over good ones; none where none is named.

    Args:
        records, good: What was read of the files of the command, and of the good one.
        options: Those of ``add_reference``.

    Raises:
        ValueError: If the good record cannot be read, or has no motion of the others; or if a
            tolerance is given without it.
    """
    if options.reference is None:
        if options.tolerance is not None:
            raise ValueError("--tolerance is of a --reference, which is not given; name a record")
        return []
    from breaker.drive.answers.reference_curve import TOLERANCE, overlaid

    if good and all(each.reason for each in good):
        raise ValueError(f"the reference cannot be used: {good[0].reason}")
    if not (found := overlaid(records, good, options.tolerance or TOLERANCE)):
        motions = " or ".join({each.motion: "" for each in records})
        raise ValueError(
            f"the reference {options.reference} has no usable {motions}; name one that has"
        )
    return found
