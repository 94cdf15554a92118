"""Of which breaker each file of a folder is."""

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence

from breaker.reading.files.file_facts import FoundFile
from breaker.reading.files.file_names import numbers_in
from breaker.reading.files.operations_table import FILL_IN
from breaker.reading.files.word_meanings import bare

_LONGEST = 200  # signs of a cell
_LONG = re.compile(r"\d{5,}")  # a number of a breaker, rather than a counter


def with_breakers(files: Sequence[FoundFile]) -> tuple[list[FoundFile], list[str]]:
    """Return files with their breakers, and what to check of these.

    A breaker is the serial number that a file states, or else the bay. One serial number in two
    bays stands for two breakers, since operations of two drives must not become those of one. Of
    what states neither, files of the same name but for date and phase tell, or those of its folder,
    or else the folder itself; where some files state a breaker and nothing tells, it is to be
    filled in.
    """
    named, remarks = _stated(files)
    by_name, by_folder = defaultdict(set), defaultdict(set)
    for file in files:
        if name := named.get(file.path):
            by_name[file.folder, file.key].add(name)
            by_folder[file.folder].add(name)
    numbers = [{*_LONG.findall(file.key)} for file in files]
    several = 1 < len(set().union(*numbers)) < len(files)
    counted = all(isinstance(each, int) for each in numbers_in([file.stem for file in files]))
    found, linked = [], 0
    for file in files:
        name = named.get(file.path, "")
        if not name:
            same = by_name.get((file.folder, file.key), set()) if file.key else set()
            there = by_folder.get(file.folder, set())
            if len(same) == 1:
                (name,) = same
                linked += 1
            elif file.folder and not there:
                name = file.folder
            elif there or named or (several and not counted):
                name = FILL_IN
        found.append(file._replace(breaker=name[:_LONGEST]))
    if linked:
        remarks.append(
            f"the breaker of {linked} files is that of files of the same name but for date and "
            "phase, as they state none"
        )
    if lacking := [file.path for file in found if file.breaker == FILL_IN]:
        remarks.append(
            f"the breaker of {len(lacking)} files, first {lacking[0]}, is to be filled in: neither "
            "they nor their names state it"
        )
    return found, remarks


def _stated(files: Sequence[FoundFile]) -> tuple[dict[str, str], list[str]]:
    """Breakers that files state, by their path, and serial numbers that stand in several bays."""
    bays: dict[str, dict[str, str]] = defaultdict(dict)
    for file in files:
        stated = file.seen.preamble
        if stated.serial and stated.bay:
            bays[stated.serial].setdefault(bare(stated.bay), " ".join(stated.bay.split()))
    found = {}
    for file in files:
        stated = file.seen.preamble
        name = stated.serial or " ".join(stated.bay.split())
        if len(bays.get(stated.serial, ())) > 1:
            name = f"{stated.serial} {bays[stated.serial][bare(stated.bay)]}" if stated.bay else ""
        if name:
            found[file.path] = name
    return found, [_twice(serial, each) for serial, each in bays.items() if len(each) > 1]


def _twice(serial: str, bays: Mapping[str, str]) -> str:
    return (
        f"serial number {serial} is on files of {len(bays)} bays, {' and '.join(bays.values())}: "
        "taken for as many breakers, with the bay in their names; if it is one that was moved, "
        "name it alike and number its operations anew"
    )
