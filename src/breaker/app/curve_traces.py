"""The curves of a page: every channel of each file, the marks on it, and readings at two cursors.

Samples are those of the file, thinned to the lowest and highest of each part where there are more
than a screen shows; a part that is zoomed into is sent anew.
"""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from breaker.diagnosis.curves import Overlay
from breaker.diagnosis.estimate import DriveRecord, Estimate
from breaker.records.files import printable
from breaker.records.measurements import Reading
from breaker.records.settings import TO_MS
from breaker.records.sheet import Sheet
from breaker.records.words import holds

MOST = 3000
"""Points of a trace that are sent at once."""


class Trace(NamedTuple):
    """A channel.

    Attributes:
        name, unit: What it is called; the unit is as in the file, or mm.
        kind: "travel", "contact", "coil" or "other".
        time, reading: Its samples, ``(t,)``, ms of the file.
        laid: Whether it is of another record, laid over one of these.
        band: Half of the band about it, of its unit; nan without one.
    """

    name: str
    unit: str
    kind: str
    time: np.ndarray
    reading: np.ndarray
    laid: bool = False
    band: float = np.nan


class Mark(NamedTuple):
    """A time, or a zone between two, that is measured or inferred.

    Attributes:
        name, channel: What it is, and of which channel.
        start, stop: ms of the file; the same where it is no zone.
        low, high: Travel there, mm; nan where none is.
        inferred: Whether the model tells it.
    """

    name: str
    channel: str
    start: float
    stop: float
    low: float
    high: float
    inferred: bool = False


def record_traces(records: Sequence[DriveRecord], layouts: Sequence[Sheet]) -> list[Trace]:
    """Return travels as they were read, and all other columns as they are in their files.

    Args:
        records: Of the visit; those that were rejected have none.
        layouts: What is in each of the files. Where no record was read, their times are the numbers
            of samples, as nobody knows them; else those of other files are left out.
    """
    labels, travels = _labels(records, layouts), {}
    beside: dict[str, list[DriveRecord]] = {}
    for each in records:
        if each.raw is None:
            continue
        file, column = str(each.operation.file), each.raw.settings["travel_column"]
        column = each.operation.channel or column
        beside.setdefault(file, []).append(each)
        name, phase = printable(str(column)), each.operation.phase
        name = name if phase in ["", *name.split()] else f"{name} {phase}"
        found = Trace(name, "mm", "travel", each.raw.time, each.raw.sure)
        travels.setdefault((file, str(column)), found)
    found = [(file, trace) for (file, _), trace in travels.items()]
    for layout in layouts:
        file = str(layout.file)
        if beside and file not in beside:
            continue  # nobody knows its times, and others are shown over theirs
        taken = {column for of, column in travels if of == file}
        found += [(file, each) for each in _columns(layout, beside.get(file, ()), taken)]
    return [each._replace(name=labels.get(file, "") + each.name) for file, each in found]


def _labels(records: Sequence[DriveRecord], layouts: Sequence[Sheet]) -> dict[str, str]:
    """The file before the names of its channels, where there are several files."""
    files = {str(e.file) for e in layouts} | {str(e.operation.file) for e in records}
    return {file: f"{_plain(file)}: " for file in files} if len(files) > 1 else {}


def _plain(file: str) -> str:
    return printable(file).rpartition("/")[2]


def _columns(layout: Sheet, own: Sequence[DriveRecord], taken: set[str]) -> Iterator[Trace]:
    """The columns of a file beside those of travel that were read and of the time: first those that
    its records take for contact and coil.
    """
    form = own[0].raw.settings if own else layout.settings
    place = None if form.get("time_column") is None else layout.place_of(form["time_column"])
    if place is not None:
        time = layout.columns[place] * TO_MS[form["time_unit"]]
    else:
        time = np.arange(layout.columns[0].size) * (own[0].raw.step if own else 1.0)
    kinds = {
        layout.place_of(each.raw.settings[f"{key}_column"]): kind
        for key, kind in (("contact", "contact"), ("trigger", "coil"))
        for each in own
        if each.raw.settings.get(f"{key}_column") is not None
    }
    last = []
    for i, values in sorted(enumerate(layout.columns), key=lambda pair: pair[0] not in kinds):
        column = layout.column(i)
        if i == place or str(column) in taken or not np.isfinite(values).any():
            continue
        if np.nanmin(values) == np.nanmax(values):
            continue  # an unused channel
        named = (kind for kind in ("coil", "contact") if holds(layout.names[i], kind))
        kind = kinds.get(i) or next(named, "other")
        found = Trace(printable(str(column)), layout.units[i] or "", kind, time, values)
        if i not in kinds and kind in kinds.values():
            last.append(found._replace(kind="other"))  # of no record: of another pole, or of none
        else:
            yield found
    yield from last


def laid_over(
    records: Sequence[DriveRecord],
    overlays: Sequence[Overlay],
    what: str,
    *,
    band: bool = False,
) -> list[Trace]:
    """Return other records laid over those of a visit, at its times and from its rests.

    Args:
        records: Of the visit.
        overlays: Of these over others, from ``curves.overlaid``.
        what: What the others are.
        band: Whether the band about them is shown.
    """
    of = {}
    for each in records:
        own = each.operation
        of[own.number, each.motion, own.phase, str(own.file)] = each.raw
    found = []
    for each in overlays:
        raw = of[each.operation, each.motion, each.phase, each.file]
        sign = 1.0 if each.motion == "closing" else -1.0
        name = f"{what}: {_plain(each.good_file)}, {each.motion} {each.phase}".rstrip()
        reading = raw.segment.before + sign * each.good
        half = each.band if band else np.nan
        time = each.time + raw.moves
        found.append(Trace(name, "mm", "travel", time, reading, laid=True, band=half))
    return found


def marks_of(answers: Sequence[Estimate]) -> list[Mark]:
    """Return the times that are measured or inferred, and the zones of speeds."""
    return [mark for each in answers if each.record.raw is not None for mark in _marks(each)]


def _marks(answer: Estimate) -> list[Mark]:
    """Those of a record, at times of its file."""
    record, contact = answer.record, answer.contact
    channel = record.operation.phase
    reading = Reading(record.raw, contact)
    sign = 1.0 if record.motion == "closing" else -1.0
    found = []
    if not record.raw.reading.start_hidden:
        moves, level = [record.raw.moves] * 2, _level(record, record.raw.moves)
        found.append(Mark(f"{record.motion}: first motion", channel, *moves, *[level] * 2))
    if np.isfinite(contact.time):
        event = "touch" if record.motion == "closing" else "separation"
        level, inferred = _level(record, contact.time), not record.timed
        name = f"{record.motion}: {event}" + " (inferred)" * inferred
        found.append(Mark(name, channel, *[contact.time] * 2, *[level] * 2, inferred))
    if np.isfinite(trigger := record.raw.contact.trigger):
        found.append(Mark(f"{record.motion}: coil", channel, *[trigger] * 2, *[np.nan] * 2))
    for speed in answer.speeds:
        if speed.motion == record.motion and not answer.measured[speed.name].reason:
            (start, low), (stop, high) = map(reading.place, (speed.start, speed.end))
            ends = start.value, stop.value, sign * low.value, sign * high.value
            told = speed.of_event and not record.timed
            found.append(Mark(speed.name.replace("_", " "), channel, *ends, told))
    return found


def _level(record: DriveRecord, at: float) -> float:
    raw = record.raw
    time, left = raw.time[raw.inside], raw.left
    known = np.isfinite(left)
    return float(np.interp(at, time[known], left[known]))


def thinned(trace: Trace, begin: float, end: float) -> dict[str, list]:
    """Return the points of a trace between two times: all, or of each part the lowest and highest.

    >>> trace = Trace("a", "", "other", np.arange(9000.0), np.arange(9000.0))
    >>> len(thinned(trace, 0, 9000)["x"]), len(thinned(trace, 10, 19)["x"])
    (3000, 12)
    """
    first, last = np.searchsorted(trace.time, (begin, end))
    kept = np.arange(max(first - 1, 0), min(last + 2, trace.time.size))
    if kept.size > MOST:
        parts = np.array_split(kept, MOST // 2)
        above, below = (np.nan_to_num(trace.reading, nan=each) for each in (np.inf, -np.inf))
        low = [part[np.argmin(above[part])] for part in parts]
        high = [part[np.argmax(below[part])] for part in parts]
        kept = np.sort(np.concatenate([low, high]))
    x, y = trace.time[kept], trace.reading[kept]
    ends = {"low": y - trace.band, "high": y + trace.band} if math.isfinite(trace.band) else {}
    return {name: plain(each) for name, each in {"x": x, "y": y, **ends}.items()}


def plain(values: np.ndarray) -> list[float | None]:
    """Return numbers for JSON, which has no nan."""
    return [each if math.isfinite(each) else None for each in np.round(values, 6).tolist()]


def at_cursors(
    traces: Sequence[Trace], first: float, second: float
) -> list[tuple[Trace, float, float]]:
    """Return each trace with its readings at the samples nearest to two times, ms; nan where it has
    none.
    """
    return [(each, _nearest(each, first), _nearest(each, second)) for each in traces]


def _nearest(trace: Trace, at: float) -> float:
    if not (trace.time.size and trace.time[0] <= at <= trace.time[-1]):
        return np.nan
    return float(trace.reading[np.nanargmin(np.abs(trace.time - at))])
