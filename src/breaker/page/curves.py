"""The curves of an inspection as plain data: a tab for each motion, its panels, and its marks."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from breaker.common.colours import phase_colours
from breaker.diagnosis.curves import Overlay, not_overlaid, overlaid
from breaker.diagnosis.estimate import DriveRecord, Estimate
from breaker.diagnosis.session import Diagnosis
from breaker.model.quantities import OF_STROKE, SHARES
from breaker.records.files import Files, printable
from breaker.records.formats.registry import look_into
from breaker.records.settings import TO_MS
from breaker.records.sheet import Sheet

_MOST = 4000  # points of a curve, twice as many as a screen has columns: ends of each part stay
_AROUND = 0.25, 1.0  # durations of the motion that are shown before and after it
_SMOOTH = 1.0  # ms on both sides of the straight lines whose slopes are the velocity
_PANELS = {  # heights in pixels, and labels; those without one have the label of their curve
    "travel": (280, "travel (mm)"),
    "velocity": (105, "velocity (m/s)"),
    "contact": (75, ""),
    "test current": (75, ""),
    "coil": (85, ""),
    "resistance": (190, "resistance (µΩ)"),
}
_OF_FILE = 150  # height of the panel of a unit, pixels
_CHANNELS = {"contact": "contact", "current": "test current", "trigger": "coil", "motor": "coil"}


class Tab(NamedTuple):
    """A motion of an operation: its title, motion, and the records of its poles, of which some may
    not be ``read``.
    """

    title: str
    motion: str
    records: Sequence[DriveRecord]

    @property
    def read(self) -> list[DriveRecord]:
        """The records that were read."""
        return [record for record in self.records if record.raw is not None]


class Curve(NamedTuple):
    """A curve: its panel, phase, name, times after the tab's origin in ms, and values, ``(n,)``; a
    resistance has travels in place of times. Its look is "", "faint" for doubtful samples, or
    "earlier" or "reference" for other records.
    """

    panel: str
    phase: str
    name: str
    time: np.ndarray
    values: np.ndarray
    look: str = ""


def tabs_of(records: Sequence[DriveRecord]) -> list[Tab]:
    """Return the motions of which a record was read, closing first, in the order of operations."""
    groups: dict[tuple[str, int], list[DriveRecord]] = {}
    for record in records:
        groups.setdefault((record.motion, record.operation.number), []).append(record)
    motions = [motion for motion, _ in groups]
    tabs = [
        Tab(motion + f" {number}" * (motions.count(motion) > 1), motion, some)
        for (motion, number), some in sorted(groups.items())
    ]
    return [tab for tab in tabs if tab.read]


def origins_of(tab: Tab) -> tuple[dict[int, float], str]:
    """Return the time of the file that is zero, ms, by record, and the name of the time axis.

    Poles of one file keep its clock; those of several are shown from the trigger, if all have one,
    or else from the first motion.
    """
    read = tab.read
    if len({str(record.operation.file) for record in read}) <= 1:
        return {id(record): 0.0 for record in read}, "time (ms)"
    triggers = [record.raw.contact.trigger for record in read]
    if np.isfinite(triggers).all():
        return dict(zip(map(id, read), triggers, strict=True)), "time after the trigger (ms)"
    return {id(record): record.raw.moves for record in read}, "time after the first motion (ms)"


def colours_of(names: Sequence[str], own: Mapping[str, str]) -> dict[str, str]:
    """Return the colour of each phase; black is the colour of text, which a dark page has light."""
    colours = phase_colours(names, own)
    return {name: colour.replace("#000000", "currentColor") for name, colour in colours.items()}


# ---- curves --------------------------------------------------------------------------------------


def drawn(tab: Tab, diagnosis: Diagnosis, files: Files, own: Mapping[str, str]) -> dict:
    """Return panels with curves, and the times that are shown first; ``own`` are colours."""
    origins, axis = origins_of(tab)
    laid = [(overlay, "reference") for overlay in diagnosis.overlays]
    laid += [(overlay, "earlier") for overlay in overlaid(diagnosis.records, diagnosis.before)]
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
        key = operation.number, record.motion, operation.phase, str(operation.file)
        for overlay, look in laid:
            if key == (overlay.operation, overlay.motion, overlay.phase, overlay.file):
                curves.append(_overlay(record, overlay, look, zero))
    colours = colours_of([record.operation.phase for record in tab.records], own)
    window, panels = (min(begins), max(ends)), []
    for panel, (height, label) in _PANELS.items():
        some = [curve for curve in curves if curve.panel == panel]
        if some:
            lines = [_line(curve, window, colours) for curve in some]
            panels.append(_panel(panel, height, label or some[0].name, lines))
    notes = [*dict.fromkeys(not_overlaid(tab.read, diagnosis.before))]
    return {"window": window, "axis": axis, "panels": panels, "notes": notes}


def drawn_file(sheet: Sheet) -> dict:
    """Return all columns of a file of which nothing could be read, over the number of samples, with
    a panel for each unit.
    """
    names = [printable(str(sheet.column(i))) for i in range(len(sheet.columns))]
    samples = np.arange(sheet.columns[0].size, dtype=float)
    colours, window = colours_of(names, {}), (0.0, float(samples.size))
    panels: dict[str, list[dict]] = {}
    for name, unit, values in zip(names, sheet.units, sheet.columns, strict=True):
        if np.isfinite(values).any() and np.nanmin(values) < np.nanmax(values):
            curve = Curve("", name, name, samples, values)
            panels.setdefault(printable(unit or "reading"), []).append(
                _line(curve, window, colours)
            )
    drawn_panels = [_panel("", _OF_FILE, unit, lines) for unit, lines in panels.items()]
    return {"window": window, "axis": "sample", "panels": drawn_panels, "notes": []}


def _own_curves(record: DriveRecord, zero: float) -> Iterator[Curve]:
    """Yield travel and velocity over time, and the resistance over travel, which shows the arcing
    contact.
    """
    raw, phase = record.raw, record.operation.phase
    time, doubtful = raw.time - zero, np.where(raw.doubts == "", np.nan, raw.whole)
    yield Curve("travel", phase, "travel", time, raw.sure)
    if np.isfinite(doubtful).any():
        yield Curve("travel", phase, "doubtful samples", time, doubtful, "faint")
    yield Curve("velocity", phase, "velocity", time, _velocity(raw.sure, raw.step))
    if np.isfinite(raw.resistance).any():
        at = raw.sure[raw.inside], raw.resistance[raw.inside]
        yield Curve("resistance", phase, "resistance", *at)


def _velocity(travel: np.ndarray, step: float) -> np.ndarray:
    """Return the slope of straight lines through the travel, ``(n,)``, m/s; nan where none is."""
    known, half = np.isfinite(travel), max(2, round(_SMOOTH / step))
    if travel.size < 4 * half or known.sum() < 2:
        return np.full(travel.size, np.nan)
    places = np.arange(-half, half + 1)
    filled = np.interp(np.arange(travel.size), np.flatnonzero(known), travel[known])
    slopes = np.convolve(filled, -places / (step * np.square(places).sum()), "same")
    slopes[:half] = slopes[-half:] = np.nan  # lines that reach beyond the ends
    return np.where(known, slopes, np.nan)


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
    """Return another record, aligned at half of the travel."""
    way, good = np.nan_to_num(other.way), np.nan_to_num(other.good)
    half = 0.5 * record.shape.stroke
    shift = other.time[int((way > half).argmax())] - other.time[int((good > half).argmax())]
    sign = 1.0 if record.motion == "closing" else -1.0
    travel = record.raw.segment.before + sign * other.good
    name = f"{look}: {printable(other.good_file).rpartition('/')[2]}"
    time = other.time + record.raw.moves + shift - zero
    return Curve("travel", record.operation.phase, name, time, travel, look)


def _panel(name: str, height: int, label: str, lines: Sequence[dict]) -> dict:
    return {"name": name, "height": height, "label": label, "curves": lines}


def _line(
    curve: Curve, window: tuple[float, float], colours: Mapping[str, str]
) -> dict[str, object]:
    x, y = curve.time, curve.values
    if curve.panel != "resistance":
        x, y = thinned(curve, *window)
    colour = "currentColor" if curve.look == "reference" else colours[curve.phase]
    about = {"phase": curve.phase, "name": curve.name, "look": curve.look, "colour": colour}
    return about | {"x": _plain(x), "y": _plain(y)}


def _plain(values: np.ndarray) -> list[float | None]:
    """Return numbers as JSON has them, with as many digits as a screen shows after a zoom."""
    rounded = np.round(values.astype(float), 4)
    return np.where(np.isfinite(rounded), rounded, None).tolist()


def thinned(curve: Curve, begin: float, end: float) -> tuple[np.ndarray, np.ndarray]:
    """Return times and values ``(m,)`` of a curve in a window and around it for as long: all, or
    the ends of each part.

    >>> some = Curve("travel", "", "", np.arange(20_000.0), np.arange(20_000.0))
    >>> thinned(some, 0.0, 20_000.0)[0].size, thinned(some, 10.0, 19.0)[0].size
    (4000, 27)
    """
    wide = end - begin
    first, last = np.searchsorted(curve.time, (begin - wide, end + wide))
    kept = np.arange(first, last)
    if kept.size > _MOST:
        parts = np.pad(kept, (0, -kept.size % (_MOST // 2)), "edge").reshape(_MOST // 2, -1)
        low = np.nan_to_num(curve.values, nan=np.inf)[parts].argmin(axis=1)
        high = np.nan_to_num(curve.values, nan=-np.inf)[parts].argmax(axis=1)
        kept = np.union1d(*(parts[np.arange(len(parts)), at] for at in (low, high)))
    return curve.time[kept], curve.values[kept]


# ---- marks ---------------------------------------------------------------------------------------

_SPOTS = {  # events between which a quantity is measured
    "stroke": ("begin", "end"),
    "reaction_time": ("trigger", "first motion"),
    **dict.fromkeys(("touch_time", "separation_time"), ("first motion", "contact")),
    **dict.fromkeys(("closing_time", "opening_time"), ("trigger", "contact")),
    **dict.fromkeys(("main_closing_time", "main_opening_time"), ("trigger", "main")),
    **dict.fromkeys(("over_travel", "opening_over_travel"), ("arrival", "end")),
    **{"closing_wipe": ("contact", "end"), "opening_wipe": ("begin", "contact")},
    **dict.fromkeys(("arcing_wipe", "arcing_resistance"), ("arcing", "main")),
}


def spots_of(estimate: Estimate) -> dict[str, tuple[float, float]]:
    """Return from when to when each quantity of a record is measured, ms of its file, by name."""
    raw, contact, measured = estimate.record.raw, estimate.contact, estimate.measured
    reading = raw.reading.with_contact(contact, estimate.speeds, raw.currents)
    begin, end = raw.time[raw.inside][[0, -1]]
    events = {"begin": begin, "end": end, "first motion": raw.moves, "arrival": reading.arrival}
    events |= {"contact": contact.time, "trigger": contact.trigger}
    events |= {"main": contact.main, "arcing": contact.arcing}
    spots = {name: (events[first], events[last]) for name, (first, last) in _SPOTS.items()}
    since = {name: measured[name].value for name in ("coil_dip_time", "coil_off_time", *SHARES)}
    spots |= {name: (contact.trigger, contact.trigger + late) for name, late in since.items()}
    for speed in estimate.speeds:
        if speed.motion == estimate.record.motion and not measured[speed.name].reason:
            points = (speed.start, speed.end)
            spots[speed.name] = tuple(reading.place(point)[0].value for point in points)
            if speed.points == OF_STROKE[f"{speed.motion}_speed_10_90"]:
                spots["travel_time"] = spots[speed.name]
    return {
        name: (float(min(ends)), float(max(ends)))
        for name, ends in spots.items()
        if np.isfinite(ends).all()
    }


def marks_of(tab: Tab, estimates: Sequence[Estimate], own: Mapping[str, str]) -> list[dict]:
    """Return the events and the speed zone of each pole: a name, a phase, a colour, and points."""
    colours = colours_of([record.operation.phase for record in tab.records], own)
    origins, _ = origins_of(tab)
    event = "touch" if tab.motion == "closing" else "separation"
    marks = []
    for estimate in (one for one in estimates if one.record.raw is not None):
        raw, phase = estimate.record.raw, estimate.record.operation.phase
        inferred = "" if estimate.record.timed else " (inferred)"
        times: dict[str, Any] = {
            "trigger": [raw.contact.trigger],
            "first motion": [raw.moves],
            event + inferred: [estimate.contact.time],
            "speed zone": spots_of(estimate).get(f"{tab.motion}_speed", [np.nan]),
        }
        known = np.isfinite(raw.sure)
        for name, at in times.items():
            if np.isfinite(at).all():
                y = np.interp(at, raw.time[known], raw.sure[known])
                x = np.asarray(at) - origins[id(estimate.record)]
                about = {"name": name, "phase": phase, "colour": colours[phase]}
                marks.append(about | {"x": x.tolist(), "y": y.tolist()})
    return marks
