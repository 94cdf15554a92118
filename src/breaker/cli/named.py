"""The files and folders that a command names, as operations to be read, and its outputs."""

import argparse
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

__all__ = ["MOTIONS", "add_choice", "check_output", "operations_of"]

MOTIONS = ("closing", "opening")
"""Those that records may be of; here, so that a command's options are known before its imports."""

_STORE = (".zgroup", "zarr.json")  # one of which every Zarr store has
_PICTURES = (".png", ".pdf", ".svg", ".jpg", ".jpeg")


def add_choice(command: argparse.ArgumentParser) -> None:
    """Add the options that choose among the records of a command's files, called after it."""
    name = command.prog.split()[-1]
    command.add_argument("--motion", choices=MOTIONS, help=f"{name} this motion alone")
    command.add_argument("--channel", default="", metavar="NAME", help="the column of travel")
    command.add_argument("--breaker", metavar="NAME", help="which breaker of a folder's table")
    command.add_argument("--phase", metavar="NAME", help="which phase of a folder's table")


def operations_of(
    named: Sequence[str],
    motions: Sequence[str],
    chosen: Mapping[str, str | None],
    channel: str = "",
) -> tuple[dict[str, list], bool]:
    """Return the operations in files and folders, by motion, and whether each file may hold either.

    A file may hold any motion, and so may those of a folder, which count from 1 on. Where a single
    folder has a table of operations, or a folder for each motion, these give motions and numbers.

    Args:
        named: Files and folders.
        motions: "closing", "opening" or both.
        chosen: ``breaker`` and ``phase``: which of those in a table.
        channel: Column of the travel, where it is not that of the settings.

    Raises:
        FileNotFoundError: If a folder has no file of a record.
        ValueError: If a table is wrong or has several drives, or a choice cannot be made.
    """
    from breaker.files import MANIFEST, Operation, record_files

    folders = [Path(each) for each in named if _is_folder(each)]
    if len(named) == len(folders) == 1:
        folder = folders[0]
        parts = [motion for motion in motions if (folder / motion).is_dir()]
        if os.path.lexists(folder / MANIFEST) or parts:
            return _listed(folder, motions, chosen, channel), False
    if wrong := [f"--{key}" for key, value in chosen.items() if value]:
        raise ValueError(
            f"{' and '.join(wrong)} can be chosen in one folder with a table {MANIFEST} only"
        )
    files: list[Path] = []
    for each in named:
        inside = record_files(each) if _is_folder(each) else [Path(each)]
        if not inside and len(named) == 1:
            raise FileNotFoundError(f"{each} has no file of a record, and no table {MANIFEST}")
        files += inside or [Path(each)]  # beside others it is rejected, and does not stop them
    files = list(dict.fromkeys(files))
    loose = [Operation(i, file, channel=channel) for i, file in enumerate(files, start=1)]
    return dict.fromkeys(motions, loose), True


def _is_folder(name: str) -> bool:
    """Whether a name is that of a folder that is no record."""
    return os.path.isdir(name) and Path(name).suffix.lower() != ".zarr"


def _listed(
    folder: Path, motions: Sequence[str], chosen: Mapping[str, str | None], channel: str
) -> dict[str, list]:
    """Operations of a folder by its table, or its folders of motions; of those that are there."""
    from breaker.files import list_operations

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


def check_output(
    path: str, inputs: Sequence[str], *, store: bool = False, picture: bool = False
) -> None:
    """Refuse what cannot be written, before any work is done.

    Args:
        path: What is to be written.
        inputs: Files and folders that are read.
        store: Whether it is a Zarr store, a folder, which may replace one.
        picture: Whether it is a picture, whose kind its ending says.

    Raises:
        OSError: If its folder is not there, it may not be written, or it is a folder of another
            kind.
        ValueError: If it is one of the records that are read, or a picture of no known ending.
    """
    target = Path(path)
    folder = target.parent
    if not folder.is_dir():
        raise FileNotFoundError(f"there is no folder {folder}/ for {path}; make it first")
    if target.exists() and any(os.path.exists(each) and target.samefile(each) for each in inputs):
        raise ValueError(f"{path} is what is read, and would be replaced; name another file")
    if picture and target.suffix.lower() not in _PICTURES and not target.is_dir():
        raise ValueError(f"{path} is no name of a picture; end it in {' or '.join(_PICTURES[:3])}")
    if target.is_dir() and not (store and any((target / name).is_file() for name in _STORE)):
        raise IsADirectoryError(f"{path} is a folder, and is not replaced; name another")
    if store and target.is_file():
        raise FileExistsError(f"{path} is a file, and a store is a folder; name another")
    if not os.access(target if target.exists() else folder, os.W_OK):
        raise PermissionError(f"{path} may not be written; name another")
