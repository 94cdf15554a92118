"""A first ``operations.csv`` of a folder, to be checked and completed: the only place that guesses.

Light to import.
"""

import csv
import os
import re
from collections.abc import Iterator, Sequence
from io import StringIO
from pathlib import Path
from typing import NamedTuple

from breaker.files.cells import MOTIONS
from breaker.files.guards import no_file, printable
from breaker.files.listing import odd_signs, record_files
from breaker.files.manifest import ABOUT
from breaker.files.naming import Moment, moments, natural, numbers_in

__all__ = ["propose_manifest"]

_COLUMNS = ("file", "motion", "operation", "channel", *ABOUT, "from", "to")
_WORDS = {
    "closing": {"closing", "close", "closes", "ein"},
    "opening": {"opening", "open", "opens", "trip", "tripping", "aus"},
}


class _File(NamedTuple):
    """A file of records.

    Attributes:
        path: From the folder of the table, with / between its parts.
        stem: Name without ending.
        motions: The one that its folders, or else its name, say it holds; both if none does.
        breaker: Its other folders.
        date: The first one in its name, None without one.
        written: When the file was written, s.
    """

    path: str
    stem: str
    motions: tuple[str, ...]
    breaker: str
    date: Moment | None
    written: float


def propose_manifest(
    folder: str | Path, channels: Sequence[str] = (), motions: Sequence[str] = MOTIONS
) -> tuple[str, list[str]]:
    """Propose the table of a folder and those below it.

    The motion comes from folders named after it, or else from the name; other folders are breakers.
    The counter comes from the names where they leave no doubt; else operations are numbered from 1,
    by the dates in the names, or else by the times at which the files were written.

    Args:
        folder: Folder of the curve files.
        channels: Columns of travel that each file has, side by side: a row for each, and each a
            phase of its own.
        motions: Which motions have rows; a file of another one is left out.

    Returns:
        The text of the table, and what to check in it, in words.

    Raises:
        FileNotFoundError: If there is no such folder, or no file of a record of these motions.
    """
    if not os.path.isdir(folder):
        raise FileNotFoundError(
            f"there is no folder {printable(folder)!r}; name that of the curve files"
        )
    every, remarks = _files(Path(folder))
    files = [file for file in every if {*file.motions} & {*motions}]
    if others := len(every) - len(files):
        remarks.append(f"left out: {others} files of another motion than {' or '.join(motions)}")
    if not files:
        raise FileNotFoundError(
            "; ".join([f"{printable(folder)} has no file of a record", *remarks])
        )
    if unsaid := sum(len(file.motions) > 1 for file in files):
        remarks.append(
            f"no folder or name says the motion of {unsaid} files, so each has a row of "
            f"{' and '.join(motions)}: delete what it does not hold"
        )
    if any(file.date for file in files):
        remarks.append("dates are from the names, the day before the month where both can be")
    groups: dict[tuple[str, str], list[_File]] = {}
    for file in files:
        for motion in {*file.motions} & {*motions}:
            groups.setdefault((file.breaker, motion), []).append(file)
    rows = []
    for (breaker, motion), group in sorted(groups.items()):
        numbers, order = _numbers(group)
        if order:
            remarks.append(
                f"{breaker} {motion}".strip() + f": {len(group)} operations are numbered from 1 in "
                f"the order of {order}, as the names do not say the counter"
            )
        rows += [(breaker, number, motion, of) for number, of in zip(numbers, group, strict=True)]
    return _text(rows, channels or [""]), remarks


def _files(folder: Path) -> tuple[list[_File], list[str]]:
    """The files of records in a folder and those below it, and what was left out."""
    found, remarks = [], []
    for file in _walk(folder):
        path = file.relative_to(folder).as_posix()
        why = "" if file.suffix.lower() == ".zarr" and file.is_dir() else no_file(file)
        if odd := odd_signs(path):
            why = f"has {odd} in its name; rename it"
        elif any("\ud800" <= sign <= "\udfff" for sign in path):
            why = "has a name that is not UTF-8; rename it"
        elif "\\" in path:
            why = "has a \\ in its name; rename it"
        if why:
            remarks.append(f"left out: {printable(path)} {why}")
            continue
        found.append(_described(file, path, folder.resolve().name))
    return found, remarks


def _walk(folder: Path) -> Iterator[Path]:
    """What has the ending of a record, also in folders below that are neither hidden nor such."""
    for place, folders, _ in os.walk(folder):
        folders[:] = sorted(
            name for name in folders if not name.startswith(".") and not name.endswith(".zarr")
        )
        yield from record_files(place)


def _described(file: Path, path: str, top: str) -> _File:
    parts = path.split("/")[:-1]
    spoken = [_motions(part) for part in parts]
    # The folder that is nearest to the file goes first, then its name.
    motions = next(filter(None, [*reversed(spoken), _motions(file.stem), _motions(top)]), ())
    return _File(
        path=path,
        stem=file.stem,
        motions=motions if len(motions) == 1 else MOTIONS,
        breaker="/".join(part for part, each in zip(parts, spoken, strict=True) if not each),
        date=next((each for each in moments(file.stem) if each.when), None),
        written=os.stat(file).st_mtime,
    )


def _motions(text: str) -> tuple[str, ...]:
    """The motions that a name speaks of."""
    words = set(re.findall("[a-z]+", text.lower()))
    return tuple(motion for motion, its in _WORDS.items() if words & its)


def _numbers(files: Sequence[_File]) -> tuple[list[int], str]:
    """A counter of each file, and by what they are ordered where no name says it."""
    said = numbers_in([file.stem for file in files])
    if all(isinstance(number, int) for number in said) and len(set(said)) == len(said):
        return said, ""
    dated = all(file.date for file in files)
    keys = [(file.date.when if dated else file.written, natural(file.path)) for file in files]
    order = sorted(range(len(files)), key=keys.__getitem__)
    words = "the dates in their names" if dated else "the times at which the files were written"
    return [order.index(i) + 1 for i in range(len(files))], words


def _text(rows: Sequence[tuple[str, int, str, _File]], channels: Sequence[str]) -> str:
    text = StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(_COLUMNS)
    for breaker, number, motion, file in sorted(rows, key=lambda row: row[:3]):
        date = "" if file.date is None else file.date.iso
        for channel in channels:
            known = file.path, motion, number, channel, breaker, channel, date
            table.writerow([*known, *[""] * (len(_COLUMNS) - len(known))])
    return text.getvalue()
