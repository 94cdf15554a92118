"""List the operations in the files and folders that a user names, and choose among them.

In a folder with a table ``operations.csv``, the rows are the operations. Any other file may contain
one motion or both, each once or several times.
"""

import os
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from breaker.common.clean_text import usual_spelling
from breaker.model.parameters import MOTIONS
from breaker.records import folder
from breaker.records.dates import one_date
from breaker.records.files import Files, Opened, printable
from breaker.records.formats.detection import look_into, stated_in
from breaker.records.operations import MANIFEST, Operation
from breaker.records.settings import FORMAT
from breaker.records.words import phases_in_names

ANY = ""
"""Key of operations whose files may have any motion."""

Operations = Mapping[str, Sequence[Operation]]
"""Operations by motion; key ``ANY`` for operations with any motion."""


class Choice(NamedTuple):
    """Choice of the records of one drive in files and folders.

    Attributes:
        motions: Motions to read.
        channels: Columns of travel; by default the configured column, or all columns of travel
            (``every``).
        breaker, phase: Names in the table of a folder; a phase also as a file states it.
        every: Whether to take all channels and all phases.
    """

    motions: Sequence[str] = MOTIONS
    channels: Sequence[str] = ()
    breaker: str | None = None
    phase: str | None = None
    every: bool = False


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
        if not place.is_dir():
            loose.append(place)
        elif os.path.lexists(place / MANIFEST):
            for motion, rows in _in_folder(place, endurance, choice).items():
                listed[motion] += rows
        elif inside := folder.record_files(place):
            loose += inside
        else:
            what = f"{printable(place)} has no file of a record and no table {MANIFEST}"
            raise FileNotFoundError(f"{what}. Name a folder with records")
    rows = [row for group in listed.values() for row in group]
    if len(names := sorted({row.breaker for row in rows} - {""})) > 1:
        what = f"the tables name several breakers: {', '.join(names)}"
        raise ValueError(f"{what}. Name the records of one breaker")
    if loose and choice.breaker:
        what = f"--breaker chooses in the table {MANIFEST} of a folder"
        raise ValueError(f"{what}, and {printable(loose[0])} is in none. Leave it out")
    last = max((row.number for row in rows), default=0)
    loose = folder.each_once(loose)
    return {**listed, ANY: _in_files(loose, endurance["format"], choice, files, last)}


def _in_folder(place: Path, endurance: Mapping, choice: Choice) -> dict[str, list[Operation]]:
    """Return the operations in the table of a folder."""
    if choice.every:
        rows = [row for group in folder.list_fleet(place).values() for row in group]
        return {
            motion: [operation for row_motion, operation in rows if row_motion == motion]
            for motion in choice.motions
        }
    chosen = {name: getattr(choice, name) or endurance[name] for name in ("breaker", "phase")}
    by_motion, lacking = {}, []
    for motion in choice.motions:
        try:
            operations = folder.list_operations(place, motion, **chosen)
        except FileNotFoundError as error:
            lacking.append(error)
            continue
        if choice.channels and any(operation.channel for operation in operations):
            what = "the table of a folder names the channels"
            raise ValueError(f"{what}. Leave --channel out, or choose by --phase")
        channel = "".join(choice.channels[:1])
        by_motion[motion] = [replace(e, channel=e.channel or channel) for e in operations]
    if not by_motion:
        raise lacking[0]
    return by_motion


def _in_files(
    paths: Sequence[Path], form: Mapping, choice: Choice, files: Files, last: int
) -> list[Operation]:
    """Return the operations in files without a stated motion, numbered from ``last`` + 1 on."""
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
        what = f"no file states phase {choice.phase}; they state: {known}"
        raise ValueError(f"{what}. Name another phase, or write a table {MANIFEST}")
    numbers = _number_poles(poles)
    return folder.each_line(
        Operation(last + numbers[path], path, channel, phase=phase)
        for (path, channel), phase in wanted.items()
    )


def _number_poles(files: Mapping[Path, tuple[Sequence[str], str]]) -> dict[Path, int]:
    """Return the number of the operation of each file, from 1, by its phases and its day.

    On one day, the first files of several phases are poles of one operation, their second files
    are the next operation. A file without a stated phase is a separate operation.
    """
    turns, operations, poles = Counter(), {}, {}
    for path, (phases, day) in files.items():
        turns.update((day, phase) for phase in {*phases})
        turn = max((turns[day, phase] for phase in phases), default=path)
        poles[path] = operations.setdefault((day, turn), len(operations) + 1)
    return poles


def _channels(file: Opened, form: Mapping, choice: Choice) -> dict[str, str]:
    """Return the phase of each chosen column of travel; "" if no phase is stated.

    If all channels are chosen and there are several, a channel without a phase gets its column.
    """
    if not (choice.every or choice.phase):
        channel = "".join(choice.channels[:1])
        stated = stated_in(file, form, channel)
        return {channel: stated.phase_of(channel or form["travel_column"])}
    from breaker.records.description import travel_channels  # most commands do not need it

    moving, usual = {}, form["travel_column"]
    with suppress(ValueError):  # read as configured, or rejected with the reason
        if usual == FORMAT["travel_column"] or look_into(file, usual).place_of(usual) is not None:
            named = travel_channels(file, usual)
            moving = {column: name for column, (name, _) in named.items()}
    names = {item: moving.get(item, item) for item in choice.channels or moving or [""]}
    return {key: "" if len(names) == 1 and name == key else name for key, name in names.items()}


def stated_types(operations: Operations, form: Mapping, files: Files) -> list[str]:
    """Return the types of breaker that rows of a table, or else files, state, each once."""
    every = (operation for group in operations.values() for operation in group)
    named = (
        operation.type or stated_in(files[operation.file], form, operation.channel).type
        for operation in every
    )
    return [*usual_spelling(filter(None, named)).values()]
