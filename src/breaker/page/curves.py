"""The curves of an inspection as Bokeh figures: a tab for each motion, and the marks on it."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from bokeh.embed import json_item
from bokeh.layouts import gridplot
from bokeh.models import (
    BoxAnnotation,
    ColumnDataSource,
    DataRange1d,
    HoverTool,
    Legend,
    LegendItem,
    Range1d,
    Span,
)
from bokeh.plotting import figure
from bokeh.themes import DARK_MINIMAL, LIGHT_MINIMAL, built_in_themes

from breaker.common.colours import phase_colours
from breaker.diagnosis.curves import overlaid
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
_HEIGHTS = {
    **{"travel": 280, "velocity": 105, "contact": 75, "test current": 75, "coil": 85},
    "resistance": 190,
}
_AXES = {"travel": "travel (mm)", "velocity": "velocity (m/s)", "resistance": "resistance (µΩ)"}
_CHANNELS = {"contact": "contact", "current": "test current", "trigger": "coil", "motor": "coil"}
_INK = {False: "#1c2127", True: "#e6e8eb"}  # of marks and cursors, where the page is dark


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

    @property
    def phases(self) -> list[str]:
        """Phase of each record."""
        return [record.operation.phase for record in self.records]


class Channel(NamedTuple):
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


# ---- channels ------------------------------------------------------------------------------------


def channels_of(tab: Tab, diagnosis: Diagnosis, files: Files) -> list[Channel]:
    """Return the curves of a tab."""
    origins, _ = origins_of(tab)
    found = []
    for record in tab.read:
        raw, phase, zero = record.raw, record.operation.phase, origins[id(record)]
        time = raw.time - zero
        doubtful = np.where(raw.doubts == "", np.nan, raw.whole)
        found += [Channel("travel", phase, "travel", time, raw.sure)]
        if np.isfinite(doubtful).any():
            found.append(Channel("travel", phase, "doubtful samples", time, doubtful, "faint"))
        found.append(Channel("velocity", phase, "velocity", time, _velocity(raw.sure, raw.step)))
        if np.isfinite(raw.resistance).any():  # over the travel, it shows the arcing contact
            at = raw.sure[raw.inside], raw.resistance[raw.inside]
            found.append(Channel("resistance", phase, "resistance", *at))
        found += _beside(record, look_into(files[record.operation.file]), zero)
    laid = [(each, "reference") for each in diagnosis.overlays]
    laid += [(each, "earlier") for each in overlaid(diagnosis.records, diagnosis.before)]
    for record in tab.read:
        operation, zero = record.operation, origins[id(record)]
        own = operation.number, record.motion, operation.phase, str(operation.file)
        for each, look in laid:
            if own == (each.operation, each.motion, each.phase, each.file):
                found.append(_overlay(record, each, look, zero))
    return found


def _overlay(record: DriveRecord, other: Any, look: str, zero: float) -> Channel:
    """Return another record, aligned at half of the travel."""
    way, good = np.nan_to_num(other.way), np.nan_to_num(other.good)
    half = 0.5 * record.shape.stroke
    shift = other.time[int((way > half).argmax())] - other.time[int((good > half).argmax())]
    sign = 1.0 if record.motion == "closing" else -1.0
    travel = record.raw.segment.before + sign * other.good
    name = f"{look}: {printable(other.good_file).rpartition('/')[2]}"
    time = other.time + record.raw.moves + shift - zero
    return Channel("travel", record.operation.phase, name, time, travel, look)


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


def _beside(record: DriveRecord, sheet: Sheet, zero: float) -> Iterator[Channel]:
    """Yield contact, currents and resistance of a record, over time."""
    settings, raw, phase = record.raw.settings, record.raw, record.operation.phase
    if settings.get("time_column") is not None:
        place = sheet.place_of(settings["time_column"])
        time = sheet.columns[place] * TO_MS[settings["time_unit"]] - zero
    else:
        time = np.arange(sheet.columns[0].size) * raw.step - zero
    for key, panel in _CHANNELS.items():
        column = settings.get(f"{key}_column")
        place = None if column in (None, 0) else sheet.place_of(column)
        if place is not None:
            unit = f" ({printable(sheet.units[place])})" if sheet.units[place] else ""
            name = f"{panel}{unit}"
            yield Channel(panel, phase, name, time, sheet.columns[place])


# ---- figures -------------------------------------------------------------------------------------


def drawn(tab: Tab, diagnosis: Diagnosis, files: Files, dark: bool, own: Mapping) -> dict:
    """Return a tab as an item for ``Bokeh.embed.embed_item``; ``own`` are colours of phases."""
    colours = phase_colours(tab.phases, own)
    if dark:
        colours = {name: each.replace("#000000", _INK[True]) for name, each in colours.items()}
    channels, (_, axis) = channels_of(tab, diagnosis, files), origins_of(tab)
    return _item(channels, _window(tab), axis, colours, dark)


def drawn_file(sheet: Sheet, dark: bool) -> dict:
    """Return all columns of a file of which nothing could be read, over the number of samples."""
    names = [printable(str(sheet.column(i))) for i in range(len(sheet.columns))]
    samples = np.arange(sheet.columns[0].size, dtype=float)
    channels = [
        Channel("travel", name, name, samples, values)
        for name, values in zip(names, sheet.columns, strict=True)
        if np.isfinite(values).any() and np.nanmin(values) < np.nanmax(values)
    ]
    colours, window = phase_colours(names), (0.0, float(samples.size))
    return _item(channels, window, "sample", colours, dark)


def _window(tab: Tab) -> tuple[float, float]:
    """Return the times that are shown, ms."""
    origins, _ = origins_of(tab)
    begins, ends = [], []
    for record in tab.read:
        zero, moves, arrival = origins[id(record)], record.raw.moves, record.raw.reading.arrival
        start = min(moves, np.nan_to_num(record.raw.contact.trigger, nan=np.inf))
        begins.append(start - zero - _AROUND[0] * (arrival - moves))
        ends.append(arrival - zero + _AROUND[1] * (arrival - moves))
    return min(begins), max(ends)


def _item(
    channels: Sequence[Channel],
    window: tuple[float, float],
    axis: str,
    colours: Mapping[str, str],
    dark: bool,
) -> dict:
    x_range, figures = Range1d(*window), []
    for panel in _HEIGHTS:
        some = [each for each in channels if each.panel == panel]
        if some:
            figures.append(_panel(panel, some, x_range, colours, _INK[dark]))
    timed = [each for each in figures if each.x_range is x_range]
    for above in timed[:-1]:
        above.xaxis.major_label_text_font_size = "0px"
    timed[-1].height += 40  # for the labels of the axis
    timed[-1].xaxis.axis_label = axis
    _add_marks(figures[0], _INK[dark])
    for each in timed:
        for name, dash in (("cursor1", "solid"), ("cursor2", "dotted")):
            look = {"line_color": _INK[dark], "line_dash": dash, "visible": False}
            each.add_layout(Span(dimension="height", name=name, **look))
        each.add_layout(
            BoxAnnotation(name="spot", fill_color="#2f7fd0", fill_alpha=0.15, visible=False)
        )
    grid = gridplot(
        [[each] for each in figures], toolbar_location="right", sizing_mode="stretch_width"
    )
    grid.toolbar.logo = None
    return json_item(grid, theme=built_in_themes[DARK_MINIMAL if dark else LIGHT_MINIMAL])


def _panel(
    panel: str,
    channels: Sequence[Channel],
    x_range: Range1d,
    colours: Mapping[str, str],
    ink: str,
) -> Any:
    over_travel = panel == "resistance"
    found = figure(
        name="" if over_travel else "over time",
        height=_HEIGHTS[panel],
        x_range=DataRange1d() if over_travel else x_range,
        y_range=DataRange1d(only_visible=True, range_padding=0.16),
        x_axis_label="travel (mm)" if over_travel else None,
        y_axis_label=_AXES.get(panel, channels[0].name),
        y_axis_type="log" if over_travel else "linear",
        sizing_mode="stretch_width",
        tools="xpan,xwheel_zoom,box_zoom,undo,reset,save",
        active_drag="xpan",
        active_scroll="xwheel_zoom",
    )
    items: dict[str, list] = {}
    dashes = {"": "solid", "faint": "dotted", "earlier": "dotted", "reference": "dashed"}
    for each in channels:
        time, values = each.time, each.values
        if not over_travel:
            time, values = thinned(each, x_range.start, x_range.end, panel != "velocity")
        source = ColumnDataSource({"x": time, "y": values}, name=f"{each.phase} {each.name}")
        colour = ink if each.look == "reference" else colours[each.phase]
        line = found.line(
            "x", "y", source=source, line_color=colour, line_dash=dashes[each.look], line_width=1.5
        )
        line.nonselection_glyph = line.muted_glyph = line.hover_glyph = None
        if panel == "travel":
            items.setdefault(each.name if each.look else each.phase or each.name, []).append(line)
    if items:
        own = [LegendItem(label={"value": key}, renderers=some) for key, some in items.items()]
        legend = Legend(items=own, click_policy="hide", orientation="horizontal", padding=2)
        legend.update(label_text_font_size="11px", border_line_color=None, margin=0)
        found.add_layout(legend, "above")
    found.axis.axis_label_text_font_size = "12px"
    found.min_border_left = 56  # so that panels share their axes
    return found


def _add_marks(found: Any, ink: str) -> None:
    """Add sources "marks" and "zones", which the page fills once values are measured."""
    zones = ColumnDataSource({name: [] for name in _ZONE}, name="zones")
    look = {"line_color": "colour", "line_width": 5, "alpha": 0.3}
    found.segment("x0", "y0", "x1", "y1", source=zones, **look)
    marks = ColumnDataSource({name: [] for name in _MARK}, name="marks")
    glyph = found.scatter("x", "y", source=marks, marker="diamond", size=9, color="colour")
    look = {"x_offset": 7, "y_offset": -8, "text_color": ink, "text_font_size": "11px"}
    found.text("x", "y", "label", source=marks, **look)
    tips = [("", "@name"), ("ms", "@x{0.00}"), ("mm", "@y{0.00}")]
    found.add_tools(HoverTool(renderers=[glyph], tooltips=tips))


def thinned(
    channel: Channel, begin: float, end: float, around: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Return times and values ``(m,)`` of a curve in a window, and ``around`` it for as long: all,
    or the ends of each part.

    >>> some = Channel("travel", "", "", np.arange(20_000.0), np.arange(20_000.0))
    >>> thinned(some, 0.0, 20_000.0)[0].size, thinned(some, 10.0, 19.0)[0].size
    (4000, 27)
    """
    wide = around * (end - begin)
    first, last = np.searchsorted(channel.time, (begin - wide, end + wide))
    kept = np.arange(first, last)
    if kept.size > _MOST:
        parts = np.array_split(kept, _MOST // 2)
        above, below = (np.nan_to_num(channel.values, nan=each) for each in (np.inf, -np.inf))
        low = [part[np.argmin(above[part])] for part in parts]
        high = [part[np.argmax(below[part])] for part in parts]
        kept = np.sort(np.concatenate([low, high]))
    return channel.time[kept], channel.values[kept]


# ---- marks ---------------------------------------------------------------------------------------

_MARK = "x", "y", "name", "label", "colour"
_ZONE = "x0", "y0", "x1", "y1", "colour"
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
    found = {name: (events[first], events[last]) for name, (first, last) in _SPOTS.items()}
    since = {name: measured[name].value for name in ("coil_dip_time", "coil_off_time", *SHARES)}
    found |= {name: (contact.trigger, contact.trigger + late) for name, late in since.items()}
    for speed in estimate.speeds:
        if speed.motion == estimate.record.motion and not measured[speed.name].reason:
            points = (speed.start, speed.end)
            found[speed.name] = tuple(reading.place(point)[0].value for point in points)
            if speed.points == OF_STROKE[f"{speed.motion}_speed_10_90"]:
                found["travel_time"] = found[speed.name]
    return {
        name: (float(min(ends)), float(max(ends)))
        for name, ends in found.items()
        if np.isfinite(ends).all()
    }


def marks_of(tab: Tab, estimates: Sequence[Estimate], own: Mapping) -> dict[str, dict]:
    """Return the data of the sources "marks" and "zones" of a tab."""
    colours, (origins, _) = phase_colours(tab.phases, own), origins_of(tab)
    marks, zones, labels = [], [], set()
    event = "touch" if tab.motion == "closing" else "separation"
    for each in (estimate for estimate in estimates if estimate.record.raw is not None):
        raw, phase, spots = each.record.raw, each.record.operation.phase, spots_of(each)
        zero, known = origins[id(each.record)], np.isfinite(raw.sure)

        def place(time: float, raw=raw, zero=zero, known=known) -> tuple[float, float]:
            return time - zero, float(np.interp(time, raw.time[known], raw.sure[known]))

        inferred = "" if each.record.timed else " (inferred)"
        times = {"trigger": raw.contact.trigger, "first motion": raw.moves}
        times[event + inferred] = each.contact.time
        for name, time in times.items():
            if np.isfinite(time):
                label = "" if name in labels else name  # once for all poles
                marks.append((*place(time), f"{name} {phase}".strip(), label, colours[phase]))
                labels.add(name)
        zone = spots.get(f"{tab.motion}_speed")
        if zone:
            zones.append((*place(zone[0]), *place(zone[1]), colours[phase]))
    return {"marks": _columns(_MARK, marks), "zones": _columns(_ZONE, zones)}


def _columns(names: Sequence[str], rows: Sequence[tuple]) -> dict[str, list]:
    """Return rows as columns by name."""
    return {name: [row[k] for row in rows] for k, name in enumerate(names)}
