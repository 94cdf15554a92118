"""The curves of an inspection as plain data: panels that share their times, and marks."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from breaker.diagnosis.curves import Overlay, overlaid, phase_colours, speed_zone
from breaker.diagnosis.estimate import DriveRecord, Estimate
from breaker.diagnosis.report import Panel
from breaker.diagnosis.session import Diagnosis
from breaker.records.files import printable
from breaker.records.noise import slope

_MOST = 4000  # points of a curve: two for each pixel column of a screen
_AROUND = 0.25, 1.0  # times shown before and after the motion, as shares of its duration
_SMOOTH = 1.0  # ms on both sides of a sample in the linear fit whose slope is the velocity
_PANELS = {  # heights in pixels, and labels
    "travel": (280, "travel (mm)"),
    "velocity": (105, "velocity (m/s)"),
    "contact": (75, "contact"),
    "current": (75, "test current"),
    "coil": (85, "coil"),
    "resistance": (140, "resistance (µΩ)"),
}
_CHANNELS = {"contact": "contact", "current": "current", "trigger": "coil"}


class Curve(NamedTuple):
    """A curve: panel, phase, name, times after the origin in ms, and values, ``(n,)``. The look is
    "", "faint" for doubtful samples, or "earlier" or "reference" for other records.
    """

    panel: str
    phase: str
    name: str
    time: np.ndarray
    values: np.ndarray
    look: str = ""


def drawn(panel: Panel, diagnosis: Diagnosis) -> dict[str, Any]:
    """Return title, panels with curves, marks, notes, and initial time window of a motion."""
    records = [estimate.record for estimate in panel.estimates]
    origins, axis = _origins(records)
    laid = [(overlay, "reference") for overlay in panel.overlays]
    earlier, hidden = overlaid(records, diagnosis.before)
    laid += [(overlay, "earlier") for overlay in earlier]
    names = [record.operation.phase for record in records]
    colours = phase_colours(names)
    black = [name for name, colour in colours.items() if colour == "#000000"]
    colours |= dict.fromkeys(black, "currentColor")  # light on a dark page
    lines: list[Curve] = []
    begins, ends, marks = [], [], []
    for estimate, zero in zip(panel.estimates, origins, strict=True):
        record, raw = estimate.record, estimate.record.raw
        duration = raw.reading.arrival - raw.moves
        start = min(raw.moves, np.nan_to_num(raw.contact.trigger, nan=np.inf))
        begins.append(start - zero - _AROUND[0] * duration)
        ends.append(raw.reading.arrival - zero + _AROUND[1] * duration)
        lines += _curves_of(record, zero)
        lines += [_overlay(*pair, zero) for pair in laid if pair[0].record is record]
        marks += _marks(estimate, zero, colours[record.operation.phase])
    window = min(begins), max(ends)
    about = {"title": panel.title, "marks": marks, "notes": [*dict.fromkeys(hidden)]}
    return _panels(lines, window, colours, axis) | about


def _origins(records: Sequence[DriveRecord]) -> tuple[list[float], str]:
    """Return the origin of the time axis in the time of the file, ms, by record, and the axis name.

    Poles of one file keep its clock. For poles of several files, time counts from the trigger, if
    all have one, or else from the first motion.
    """
    if len({str(record.operation.file) for record in records}) == 1:
        return [0.0] * len(records), "time (ms)"
    triggers = [record.raw.contact.trigger for record in records]
    if np.isfinite(triggers).all():
        return triggers, "time after the trigger (ms)"
    return [record.raw.moves for record in records], "time after the first motion (ms)"


def _curves_of(record: DriveRecord, zero: float) -> Iterator[Curve]:
    """Yield travel, velocity, resistance and other channels of a record over time."""
    raw, phase = record.raw, record.operation.phase
    time, doubtful = raw.time - zero, np.where(raw.doubts == "", np.nan, raw.whole)
    yield Curve("travel", phase, "travel", time, raw.sure)
    if np.isfinite(doubtful).any():
        yield Curve("travel", phase, "doubtful samples", time, doubtful, "faint")
    half = max(2, round(_SMOOTH / raw.step))
    yield Curve("velocity", phase, "velocity", time, slope(raw.sure, half, raw.step))
    if np.isfinite(raw.resistance).any():
        yield Curve("resistance", phase, "resistance", time, raw.resistance)
    for kind, values in raw.currents.channels.items():
        yield Curve(_CHANNELS[kind], phase, kind, time, values)


def _overlay(overlay: Overlay, look: str, zero: float) -> Curve:
    """Return the curve of another record, aligned to the record at rest and first motion."""
    record = overlay.record
    sign = 1.0 if record.motion == "closing" else -1.0
    travel = record.raw.segment.before + sign * overlay.good
    name = f"{look}: {printable(overlay.reference.operation.file).rpartition('/')[2]}"
    time = overlay.time + record.raw.moves - zero
    return Curve("travel", record.operation.phase, name, time, travel, look)


def _marks(estimate: Estimate, zero: float, colour: str) -> Iterator[dict[str, Any]]:
    """Yield marks of events, and of the ends of the speed zone: name, colour, time and travel."""
    record, raw = estimate.record, estimate.record.raw
    event = "touch" if record.motion == "closing" else "separation"
    event += " (inferred)" * (not record.timed)
    instants = [("trigger", raw.contact.trigger), ("first motion", raw.moves)]
    instants += [(event, estimate.contact.time)]
    instants += [("speed zone", end) for end in speed_zone(estimate)]
    known = np.isfinite(raw.sure)
    for name, instant in instants:
        if np.isfinite(instant):
            travel = float(np.interp(instant, raw.time[known], raw.sure[known]))
            yield {"name": name, "colour": colour, "x": float(instant - zero), "y": travel}


def _panels(
    lines: Sequence[Curve], window: tuple[float, float], colours: Mapping[str, str], axis: str
) -> dict[str, Any]:
    """Return panels with curves, the initial time window, and the name of the time axis."""
    panels = []
    for name, (height, label) in _PANELS.items():
        plain = [_plain(line, window, colours) for line in lines if line.panel == name]
        panels.append({"name": name, "height": height, "label": label, "curves": plain})
    shown = [panel for panel in panels if panel["curves"]]
    return {"window": window, "axis": axis, "panels": shown}


def _plain(curve: Curve, window: tuple[float, float], colours: Mapping[str, str]) -> dict[str, Any]:
    """Return a curve for JSON; 1e-4 of a unit is resolved by a screen only after a zoom."""
    colour = "currentColor" if curve.look == "reference" else colours[curve.phase]
    about = {"phase": curve.phase, "name": curve.name, "look": curve.look, "colour": colour}
    x, y = (np.round(values.astype(float), 4) for values in thinned(curve, *window))
    return about | {k: np.where(np.isfinite(v), v, None).tolist() for k, v in (("x", x), ("y", y))}


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
