"""The files of records in a folder: what is known of each by its name and by a look, and of all."""

import hashlib
import math
import os
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from breaker.common.numerals import natural
from breaker.records.file_names import phases_in_names
from breaker.records.files import opened_at_once
from breaker.records.header import Preamble
from breaker.records.operations import FILL_IN


class Part(NamedTuple):
    """A motion of a channel that is seen in a file.

    Attributes:
        motion: "closing" or "opening".
        channel: Column of the travel.
        phase: Its phase, empty if nothing says it.
        begin, end: Part of the record in which the motion is, ms; NaN for its beginning and end.
        ratio: Stated mm for one unit of the reading; NaN where that is a length, or none is stated.
        beside: Columns that go with it, by ``contact_column``,
            ``trigger_column`` and ``motor_column``.
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
        preamble: What the text above its samples says.
        parts: The motions below.
        rate: kHz, by the times of its samples or as stated; NaN where it is doubtful or not stated,
            None where nothing is seen.
        timed: Whether it has the times of its samples.
        settings: Of ``endurance.format``, as far as the file tells how it is read; FILL IN for what
            it does not tell.
        sure: Whether it tells which of its motions close, so that this is no guess.
        reason: Why it is no record; empty if it may be one.
    """

    preamble: Preamble = Preamble()
    parts: tuple[Part, ...] = ()
    rate: float | None = None
    timed: bool = False
    settings: Mapping[str, Any] = MappingProxyType({})
    sure: bool = True
    reason: str = ""

    @property
    def lacks_rate(self) -> bool:
        """Whether its rate is to be filled in."""
        return self.rate is not None and math.isnan(self.rate)


def descriptions(
    folder: Path, paths: Sequence[str], look: Callable[[Path], Description]
) -> tuple[dict[str, Description], list[str]]:
    """Return what is seen in each file but those that have the content of another, and remarks.

    Paths are from the folder.
    """
    copies = _copies(folder, paths)
    remarks = [f"left out: {path} has the content of {first}" for path, first in copies.items()]
    found = {path: look(folder / path) for path in paths if path not in copies}
    return found, remarks + _differences(found)


def _copies(folder: Path, paths: Sequence[str]) -> dict[str, str]:
    """Files that have the content of another, and which: the first by name."""
    sizes = {path: os.path.getsize(folder / path) for path in paths}
    alike = Counter(sizes.values())
    first: dict[bytes, str] = {}
    found = {}
    for path in sorted(paths, key=natural):
        if (size := sizes[path]) and alike[size] > 1 and (folder / path).is_file():
            with opened_at_once(folder / path) as content:
                digest = hashlib.file_digest(content, "sha256").digest()
            if (other := first.setdefault(digest, path)) != path:
                found[path] = other
    return found


def _differences(found: Mapping[str, Description]) -> list[str]:
    """What to say of rates that files do not state."""
    lacking = {path: each.preamble for path, each in found.items() if each.lacks_rate}
    for path, stated in lacking.items():
        why = stated.rate_doubt or "not stated"
        return [f"the rate of {len(lacking)} files is to be filled in, first {path}: {why}"]
    return []


class FoundFile(NamedTuple):
    """A file of records.

    Attributes:
        path: From the folder of the table, with / between its parts.
        stem: Name without ending.
        motions: The one that its folders, or else its name, say it holds; both if none does.
        folder: Its other folders.
        seen: What is seen in it.
        breaker: Breaker of the file; FILL IN where other files state theirs.
        sure: Whether it is sure which of its motions close.
    """

    path: str
    stem: str
    motions: tuple[str, ...]
    folder: str
    seen: Description = Description()
    breaker: str = ""
    sure: bool = True

    @property
    def day(self) -> str:
        """Date of the test as ISO 8601, as the file states it; FILL IN where day and month may be
        either.
        """
        return FILL_IN if len(self.seen.preamble.dates) > 1 else self.seen.preamble.date


class Row(NamedTuple):
    """An operation of one motion: its file, and which of the motions of that kind in there."""

    file: FoundFile
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


def with_phases(files: Sequence[FoundFile]) -> list[FoundFile]:
    """Return the files of a breaker with the phases that their names tell, and FILL IN where
    several channels of one have none of their own.
    """
    phases = [{part.channel: part.phase for part in file.seen.parts} for file in files]
    lacking = [
        Path(file.path)
        for file, each in zip(files, phases, strict=True)
        if [*each.values()] == [""]
    ]
    in_names = phases_in_names(lacking)
    found = []
    for file, each in zip(files, phases, strict=True):
        several = [*each.values()]
        if len(each) == 1:
            named = in_names.get(Path(file.path), "")
            each = {channel: phase or named for channel, phase in each.items()}
        elif len({*several}) < len(several) or not all(several):
            each = {c: p if p and several.count(p) == 1 else FILL_IN for c, p in each.items()}
        parts = tuple(part._replace(phase=each[part.channel]) for part in file.seen.parts)
        found.append(file._replace(seen=file.seen._replace(parts=parts)))
    return found


def settings_cells(
    files: Sequence[FoundFile], defaults: Mapping[str, object]
) -> dict[str, dict[str, str]]:
    """Return the cells of settings of each file by its path; of a setting that all files have as
    the defaults have it there are none.
    """
    seen = {file.path: {**defaults, **file.seen.settings} for file in files}
    own = [k for k, v in defaults.items() if any(each[k] != v for each in seen.values())]
    looked = {file.path for file in files if file.seen.settings}
    return {
        path: {key: _setting_cell(key, each[key]) for key in own} if path in looked else {}
        for path, each in seen.items()
    }


def _setting_cell(key: str, value: object) -> str:
    if key == "time_column" and value is None:
        return "none"
    if value is None or isinstance(value, float):
        return number_cell(value)
    return {"\t": "tab", " ": "blank"}.get(str(value), str(value))


def number_cell(value: float | None) -> str:
    """Return the cell of a number; nothing for one that is not known, as None or NaN."""
    return "" if value is None or math.isnan(value) else f"{value:.6g}"
