"""Figures of reports: comparison of two inspections, and curves of a test."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.common.document import html_page
from breaker.common.numerals import in_digits
from breaker.diagnosis.curves import curve_of, phase_colours, speed_zone
from breaker.figures import panels as p
from breaker.figures import style
from breaker.figures.records import difference

if TYPE_CHECKING:
    from breaker.diagnosis.changes import QuantityChange
    from breaker.diagnosis.estimate import Estimate
    from breaker.diagnosis.inspection_change import InspectionChange
    from breaker.diagnosis.report import Panel, Report


_WIDTH, _PANEL = 7.0, 2.5  # inches: width of the text of A4; height that is easy to read (63 mm)
_LEAST_EXTENT, _EXTENT = 20.0, 40.0  # smallest and largest change that the axis shows, percent


@style.styled
def comparison(document: "InspectionChange") -> Figure:
    """Draw a comparison of two inspections: a row for each measured change, then for each parameter
    that the records determine. Red marks a change for the worse.
    """
    # Warnings contain names given by users, and are not changed.
    sentences = [style.literal(f"WARNING: {warning}") for warning in document.warnings]
    sentences += map(p.spoken, document.summary)
    headline = "\n".join(style.within(sentence, 13.3, 12.0) for sentence in sentences)
    head = 0.19 * headline.count("\n") + 0.4  # inches
    rows = [*document.measured, *(row for row in document.inferred if row.identifiable)]
    figure = style.new_figure(13.5, head + 0.29 * (len(rows) + 2.0) + 1.0)
    heights = [head, figure.get_figheight() - head]
    above, below = figure.subfigures(2, 1, height_ratios=heights)
    above.text(0.01, 0.97, headline, va="top", weight="bold", fontsize=10.5)
    axis = below.subplots()
    row_of, labels = "{:>28}  {:>11}  {:>7}".format, ["before → today"]
    numbers = [row_of("change, 90 % interval", "P unchanged", "P worse")]
    shares = [row.if_changed for row in rows if row.shown[2] == "%"]
    farthest = 1.08 * max((abs(x) for change in shares for x in change), default=0.0)
    extent = min(max(farthest, _LEAST_EXTENT), _EXTENT)
    for y, row in enumerate(rows, start=1):
        _change(axis, y, row, extent)
        values = ""
        if row.measured:
            before, today = in_digits(row.before, 4), in_digits(row.today, 4)
            values = f" ({row.unit})   {before} → {today}"
        labels.append(p.spoken(row.words + values))
        chances = (row.p_unchanged, row.p_worse)
        texts = ("" if chance is None else f"{chance:.2f}" for chance in chances)
        change, interval, _ = row.shown if row.measured or row.changed else ("", "", "")
        words = p.signed(f"{change} ({interval})") if change else ""
        numbers.append(row_of(words, *texts))
    axis.axvline(0.0, color=style.REFERENCE, lw=0.8)
    axis.axhline(len(document.measured) + 0.5, color=style.REFERENCE, lw=0.6)
    for text in p.rows_of_words(axis, labels, numbers).get_yticklabels():
        text.set_fontfamily("DejaVu Sans Mono")
    axis.set(xlim=(-extent, extent), xlabel="change since the earlier inspection (%)")
    p.legend_below(figure, columns=5)
    return figure


def _change(axis: Axes, y: int, row: "QuantityChange", extent: float) -> None:
    """Draw a change in percent with its interval; an arrow stands for a change beyond the axis."""
    if row.shown[2] != "%":
        return
    label, colour = "no change detected", style.PRIOR
    if row.changed:
        label = "changed for the worse" if row.is_worse else "changed"
        colour = style.WARNING if row.is_worse else style.CHANGED
    low, middle, high = row.if_changed if row.changed else row.change
    axis.hlines(y, low, high, color=colour, lw=2.4, label=label)
    look, mark = {"mec": "white"} if row.changed else {"mfc": "white"}, "s" if row.measured else "o"
    if abs(middle) > extent:
        middle, mark = np.copysign(0.98 * extent, middle), ">" if middle > 0.0 else "<"
    axis.plot(middle, y, mark, color=colour, ms=7, **look)


def report_page(report: "Report") -> str:
    """Return a report as a page of HTML with its pictures."""
    pictures = curves(report.panels)
    return html_page(report, [style.encoded(picture, "png") for picture in pictures])


def curves(panels: Sequence["Panel"]) -> Iterator[Figure]:
    """Draw pictures of each motion of a test for a page of A4: travel with its marks, and, if
    available, resistances, coils with other contacts, and differences from a reference.
    """
    every = [estimate for panel in panels for estimate in panel.estimates]
    colours = phase_colours(estimate.record.operation.phase for estimate in every)
    for panel in panels:
        records = [estimate.record for estimate in panel.estimates]
        drawn = {estimate.record.operation.phase: estimate for estimate in panel.estimates}
        overlays = [overlay for overlay in panel.overlays if overlay.record in records]
        for draw in (_travels, _resistances, _signals, _differences):
            figure = _picture(partial(draw, drawn, colours, overlays), panel.title, drawn)
            if figure.axes:
                yield figure


@style.styled
def _picture(draw: Callable, title: str, drawn: Mapping[str, "Estimate"]) -> Figure:
    """Draw one panel of a motion; return an empty figure if it has no data."""
    figure = style.new_figure(_WIDTH, _PANEL)
    axis = figure.subplots()
    p.read_title(axis, title, _WIDTH)
    draw(axis)
    if not axis.has_data():
        figure.clear()
        return figure
    times = np.concatenate([_curve(estimate)[0] for estimate in drawn.values()])
    axis.set(xlim=(times.min(), times.max()), xlabel="time of the record (ms)")
    labels = {*axis.get_legend_handles_labels()[1]}
    columns = max(1, 98 // (max(map(len, labels)) + 8))
    lines = axis.get_title("left").count("\n") - (-len(labels) // columns)
    figure.set_figheight(_PANEL + 0.9 + 0.2 * lines)
    p.legend_below(figure, columns=columns, fontsize=9)
    return figure


def _travels(drawn: Mapping, colours: Mapping, overlays: Sequence, axis: Axes) -> None:
    for phase, estimate in drawn.items():
        _channel(axis, estimate, colours[phase])
    for overlay in overlays:  # shifted to the channel's record
        raw, phase = overlay.record.raw, overlay.record.operation.phase
        sign = 1.0 if overlay.record.motion == "closing" else -1.0
        travel = raw.segment.before + sign * overlay.good
        look = {"color": colours[phase], "alpha": 0.3, "lw": 4.0, "zorder": 1}
        axis.plot(overlay.time + raw.moves, travel, label="reference", **look)
    axis.set_ylabel(style.TRAVEL)


def _resistances(drawn: Mapping, colours: Mapping, _: Sequence, axis: Axes) -> None:
    for phase, estimate in drawn.items():
        raw, time = estimate.record.raw, _curve(estimate)[0]
        values = np.interp(time, raw.time, raw.resistance)
        if np.isfinite(values).any():
            axis.semilogy(time, values, color=colours[phase], lw=1.0, label=_name(phase))
    axis.set_ylabel("resistance of\nthe contact (µΩ)")


def _signals(drawn: Mapping, colours: Mapping, _: Sequence, axis: Axes) -> None:
    """Draw coils and contacts as shares of their ranges, without constant ones and resistances."""
    for phase, estimate in drawn.items():
        raw, time = estimate.record.raw, _curve(estimate)[0]
        looks = {"trigger": ("coil", "-")}
        looks |= {"contact": ("contact", "--")} if np.isnan(raw.resistance).all() else {}
        for kind in (name for name in looks if name in raw.currents.channels):
            values = np.interp(time, raw.time, raw.currents.channels[kind])
            seen = values[np.isfinite(values)]  # empty for an empty column
            if seen.size and np.ptp(seen) > 0.0:
                (word, ls), share = looks[kind], (values - seen.min()) / np.ptp(seen)
                look = {"color": colours[phase], "lw": 1.0, "ls": ls}
                axis.plot(time, share, label=f"{_name(phase)}: {word}", **look)
    axis.set(ylim=(-0.08, 1.08), yticks=(0.0, 0.5, 1.0), ylabel="signal, share\nof its range")


def _differences(drawn: Mapping, colours: Mapping, overlays: Sequence, axis: Axes) -> None:
    if not overlays:
        return
    difference(axis, overlays, colours)
    for phase in dict.fromkeys(overlay.record.operation.phase for overlay in overlays):
        axis.plot([], [], color=colours[phase], label=_name(phase))
    left = [overlay for overlay in overlays if overlay.leaves]
    worst = min(left, key=lambda overlay: overlay.leaves[0]) if left else overlays[0]
    phase = worst.record.operation.phase
    words = f"{phase}: " * bool(phase and left) + worst.words
    p.read_title(axis, words, _WIDTH, failed=bool(left))


def _name(phase: str) -> str:
    return style.literal(style.shortened(phase or "record", 28))


def _curve(estimate: "Estimate") -> tuple[np.ndarray, np.ndarray]:
    """Return times of the file and travel, from shortly before the trigger on."""
    raw = estimate.record.raw
    time, travel = curve_of(estimate.record, 1.1 * (estimate.contact.trigger - raw.moves))
    return time + raw.moves, travel


def _channel(axis: Axes, estimate: "Estimate", colour: str) -> None:
    """Draw the travel of a channel with its events, speed zone and rest positions."""
    record, raw, contact = estimate.record, estimate.record.raw, estimate.contact
    (time, travel), zone = _curve(estimate), speed_zone(estimate)
    known, closes = np.isfinite(travel), record.motion == "closing"
    axis.plot(time, travel, color=colour, lw=1.1, label=_name(record.operation.phase))
    how, face = ("measured", colour) if record.timed else ("by the model", "white")
    event = f"{'touch' if closes else 'separation'}, {how}"
    moves = np.nan if raw.reading.start_hidden else raw.moves
    triangle, circle = {"marker": "v", "ms": 6}, {"marker": "o", "ms": 5, "mfc": face}
    marks = [(moves, "first detected motion", triangle), (contact.time, event, circle)]
    marks += [(end, "ends of the speed zone", {"marker": "s", "ms": 3}) for end in zone]
    for instant, label, look in (mark for mark in marks if np.isfinite(mark[0])):
        level = np.interp(instant, time[known], travel[known])
        axis.plot(instant, level, color=colour, ls="", zorder=4, label=label, **look)
    for level in (raw.segment.before, raw.segment.after):
        axis.axhline(level, color=colour, lw=0.6, ls="--", zorder=1, label="rest positions")
