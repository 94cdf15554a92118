"""Read the records of operations, with the settings of the configuration and of their files.

Settings count in this order: the row of ``operations.csv``, what the file states (its rate, and the
columns of contact and coil that belong to the travel), the configuration, the defaults. A
record that cannot be used is rejected with the name of its file, the line where there is one, and
the reason; the other records are read.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from math import isfinite
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.records.checks import (
    check_slips,
    check_stroke,
    doubtful_samples,
    doubts_in_words,
    open_rest,
)
from breaker.records.contacts import events_of
from breaker.records.conversion import even_times, seen_quantum, travel_of
from breaker.records.currents import Currents
from breaker.records.dates import one_date
from breaker.records.files import Files, Opened, RejectedCurveError, printable
from breaker.records.first_motion import first_motion
from breaker.records.formats.detection import look_into, read_columns, stated_in
from breaker.records.header import Header
from breaker.records.motion import LocatedMotion, find_segment
from breaker.records.operations import Operation
from breaker.records.record import Record
from breaker.records.rejections import OtherMotionError, SeveralMotionsError, UnusableError
from breaker.records.settings import SAME_RATE, TO_MS, complete, lacking
from breaker.records.sheet import Columns, Sheet
from breaker.records.words import MOTION_OF

_SAME_STROKE, _ROUNDED = 0.02, 0.5  # tolerance of stated strokes, share and mm; ratios exceed it


class _Samples(NamedTuple):
    """Samples of a record with any motion, at even times, ms; travel and quantum in mm."""

    columns: Columns
    settings: Mapping
    time: np.ndarray
    place: np.ndarray  # place of each row of the columns among the times
    travel: np.ndarray
    doubts: np.ndarray
    quantum: float
    remarks: tuple[str, ...]


class Reader:
    """Read records of operations, with the section ``endurance.format`` of the configuration.

    Raises:
        ValueError: If a setting is unknown or wrong by itself.
    """

    def __init__(self, settings: Mapping, files: Files | None = None) -> None:
        self.settings = complete(settings)
        self.files = Files() if files is None else files
        self._header: tuple[object, Header | None] = None, None  # key and header of the last file
        self._last: tuple[object, _Samples | None] = None, None  # the same of its samples

    def header(self, operation: Operation) -> Header:
        """Return the header of an operation's file."""
        key = operation.file, operation.channel, operation.line
        if self._header[0] != key:
            settings = {**self.settings, **operation.settings}
            self._header = key, stated_in(self.files[key[0]], settings, *key[1:])
        return self._header[1]

    def with_stated(self, operation: Operation, motion: str) -> Operation:
        """Return an operation with its date and the settings that its file states."""
        settings, header = {**self.settings, **operation.settings}, self.header(operation)
        stated = {}
        with suppress(ValueError):  # reading the record names the reason
            stated = _columns_of(self.files[operation.file], operation, motion, settings)
        if settings["rate"] is settings["time_column"] is None and isfinite(header.rate):
            stated["rate"] = header.rate
        date = one_date(operation.date, header.dates, operation.file)
        return replace(operation, date=date, settings={**stated, **operation.settings})

    def read(self, operation: Operation, motion: str) -> Record:
        """Read a motion, "closing" or "opening", of an operation.

        Raises:
            RejectedCurveError: If the record cannot be used.
        """
        full, doubts = self.with_stated(operation, motion), ""
        new = {"rate", "contact_column"} & (full.settings.keys() - operation.settings.keys())
        stated = [f"{k.replace('_', ' ')} {full.settings[k]}, by the file" for k in sorted(new)]
        try:
            samples = self._samples_of(full)
            doubts = doubts_in_words(samples.time, samples.doubts)
            return _locate(full, samples, motion, stated, self.header(operation))
        except UnusableError as error:
            reason = f"{error}; left out: {doubts}" if doubts else str(error)
            raise RejectedCurveError(operation.file, reason, line=error.line) from error

    def read_all(
        self, operations: Sequence[Operation], *motions: str
    ) -> list[list[Record | RejectedCurveError]]:
        """Read several operations; return for each motion a list of records or rejections."""
        results: list[list[Record | RejectedCurveError]] = [[] for _ in motions]
        for operation in operations:
            for motion, records in zip(motions, results, strict=True):
                try:
                    records.append(self.read(operation, motion))
                except RejectedCurveError as error:
                    records.append(error)
        return results

    def _samples_of(self, operation: Operation) -> _Samples:
        """Return the samples of a record; keep them for its other motion."""
        key = operation.file, operation.channel, operation.line, repr(operation.settings)
        if self._last[0] == key:
            return self._last[1]
        try:
            settings = complete({**self.settings, **operation.settings})
            if text := lacking(settings):
                raise UnusableError(text)
        except ValueError as error:
            keys = ", ".join(operation.settings)
            where = f"with {keys} of its row in operations.csv or its file: " if keys else ""
            raise UnusableError(f"{where}{error}") from error
        place = operation.channel, operation.line
        columns = read_columns(self.files[operation.file], settings, *place)
        if columns.time is None:
            _check_rate(columns.sheet, settings["rate"])
        time, place, uneven = even_times(columns.time, columns.lines, settings)
        travel = np.full(time.size, np.nan)
        travel[place] = travel_of(columns.travel, settings)
        if (count := int(np.isfinite(travel).sum())) < 2:
            raise UnusableError(f"has {count} samples")
        given = settings["quantum"]
        quantum = seen_quantum(travel) if given is None else given
        doubts = doubtful_samples(travel, float(time[-1] - time[0]) / (time.size - 1), quantum)
        if not doubts.astype(bool).any():  # saves memory: there may be ten thousand records
            doubts = np.broadcast_to(doubts[:1], doubts.shape)
        samples = columns, settings, time, place, travel, doubts, quantum
        self._last = key, _Samples(*samples, (*columns.remarks, uneven))
        return self._last[1]


def _check_rate(sheet: Sheet, rate: float) -> None:
    """Raise UnusableError if a column of times with a unit contradicts a rate that replaces it."""
    from breaker.records.channels import find_clock  # most files are read by their times

    try:
        clock = find_clock(sheet)
    except RejectedCurveError:  # times that decrease contradict nothing
        return
    if clock.place is None or clock.remarks:
        return
    times = sheet.columns[clock.place][np.isfinite(sheet.columns[clock.place])]
    seen = (times.size - 1) / (TO_MS[clock.unit] * float(times[-1] - times[0]))
    if abs(seen / rate - 1.0) > SAME_RATE:
        raise UnusableError(
            f"the times give {in_digits(seen, 4)} kHz, but endurance.format.rate is {rate:.4g} "
            f"kHz; set time_column to {sheet.column(clock.place)!r}, or correct the rate"
        )


def _columns_of(opened: Opened, operation: Operation, motion: str, settings: Mapping) -> dict:
    """Return the columns that belong to a travel, by key of the settings; for the usual travel,
    only columns that the settings do not name.
    """
    columns = read_columns(opened, settings, operation.channel, operation.line)
    usual = settings["travel_column"]
    if len(columns.sheet.names) < 2 + (settings["time_column"] is not None):
        return {}  # most files have only time and travel
    # Imported here, since most files need neither.
    from breaker.records.channels import current_of
    from breaker.records.description import travel_channels

    layout = look_into(opened, operation.channel or usual)
    place = layout.place_of(operation.channel or usual)
    if place is None:
        return {}
    channels = travel_channels(opened, operation.channel or usual)
    paired = channels.get(str(layout.column(place)), ("", {}))[1].get(motion, {})
    if layout.place_of(usual) not in (None, place):
        return {**paired}
    contact = settings["contact_column"]
    if contact is not None and (place := layout.place_of(contact)) is not None:
        currents = [layout.column(i) for i in current_of(layout, place)]
        paired = {**paired, "current_column": (*currents, None)[0]}
    return {key: column for key, column in paired.items() if settings[key] is None and column}


def separate_motions(operation: Operation, error: Exception) -> list[Operation]:
    """Return an operation for each part, if the record was rejected because a motion occurs several
    times; otherwise an empty list.
    """
    cause = error.__cause__
    parts = cause.parts if isinstance(cause, SeveralMotionsError) else ()
    return [replace(operation, begin=begin, end=end) for begin, end in parts]


def _locate(
    operation: Operation, samples: _Samples, motion: str, stated: Sequence[str], header: Header
) -> Record:
    """Return the record of a motion in samples; raise UnusableError if it cannot be used."""
    warning = _contradiction(operation, samples, motion, header)
    time, settings, columns = samples.time, samples.settings, samples.columns
    sure = np.where(samples.doubts == "", samples.travel, np.nan)
    segment = find_segment(time, sure, motion, begin=operation.begin, end=operation.end)
    check_slips(time, sure, samples.doubts, segment)
    check_stroke(segment.stroke, settings)
    rest, _ = open_rest(segment, settings, motion)
    inside = slice(segment.begin, segment.end)
    moves = first_motion(time[inside], sure[inside], motion)
    located = motion, time, samples.travel, samples.doubts, samples.quantum, segment, *moves
    others = {kind: np.full(time.size, np.nan) for kind in columns.paired}
    for kind, values in columns.paired.items():
        others[kind][samples.place] = values
    contact, doubtful = events_of(settings, LocatedMotion(*located), others, columns.sheet.names)
    currents = Currents(time, others, columns.sizes, motion, inside, moves[0], contact)
    remarks = *samples.remarks, *doubtful, *stated
    warning = warning or _other_stroke(operation, segment.stroke, header.strokes)
    record = Record(*located, operation, settings, rest, contact, currents, remarks, warning)
    _ = record.reading  # raises if the motion does not reach its rest
    return record


def _contradiction(operation: Operation, samples: _Samples, motion: str, header: Header) -> str:
    """Return a warning if a file states another rate than its record has, or "".

    Raises:
        UnusableError: If the file contradicts the configured rate, or states another motion.
    """
    motions = {MOTION_OF[letter] for letter in header.operation.split("-") if letter}
    if motions and motion not in motions:
        raise OtherMotionError(
            f"the file states {header.operation!r} above its samples, and is read as a record of "
            f"{motion}: check endurance.format.sign, and the motion"
        )
    rate = 1.0 / float(samples.time[1] - samples.time[0])
    if not abs(header.rate / rate - 1.0) > SAME_RATE:
        return ""
    states = f"states {in_digits(header.rate, 4)} kHz, and is read at {in_digits(rate, 4)} kHz"
    if samples.settings["time_column"] is None and "rate" not in operation.settings:
        raise UnusableError(
            f"{states}: leave endurance.format.rate out to read with the stated rate, or if "
            "the file is wrong, write the rate into the column rate of operations.csv"
        )
    return f"{printable(operation.file)} {states}"


def _other_stroke(operation: Operation, stroke: float, stated: Sequence[float]) -> str:
    """Return a warning if all strokes that a file states differ from the record's, or ""."""
    if not stated or min(abs(mm - stroke) for mm in stated) <= _SAME_STROKE * stroke + _ROUNDED:
        return ""
    strokes = " and ".join(dict.fromkeys(in_digits(mm, 4) for mm in stated))
    return (
        f"{printable(operation.file)} states a stroke of {strokes} mm, and is read with "
        f"{in_digits(stroke, 4)} mm. Check the unit, the ratio and the channel"
    )
