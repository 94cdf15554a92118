"""The curves of an inspection as plain data: tabs for motions, with panels and marks."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from breaker.common.colours import phase_colours
from breaker.diagnosis.curves import Overlay, overlaid, speed_zone
from breaker.diagnosis.estimate import DriveRecord
from breaker.diagnosis.session import Diagnosis
from breaker.records.files import Files, printable
from breaker.records.formats.registry import look_into
from breaker.records.noise import slope
from breaker.records.settings import TO_MS
from breaker.records.sheet import Sheet

_MOST = 4000  # points of a curve: two for each pixel column of a screen
_AROUND = 0.25, 1.0  # times shown before and after the motion, as shares of its duration
_SMOOTH = 1.0  # ms on both sides of a sample in the linear fit whose slope is the velocity
_PANELS = {  # heights in pixels, and labels; an empty label is replaced by the name of the curve
    "travel": (280, "travel (mm)"),
    "velocity": (105, "velocity (m/s)"),
    "contact": (75, ""),
    "test current": (75, ""),
    "coil": (85, ""),
    "resistance": (140, "resistance (µΩ)"),
}
_OF_FILE = 150  # height of other panels, pixels
_CHANNELS = {"contact": "contact", "current": "test current", "trigger": "coil"}


class Tab(NamedTuple):
    """A motion of an operation: title, motion, and the records of its poles, including records
    that could not be read.
    """

    title: str
    motion: str
    records: Sequence[DriveRecord]

    @property
    def read(self) -> list[DriveRecord]:
        """Records that could be read."""
        return [record for record in self.records if record.raw is not None]


class Curve(NamedTuple):
    """A curve: panel, phase, name, times after the tab's origin in ms, and values, ``(n,)``. The
    look is "", "faint" for doubtful samples, or "earlier" or "reference" for other records.
    """

    panel: str
    phase: str
    name: str
    time: np.ndarray
    values: np.ndarray
    look: str = ""


def tabs_of(records: Sequence[DriveRecord]) -> list[Tab]:
    """Return motions with at least one record that was read, closing first, by operation."""
    groups: dict[tuple[str, int], list[DriveRecord]] = {}
    for record in records:
        groups.setdefault((record.motion, record.operation.number), []).append(record)
    motions = [motion for motion, _ in groups]
    tabs = [
        Tab(motion + f" {number}" * (motions.count(motion) > 1), motion, poles)
        for (motion, number), poles in sorted(groups.items())
    ]
    return [tab for tab in tabs if tab.read]


def origins_of(tab: Tab) -> tuple[dict[int, float], str]:
    """Return the origin of the time axis in the time of the file, ms, by record, and the axis name.

    Poles of one file keep its clock. For poles of several files, time counts from the trigger, if
    all have one, or else from the first motion.
    """
    read = tab.read
    if len({str(record.operation.file) for record in read}) <= 1:
        return {id(record): 0.0 for record in read}, "time (ms)"
    triggers = [record.raw.contact.trigger for record in read]
    if np.isfinite(triggers).all():
        return dict(zip(map(id, read), triggers, strict=True)), "time after the trigger (ms)"
    return {id(record): record.raw.moves for record in read}, "time after the first motion (ms)"


def colours_of(names: Sequence[str]) -> dict[str, str]:
    """Return the colour of each phase; black becomes the text colour, light on a dark page."""
    colours = phase_colours(names)
    return {name: colour.replace("#000000", "currentColor") for name, colour in colours.items()}


# ---- curves --------------------------------------------------------------------------------------


def drawn(tab: Tab, diagnosis: Diagnosis, files: Files) -> dict:
    """Return panels with curves, and the initial time window."""
    origins, axis = origins_of(tab)
    laid = [(overlay, "reference") for overlay in diagnosis.overlays]
    earlier, hidden = overlaid(tab.read, diagnosis.before)
    laid += [(overlay, "earlier") for overlay in earlier]
    curves: list[Curve] = []
    begins, ends = [], []
    for record in tab.read:
        raw, operation, zero = record.raw, record.operation, origins[id(record)]
        duration = raw.reading.arrival - raw.moves
        start = min(raw.moves, np.nan_to_num(raw.contact.trigger, nan=np.inf))
        begins.append(start - zero - _AROUND[0] * duration)
        ends.append(raw.reading.arrival - zero + _AROUND[1] * duration)
        curves += _own_curves(record, zero)
        curves += _other_channels(record, look_into(files[operation.file]), zero)
        for overlay, look in laid:
            if overlay.record is record:
                curves.append(_overlay(record, overlay, look, zero))
    phases = [record.operation.phase for record in tab.records]
    colours = colours_of(phases)
    notes = [*dict.fromkeys(hidden)]
    return _panels(curves, (min(begins), max(ends)), colours, axis) | {"notes": notes}


def drawn_file(sheet: Sheet) -> dict:
    """Return all columns of a file without a readable motion, over the sample number, with a panel
    for each unit.
    """
    names = [printable(str(sheet.column(i))) for i in range(len(sheet.columns))]
    samples, curves = np.arange(sheet.columns[0].size, dtype=float), []
    for name, unit, values in zip(names, sheet.units, sheet.columns, strict=True):
        if np.isfinite(values).any() and np.nanmin(values) < np.nanmax(values):
            curves.append(Curve(printable(unit or "reading"), name, name, samples, values))
    window = 0.0, float(samples.size)
    return _panels(curves, window, colours_of(names), "sample") | {"notes": []}


def _panels(
    curves: Sequence[Curve], window: tuple[float, float], colours: Mapping[str, str], axis: str
) -> dict:
    """Return panels with curves, the initial time window, and the name of the time axis."""
    panels = []
    for name in dict.fromkeys([*_PANELS, *(curve.panel for curve in curves)]):
        lines = [_line(curve, window, colours) for curve in curves if curve.panel == name]
        if lines:
            height, label = _PANELS.get(name, (_OF_FILE, name))
            about = {"name": name, "height": height, "label": label or lines[0]["name"]}
            panels.append(about | {"curves": lines})
    return {"window": window, "axis": axis, "panels": panels}


def _own_curves(record: DriveRecord, zero: float) -> Iterator[Curve]:
    """Yield travel, velocity and resistance of a record over time."""
    raw, phase = record.raw, record.operation.phase
    time, doubtful = raw.time - zero, np.where(raw.doubts == "", np.nan, raw.whole)
    yield Curve("travel", phase, "travel", time, raw.sure)
    if np.isfinite(doubtful).any():
        yield Curve("travel", phase, "doubtful samples", time, doubtful, "faint")
    half = max(2, round(_SMOOTH / raw.step))
    yield Curve("velocity", phase, "velocity", time, slope(raw.sure, half, raw.step))
    if np.isfinite(raw.resistance).any():
        yield Curve("resistance", phase, "resistance", time, raw.resistance)


def _other_channels(record: DriveRecord, sheet: Sheet, zero: float) -> Iterator[Curve]:
    """Yield contact and currents of a record, over time."""
    settings, raw, phase = record.raw.settings, record.raw, record.operation.phase
    time = np.arange(sheet.columns[0].size) * raw.step - zero
    if settings.get("time_column") is not None:
        place = sheet.place_of(settings["time_column"])
        time = sheet.columns[place] * TO_MS[settings["time_unit"]] - zero
    for key, panel in _CHANNELS.items():
        column = settings.get(f"{key}_column")
        place = None if column in (None, 0) else sheet.place_of(column)
        if place is not None:
            unit = f" ({printable(sheet.units[place])})" if sheet.units[place] else ""
            yield Curve(panel, phase, f"{panel}{unit}", time, sheet.columns[place])


def _overlay(record: DriveRecord, other: Overlay, look: str, zero: float) -> Curve:
    """Return the curve of another record, aligned to this record at rest and first motion."""
    sign = 1.0 if record.motion == "closing" else -1.0
    travel = record.raw.segment.before + sign * other.good
    name = f"{look}: {printable(other.reference.operation.file).rpartition('/')[2]}"
    time = other.time + record.raw.moves - zero
    return Curve("travel", record.operation.phase, name, time, travel, look)


def _line(curve: Curve, window: tuple[float, float], colours: Mapping[str, str]) -> dict:
    colour = "currentColor" if curve.look == "reference" else colours[curve.phase]
    about = {"phase": curve.phase, "name": curve.name, "look": curve.look, "colour": colour}
    x, y = map(_plain, thinned(curve, *window))
    return about | {"x": x, "y": y}


def _plain(values: np.ndarray) -> list[float | None]:
    """Return numbers for JSON, rounded to 1e-4, which a screen resolves only after a zoom."""
    rounded = np.round(values.astype(float), 4)
    return np.where(np.isfinite(rounded), rounded, None).tolist()


def thinned(curve: Curve, begin: float, end: float) -> tuple[np.ndarray, np.ndarray]:
    """Return times and values ``(m,)`` of a curve in a window and one window width on both sides:
    all samples, or the smallest and largest value of each part.

    >>> some = Curve("travel", "", "", np.arange(20_000.0), np.arange(20_000.0))
    >>> thinned(some, 0.0, 20_000.0)[0].size, thinned(some, 10.0, 19.0)[0].size
    (4000, 27)
    """
    wide = end - begin
    kept = np.arange(*np.searchsorted(curve.time, (begin - wide, end + wide)))
    if kept.size > _MOST:
        parts = np.pad(kept, (0, -kept.size % (_MOST // 2)), "edge").reshape(_MOST // 2, -1)
        low = np.nan_to_num(curve.values, nan=np.inf)[parts].argmin(axis=1)
        high = np.nan_to_num(curve.values, nan=-np.inf)[parts].argmax(axis=1)
        kept = np.union1d(*(parts[np.arange(len(parts)), column] for column in (low, high)))
    return curve.time[kept], curve.values[kept]


# ---- marks ---------------------------------------------------------------------------------------


def marks_of(tab: Tab, diagnosis: Diagnosis) -> list[dict]:
    """Return marks of events and speed zone of each pole: name, phase, colour, and points."""
    phases, marks = [record.operation.phase for record in tab.records], []
    colours = colours_of(phases)
    origins, _ = origins_of(tab)
    for estimate in diagnosis.estimates:
        record, raw = estimate.record, estimate.record.raw
        if record not in tab.read:
            continue
        event = "touch" if tab.motion == "closing" else "separation"
        times: dict[str, Any] = {
            "trigger": [raw.contact.trigger],
            "first motion": [raw.moves],
            event + " (inferred)" * (not record.timed): [estimate.contact.time],
            "speed zone": speed_zone(estimate) or [np.nan],
        }
        known = np.isfinite(raw.sure)
        for name, instants in times.items():
            if np.isfinite(instants).all():
                y = np.interp(instants, raw.time[known], raw.sure[known])
                x = np.asarray(instants) - origins[id(record)]
                about = {"name": name, "phase": record.operation.phase}
                about["colour"] = colours[record.operation.phase]
                marks.append(about | {"x": x.tolist(), "y": y.tolist()})
    return marks
