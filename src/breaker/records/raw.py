"""A record as it is in its file: even times, travel in mm, its motion and the first of it.

All that a record shows without a model's grid; ``reader`` puts it there.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from tqdm import tqdm

from breaker.files import Operation, RejectedCurveError, complete, lacking, read_columns
from breaker.mechanism import Speed
from breaker.records.clock import count_remark, even_times
from breaker.records.consistency import inconsistencies
from breaker.records.doubtful import doubtful_samples, doubts_in_words
from breaker.records.edges import Contact, events_of
from breaker.records.errors import SeveralMotionsError, UnusableError
from breaker.records.grid import Gridded, on_grid
from breaker.records.landmarks import first_motion
from breaker.records.located import LocatedMotion
from breaker.records.measured import Measured, Reading
from breaker.records.scale import Scale, seen_quantum
from breaker.records.segments import find_segment
from breaker.records.stroke import check_stroke, rest_of_open, rest_remark

__all__ = ["Raw", "read_raw", "read_raws", "taken_apart"]

_MANY = 100  # files, from which the progress is shown


@dataclass(frozen=True)
class Raw(LocatedMotion):
    """A record as it is in its file.

    Attributes:
        operation: What it is of.
        settings: The section ``endurance.format``, complete, and what its row states over it.
        rest: Reading of the open breaker, mm, that is subtracted on the grid.
        contact: When the main contact touched or parted, and the trigger came.
        said: What is doubtful about the file, in words; "" is nothing.
    """

    operation: Operation
    settings: Mapping
    rest: float
    contact: Contact
    said: tuple[str, ...]

    def on_grid(self, times: np.ndarray) -> Gridded:
        """Return the record on a model's grid ``(t,)``, ms around the first motion."""
        return on_grid(self.time[self.inside], self.left - self.rest, times, self.moves)

    def remarks_on(self, noise_sd: float | None = None, zero_sd: float | None = None) -> list[str]:
        """Say what is doubtful about it, without a model's grid; "" is nothing.

        Args:
            noise_sd, zero_sd: Noise and error of the zero that a model takes for granted, mm.
        """
        time, left = self.time[self.inside], self.left
        return [
            *self.said,
            rest_remark(self.segment, self.settings, self.motion, zero_sd),
            doubts_in_words(self.time, self.whole, self.doubts),
            *inconsistencies(time, left, self.moves, noise_sd or 0.0, self.quantum),
        ]

    def measured(
        self, speeds: Sequence[Speed], contact: Contact | None = None
    ) -> dict[str, Measured]:
        """Return the quantities that are read from the record itself.

        Args:
            speeds: How speeds are defined.
            contact: When it switched, where the record has not seen it.
        """
        return Reading(self, contact or self.contact, speeds).quantities()


def read_raw(operation: Operation, settings: Mapping, scale: Scale, motion: str) -> Raw:
    """Read the record of one operation as it is in its file.

    Args:
        settings: The section ``endurance.format``, complete.
        motion: "closing" or "opening".

    Raises:
        RejectedCurveError: If the record cannot be used.
    """
    columns = read_columns(operation.file, settings, operation.channel)
    doubts = None
    try:
        time, place, uneven = even_times(columns.time, columns.lines, settings)
        whole, lines = np.full(time.size, np.nan), np.zeros(time.size, dtype=int)
        whole[place], lines[place] = scale.travel(columns.travel), columns.lines
        doubts, quantum = _doubts(time, whole, lines, settings)
        left = np.where(doubts == "", whole, np.nan)
        part = {"begin": operation.begin, "end": operation.end}
        segment = find_segment(time, left, motion, **part)
        check_stroke(segment.stroke, settings)
        rest = rest_of_open(segment, settings, motion)
        inside = slice(segment.begin, segment.end)
        moves = first_motion(time[inside], left[inside], motion)
        found = motion, time, whole, doubts, quantum, segment, moves
        beside = {kind: _placed(each, place, time) for kind, each in columns.beside.items()}
        contact, odd = events_of(operation, settings, LocatedMotion(*found), beside)
    except UnusableError as error:
        words = "" if doubts is None else doubts_in_words(time, whole, doubts)
        reason = f"{error}; left out: {words}" if words else str(error)
        raise RejectedCurveError(operation.file, reason, line=error.line) from error
    said = (*columns.remarks, uneven, count_remark(time.size, settings), *odd)
    return Raw(*found, operation, settings, rest, contact, said)


def read_raws(
    operations: Sequence[Operation], settings: Mapping, motion: str
) -> list[Raw | RejectedCurveError]:
    """Read the records of several operations as they are in their files, or why there is none.

    Args:
        operations, settings, motion: As for ``read_curves``.
    """
    alone = not any(operation.settings for operation in operations)
    ready: dict[str, tuple[dict, Scale]] = {}  # a table of readings is read once
    raws: list[Raw | RejectedCurveError] = []
    few = {"disable": True} if len(operations) < _MANY else {}
    for operation in tqdm(operations, desc=f"read {motion}", mininterval=5, unit="file", **few):
        try:
            if (stated := repr(operation.settings)) not in ready:
                ready[stated] = _settings_of(operation, settings, alone=alone)
            raws.append(read_raw(operation, *ready[stated], motion))
        except RejectedCurveError as error:
            raws.append(error)
    return raws


def taken_apart(operation: Operation, raw: Raw | RejectedCurveError) -> list[Operation]:
    """Return an operation once for each of its motions, where it was rejected for having several;
    none if it was not.
    """
    why = getattr(raw, "__cause__", None)
    parts = why.parts if isinstance(why, SeveralMotionsError) else ()
    return [replace(operation, begin=begin, end=end) for begin, end in parts]


def _settings_of(operation: Operation, settings: Mapping, *, alone: bool) -> tuple[dict, Scale]:
    """The settings of a record, those that its row states over the others, and its scale.

    Raises:
        ValueError: If they are wrong; RejectedCurveError unless they alone are of all records.
    """
    try:
        laid = complete({**settings, **operation.settings})
        if text := lacking(laid):
            raise ValueError(text)
        return laid, Scale.from_settings(laid)
    except ValueError as error:
        if alone:
            raise
        stated = ", ".join(operation.settings)
        said = f"with {stated} of its row in operations.csv: {error}" if stated else str(error)
        raise RejectedCurveError(operation.file, said) from error


def _placed(column: np.ndarray, place: np.ndarray, time: np.ndarray) -> np.ndarray:
    """A column of the file at the record's even times, ``(n,)``; nan where it has no sample."""
    found = np.full(time.size, np.nan)
    found[place] = column
    return found


def _doubts(
    time: np.ndarray, whole: np.ndarray, lines: np.ndarray, settings: Mapping
) -> tuple[np.ndarray, float]:
    """Kinds of doubtful samples, ``(n,)``, and the quantum, mm.

    Raises:
        UnusableError: If there is hardly a sample, or a doubtful one where these are refused.
    """
    if (count := int((~np.isnan(whole)).sum())) < 2:
        raise UnusableError(f"has {count} samples")
    given = settings["quantum"]
    quantum = seen_quantum(whole) if given is None else given
    doubts = doubtful_samples(whole, float(time[-1] - time[0]) / (time.size - 1), quantum)
    found = np.flatnonzero(doubts)
    if found.size and settings["doubtful"] == "reject":
        words = doubts_in_words(time, whole, doubts)
        raise UnusableError(words, line=int(lines[found[0]]))
    return doubts, quantum
