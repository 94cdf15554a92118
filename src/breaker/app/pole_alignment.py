"""Files of poles of one operation on one time axis: an analyser writes each at times of its own."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from breaker.drive.answers.evidence import DriveRecord
from breaker.model.quantities import EVENTS
from breaker.reading.files.guards import printable

_BY: Mapping[str, Callable[[DriveRecord], float]] = {
    "coil": lambda record: record.raw.contact.trigger,
    "event": lambda record: record.raw.contact.time,
    "first motion": lambda record: record.raw.moves,
}
"""What all poles may have in common, the best first: only the coil's start is at one time."""


class Alignment(NamedTuple):
    """Files on one time axis.

    Attributes:
        shifts: ms that are added to the times of each file; files that are as they were are left
            out.
        said: What was done, in words; empty where nothing was.
    """

    shifts: Mapping[str, float]
    said: str


def aligned(records: Sequence[DriveRecord]) -> Alignment:
    """Return how files of poles of one operation come onto the times of its first file: by the
    first motion in each, at its coil where all have one, else at the contact, else where it moves.
    """
    first: dict[int, dict[str, DriveRecord]] = {}
    for each in sorted((e for e in records if e.raw), key=lambda each: each.raw.moves):
        first.setdefault(each.operation.number, {}).setdefault(str(each.operation.file), each)
    order = list(dict.fromkeys(str(each.operation.file) for each in records))
    shifts, said = {}, {}
    for own in first.values():
        files = sorted(own, key=order.index)
        motions = {each.motion for each in own.values()}
        if len(files) == 1 or len(motions) > 1:
            continue
        for name, of in _BY.items():
            at = np.array([of(own[file]) for file in files])
            if np.isfinite(at).all():
                shifts |= dict(zip(files, (at[0] - at).tolist(), strict=True))
                said[_words(name, motions.pop(), files[0])] = None
                break
    return Alignment(shifts, " ".join(said))


def _words(name: str, motion: str, file: str) -> str:
    """At what files are aligned, and what is then not seen."""
    of, event = printable(file).rpartition("/")[2], EVENTS[motion] if name == "event" else name
    said = f"Poles in files of their own lie at the times of {of}, by the {event} of {motion}."
    return said if name == "coil" else f"{said} Not all have a coil, so none leads or lags here."
