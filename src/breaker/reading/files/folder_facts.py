"""What is seen in the files of a folder, and what they say of one another."""

import hashlib
import math
import os
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from breaker.common.numerals import in_digits
from breaker.reading.files.date_text import moments
from breaker.reading.files.guards import opened_at_once
from breaker.reading.files.preamble import Preamble


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
        others: Columns of contacts that are not taken.
    """

    motion: str
    channel: str
    phase: str
    begin: float
    end: float
    ratio: float
    beside: Mapping[str, str | int] = MappingProxyType({})
    others: tuple[str | int, ...] = ()


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
    """Files that have the content of another, and which: of names the shortest with a date."""
    sizes = {path: os.path.getsize(folder / path) for path in paths}
    alike = Counter(sizes.values())
    first: dict[bytes, str] = {}
    found = {}
    for path in sorted(paths, key=lambda path: (not moments(Path(path).stem), len(path))):
        if (size := sizes[path]) and alike[size] > 1 and (folder / path).is_file():
            with opened_at_once(folder / path) as content:
                digest = hashlib.file_digest(content, "sha256").digest()
            if (other := first.setdefault(digest, path)) != path:
                found[path] = other
    return found


def _differences(found: Mapping[str, Description]) -> list[str]:
    """What to check of the rates and ratios that files state, and of contacts left out."""
    lacking = {path: each.preamble for path, each in found.items() if each.lacks_rate}
    said = []
    for path, stated in list(lacking.items())[:1]:
        why = stated.rate_doubt or "not stated"
        said.append(f"the rate of {len(lacking)} files is to be filled in, first {path}: {why}")
    for what, unit in (("rate", " kHz"), ("ratio", "")):
        stated = (getattr(each.preamble, what) for each in found.values())
        values = sorted({value for value in stated if value > 0})
        if len(values) > 1:
            listed = ", ".join(in_digits(value, 6) + unit for value in values)
            said.append(f"files differ in the stated {what}: {listed}")
    left = (part for each in found.values() for part in each.parts if part.others)
    return [*said, *dict.fromkeys(map(_left_out, left))]


def _left_out(part: Part) -> str:
    taken, others = part.beside.get("contact_column"), ", ".join(map(repr, part.others))
    return f"{part.motion} of {part.channel!r}: contact {taken!r} is taken, not {others}"
