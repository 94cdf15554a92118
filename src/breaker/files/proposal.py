"""A first ``operations.csv`` of a folder, to be checked and completed: the only place that guesses.

Light to import.
"""

import math
import os
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from breaker.files.dates import earlier
from breaker.files.described import Description, Part, descriptions
from breaker.files.guards import no_file, printable
from breaker.files.listing import odd_signs, record_files
from breaker.files.manifest import ABOUT, FILL_IN
from breaker.files.motions import motions_in
from breaker.files.naming import Moment, moments, natural, numbers_in
from breaker.files.outgoing import table_text
from breaker.mechanism import MOTIONS

_COLUMNS = ("file", "motion", "operation", "channel", *ABOUT, "from", "to")
_LONGEST = 200  # signs of a cell


class _File(NamedTuple):
    """A file of records.

    Attributes:
        path: From the folder of the table, with / between its parts.
        stem: Name without ending.
        motions: The one that its folders, or else its name, say it holds; both if none does.
        folder: Its other folders.
        date: The first one in its name, None without one.
        written: When the file was written, s.
        seen: What is seen in it.
    """

    path: str
    stem: str
    motions: tuple[str, ...]
    folder: str
    date: Moment | None
    written: float
    seen: Description = Description()

    def described(self, seen: Description) -> "_File":
        """The same with what is seen in the file, whose motions go before what names say."""
        held = {part.motion for part in seen.parts}
        motions = tuple(motion for motion in MOTIONS if motion in held)
        return self._replace(seen=seen, motions=motions or self.motions)

    @property
    def breaker(self) -> str:
        """Serial number, or else bay, as stated, or else its folders."""
        stated = self.seen.preamble
        return (stated.serial or stated.bay or self.folder)[:_LONGEST]

    @property
    def day(self) -> str:
        """Date of the test as stated, or else that in the name; empty where there is none."""
        named = "" if self.date is None else self.date.iso
        return named if not self.seen.preamble.dates else self.seen.preamble.date


class _Row(NamedTuple):
    """An operation of one motion: its file, and which of the motions of that kind in there."""

    file: _File
    motion: str
    place: int

    @property
    def parts(self) -> list[Part]:
        """That motion in each channel, where it is seen."""
        own = [part for part in self.file.seen.parts if part.motion == self.motion]
        channels = dict.fromkeys(part.channel for part in own)
        each = ([part for part in own if part.channel == channel] for channel in channels)
        return [of[self.place] for of in each if len(of) > self.place]

    @property
    def phase(self) -> str:
        """Phase of its only channel; empty where there are several, or none is stated."""
        phases = [part.phase for part in self.parts]
        return phases[0] if len(phases) == 1 else ""


def propose_manifest(
    folder: str | Path,
    channels: Sequence[str] = (),
    motions: Sequence[str] = MOTIONS,
    look: Callable[[Path], Description] | None = None,
) -> tuple[str, list[str]]:
    """Propose the table of a folder and those below it.

    Breaker, phases and date are those that the files state; a file that has the content of another
    is left out. Else the motion comes from folders named after it, or else from the name; other
    folders are breakers. The counter comes from the names where they leave no doubt; else
    operations are numbered from 1, by their dates, or else by the times at which the files were
    written.

    Args:
        folder: Folder of the curve files.
        channels: Columns of travel that each file has, side by side: a row for each, and each a
            phase of its own.
        motions: Which motions have rows; a file of another one is left out.
        look: Says what is seen in a file, so that it is not only its name that tells.

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
    if look:
        seen, said = descriptions(Path(folder), [file.path for file in every], look)
        every = [file.described(seen[file.path]) for file in every if file.path in seen]
        remarks += said
    files = [file for file in every if {*file.motions} & {*motions}]
    if others := len(every) - len(files):
        remarks.append(f"left out: {others} files of another motion than {' or '.join(motions)}")
    if not files:
        raise FileNotFoundError(
            "; ".join([f"{printable(folder)} has no file of a record", *remarks])
        )
    if unsaid := sum(len(file.motions) > 1 and not file.seen.parts for file in files):
        remarks.append(
            f"no folder or name says the motion of {unsaid} files, so each has a row of "
            f"{' and '.join(motions)}: delete what it does not hold"
        )
    if any(file.date and file.day == file.date.iso for file in files):
        remarks.append("dates are from the names, the day before the month where both can be")
    rows, said = _rows(files, motions)
    return _text(rows, channels), remarks + said


def _rows(
    files: Sequence[_File], motions: Sequence[str]
) -> tuple[list[tuple[int, _Row]], list[str]]:
    """Operations with their counters, and by what they are ordered where no name says these."""
    whole: dict[tuple[str, str], list[_Row]] = {}
    for file in files:
        for motion in {*file.motions} & {*motions}:
            per_channel = Counter(p.channel for p in file.seen.parts if p.motion == motion)
            for place in range(max(per_channel.values(), default=1)):
                whole.setdefault((file.breaker, motion), []).append(_Row(file, motion, place))
    groups: dict[tuple[str, str, str], list[_Row]] = {}
    for key, every in whole.items():  # files of one pole each are poles of the same operations
        poles = all(row.phase for row in every)
        for row in every:
            groups.setdefault((*key, row.phase if poles else ""), []).append(row)
    rows, remarks = [], []
    for (breaker, motion, _), group in sorted(groups.items()):
        numbers, order = _numbers(group)
        if order:
            remarks.append(
                f"{breaker} {motion}".strip() + f": {len(group)} operations are numbered from 1 in "
                f"the order of {order}, as the names do not say the counter"
            )
        remarks += _falling(dict(sorted(zip(numbers, group, strict=True))))
        rows += zip(numbers, group, strict=True)
    return rows, remarks


def _falling(rows: Mapping[int, _Row]) -> list[str]:
    """Say where the dates of files fall while the numbers in their names rise."""
    for (first, one), (second, other) in pairwise(rows.items()):
        if earlier(one.file.day, other.file.day):
            return [
                f"the date of {other.file.path}, operation {second}, {other.file.day}, is earlier "
                f"than that of operation {first}, {one.file.day}: mend the numbers or the dates; "
                "the table is refused as it is"
            ]
    return []


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
    spoken = [motions_in(part) for part in parts]
    # The folder that is nearest to the file goes first, then its name.
    motions = next(filter(None, [*reversed(spoken), motions_in(file.stem), motions_in(top)]), ())
    return _File(
        path=path,
        stem=file.stem,
        motions=motions if len(motions) == 1 else MOTIONS,
        folder="/".join(part for part, each in zip(parts, spoken, strict=True) if not each),
        date=next((each for each in moments(file.stem) if each.when), None),
        written=os.stat(file).st_mtime,
    )


def _numbers(rows: Sequence[_Row]) -> tuple[list[int], str]:
    """A counter of each operation, and by what they are ordered where no name says it."""
    files = [row.file for row in rows]
    said = numbers_in([file.stem for file in files])
    if all(isinstance(number, int) for number in said) and len(set(said)) == len(said):
        return said, ""
    dated, stated = all(file.day for file in files), all(f.seen.preamble.date for f in files)
    keys = [
        (row.file.day if dated else row.file.written, natural(row.file.path), row.place)
        for row in rows
    ]
    order = sorted(range(len(rows)), key=keys.__getitem__)
    words = "the times at which the files were written"
    if dated:
        words = "the dates that they state" if stated else "the dates in their names"
    return [order.index(i) + 1 for i in range(len(rows))], words


def _text(rows: Sequence[tuple[int, _Row]], channels: Sequence[str]) -> str:
    """The table; with rates and ratios where files differ in them, and columns beside travels."""
    files = [row.file.seen for _, row in rows]
    rates = {_rate(seen) for seen in files if not seen.timed} - {""}
    ratios = {part.ratio for seen in files for part in seen.parts if part.ratio > 0}
    own = ["rate"] if len(rates) > 1 or FILL_IN in rates else []
    own += ["ratio"] if len(ratios) > 1 else []
    beside = {key for seen in files for part in seen.parts for key in part.beside}
    own += sorted(beside)
    table = []
    for number, row in sorted(
        rows, key=lambda each: (each[1].file.breaker, each[0], each[1].motion)
    ):
        file = row.file
        known = {"file": file.path, "motion": row.motion, "operation": number}
        known |= {"breaker": file.breaker, "date": file.day, "rate": _rate(file.seen)}
        parts = [{"channel": channel, "phase": channel} for channel in channels] or [
            {"channel": part.channel, "phase": part.phase, "from": _cell(part.begin)}
            | {"to": _cell(part.end), "ratio": _cell(part.ratio), **part.beside}
            for part in row.parts
        ]
        for part in parts or [{}]:
            table.append(known | part)
    return table_text([*_COLUMNS, *own], table)


def _rate(seen: Description) -> str:
    """The rate of a file, as a cell: what it does not tell must not be that of the settings."""
    return FILL_IN if seen.lacks_rate else _cell(math.nan if seen.rate is None else seen.rate)


def _cell(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.6g}"
