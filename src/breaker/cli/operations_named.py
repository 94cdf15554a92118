"""The files and folders that a command names, as operations to be read."""

import argparse
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

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
    from breaker.reading.files.file_names import natural

    found: dict[str, str | Path] = {}
    for path in sorted(paths, key=natural):
        found.setdefault(os.path.realpath(path), path)
    return list(found.values())


def is_folder(name: str) -> bool:
    """Whether a name is that of a folder that is no record."""
    from breaker.reading.files.netcdf import is_store

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
