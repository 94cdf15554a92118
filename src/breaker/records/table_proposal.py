"""A first ``operations.csv`` of a folder, to be checked and completed.

What files state goes before their names. What neither states is FILL IN, so that the table is
refused until it is completed. Light to import.
"""

import math
import os
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from breaker.common.numerals import natural
from breaker.common.safe_text import table_text
from breaker.model.parameters import MOTIONS
from breaker.model.quantities import ABOUT
from breaker.records.dates import dates_of, day_order, in_order, name_dates
from breaker.records.file_names import numbers_in, phases_in_names
from breaker.records.files import MOST_PARTS, is_store, printable
from breaker.records.folder import record_files, why_no_record
from breaker.records.header import Header
from breaker.records.lexicon import WORDS
from breaker.records.operations import FILL_IN, LONGEST
from breaker.records.settings import FORMAT
from breaker.records.words import by_words, motions_in

_meant = by_words(WORDS["stated"])
_COLUMNS = ("file", "motion", "operation", "channel", *ABOUT, "from", "to")


class Part(NamedTuple):
    """A motion of a channel that is seen in a file.

    Attributes:
        motion: "closing" or "opening".
        channel: Column of the travel.
        phase: Its phase, empty if nothing states it.
        begin, end: Part of the record that contains the motion, ms; NaN for its beginning and end.
        ratio: Stated mm for one unit of the reading; NaN where that is a length, or none is stated.
        beside: Columns that go with it, by ``contact_column``, ``trigger_column`` and
            ``motor_column``.
    """

    motion: str
    channel: str
    phase: str
    begin: float
    end: float
    ratio: float
    beside: Mapping[str, str | int] = MappingProxyType({})


class Description(NamedTuple):
    """What is seen in a file.

    Attributes:
        preamble: Header of the file.
        parts: Motions in the file.
        rate: kHz, by the times of its samples or as stated; NaN where it is doubtful or not stated,
            None where nothing is seen.
        timed: Whether it has the times of its samples.
        settings: Of ``endurance.format``, as far as the file shows how it is read; FILL IN for
            others.
        sure: Whether it is certain which of its motions close.
        reason: Why it is not a record; empty if it may be one.
        samples: Digest of the samples of its travels, the same in copies; empty where not known.
    """

    preamble: Header = Header()
    parts: tuple[Part, ...] = ()
    rate: float | None = None
    timed: bool = False
    settings: Mapping[str, Any] = MappingProxyType({})
    sure: bool = True
    reason: str = ""
    samples: str = ""

    @property
    def rate_cell(self) -> str:
        """The rate as a cell; one that is not stated must not be that of the settings."""
        return FILL_IN if self.rate is not None and math.isnan(self.rate) else _cell(self.rate)


class _File(NamedTuple):
    """A file of records.

    Attributes:
        path: From the folder of the table, with / between its parts.
        motions: Motions that are seen, or else stated by its folders or its name; both if unknown.
        folder: Its other folders.
        seen: What is seen in it.
        breaker, date: Cells of the table.
        sure: Whether it is certain which of its motions close.
    """

    path: str
    motions: tuple[str, ...]
    folder: str
    seen: Description = Description()
    breaker: str = ""
    date: str = ""
    sure: bool = True

    @property
    def stem(self) -> str:
        """Name without ending."""
        return Path(self.path).stem


class _Row(NamedTuple):
    """An operation of one motion: its file, and which of the motions of that kind in the file."""

    file: _File
    motion: str
    place: int

    @property
    def parts(self) -> list[Part]:
        """That motion in each channel, where it is seen."""
        own = [part for part in self.file.seen.parts if part.motion == self.motion]
        channels = dict.fromkeys(part.channel for part in own)
        of_each = ([part for part in own if part.channel == channel] for channel in channels)
        return [parts[self.place] for parts in of_each if len(parts) > self.place]


def propose_manifest(
    folder: str | Path,
    channels: Sequence[str] = (),
    motions: Sequence[str] = MOTIONS,
    look: Callable[[Path], Description] | None = None,
    *,
    configured: bool = False,
) -> tuple[str, list[str]]:
    """Propose the table of a folder and those below it.

    A copy of another file, and a file that is not a record, are left out. Breaker and settings are
    those that the files state, phases and dates those of the files or else of their names. A motion
    that is not seen comes from a folder that is named after it, or else from the name; other
    folders are breakers. The counter comes from the names where they leave no doubt; else
    operations are numbered from 1, by their dates, or else by name.

    Args:
        folder: Folder of the curve files.
        channels: Columns of travel that each file has, side by side: a row for each, and each a
            phase of its own.
        motions: Which motions have rows; a file of another one is left out.
        look: Describes a file, so that not only its name counts.
        configured: Whether a configuration states how the files are read: then the table does so
            only of rates and ratios in which they differ.

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
        every = [_seen(e, look(Path(folder, e.path)), configured or bool(channels)) for e in every]
        every = _records(every, remarks)
    files = [file for file in every if {*file.motions} & {*motions}]
    if others := len(every) - len(files):
        remarks.append(f"left out: {others} files of another motion than {' or '.join(motions)}")
    if not files:
        raise FileNotFoundError(
            "; ".join([f"{printable(folder)} has no file of a record", *remarks])
        )
    _check_motions(files, motions, remarks)
    files = _with_dates(_with_breakers(files, remarks), remarks)
    return _text(_numbered(files, motions, remarks), channels), remarks


# ---- files ---------------------------------------------------------------------------------------


def _files(folder: Path) -> tuple[list[_File], list[str]]:
    """Return the files in a folder and below that may be records, and what was left out."""
    found, remarks = [], []
    top = motions_in(folder.resolve().name)
    for count, (place, folders, _) in enumerate(os.walk(folder)):
        if count > MOST_PARTS:
            raise FileNotFoundError(
                f"{printable(folder)} has more than {MOST_PARTS:,} folders, which no collection "
                "of curve files needs; name the folder of the curve files"
            )
        folders[:] = sorted(
            name for name in folders if not name.startswith(".") and not is_store(name)
        )
        for file in record_files(place):
            path = file.relative_to(folder).as_posix()
            if why := why_no_record(file):
                remarks.append(f"left out: {printable(path)} {why}")
                continue
            parts = path.split("/")[:-1]
            spoken = [motions_in(part) for part in parts]
            # The folder that is nearest to the file goes first, then its name.
            motions = next(filter(None, [*reversed(spoken), motions_in(file.stem), top]), ())
            other = "/".join(p for p, stated in zip(parts, spoken, strict=True) if not stated)
            found.append(_File(path, motions if len(motions) == 1 else MOTIONS, other))
    return found, remarks


def _seen(file: _File, seen: Description, configured: bool) -> _File:
    """Return a file with what is seen in it: its motions go before those of names. Parts and
    settings are left out where a configuration has them, or names state the motion of a file that
    is read with the defaults.
    """
    named, stated = len(file.motions) == 1, seen.preamble.serial or seen.preamble.bay
    usual = {**FORMAT, **seen.settings, "sign": 1, "zero": 0.0}
    plain = usual == FORMAT and [*dict.fromkeys(p.channel for p in seen.parts)] == ["travel"]
    if not stated and (configured or (named and plain)):
        seen = seen._replace(parts=())
    if configured or plain:
        seen = seen._replace(settings={}, sure=True)
    if configured or named:  # reading shows why not
        seen = seen._replace(reason="")
    found = tuple(motion for motion in MOTIONS if motion in {part.motion for part in seen.parts})
    return file._replace(seen=seen, motions=found or file.motions, sure=seen.sure or named)


def _records(files: Sequence[_File], remarks: list[str]) -> list[_File]:
    """Return the files that are records, each once: of files with equal samples the first by name;
    all, with a remark, where they state different breakers, dates or phases.
    """
    first: dict[str, _File] = {}
    kept = set()
    for file in sorted(files, key=lambda file: natural(file.path)):
        other = first.setdefault(file.seen.samples, file) if file.seen.samples else file
        if file.seen.reason:
            remarks.append(f"left out: {printable(file.path)} is no record: {file.seen.reason}")
        elif other is file:
            kept.add(file.path)
        elif all(a == b for a, b in zip(_stated(file), _stated(other), strict=True) if a and b):
            remarks.append(f"left out: {file.path} has the samples of {other.path}")
        else:
            kept.add(file.path)
            remarks.append(
                f"{file.path} has the samples of {other.path}, but states another breaker, date or "
                "phase: leave out the one that is a copy"
            )
    found = [file for file in files if file.path in kept]
    lacking = [file for file in found if file.seen.rate_cell == FILL_IN]
    whys = [file.seen.preamble.rate_doubt or "not stated" for file in lacking[:1]]
    remarks += _to_fill_in("rate", lacking, *whys)
    return found


def _to_fill_in(what: str, files: Sequence[_File], why: str = "") -> list[str]:
    """Return a remark on files in which something is to be filled in, if there are any."""
    first = f"the {what} of {len(files)} files is to be filled in, first "
    return [f"{first}{files[0].path}: {why}"] if files else []


def _stated(file: _File) -> tuple:
    """Return what a file states that may differ between records with equal samples."""
    stated = file.seen.preamble
    phases = {part.phase for part in file.seen.parts} - {""}
    return stated.serial, stated.bay, stated.dates, phases


def _check_motions(files: Sequence[_File], motions: Sequence[str], remarks: list[str]) -> None:
    """Remark where nothing states the motion of files, or some motions are in no file."""
    unsaid = sum(len(file.motions) > 1 and not file.seen.parts for file in files)
    held = [motion for motion in motions if any(motion in file.motions for file in files)]
    if unsaid:
        remarks.append(
            f"no folder or name states the motion of {unsaid} files, so each has a row of "
            f"{' and '.join(motions)}: delete what it does not contain"
        )
    elif len(held) < len(motions) and any(file.seen.parts for file in files):
        lacking = " or ".join(motion for motion in motions if motion not in held)
        remarks.append(
            f"no file contains {lacking}: set motions: [{', '.join(held)}] in the configuration"
        )


def _with_breakers(files: Sequence[_File], remarks: list[str]) -> list[_File]:
    """Return files with their breakers: the serial number that a file states, or else the bay, or
    else its folder; to be filled in where other files, or others of the folder, state theirs.
    """
    stated = [f.seen.preamble.serial or " ".join(f.seen.preamble.bay.split()) for f in files]
    states = {file.folder for file, name in zip(files, stated, strict=True) if name}
    found = []
    for file, name in zip(files, stated, strict=True):
        other = FILL_IN if states and (file.folder in states or not file.folder) else file.folder
        found.append(file._replace(breaker=(name or other)[:LONGEST]))
    lacking = [file for file in found if file.breaker == FILL_IN]
    remarks += _to_fill_in("breaker", lacking, "they do not state it, and others do")
    return found


def _with_dates(files: Sequence[_File], remarks: list[str]) -> list[_File]:
    """Return files with their dates: that of the header, or else that of the name. Others of the
    same kind decide where the day and the month may be either; else the date is to be filled in.
    """
    pairs = [pair for file in files for pair in file.seen.preamble.pairs]
    order = day_order(dates_of(pair.text) for pair in pairs if "date" in _meant(pair.name))
    in_names = [name_dates(file.stem) for file in files]
    order_of_names = day_order(in_names)
    found, decided = [], []
    for file, named in zip(files, in_names, strict=True):
        stated = file.seen.preamble.dates
        readings = dict(zip((True, False), stated * (3 - len(stated)), strict=False)) or named
        days = in_order(readings, order if stated else order_of_names)
        decided += [file.path] if len({*readings.values()}) > len(days) else []
        found.append(file._replace(date=FILL_IN if len(days) > 1 else "".join(days)))
    lacking = [file for file in found if file.date == FILL_IN]
    remarks += _to_fill_in("date", lacking, "day and month may be either")
    if decided:
        remarks.append(
            f"day and month of {len(decided)} files, first {decided[0]}, are in the order of "
            "another file, in which only one order is possible"
        )
    return found


def _with_phases(files: Sequence[_File]) -> list[_File]:
    """Return the files of a breaker with the phases in their names, and FILL IN where several
    channels of one file have none of their own.
    """
    phases = [{part.channel: part.phase for part in file.seen.parts} for file in files]
    pairs = list(zip(files, phases, strict=True))
    in_names = phases_in_names([Path(f.path) for f, own in pairs if [*own.values()] == [""]])
    found = []
    for file, own in pairs:
        several = [*own.values()]
        if len(own) == 1:
            named = in_names.get(Path(file.path), "")
            own = {channel: phase or named for channel, phase in own.items()}
        else:
            own = {c: p if p and several.count(p) == 1 else FILL_IN for c, p in own.items()}
        parts = tuple(part._replace(phase=own[part.channel]) for part in file.seen.parts)
        found.append(file._replace(seen=file.seen._replace(parts=parts)))
    return found


# ---- operations ----------------------------------------------------------------------------------


def _numbered(
    files: Sequence[_File], motions: Sequence[str], remarks: list[str]
) -> list[tuple[int, _Row]]:
    """Return operations with their counters, breaker by breaker."""
    breakers: dict[tuple[str, str], list[_File]] = defaultdict(list)
    for file in files:
        unknown = file.folder if file.breaker == FILL_IN else ""
        breakers[file.breaker, unknown].append(file)
    found = []
    for (breaker, _), own in sorted(breakers.items()):
        rows = [row for file in _with_phases(own) for row in _rows_of(file, motions)]
        numbered = _by_names(rows)
        if numbered is None:
            numbered, order = _in_order(rows)
            name = "" if breaker in ("", FILL_IN) else f"{breaker}: "
            remarks.append(
                f"{name}{len(rows)} operations are numbered from 1 in the order of {order}, as "
                "the names do not state the counter"
            )
        found += numbered
    return sorted(found, key=lambda pair: (pair[1].file.breaker, pair[0], pair[1].motion))


def _rows_of(file: _File, motions: Sequence[str]) -> Iterator[_Row]:
    """Yield the operations in a file, in each motion as many as its channels have at most."""
    for motion in motions:
        if motion in file.motions:
            counts = Counter(p.channel for p in file.seen.parts if p.motion == motion)
            for place in range(max(counts.values(), default=1)):
                yield _Row(file, motion, place)


def _by_names(rows: Sequence[_Row]) -> list[tuple[int, _Row]] | None:
    """Return operations with the counters in the names; None where they leave a doubt."""
    groups: dict[tuple[str, str], list[_Row]] = defaultdict(list)
    for row in rows:
        phases = [part.phase for part in row.parts]
        groups[row.motion, phases[0] if len(phases) == 1 else ""].append(row)
    found = []
    for group in groups.values():
        numbers = numbers_in([row.file.stem for row in group])
        if len({*numbers}) < len(numbers) or not all(isinstance(each, int) for each in numbers):
            return None
        found += zip(numbers, group, strict=True)
    return found


def _in_order(rows: Sequence[_Row]) -> tuple[list[tuple[int, _Row]], str]:
    """Return operations with counters from 1, and by what they are in order.

    Files of one pole each are poles of the same operations. The first operations of a day, in any
    motion and pole, are those after the last of the day before.
    """
    dated = all(row.file.date not in ("", FILL_IN) for row in rows)
    keys = [(row.file.date if dated else "", natural(row.file.path), row.place) for row in rows]
    found, counts, before, last = [], {}, 0, ""
    for (day, *_), row in sorted(zip(keys, rows, strict=True), key=lambda pair: pair[0]):
        if day[:10] != last:
            before, last = before + max(counts.values(), default=0), day[:10]
            counts = {}
        # Poles without a name have one operation each.
        poles = {p.phase if p.phase != FILL_IN else row.file.path for p in row.parts} or {""}
        number = 1 + max(counts.get((row.motion, pole), 0) for pole in poles)
        counts |= {(row.motion, pole): number for pole in poles}
        found.append((before + number, row))
    return found, "their dates" if dated else "their names"


# ---- cells ---------------------------------------------------------------------------------------


def _text(rows: Sequence[tuple[int, _Row]], channels: Sequence[str]) -> str:
    """Return the table: with settings where files differ from the defaults, and columns that go
    with the travel.
    """
    seen = {row.file.path: row.file.seen for _, row in rows}
    settings = {path: {**FORMAT, **each.settings} for path, each in seen.items()}
    own = {key for key in FORMAT if any(each[key] != FORMAT[key] for each in settings.values())}
    rates = {each.rate_cell for each in seen.values() if not each.timed} - {""}
    ratios = {part.ratio for each in seen.values() for part in each.parts if part.ratio > 0}
    shown = own | ({"ratio"} if len(ratios) > 1 else set())
    shown |= {"rate"} if len(rates) > 1 or FILL_IN in rates or "time_column" in own else set()
    shown |= {key for each in seen.values() for part in each.parts for key in part.beside}
    table = []
    for number, row in rows:
        file = row.file
        cells = {"file": file.path, "motion": row.motion, "operation": number}
        cells |= {"breaker": file.breaker, "date": file.date}
        if file.seen.settings:
            cells |= {key: _cell(settings[file.path][key], key) for key in own}
        cells |= {} if file.seen.timed else {"rate": file.seen.rate_cell}
        cells |= {} if file.sure else {"motion": FILL_IN, "sign": FILL_IN}
        parts = [{"channel": channel, "phase": channel} for channel in channels]
        parts = parts or [_part_cells(file, part) for part in row.parts] or [{}]
        table += [cells | part for part in parts]
    return table_text([*_COLUMNS, *(key for key in FORMAT if key in shown)], table)


def _part_cells(file: _File, part: Part) -> dict[str, Any]:
    """Return the cells of a motion; where it is, is to be filled in where several are, at an
    unknown rate.
    """
    alike = [p for p in file.seen.parts if (p.motion, p.channel) == (part.motion, part.channel)]
    lacking = file.seen.rate_cell == FILL_IN and len(alike) > 1
    ends = {"from": part.begin, "to": part.end}
    cells = {key: FILL_IN if lacking else _cell(at) for key, at in ends.items()}
    cells |= {"channel": part.channel, "phase": part.phase, **part.beside}
    return cells | ({"ratio": _cell(part.ratio)} if part.ratio > 0 else {})


def _cell(value: object, key: str = "") -> str:
    """Return the cell of a setting or a number; empty if it is not known, as None or NaN."""
    if value is None or value != value:
        return "none" if key == "time_column" else ""
    if isinstance(value, float):
        return f"{value:.6g}"
    return {"\t": "tab", " ": "blank"}.get(str(value), str(value))
