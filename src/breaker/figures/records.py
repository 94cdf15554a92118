"""Single records: as inspected, with a reference, and with the inferred drive."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.common.numerals import in_digits, in_p
from breaker.figures import panels as p
from breaker.figures import style
from breaker.model.parameters import PARAMETERS
from breaker.model.quantities import EVENTS
from breaker.records.files import printable
from breaker.records.noise import slope

if TYPE_CHECKING:
    from breaker.diagnosis.estimate import Estimate
    from breaker.records.proposal import Proposal
    from breaker.records.table_proposal import InspectedMotion

MOTIONS = {"closing": style.CORRECTED, "opening": style.AMORTISED}  # colours
BAND = {"color": style.PRIOR, "alpha": 0.25, "lw": 0}  # look of tolerance bands
_MOST = 30  # most operations whose posteriors are drawn


@style.styled
def record(proposal: "Proposal") -> Figure:
    """Draw a record as inspected: all channels, and the speed, the first two motions and the rest
    position of the first channel. If no motion can be read, draw the columns of the file.
    """
    read = [checked for checked in proposal.motions if checked.record]
    name = style.literal(f"record {proposal.findings.sheet.file.name}")
    if not read:
        figure = style.new_figure(11.0, 4.0)
        axis = figure.subplots()
        for travel in proposal.findings.travels:
            axis.plot(proposal.findings.sheet.columns[travel.place], color=style.MEASURED, lw=0.8)
        axis.set(xlabel="sample", ylabel=f"travel ({travel.unit or 'no unit'})")
        style.title(figure, "No motion could be read", name, failed=True)
        return figure
    first = [motion for motion in read if motion.column == read[0].column]
    one, noise, shown = first[0].record, first[0].result.noise, first[:2]
    figure = style.new_figure(11.0, 9.4)
    grid = figure.add_gridspec(3, len(shown) + 1, height_ratios=[1.5, 0.9, 1.1])
    entire = figure.add_subplot(grid[0, :])
    speed = figure.add_subplot(grid[1, :], sharex=entire)
    for column, channel in {read_motion.column: read_motion.record for read_motion in read}.items():
        main = column == first[0].column
        look = {"color": style.MEASURED, "lw": 1.4} if main else {"color": style.PRIOR, "lw": 0.7}
        entire.plot(channel.time, channel.sure, zorder=3 if main else 2, **look)
    duration = min(read_motion.arrives - read_motion.begins for read_motion in first)
    half = max(2, round(0.06 * duration / one.step))  # straight lines through an eighth of a motion
    speed.plot(one.time, slope(one.sure, half, one.step), color=style.MEASURED, lw=1.0)
    for seen in first:
        _motion(entire, speed, seen)
    entire.set(ylabel=style.TRAVEL, xlim=one.time[[0, -1]])
    speed.set_ylabel("speed (m/s)")
    for k, seen in enumerate(shown):
        reach = max(4.0, 0.15 * (seen.arrives - seen.begins))
        axis = figure.add_subplot(grid[2, k])
        _near(axis, seen, -reach, reach, f"{seen.motion} begins at {seen.record.moves:.1f} ms")
        axis.axvline(seen.record.moves, color=MOTIONS[seen.motion], lw=1.2)
    axis, sd = figure.add_subplot(grid[2, -1]), noise.sd
    words = [f"at rest: sd {in_digits(sd, 2)} mm"]
    words += [f"steps of {in_digits(one.quantum, 2)} mm"] if one.quantum else []
    words += [f"correlation {noise.colour:.2f}"] if np.isfinite(noise.colour) else []
    _near(axis, shown[0], -50.0, -1.0, ", ".join(words))
    axis.axhspan(one.segment.before - sd, one.segment.before + sd, **BAND)
    doubts = sum(int((seen.record.doubts != "").sum()) for seen in read)
    count = "One motion" if len(read) == 1 else f"{len(read)} motions"
    style.title(figure, f"{count} found, {doubts or 'no'} doubtful samples", name)
    p.legend_below(figure, columns=4)
    return figure


def _motion(entire: Axes, speed: Axes, seen: "InspectedMotion") -> None:
    """Mark a motion, its rest positions and doubtful samples."""
    one, colour = seen.record, MOTIONS[seen.motion]
    for axis in (entire, speed):
        label = f"{seen.motion}, to its rest"
        axis.axvspan(one.moves, seen.arrives, color=colour, alpha=0.15, lw=0, label=label)
        axis.axvline(one.moves, color=colour, lw=1.2, label=f"{seen.motion}: first motion")
    begin, end = one.time[one.segment.begin], one.time[one.segment.end - 1]
    look = {"color": colour, "ls": "--", "lw": 1.2, "zorder": 4, "label": "rest position"}
    entire.hlines([one.segment.before], begin, one.moves, **look)
    entire.hlines([one.segment.after], seen.arrives, end, **look)
    doubtful = one.doubts != ""
    if doubtful.any():
        inside = np.clip(one.whole[doubtful], *entire.get_ylim())
        look = {"color": style.WARNING, "ms": 6, "zorder": 5, "label": "doubtful sample"}
        entire.plot(one.time[doubtful], inside, "x", **look)


def _near(axis: Axes, seen: "InspectedMotion", low: float, high: float, title: str) -> None:
    """Draw single samples from ``low`` to ``high`` ms after the first motion."""
    one = seen.record
    near = (one.time >= one.moves + low) & (one.time <= one.moves + high)
    fine, doubtful = near & (one.doubts == ""), near & (one.doubts != "")
    axis.plot(one.time[fine], one.whole[fine], ".", color=style.MEASURED, ms=3)
    if high > 0.0:
        axis.plot(one.time[doubtful], one.whole[doubtful], "x", color=style.WARNING, ms=6)
    axis.axhline(one.segment.before, color=MOTIONS[seen.motion], ls="--", lw=1.2)
    axis.set(xlabel="time of the record (ms)", ylabel=style.TRAVEL)
    p.read_title(axis, title, 3.2)


def difference(axis: Axes, overlays: Sequence, colours: Mapping) -> None:
    """Draw differences, their tolerance band, and where they leave it; colours by phase."""
    for overlay in overlays:
        begin, phase = overlay.record.raw.moves, overlay.record.operation.phase
        axis.plot(begin + overlay.time, overlay.difference, color=colours[phase], lw=1.0)
        if overlay.leaves:
            time, value = overlay.leaves
            axis.axvline(begin + time, color=style.WARNING, lw=1.0, label="leaves the tolerance")
            axis.plot(begin + time, value, "o", color=style.WARNING, ms=5, zorder=5)
    band = max(overlay.band for overlay in overlays)
    axis.axhspan(-band, band, **BAND)
    axis.axhline(0.0, color=style.REFERENCE, lw=0.6)
    axis.margins(x=0)
    axis.set_ylabel("difference (mm)")


@style.styled
def answer(estimates: Sequence["Estimate"], prior: np.ndarray) -> Figure:
    """Draw the inferred drive: the first record of each motion with the family's nearest shape and
    the residual, and posteriors of parameters with the prior.

    Args:
        estimates: Estimates, with at least one usable record.
        prior: Prior draws, ``(n, p)``.
    """
    usable = [estimate for estimate in estimates if not estimate.record.reason]
    first = {estimate.record.motion: estimate for estimate in reversed(usable)}
    figure = style.new_figure(12.0, 11.2)
    above, below = figure.subfigures(2, 1, height_ratios=[1.35, 1.0])
    size = {"height_ratios": [2, 1], "sharex": "col", "squeeze": False}
    grid = above.subplots(2, len(first), **size)
    for motion, (upper, lower) in zip(sorted(first), grid.T, strict=True):
        _fitted(upper, lower, first[motion], figure.get_figwidth() / len(first) - 0.9)
    drawn = [e for e in usable if e.draws and e.record.motion == e.motions[0]]
    *axes, last = below.subplots(2, 4).flat
    last.set_axis_off()
    for k, (axis, parameter) in enumerate(zip(axes, PARAMETERS, strict=True)):
        posteriors: dict[str, list] = {}
        for one in drawn[:_MOST]:
            if not one.why_not(parameter.name):
                posteriors.setdefault(" and ".join(one.motions), []).append(one.draws.theta[:, k])
        _densities(axis, posteriors, prior[:, k])
        axis.set_title(p.named(parameter.name), loc="left", fontsize=10)
        axis.set_xlabel(parameter.label)
    files = dict.fromkeys(_file(first[motion]) for motion in sorted(first))
    style.title(figure, f"Drive as inferred from {style.literal(', '.join(files))}")
    p.legend_below(figure, columns=3)
    return figure


def _file(estimate: "Estimate") -> str:
    """Return the name of an estimate's file."""
    return style.shortened(printable(estimate.record.operation.file.name), 46)


def _fitted(upper: Axes, lower: Axes, estimate: "Estimate", width: float) -> None:
    """Draw a record, the nearest shape, the contact event, and the residual. Times count from the
    first motion; ``width`` is in inches.
    """
    from breaker.diagnosis.curves import curve_of
    from breaker.diagnosis.words import say
    from breaker.family.shape import SHAPE_TIMES

    record, match, shape = estimate.record, estimate.match, estimate.record.shape
    motion, after = record.motion, record.tenth - record.raw.moves
    colour, sign = MOTIONS[motion], 1.0 if motion == "closing" else -1.0
    if estimate.draws and not estimate.contact_unknown:
        switching = after + estimate.draws.switching[motion]
        low, middle, high = np.quantile(switching, [0.025, 0.5, 0.975])
        upper.axvspan(low, high, color=colour, alpha=0.25, lw=0)
        upper.axvline(middle, color=colour, lw=1.2)
        y, side = (0.08, "bottom") if motion == "closing" else (0.95, "top")  # away from the curve
        words = f"{EVENTS[motion]} at {middle:.1f} ms\n95 %: {low:.1f} to {high:.1f} ms"
        look = {"color": colour, "ha": "right", "va": side, "transform": upper.transAxes}
        upper.text(0.97, y, words, **look)
    dots = {"color": style.MEASURED, "ms": 2, "mew": 0}
    upper.plot(*curve_of(record), "o", label="record", **dots)
    times = after + shape.duration * SHAPE_TIMES
    nearest = sign * (shape.rest + shape.stroke * match.nearest)
    look = {"color": style.CHANGED, "lw": 1.0, "label": "nearest shape of the family"}
    upper.plot(times, nearest, **look)
    upper.set_ylabel(style.TRAVEL)
    upper.margins(x=0)
    words = say("picture-outside" if estimate.misfit else "picture-inside", p=in_p(match.p_value))
    p.read_title(upper, f"{motion} in {_file(estimate)}: {words}", width, failed=estimate.misfit)
    left = np.where(shape.present, sign * shape.stroke * (shape.way - match.nearest), np.nan)
    lower.plot(times, left, "o", **dots)
    lower.axhline(0.0, color=style.REFERENCE, lw=0.6)
    lower.set(xlabel="time after the first motion (ms)", ylabel="record minus\nshape (mm)")


def _densities(axis: Axes, posteriors: Mapping[str, Sequence], prior: np.ndarray) -> None:
    """Draw posterior densities of a parameter by operation, and the prior near them."""
    axis.set(yticks=[])
    every = [draws for samples in posteriors.values() for draws in samples]
    low, high = np.quantile(np.concatenate(every or [prior]), [0.001, 0.999])
    wide = np.quantile(prior, [0.005, 0.995])
    low, high = max(min(wide[0], low), 2 * low - high), min(max(wide[1], high), 2 * high - low)
    axis.hist(prior, bins=40, range=(low, high), density=True, label="prior", **BAND)
    for motions, samples in posteriors.items():
        for i, draws in enumerate(samples):
            look = {"lw": 0.6 if i else 1.8, "color": MOTIONS.get(motions, style.MODEL)}
            look["label"] = f"posteriors: {motions} (the first thick)"
            axis.hist(draws, bins=40, range=(low, high), density=True, histtype="step", **look)
    axis.set_xlim(low, high)
