"""Read the records of operations, with the settings of the configuration and of their files.

Settings count in this order: the row of ``operations.csv``, what the file states (its rate, and the
columns of contact, coil and motor that belong to the travel), the configuration, the defaults. A
stated rate that contradicts the configuration rejects the record: one of both is wrong.

1. ``formats``: columns of the file, in its own units.
2. ``axes``: even times, ms, and travel, mm towards closed; missing samples are NaN.
3. ``checks``: samples that no sensor of this stroke can give become NaN.
4. ``motion``: the part of the record that is the motion; ``checks``: whether it is one of a
   breaker.
5. ``first_motion``, ``contacts``, ``currents``.

A record that a step cannot use is rejected with the name of its file, the line where there is one,
and the reason; the other records are read.
"""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from math import isfinite
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.records.axes import Scale, even_times, seen_quantum
from breaker.records.checks import (
    check_slips,
    check_stroke,
    doubtful_samples,
    doubts_in_words,
    rest_of_open,
)
from breaker.records.contacts import events_of
from breaker.records.currents import Channel, Currents
from breaker.records.dates import one_date
from breaker.records.files import Files, Opened, RejectedCurveError, printable
from breaker.records.first_motion import first_motion
from breaker.records.formats.registry import look_into, read_columns, stated_in
from breaker.records.header import Header
from breaker.records.motion import LocatedMotion, find_segment
from breaker.records.operations import Operation
from breaker.records.record import Record
from breaker.records.rejections import SeveralMotionsError, UnusableError
from breaker.records.settings import complete, lacking
from breaker.records.sheet import Columns
from breaker.records.words import MOTION_OF, holds

_MANY = 100  # records from which a progress bar is shown: they take more than a second
_OF_A_TRAVEL = {"contact_column", "current_column", "trigger_column", "motor_column"}
_SCALE = ("travel_unit", "ratio", "table", "zero", "sign")
_SAME_RATE = 0.01  # share by which rates may differ: clocks of recorders agree to far less
_SAME_LENGTH = 0.02  # the same of lengths, which are printed rounded


class _Samples(NamedTuple):
    """Samples of a record, whatever its motion.

    Attributes:
        columns: Columns of the file.
        settings: Complete settings.
        time: Even times, ``(n,)``, ms.
        place: Place of each row of the columns among the times, ``(t,)``.
        whole: Travel, ``(n,)``, mm; NaN where there is no sample.
        doubts: Kind of each doubtful sample, ``(n,)`` of text.
        quantum: Step of the reading, mm.
        remarks: Remarks on the file and its times.
    """

    columns: Columns
    settings: Mapping
    time: np.ndarray
    place: np.ndarray
    whole: np.ndarray
    doubts: np.ndarray
    quantum: float
    remarks: tuple[str, ...]

    def at_times(self, values: np.ndarray) -> np.ndarray:
        """Return a column of the file at the even times, ``(n,)``; NaN where there is no sample."""
        placed = np.full(self.time.size, np.nan)
        placed[self.place] = values
        return placed


class Reader:
    """Read records of operations.

    Attributes:
        settings: The section ``endurance.format`` of the configuration; missing keys have their
            default.
        files: Files that are opened, each once.

    Raises:
        ValueError: If a setting is unknown or wrong by itself.
    """

    def __init__(self, settings: Mapping, files: Files | None = None) -> None:
        self.settings = complete(settings)
        self.files = Files() if files is None else files
        self._headers: dict[tuple, Header] = {}
        self._scales: dict[str, Scale] = {}
        self._last: tuple[object, _Samples | None] = None, None

    def header(self, operation: Operation) -> Header:
        """Return what stands above the samples of an operation's file."""
        key = operation.file, operation.channel, operation.line
        if key not in self._headers:
            settings = {**self.settings, **operation.settings}
            self._headers[key] = stated_in(self.files[key[0]], settings, *key[1:])
        return self._headers[key]

    def with_stated(self, operation: Operation, motion: str) -> Operation:
        """Return an operation with its date and the settings that its file states."""
        settings = {**self.settings, **operation.settings}
        stated = self._columns_with(operation, motion, settings)
        header = self.header(operation)
        if settings["rate"] is settings["time_column"] is None and isfinite(header.rate):
            stated["rate"] = header.rate
        date = one_date(operation.date, header.dates, operation.file)
        return replace(operation, date=date, settings={**operation.settings, **stated})

    def read(self, operation: Operation, motion: str) -> Record:
        """Read a motion of an operation.

        Args:
            operation: Operation whose file holds the record.
            motion: "closing" or "opening".

        Raises:
            RejectedCurveError: If the record cannot be used.
        """
        full = self.with_stated(operation, motion)
        new = full.settings.keys() - operation.settings.keys()
        samples = None
        try:
            samples = self._samples_of(full)
            record = _locate(full, samples, motion)
            warning = _contradiction(record, self.header(operation))
        except UnusableError as error:
            reason = str(error)
            if samples and (words := doubts_in_words(samples.time, samples.doubts)):
                reason = f"{reason}; left out: {words}"
            raise RejectedCurveError(operation.file, reason, line=error.line) from error
        remarks = list(record.file_remarks)
        if "rate" in new:
            remarks.append(f"the rate, {in_digits(1.0 / record.step, 4)} kHz, is that of the file")
        if "contact_column" in new:
            column = full.settings["contact_column"]
            remarks.append(f"the contact is that of column {column}, which belongs to the travel")
        return replace(record, file_remarks=tuple(remarks), warning=warning)

    def read_all(
        self, operations: Sequence[Operation], *motions: str
    ) -> list[list[Record | RejectedCurveError]]:
        """Read motions of several operations, each a record or why it cannot be used.

        Returns:
            For each of the motions a list in the order of the operations.
        """
        found: list[list[Record | RejectedCurveError]] = [[] for _ in motions]
        for operation in _with_progress(operations, motions):
            for motion, records in zip(motions, found, strict=True):
                try:
                    records.append(self.read(operation, motion))
                except RejectedCurveError as error:
                    records.append(error)
        return found

    def _samples_of(self, operation: Operation) -> _Samples:
        """Return the samples of a record; those of the last one are kept for another motion."""
        key = operation.file, operation.channel, operation.line, repr(operation.settings)
        if self._last[0] != key:
            self._last = key, self._read_samples(operation)
        return self._last[1]

    def _read_samples(self, operation: Operation) -> _Samples:
        """Read the samples of a record; raise UnusableError or RejectedCurveError."""
        settings, scale = self._scale_of(operation)
        place = operation.channel, operation.line
        columns = read_columns(self.files[operation.file], settings, *place)
        time, place, uneven = even_times(columns.time, columns.lines, settings)
        whole = np.full(time.size, np.nan)
        whole[place] = scale.travel(columns.travel)
        if (count := int(np.isfinite(whole).sum())) < 2:
            raise UnusableError(f"has {count} samples")
        given = settings["quantum"]
        quantum = seen_quantum(whole) if given is None else given
        doubts = doubtful_samples(whole, float(time[-1] - time[0]) / (time.size - 1), quantum)
        remarks = *columns.remarks, uneven
        return _Samples(columns, settings, time, place, whole, doubts, quantum, remarks)

    def _scale_of(self, operation: Operation) -> tuple[dict, Scale]:
        """Return complete settings and the scale of a record; raise UnusableError if one is wrong.

        A table of readings is read once.
        """
        try:
            settings = complete({**self.settings, **operation.settings})
            if text := lacking(settings):
                raise ValueError(text)
            key = repr([settings[name] for name in _SCALE])
            if key not in self._scales:
                self._scales[key] = Scale.from_settings(settings)
            return settings, self._scales[key]
        except ValueError as error:
            row = ", ".join(operation.settings)
            where = f"with {row} of its row in operations.csv or its file: " if row else ""
            raise UnusableError(f"{where}{error}") from error

    def _columns_with(self, operation: Operation, motion: str, settings: Mapping) -> dict:
        """Return the columns that belong to a travel, where neither row nor settings name them."""
        usual, wanted = settings["travel_column"], _OF_A_TRAVEL - operation.settings.keys()
        column = operation.channel or usual
        if column == usual:
            wanted = {key for key in wanted if settings[key] is None}
        if not wanted:
            return {}
        opened = self.files[operation.file]
        with suppress(ValueError):  # reading the record names the reason
            columns = read_columns(opened, settings, operation.channel, operation.line)
            names, kinds = columns.sheet.names, ("motor", "current")
            if len(names) < 2 + (settings["time_column"] is not None):
                return {}  # most files: time and travel alone
            named = not any(names) or any(holds(name, kind) for name in names for kind in kinds)
            if wanted <= {"current_column", "motor_column"} and not named:
                return {}  # contact and coil are named, and there is no other current
            proposed, own = _belonging(opened, column, motion, settings)
            return {
                k: v for k, v in proposed.items() if k in wanted and (own or settings[k] is None)
            }
        return {}


def _belonging(
    opened: Opened, column: str | int, motion: str, settings: Mapping
) -> tuple[dict[str, str | int], bool]:
    """Return the columns that belong to a travel, by key of the settings, and whether the travel is
    another one than that of the settings.
    """
    # Imported here, since most files need neither.
    from breaker.records.contact_columns import current_of
    from breaker.records.description import travel_channels

    layout = look_into(opened)
    place, usual = layout.place_of(column), layout.place_of(settings["travel_column"])
    if place is None:
        return {}, False
    _, columns_by_motion = travel_channels(opened).get(str(layout.column(place)), ("", {}))
    columns = dict(columns_by_motion.get(motion, {}))
    other = usual is not None and place != usual
    if not other and settings["contact_column"] is not None:
        contact = layout.place_of(settings["contact_column"])
        columns.pop("current_column", None)
        if contact is not None and (current := current_of(layout, contact)):
            columns["current_column"] = layout.column(current[0])
    return columns, other


def separate_motions(operation: Operation, error: Exception) -> list[Operation]:
    """Return an operation once for each motion, where it was rejected for having several of one.

    An operation that was rejected for another reason gives an empty list.
    """
    cause = error.__cause__
    parts = cause.parts if isinstance(cause, SeveralMotionsError) else ()
    return [replace(operation, begin=begin, end=end) for begin, end in parts]


def _locate(operation: Operation, samples: _Samples, motion: str) -> Record:
    """Return a motion in samples; raise UnusableError."""
    time, settings, columns = samples.time, samples.settings, samples.columns
    sure = np.where(samples.doubts == "", samples.whole, np.nan)
    segment = find_segment(time, sure, motion, begin=operation.begin, end=operation.end)
    check_slips(time, sure, samples.doubts, segment)
    check_stroke(segment.stroke, settings)
    rest = rest_of_open(segment, settings, motion)
    inside = slice(segment.begin, segment.end)
    moves = first_motion(time[inside], sure[inside], motion)
    located = motion, time, samples.whole, samples.doubts, samples.quantum, segment, *moves
    others = {kind: samples.at_times(values) for kind, values in columns.beside.items()}
    contact, doubtful = events_of(settings, LocatedMotion(*located), others, columns.sheet.names)
    channels = {k: Channel(others[k], amperes) for k, amperes in columns.amperes.items()}
    event = contact.trigger, contact.trigger_sd
    currents = Currents(time, channels, inside, moves[0], *event)
    remarks = *samples.remarks, *doubtful
    return Record(*located, operation, settings, rest, contact, currents, remarks)


def _with_progress(operations: Sequence[Operation], motions: Iterable[str]) -> Iterable[Operation]:
    if len(operations) < _MANY:
        return operations
    from tqdm import tqdm  # imported here, since the import takes longer than one record

    return tqdm(operations, desc=f"read {' and '.join(motions)}", mininterval=5, unit="file")


def _contradiction(record: Record, header: Header) -> str:
    """Return a warning where a file states another rate or length than its record has, or "".

    Raises:
        UnusableError: If the file states another rate than the configuration, or another motion.
    """
    motions = {MOTION_OF[letter] for letter in header.operation.split("-") if letter}
    if motions and record.motion not in motions:
        raise UnusableError(
            f"the file states {header.operation!r} above its samples, and is read as a record of "
            f"{record.motion}: check endurance.format.sign, and the motion that you named"
        )
    name = printable(record.operation.file)
    rate, lasts = 1.0 / record.step, record.time.size * record.step
    timed = record.settings["time_column"] is not None
    if isfinite(header.rate) and abs(header.rate / rate - 1.0) > _SAME_RATE:
        states = f"states {in_digits(header.rate, 4)} kHz"
        if not timed and "rate" not in record.operation.settings:
            raise UnusableError(
                f"the file {states}, and endurance.format.rate is {in_digits(rate, 4)} kHz: leave "
                "that out to read with the stated rate. If the file is wrong, write the rate into "
                "the column rate of operations.csv"
            )
        by = "its column of times" if timed else "operations.csv"
        return f"{name} {states}, and is read at {in_digits(rate, 4)} kHz, by {by}"
    if not timed and isfinite(header.length) and abs(lasts / header.length - 1.0) > _SAME_LENGTH:
        return (
            f"{name} states a length of {in_digits(header.length, 4)} ms, and lasts "
            f"{in_digits(lasts, 4)} ms at {in_digits(rate, 4)} kHz: check endurance.format.rate"
        )
    return ""
