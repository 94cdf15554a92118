"""A first ``operations.csv`` of a folder, to be checked and completed.

What files state goes before their names. What neither tells is FILL IN, so that the table is
refused until it is completed. Light to import.
"""

import os
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from breaker.common.numerals import natural
from breaker.common.safe_text import table_text
from breaker.model.parameters import MOTIONS
from breaker.model.quantities import ABOUT
from breaker.records.file_facts import (
    Description,
    FoundFile,
    Part,
    Row,
    descriptions,
    number_cell,
    settings_cells,
    with_phases,
)
from breaker.records.file_names import numbers_in
from breaker.records.files import is_store, printable
from breaker.records.folder import record_files, why_no_record
from breaker.records.operations import FILL_IN
from breaker.records.settings import FORMAT
from breaker.records.words import motions_in

_MOST_FOLDERS = 20_000  # of a walk: a large fleet has some thousands
_LONGEST = 200  # signs of a cell
_COLUMNS = ("file", "motion", "operation", "channel", *ABOUT, "from", "to")


def propose_manifest(
    folder: str | Path,
    channels: Sequence[str] = (),
    motions: Sequence[str] = MOTIONS,
    look: Callable[[Path], Description] | None = None,
    *,
    configured: bool = False,
) -> tuple[str, list[str]]:
    """Propose the table of a folder and those below it.

    Breaker, date and settings are those that the files state, phases those of the files or else of
    their names. A file that has the content of another, or is no record, is left out. Where nothing
    is seen the motion comes from folders named after it, or else from the name; other folders are
    breakers. The counter comes from the names where they leave no doubt; else operations are
    numbered from 1, by the dates that the files state, or else by name.

    Args:
        folder: Folder of the curve files.
        channels: Columns of travel that each file has, side by side: a row for each, and each a
            phase of its own.
        motions: Which motions have rows; a file of another one is left out.
        look: Says what is seen in a file, so that it is not only its name that tells.
        configured: Whether a configuration says how the files are read: then the table does so only
            of rates and ratios in which they differ.

    Returns:
        The text of the table, and what to check in it, in words.

    Raises:
        FileNotFoundError: If there is no such folder, too many below it, or no file of a record of
            these motions.
    """
    if not os.path.isdir(folder):
        raise FileNotFoundError(
            f"there is no folder {printable(folder)!r}; name that of the curve files"
        )
    every, remarks = _files(Path(folder))
    if look:
        every, said = _looked_at(Path(folder), every, look, configured or bool(channels))
        remarks += said
    files = [file for file in every if {*file.motions} & {*motions}]
    if others := len(every) - len(files):
        remarks.append(f"left out: {others} files of another motion than {' or '.join(motions)}")
    if not files:
        raise FileNotFoundError(
            "; ".join([f"{printable(folder)} has no file of a record", *remarks])
        )
    remarks += _of_motions(files, motions)
    files = _with_breakers(files)
    for what in ("breaker", "date"):
        remarks += _to_fill_in(files, what)
    rows, said = _rows(files, motions)
    return _text(rows, channels), [*remarks, *said]


def _looked_at(
    folder: Path, files: Sequence[FoundFile], look: Callable[[Path], Description], configured: bool
) -> tuple[list[FoundFile], list[str]]:
    """Files of records with what is seen in them, and what is left out."""
    seen, remarks = descriptions(folder, [file.path for file in files], look)
    found = [_seen(file, seen[file.path], configured) for file in files if file.path in seen]
    remarks += [
        f"left out: {printable(each.path)} is no record: {each.seen.reason}"
        for each in found
        if each.seen.reason
    ]
    return [each for each in found if not each.seen.reason], remarks


def _of_motions(files: Sequence[FoundFile], motions: Sequence[str]) -> list[str]:
    """What to check of motions, where nothing says them or some are in no file."""
    if unsaid := sum(len(file.motions) > 1 and not file.seen.parts for file in files):
        return [
            f"no folder or name says the motion of {unsaid} files, so each has a row of "
            f"{' and '.join(motions)}: delete what it does not hold"
        ]
    held = [each for each in motions if any(each in file.motions for file in files)]
    lacking = " or ".join(each for each in motions if each not in held)
    said = f"no file holds {lacking}: set motions: [{', '.join(held)}] in the configuration"
    return [said] if lacking and any(file.seen.parts for file in files) else []


def _seen(file: FoundFile, seen: Description, configured: bool) -> FoundFile:
    """A file with what is seen in it: its motions go before what names say. Parts and settings are
    left out where a configuration has them, or names say the motion of what is read as it is.
    """
    said, stated = len(file.motions) == 1, seen.preamble.serial or seen.preamble.bay
    usual = {**FORMAT, **seen.settings, "sign": 1, "zero": 0.0}
    plain = usual == FORMAT and [*dict.fromkeys(p.channel for p in seen.parts)] == ["travel"]
    if not stated and (configured or (said and plain)):
        seen = seen._replace(parts=())
    if configured or plain:
        seen = seen._replace(settings={}, sure=True)
    if configured or said:  # reading says why not
        seen = seen._replace(reason="")
    held = {part.motion for part in seen.parts}
    found = tuple(motion for motion in MOTIONS if motion in held)
    return file._replace(seen=seen, motions=found or file.motions, sure=seen.sure or said)


def _with_breakers(files: Sequence[FoundFile]) -> list[FoundFile]:
    """Files with their breakers: the serial number that a file states, or else the bay, or else its
    folder; to be filled in where other files, or others of the folder, state theirs.
    """
    preambles = [file.seen.preamble for file in files]
    stated = [each.serial or " ".join(each.bay.split()) for each in preambles]
    states = {file.folder for file, name in zip(files, stated, strict=True) if name}
    unknown = FILL_IN if states else ""
    found = []
    for file, name in zip(files, stated, strict=True):
        folder = "" if file.folder in states else file.folder
        found.append(file._replace(breaker=(name or folder or unknown)[:_LONGEST]))
    return found


def _to_fill_in(files: Sequence[FoundFile], what: str) -> list[str]:
    """What to check of breakers or dates that are to be filled in."""
    why = {
        "breaker": "they do not state it, and others do",
        "date": "day and month may be either",
    }
    cells = {file.path: file.breaker if what == "breaker" else file.day for file in files}
    lacking = [path for path, cell in cells.items() if cell == FILL_IN]
    said = f"the {what} of {len(lacking)} files is to be filled in, first "
    return [f"{said}{lacking[0]}: {why[what]}"] if lacking else []


def _rows(
    files: Sequence[FoundFile], motions: Sequence[str]
) -> tuple[list[tuple[int, Row]], list[str]]:
    """Operations with their counters, and what to check of these."""
    breakers: dict[tuple[str, str], list[FoundFile]] = defaultdict(list)
    for file in files:
        unknown = file.folder if file.breaker == FILL_IN else ""
        breakers[file.breaker, unknown].append(file)
    rows, remarks = [], []
    for (breaker, _), own in sorted(breakers.items()):
        found = [row for file in with_phases(own) for row in _rows_of(file, motions)]
        numbered = _by_names(found)
        if numbered is None:
            numbered, order = _in_order(found)
            name = "" if breaker in ("", FILL_IN) else f"{breaker}: "
            remarks.append(
                f"{name}{len(found)} operations are numbered from 1 in the order of {order}, as "
                "the names do not say the counter"
            )
        rows += numbered
    return rows, remarks


def _rows_of(file: FoundFile, motions: Sequence[str]) -> Iterator[Row]:
    """The operations in a file, in each motion as many as its channels have at most."""
    for motion in motions:
        if motion in file.motions:
            counts = Counter(p.channel for p in file.seen.parts if p.motion == motion)
            for place in range(max(counts.values(), default=1)):
                yield Row(file, motion, place)


def _by_names(rows: Sequence[Row]) -> list[tuple[int, Row]] | None:
    """Operations with the counters that names say; None where they leave a doubt."""
    groups: dict[tuple[str, str], list[Row]] = defaultdict(list)
    for row in rows:
        groups[row.motion, row.phase].append(row)
    found = []
    for group in groups.values():
        numbers = numbers_in([row.file.stem for row in group])
        if len({*numbers}) < len(numbers) or not all(isinstance(each, int) for each in numbers):
            return None
        found += zip(numbers, group, strict=True)
    return found


def _in_order(rows: Sequence[Row]) -> tuple[list[tuple[int, Row]], str]:
    """Operations with counters from 1, and by what they are in order.

    Files of one pole each are poles of the same operations. The first operations of a day, in any
    motion and pole, are those after the last of the day before.
    """
    dated = all(row.file.day not in ("", FILL_IN) for row in rows)
    days = [row.file.day if dated else "" for row in rows]
    pairs = zip(days, rows, strict=True)
    found, counts, before, last = [], {}, 0, ""
    for day, row in sorted(
        pairs, key=lambda pair: (pair[0], natural(pair[1].file.path), pair[1].place)
    ):
        if day[:10] != last:
            before, last = before + max(counts.values(), default=0), day[:10]
            counts = {}
        # Poles without a name have one operation each.
        poles = {p.phase if p.phase != FILL_IN else row.file.path for p in row.parts} or {""}
        number = 1 + max(counts.get((row.motion, pole), 0) for pole in poles)
        counts |= {(row.motion, pole): number for pole in poles}
        found.append((before + number, row))
    return found, "the dates that they state" if dated else "their names"


def _files(folder: Path) -> tuple[list[FoundFile], list[str]]:
    """The files of records in a folder and those below it, and what was left out."""
    found, remarks = [], []
    for file in _walk(folder):
        path = file.relative_to(folder).as_posix()
        if why := why_no_record(file):
            remarks.append(f"left out: {printable(path)} {why}")
        else:
            found.append(_described(file, path, folder.resolve().name))
    return found, remarks


def _walk(folder: Path) -> Iterator[Path]:
    """What has the ending of a record, also in folders below that are neither hidden nor such.

    Raises:
        FileNotFoundError: If there are more than ``_MOST_FOLDERS`` of these.
    """
    for count, (place, folders, _) in enumerate(os.walk(folder)):
        if count > _MOST_FOLDERS:
            raise FileNotFoundError(
                f"{printable(folder)} has more than {_MOST_FOLDERS:,} folders, which no collection "
                "of curve files needs; name the folder of the curve files"
            )
        folders[:] = sorted(
            name for name in folders if not name.startswith(".") and not is_store(name)
        )
        yield from record_files(place)


def _described(file: Path, path: str, top: str) -> FoundFile:
    parts = path.split("/")[:-1]
    spoken = [motions_in(part) for part in parts]
    # The folder that is nearest to the file goes first, then its name.
    motions = next(filter(None, [*reversed(spoken), motions_in(file.stem), motions_in(top)]), ())
    return FoundFile(
        path=path,
        stem=file.stem,
        motions=motions if len(motions) == 1 else MOTIONS,
        folder="/".join(part for part, each in zip(parts, spoken, strict=True) if not each),
    )


def _text(rows: Sequence[tuple[int, Row]], channels: Sequence[str]) -> str:
    """The table; with settings where files differ from the usual, and columns beside travels."""
    seen = [row.file.seen for _, row in rows]
    settings = settings_cells([row.file for _, row in rows], FORMAT)
    rates = {_rate(each) for each in seen if not each.timed} - {""}
    ratios = {part.ratio for each in seen for part in each.parts if part.ratio > 0}
    own = {key for cells in settings.values() for key in cells}
    own |= {"rate"} if len(rates) > 1 or FILL_IN in rates or "time_column" in own else set()
    own |= {"ratio"} if len(ratios) > 1 else set()
    own |= {key for each in seen for part in each.parts for key in part.beside}
    columns, table = [*_COLUMNS, *(key for key in FORMAT if key in own)], []
    for number, row in sorted(
        rows, key=lambda each: (each[1].file.breaker, each[0], each[1].motion)
    ):
        file = row.file
        known = {"file": file.path, "motion": row.motion, "operation": number}
        known |= {"breaker": file.breaker, "date": file.day, **settings[file.path]}
        known |= {} if file.seen.timed else {"rate": _rate(file.seen)}
        known |= {} if file.sure else {"motion": FILL_IN, "sign": FILL_IN}
        parts = [{"channel": channel, "phase": channel} for channel in channels] or [
            {"channel": part.channel, "phase": part.phase, **_ends(file, part)}
            | ({"ratio": number_cell(part.ratio)} if part.ratio > 0 else {})
            | part.beside
            for part in row.parts
        ]
        for part in parts or [{}]:
            table.append(known | part)
    return table_text(columns, table)


def _ends(file: FoundFile, part: Part) -> dict[str, str]:
    """Where in its record a motion is; to be filled in where several are, at an unknown rate."""
    same = [p for p in file.seen.parts if (p.motion, p.channel) == (part.motion, part.channel)]
    lacking = file.seen.lacks_rate and len(same) > 1
    ends = {"from": part.begin, "to": part.end}
    return {key: FILL_IN if lacking else number_cell(at) for key, at in ends.items()}


def _rate(seen: Description) -> str:
    """The rate of a file, as a cell: what it does not tell must not be that of the settings."""
    return FILL_IN if seen.lacks_rate else number_cell(seen.rate)
