"""Records in the files and folders that a user names.

In a folder with a table ``operations.csv`` the operations are the rows of the table. In a folder
with a subfolder for each motion, the names of the files number them. All other files may hold any
motion, and are numbered in the natural order of their names. For a report, files of poles of one
operation share its number: an analyser writes a file for each pole, seconds or minutes apart.
"""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from breaker.common.numerals import natural
from breaker.diagnosis.estimate import DriveRecord
from breaker.diagnosis.session import Diagnosis
from breaker.model.parameters import MOTIONS
from breaker.records.dates import one_date
from breaker.records.description import travel_channels
from breaker.records.file_names import phases_in_names
from breaker.records.files import Files, Opened
from breaker.records.folder import (
    each_line,
    is_folder,
    list_fleet,
    list_operations,
    record_files,
)
from breaker.records.formats.registry import stated_in
from breaker.records.operations import MANIFEST, Operation

_Pole = tuple[Sequence[str], str]  # phases of a file's channels, and its date; "" where not known


def read_records(
    named: Sequence[str],
    assessment: Diagnosis,
    *,
    motion: str | None = None,
    channel: str = "",
    breaker: str | None = None,
    phase: str | None = None,
) -> list[DriveRecord]:
    """Read the records of one drive in files and folders.

    Args:
        named: Files and folders.
        assessment: What reads them.
        motion: The only motion that is read; None for both.
        channel: Column of travel.
        breaker, phase: Which of a folder's table; None for those of the configuration.

    Raises:
        FileNotFoundError: If a folder has no file of a record.
        ValueError: If a table is wrong or has several drives, or a choice cannot be made.
    """
    settings, motions = assessment.config["endurance"], [motion] if motion else MOTIONS
    chosen = {"breaker": breaker or settings["breaker"], "phase": phase or settings["phase"]}
    rows, files = _found(named, motions, lambda *of: list_operations(*of, **chosen))
    if files and (breaker or phase):
        raise ValueError(
            f"--breaker and --phase choose in one folder with a table {MANIFEST}, and {files[0]} "
            "is in none; leave them out"
        )
    if channel and any(each.channel for some in rows.values() for each in some):
        raise ValueError(
            "the table of a folder names the channels; leave --channel out, or choose by --phase"
        )
    rows = {m: [replace(e, channel=e.channel or channel) for e in some] for m, some in rows.items()}
    numbered = enumerate(files, start=1 + _last_number(rows))
    loose = each_line(Operation(i, file, channel=channel) for i, file in numbered)
    both = dict.fromkeys(motions, loose)
    return [*assessment.read(rows), *assessment.read(both, loose=True)]


def read_visit(
    named: Sequence[str],
    channels: Sequence[str],
    assessment: Diagnosis,
    opened: Files | None = None,
) -> list[DriveRecord]:
    """Read every channel and motion in files and folders of one breaker.

    A channel is the operation's phase.

    Args:
        named: Files and folders.
        channels: Columns of travel; all that move where there are none.
        assessment: What reads them.
        opened: In which files are opened, once.

    Raises:
        FileNotFoundError: If a folder has no file of a record.
        ValueError: If a table names several breakers.
    """
    opened = Files() if opened is None else opened
    rows, files = _found(named, MOTIONS, _every_phase)
    if len(names := {each.breaker for some in rows.values() for each in some}) > 1:
        raise ValueError(
            f"a report is of one breaker, and the tables name {', '.join(sorted(names))}; write a "
            "report of each"
        )
    form, after = assessment.config["endurance"]["format"], _last_number(rows)
    phases_of = {file: _channels(opened[file], channels, form["travel_column"]) for file in files}
    in_names = phases_in_names(files)
    poles = {}
    for file, found in phases_of.items():
        if file in in_names and len(found) == 1:
            ((channel, phase),) = found.items()
            found[channel] = phase or in_names[file]
        phases = [phase for channel, phase in found.items() if phase not in (channel, "")]
        stated = stated_in(opened[file], form, next(iter(found)))
        when = one_date("", stated.dates, file)
        poles[file] = phases if len(phases) == len(found) else (), when
    numbers = numbers_of_poles(poles)
    loose = each_line(
        Operation(after + numbers[file], file, channel, phase=phase)
        for file, found in phases_of.items()
        for channel, phase in found.items()
    )
    both = dict.fromkeys(MOTIONS, loose)
    return [*assessment.read(rows, files=opened), *assessment.read(both, loose=True, files=opened)]


def _found(
    named: Sequence[str],
    motions: Sequence[str],
    list_motion: Callable[[Path, str], Iterable[Operation]],
) -> tuple[dict[str, list[Operation]], list[Path]]:
    """Return operations of folders that state them, by motion, and all other files once each."""
    rows: dict[str, list[Operation]] = {}
    files: list[Path] = []
    for each in map(Path, named):
        if not is_folder(each):
            files.append(each)
        elif any(os.path.lexists(each / name) for name in (MANIFEST, *motions)):
            lacking = []
            for motion in motions:
                try:
                    rows.setdefault(motion, []).extend(list_motion(each, motion))
                except FileNotFoundError as error:
                    lacking.append(error)
            if len(lacking) == len(motions):
                raise lacking[0]
        elif inside := record_files(each):
            files += inside
        else:
            raise FileNotFoundError(f"{each} has no file of a record, and no table {MANIFEST}")
    return rows, each_once(files)


def _every_phase(folder: Path, motion: str) -> list[Operation]:
    """Return the operations of a motion in a folder, of all breakers and phases of its table."""
    if not (folder / MANIFEST).exists():
        return list_operations(folder, motion)
    rows = (row for some in list_fleet(folder).values() for row in some)
    return [operation for of, operation in rows if of == motion]


def _last_number(rows: Mapping[str, Sequence[Operation]]) -> int:
    return max((each.number for some in rows.values() for each in some), default=0)


def each_once(paths: Iterable[str | Path]) -> list:
    """Return files or folders each once, under whatever names they are there twice.

    Their order is natural: that of a command must not matter, as draws depend on a record's number.
    """
    found: dict[str, str | Path] = {}
    for path in sorted(paths, key=natural):
        found.setdefault(os.path.realpath(path), path)
    return list(found.values())


def _channels(file: Opened, chosen: Sequence[str], usual: str | int) -> dict[str, str]:
    """Return the phases or names of the channels of a file, by their columns of travel.

    A single channel for which the file states no phase has an empty one.
    """
    found = {}
    with suppress(ValueError):  # to be read as configured, or rejected with the reason
        found = travel_channels(file, usual)
    names = {each: found[each][0] if each in found else each for each in chosen or found or [""]}
    return {key: "" if len(names) == 1 and name == key else name for key, name in names.items()}


def numbers_of_poles(files: Mapping[Path, _Pole]) -> dict[Path, int]:
    """Return the number of the operation of each file, from 1 in the order of the files.

    Files are of one operation where no phase stands in two of them and they state the same day; of
    several such operations the first counts.

    Args:
        files: Phases of the channels of each file, none where one is not known, and its date as ISO
            8601, "" where the file states none.

    Example:
        >>> times = {"R": "2020-12-24T06:07:25", "Y": "2020-12-24T06:07:26"}
        >>> files = {Path(phase): ([phase], time) for phase, time in times.items()}
        >>> [*numbers_of_poles(files | {Path("R 2"): (["R"], "")}).values()]
        [1, 1, 2]
    """
    groups: dict[int, list[_Pole]] = {}
    found = {}
    for path, each in sorted(files.items(), key=lambda item: item[1][1] or "9999"):
        own = next((k for k, some in groups.items() if _beside(some, each)), len(groups))
        groups.setdefault(own, []).append(each)
        found[path] = own
    order = {of: k for k, of in enumerate(dict.fromkeys(found[path] for path in files), start=1)}
    return {path: order[found[path]] for path in files}


def _beside(group: Sequence[_Pole], one: _Pole) -> bool:
    """Return whether a file is of the same operation as others, by phases and days."""
    known = all(phases for phases, _ in (*group, one))
    there = {phase for phases, _ in group for phase in phases}
    days = {date[:10] for _, date in (*group, one)} - {""}
    return known and not there & {*one[0]} and len(days) < 2
