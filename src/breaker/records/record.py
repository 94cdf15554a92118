"""A record as it is in its file: even times, travel in mm, its motion and the first of it.

All that a record shows without a model's grid; ``curve_reader`` puts it there.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from breaker.common.numerals import in_digits
from breaker.model.quantities import Speed
from breaker.records.axes import Scale, even_times, seen_quantum
from breaker.records.contacts import ContactTimes, events_of
from breaker.records.currents import Channel, Currents
from breaker.records.faulty_samples import doubtful_samples, doubts_in_words
from breaker.records.files import Files, RejectedCurveError
from breaker.records.first_motion import first_motion
from breaker.records.formats.registry import read_columns
from breaker.records.grid import Gridded, on_grid
from breaker.records.measurements import Measured, Reading
from breaker.records.motion import LocatedMotion, find_segment
from breaker.records.operations import Operation
from breaker.records.record_doubts import (
    check_stroke,
    inconsistencies,
    of_no_drive,
    rest_of_open,
    rest_remark,
)
from breaker.records.rejections import NotShownError, SeveralMotionsError, UnusableError
from breaker.records.settings import complete, lacking
from breaker.records.sheet import Columns

_MANY = 100  # files, from which the progress is shown


@dataclass(frozen=True)
class Raw(LocatedMotion):
    """A record as it is in its file.

    Attributes:
        operation: What it is of.
        settings: The section ``endurance.format``, complete, and what its row states over it.
        rest: Reading of the open breaker, mm, that is subtracted on the grid.
        contact: When the main contact touched or parted, and the trigger came.
        currents: Of coil and motor.
        said: What is doubtful about the file, in words; "" is nothing.
        warning: What its file states against how it was read, to be said before anything else.
    """

    operation: Operation
    settings: Mapping
    rest: float
    contact: ContactTimes
    currents: Currents
    said: tuple[str, ...]
    warning: str = ""

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
            self._of_no_drive,
            rest_remark(self.segment, self.settings, self.motion, zero_sd, self._settles),
            doubts_in_words(self.time, self.whole, self.doubts),
            self._rippled,
            self._slipped,
            self._hidden,
            *inconsistencies(time, left, self.moves, noise_sd or 0.0, self.quantum),
        ]

    @cached_property
    def _reading(self) -> Reading:
        return Reading(self, self.contact, ())

    @property
    def _settles(self) -> tuple[float, float]:
        """Where the travel settles after the motion, and its sd, mm; NaN where it is not seen."""
        with suppress(NotShownError):
            after, sign = self._reading.after, 1.0 if self.motion == "closing" else -1.0
            return sign * after.value, self._reading.trace.sd(after)
        return float("nan"), float("nan")

    @property
    def _of_no_drive(self) -> str:
        """Why this is no motion of a breaker's drive; "" where it may be one."""
        before, after = self.segment.before, self.segment.after
        done = (self.left - before) / (after - before)
        return of_no_drive(self.motion, self.time[self.inside], done, self.segment.stroke)

    @property
    def _slipped(self) -> str:
        """That rests of a record are not where others were, in words; "" if they are."""
        if not (off := self.unreturned):
            return ""
        return (
            f"the drive rests {in_digits(off, 2)} mm from where it rested before another motion of "
            "the record: the transducer slipped, and the stroke is no better known than that"
        )

    @property
    def _hidden(self) -> str:
        """That the reading steps within its noise, in words; "" if it does not."""
        if self._reading.hidden is None:
            return ""
        place, size = self._reading.hidden
        return (
            f"at {in_digits(self._reading.trace.time[place], 5)} ms the reading steps by "
            f"{in_digits(abs(size), 2)} mm, as if the transducer slipped: the stroke is no better "
            "known than that"
        )

    @property
    def _rippled(self) -> str:
        """What a ripple of the reading does, in words; "" if there is none."""
        swing, period = self.ripple
        if not swing:
            return ""
        return (
            f"during the motion the reading ripples by +-{in_digits(swing, 2)} mm with a period of "
            f"{in_digits(period, 2)} ms, as on an elastic linkage: taken for noise of the sensor"
        )

    def measured(
        self, speeds: Sequence[Speed], contact: ContactTimes | None = None
    ) -> dict[str, Measured]:
        """Return the quantities that are read from the record itself.

        Args:
            speeds: How speeds are defined.
            contact: When it switched, where the record has not seen it.
        """
        return Reading(self, contact or self.contact, speeds, self.currents).quantities()


class Preparation(Protocol):
    """What is done with every record of a command: see ``records.preparation``."""

    files: Files

    def told(self, operation: Operation, motion: str) -> Operation:
        """Return an operation with settings that its file tells."""

    def checked(self, raw: Raw, row: Operation) -> Raw:
        """Return a record with what is to be said of it; raise UnusableError to reject it."""


class _Samples(NamedTuple):
    """A record as it is in its file, whatever its motion; see ``Raw``.

    Attributes:
        place: Of each sample of the columns among the even times, ``(t,)``.
        uneven: What is doubtful about the times.
    """

    operation: Operation
    settings: Mapping
    columns: Columns
    time: np.ndarray
    place: np.ndarray
    uneven: str
    whole: np.ndarray
    doubts: np.ndarray
    quantum: float

    @property
    def beside(self) -> dict[str, np.ndarray]:
        """Other columns of the file at the even times, ``(n,)``; nan where there is no sample."""
        found = {kind: np.full(self.time.size, np.nan) for kind in self.columns.beside}
        for kind, column in found.items():
            column[self.place] = self.columns.beside[kind]
        return found


def read_raw(
    operation: Operation, settings: Mapping, scale: Scale, motion: str, files: Files | None = None
) -> Raw:
    """Read the record of one operation as it is in its file.

    Args:
        settings: The section ``endurance.format``, complete.
        motion: "closing" or "opening".
        files: In which the file is opened.

    Raises:
        RejectedCurveError: If the record cannot be used.
    """
    return _raw(_samples(operation, settings, scale, files), motion)


def _samples(
    operation: Operation, settings: Mapping, scale: Scale, files: Files | None = None
) -> _Samples:
    """Read the samples of a record; raise as ``read_raw``."""
    file = operation.file if files is None else files[operation.file]
    columns = read_columns(file, settings, operation.channel)
    try:
        time, place, uneven = even_times(columns.time, columns.lines, settings)
        whole = np.full(time.size, np.nan)
        whole[place] = scale.travel(columns.travel)
        found = time, place, uneven, whole, *_doubts(time, whole, settings)
    except UnusableError as error:
        raise RejectedCurveError(operation.file, str(error), line=error.line) from error
    return _Samples(operation, settings, columns, *found)


def _raw(samples: _Samples, motion: str) -> Raw:
    """Find a motion in samples; raise as ``read_raw``."""
    operation, settings, columns, time, _, uneven, whole, doubts, quantum = samples
    left = np.where(doubts == "", whole, np.nan)
    try:
        part = {"begin": operation.begin, "end": operation.end}
        segment = find_segment(time, left, motion, **part)
        check_stroke(segment.stroke, settings)
        rest = rest_of_open(segment, settings, motion)
        inside = slice(segment.begin, segment.end)
        moves = first_motion(time[inside], left[inside], motion)
        found = motion, time, whole, doubts, quantum, segment, *moves
        beside = samples.beside
        contact, odd = events_of(settings, LocatedMotion(*found), beside)
    except UnusableError as error:
        words = doubts_in_words(time, whole, doubts)
        reason = f"{error}; left out: {words}" if words else str(error)
        raise RejectedCurveError(operation.file, reason, line=error.line) from error
    channels = {k: Channel(beside[k], amperes) for k, amperes in columns.amperes.items()}
    event = contact.trigger, contact.trigger_sd
    currents = Currents(time, channels, inside, found[-2], *event)
    said = (*columns.remarks, uneven, *odd)
    return Raw(*found, operation, settings, rest, contact, currents, said)


def read_raws(
    operations: Sequence[Operation],
    settings: Mapping,
    *motions: str,
    preparation: Preparation | None = None,
) -> list[list[Raw | RejectedCurveError]]:
    """Read the records of several operations as they are in their files, or why there is none.

    Args:
        operations, settings: As for ``read_curves``.
        motions: Those that are looked for in each.
        preparation: Of the records; none as they are.

    Returns:
        For each of the motions a list in the order of the operations.
    """
    alone = not any(operation.settings for operation in operations)
    ready: dict[str, tuple[dict, Scale]] = {}  # a table of readings is read once
    raws: list[list[Raw | RejectedCurveError]] = [[] for _ in motions]
    if len(operations) >= _MANY:
        from tqdm import tqdm  # here, as it takes longer to load than a record to read

        said = f"read {' and '.join(motions)}"
        operations = tqdm(operations, desc=said, mininterval=5, unit="file")
    files = preparation.files if preparation else None
    for row in operations:
        read: dict[str, _Samples] = {}  # most motions are read in one way
        for motion, found in zip(motions, raws, strict=True):
            operation = preparation.told(row, motion) if preparation else row
            stated = repr(operation.settings)
            try:
                if stated not in ready:
                    ready[stated] = _settings_of(operation, settings, alone=alone)
                if stated not in read:
                    read[stated] = _samples(operation, *ready[stated], files)
                raw = _raw(read[stated], motion)
                found.append(preparation.checked(raw, row) if preparation else raw)
            except RejectedCurveError as error:
                found.append(error)
            except UnusableError as error:
                found.append(RejectedCurveError(row.file, str(error)))
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


def _doubts(time: np.ndarray, whole: np.ndarray, settings: Mapping) -> tuple[np.ndarray, float]:
    """Kinds of doubtful samples, ``(n,)``, and the quantum, mm.

    Raises:
        UnusableError: If there is hardly a sample.
    """
    if (count := int((~np.isnan(whole)).sum())) < 2:
        raise UnusableError(f"has {count} samples")
    given = settings["quantum"]
    quantum = seen_quantum(whole) if given is None else given
    doubts = doubtful_samples(whole, float(time[-1] - time[0]) / (time.size - 1), quantum)
    return doubts, quantum
