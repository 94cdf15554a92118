"""Records of one drive in the files and folders that a user names.

In a folder with a table ``operations.csv`` the rows are the operations. In a folder with subfolders
``closing`` and ``opening`` the names of the files number them. Any other file may have one motion
or both, and each of them several times.
"""

import os
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits, natural
from breaker.common.text import usual_spelling
from breaker.diagnosis.estimate import DriveRecord
from breaker.diagnosis.words import say
from breaker.family.inputs import normalise_record
from breaker.model.parameters import MOTIONS
from breaker.records.dates import one_date
from breaker.records.description import travel_channels
from breaker.records.file_names import phases_in_names
from breaker.records.files import Files, Opened, printable
from breaker.records.folder import each_line, is_folder, list_fleet, list_operations, record_files
from breaker.records.formats.registry import stated_in
from breaker.records.header import Header
from breaker.records.operations import MANIFEST, Operation
from breaker.records.reader import Reader, separate_motions
from breaker.records.record import Record
from breaker.records.rejections import OtherMotionError
from breaker.records.words import channel_of, phase_in

ANY = ""
"""Key of operations whose files may have any motion."""

Operations = Mapping[str, Sequence[Operation]]
"""Operations by motion, and those of any motion by ``ANY``."""


class Choice(NamedTuple):
    """Records of the drive among those in files and folders.

    Attributes:
        motion: The only motion; both if it is empty.
        channels: Columns of travel; without them the configured one, or all that move (``every``).
        breaker, phase: Names in the table of a folder; a phase also as a file states it.
        every: Whether to take all channels and all phases.
    """

    motion: str = ""
    channels: Sequence[str] = ()
    breaker: str | None = None
    phase: str | None = None
    every: bool = False

    @property
    def motions(self) -> Sequence[str]:
        """Motions to read."""
        return [self.motion] if self.motion else MOTIONS


def list_named(
    named: Iterable[str | Path], endurance: Mapping, choice: Choice, files: Files
) -> dict[str, list[Operation]]:
    """Return the operations in files and folders, by motion; ``endurance`` is the section.

    Raises:
        FileNotFoundError: If a folder has no file of a record.
        ValueError: If a table is wrong or has several drives, or a choice cannot be made.
    """
    listed: dict[str, list[Operation]] = {motion: [] for motion in choice.motions}
    loose: list[Path] = []
    for place in map(Path, named):
        if not is_folder(place):
            loose.append(place)
        elif any(os.path.lexists(place / name) for name in (MANIFEST, *MOTIONS)):
            for motion, some in _in_folder(place, endurance, choice).items():
                listed[motion] += some
        elif inside := record_files(place):
            loose += inside
        else:
            raise FileNotFoundError(say("no-records", folder=printable(place), table=MANIFEST))
    rows = [row for some in listed.values() for row in some]
    if len(names := sorted({row.breaker for row in rows} - {""})) > 1:
        raise ValueError(say("several-breakers", names=", ".join(names)))
    if loose and choice.breaker:
        raise ValueError(say("breaker-without-table", file=printable(loose[0]), table=MANIFEST))
    last = max((row.number for row in rows), default=0)
    return {**listed, ANY: _in_files(each_once(loose), endurance["format"], choice, files, last)}


def _in_folder(folder: Path, endurance: Mapping, choice: Choice) -> dict[str, list[Operation]]:
    """Return the operations of a folder that states their motions."""
    if choice.every and (folder / MANIFEST).exists():
        rows = [row for some in list_fleet(folder).values() for row in some]
        return {motion: [each for of, each in rows if of == motion] for motion in choice.motions}
    chosen = {name: getattr(choice, name) or endurance[name] for name in ("breaker", "phase")}
    chosen, channels = ({}, ()) if choice.every else (chosen, choice.channels[:1])
    found, lacking = {}, []
    for motion in choice.motions:
        try:
            some = list_operations(folder, motion, **chosen)
        except FileNotFoundError as error:
            lacking.append(error)
            continue
        if channels and any(each.channel for each in some):
            raise ValueError(say("channel-of-table"))
        found[motion] = [replace(each, channel=each.channel or "".join(channels)) for each in some]
    if not found:
        raise lacking[0]
    return found


def _in_files(
    paths: Sequence[Path], form: Mapping, choice: Choice, files: Files, last: int
) -> list[Operation]:
    """Return the operations in files that state no motion, numbered from the last one on."""
    in_names, channels, poles = phases_in_names(paths), {}, {}
    for path in paths:
        phases = _channels(files[path], form, choice)
        if len(phases) == 1 and path in in_names:
            phases = {channel: phase or in_names[path] for channel, phase in phases.items()}
        day = one_date("", stated_in(files[path], form, next(iter(phases))).dates, path)[:10]
        sure = all(phase not in ("", channel) for channel, phase in phases.items())
        poles[path] = [*phases.values()] if sure else [], day
        channels |= {(path, channel): phase for channel, phase in phases.items()}
    wanted = {k: v for k, v in channels.items() if choice.phase in (None, v)}
    if channels and not wanted:
        known = ", ".join(sorted({*channels.values()} - {""})) or "none"
        raise ValueError(say("phase-not-there", phase=choice.phase, known=known))
    numbers = number_poles(poles)
    return each_line(
        Operation(last + numbers[path], path, channel, phase=phase)
        for (path, channel), phase in wanted.items()
    )


def _channels(file: Opened, form: Mapping, choice: Choice) -> dict[str, str]:
    """Return the phase of each column of travel that counts; "" where none is stated.

    Where all channels count and there are several, one without a phase is called by its column.
    """
    usual, moving = form["travel_column"], {}
    if not (choice.every or choice.phase):
        channel = "".join(choice.channels[:1])
        return {channel: stated_phase(stated_in(file, form, channel), channel or usual)}
    with suppress(ValueError):  # read as configured, or rejected with the reason
        moving = {column: name for column, (name, _) in travel_channels(file, usual).items()}
    names = {each: moving.get(each, each) for each in choice.channels or moving or [""]}
    return {key: "" if len(names) == 1 and name == key else name for key, name in names.items()}


def stated_phase(stated: Header, column: str | int) -> str:
    """Return the phase of a column of travel by its name or the text above the samples, or ""."""
    place, phases = channel_of(str(column)), stated.phases
    return phase_in(str(column)) or phases.get(place, phases.get(0, ""))


def stated_types(operations: Operations, form: Mapping, files: Files) -> list[str]:
    """Return the types of breaker that rows of a table, or else files, state, each once."""
    every = (each for some in operations.values() for each in some)
    named = (each.type or stated_in(files[each.file], form, each.channel).type for each in every)
    return [*usual_spelling(filter(None, named)).values()]


def each_once(paths: Iterable[str | Path]) -> list:
    """Return files or folders in natural order, each once, whatever names lead to it.

    Draws depend on the number of a record, and must not depend on the order of arguments.
    """
    rising = sorted(paths, key=natural, reverse=True)
    return [*{os.path.realpath(path): path for path in rising}.values()][::-1]


def number_poles(files: Mapping[Path, tuple[Sequence[str], str]]) -> dict[Path, int]:
    """Return the number of the operation of each file, from 1; files may be of one pole each.

    The first files of several phases on one day are poles of one operation, their second files are
    the next operation. A file without a stated phase is an operation of its own.
    """
    turns, operations, found = Counter(), {}, {}
    for path, (phases, day) in files.items():
        turns.update((day, phase) for phase in {*phases})
        turn = max((turns[day, phase] for phase in phases), default=path)
        found[path] = operations.setdefault((day, turn), len(operations) + 1)
    return found


def read_operations(
    operations: Operations,
    settings: Mapping,
    *,
    motions: Sequence[str] = MOTIONS,
    files: Files | None = None,
) -> list[DriveRecord]:
    """Read the records of a drive, motion by motion; copies of a record are rejected.

    A file of ``ANY`` has some of the ``motions``; motions of one kind are several operations.
    ``settings`` is the section ``endurance.format`` of the configuration.
    """
    reader, found = Reader(settings, files), []
    for key, listed in operations.items():
        of = [key] if key else [*motions]
        some: list[DriveRecord] = []
        for operation, *raws in zip(listed, *reader.read_all(listed, *of), strict=True):
            read = dict(zip(of, raws, strict=True))
            some += _records_in(reader, operation, read, 0 if key else len(listed))
        found += sorted(some, key=lambda record: MOTIONS.index(record.motion))
    return without_copies(found)


def _records_in(
    reader: Reader, operation: Operation, raws: Mapping[str, Record | Exception], beyond: int
) -> list[DriveRecord]:
    """Return the records of the motions that a file has, or one with the reason if it has none.

    The later motions of one kind have numbers by ``beyond`` higher; with 0 there may be only one.
    """
    of_other = (isinstance(getattr(e, "__cause__", None), OtherMotionError) for e in raws.values())
    there = [motion for motion, other in zip(raws, of_other, strict=True) if not other]
    found: dict[object, DriveRecord] = {}
    for motion in there or [*raws][:1]:
        raw = raws[motion]
        parts = separate_motions(operation, raw) if beyond and not isinstance(raw, Record) else []
        parts = [replace(e, number=e.number + k * beyond) for k, e in enumerate(parts)]
        (again,) = reader.read_all(parts, motion)
        for part, each in zip(parts or [operation], again or [raw], strict=True):
            record = _record(reader, part, motion, each)
            key = record.reason or (motion, part.number)  # a reason of both motions counts once
            found.setdefault(key, record)
    return [*found.values()]


def _record(
    reader: Reader, operation: Operation, motion: str, raw: Record | Exception
) -> DriveRecord:
    """Return a record as networks take it, or why it cannot be used."""
    stated = reader.header(operation)
    if not isinstance(raw, Record):
        return DriveRecord(reader.with_stated(operation, motion), motion, stated, str(raw))
    record = DriveRecord(raw.operation, motion, stated)
    try:
        shape, seen = normalise_record(raw)
    except ValueError as error:
        return record.rejected(f"{operation.file}: {error}")
    missing = 1.0 - float(np.trim_zeros(shape.present).mean()) if shape.present.any() else 1.0
    if missing > (allowed := raw.settings["missing"]):
        shares = {"missing": in_digits(missing, 2), "allowed": in_digits(allowed, 4)}
        return record.rejected(say("much-missing", file=printable(operation.file), **shares))
    return replace(record, raw=raw, shape=shape, seen=seen)


def samples_of(record: DriveRecord) -> tuple[str, bytes]:
    """Return the motion of a usable record and its samples, which are equal for copies."""
    return record.motion, record.raw.left.tobytes()


def without_copies(records: Iterable[DriveRecord]) -> list[DriveRecord]:
    """Return records; a record with the samples of an earlier one is rejected."""
    found, first = [], {}
    for record in records:
        if not record.reason:
            other = first.setdefault(samples_of(record), record)
            one, again = ((str(e.operation.file), e.operation.channel) for e in (other, record))
            if one != again:
                of, name = (" ".join(filter(None, map(printable, e))) for e in (one, again))
                record = record.rejected(say("copy", name=name, other=of))
        found.append(record)
    return found
