"""A file of records in a folder, and what is known of it: by its name, and by a look into it."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

from breaker.reading.files.date_text import Moment, moments
from breaker.reading.files.folder_facts import Description, Part
from breaker.reading.files.lexicon import UNLIKE_PHASES
from breaker.reading.files.operations_table import FILL_IN
from breaker.reading.files.word_meanings import PHASE, PHASES_IN_FILE

_POLES = 3.0  # s, within which no pole switches again


class FoundFile(NamedTuple):
    """A file of records.

    Attributes:
        path: From the folder of the table, with / between its parts.
        stem: Name without ending.
        motions: The one that its folders, or else its name, say it holds; both if none does.
        folder: Its other folders.
        written: When the file was written, s.
        seen: What is seen in it.
        breaker: Of which it is.
        day: Date of the test as ISO 8601; empty where there is none, FILL IN where it is unsure.
        sure: Whether it is sure which of its motions close.
    """

    path: str
    stem: str
    motions: tuple[str, ...]
    folder: str
    written: float
    seen: Description = Description()
    breaker: str = ""
    day: str = ""
    sure: bool = True

    @property
    def named(self) -> Moment | None:
        """The first date in its name."""
        return next((each for each in moments(self.stem) if each.when), None)

    @property
    def key(self) -> str:
        """What its name has beside dates and phases, as the number of a breaker."""
        text = self.stem
        for each in reversed(moments(text)):
            text = text[: each.start] + text[each.stop :]
        return " ".join(re.findall(r"[^\W_]+", PHASES_IN_FILE.sub(" ", text)))


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
    """Return files with phases that their names tell, and FILL IN where several channels of one
    have none of their own, or files of one channel were made at once, as those of poles are.
    """
    stems = {file.stem for file in files}
    found = []
    for file in files:
        phases = {part.channel: part.phase for part in file.seen.parts}
        if len(phases) == 1 and not any(phases.values()):
            phases = dict.fromkeys(phases, _phase_in(file.stem, stems))
        elif len({*phases.values()}) < len(phases) or not all(phases.values()):
            several = [*phases.values()]
            phases = {c: p if several.count(p) == 1 and p else FILL_IN for c, p in phases.items()}
        found.append(_phased(file, phases.get))
    poles = [each for each in found if [p.phase for p in each.seen.parts[:1]] == [""]]
    poles.sort(key=lambda each: (each.breaker, each.key, each.day, each.path))
    at_once = {
        path
        for one, other in pairwise(poles)
        if (one.breaker, one.key) == (other.breaker, other.key) and _at_once(one, other)
        for path in (one.path, other.path)
    }
    return [_phased(f, lambda _: FILL_IN) if f.path in at_once else f for f in found]


def _phased(file: FoundFile, phase_of: Callable[[str], str]) -> FoundFile:
    parts = tuple(part._replace(phase=phase_of(part.channel)) for part in file.seen.parts)
    return file._replace(seen=file.seen._replace(parts=parts))


def _phase_in(stem: str, others: set[str]) -> str:
    """The one phase in a name; letters that may be others only beside names of other phases."""
    bare = stem
    for each in reversed(moments(stem)):
        bare = bare[: each.start] + " " * (each.stop - each.start) + bare[each.stop :]
    found = [*PHASES_IN_FILE.finditer(bare)]
    if len(found) != 1 or not re.fullmatch(PHASE, found[0][0]):
        return ""
    (match,) = found
    names = (
        stem[: match.start()] + p + stem[match.end() :] for p in UNLIKE_PHASES.get(match[0], "")
    )
    return match[0] if match[0] not in UNLIKE_PHASES or others & {*names} else ""


def _at_once(one: FoundFile, other: FoundFile) -> bool:
    """Whether two files were made within seconds, by their names or as they state."""
    names = one.named, other.named
    if all(name and name.timed for name in names):
        return abs((names[1].when - names[0].when).total_seconds()) <= _POLES
    return "T" in one.day and one.day == other.day


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
