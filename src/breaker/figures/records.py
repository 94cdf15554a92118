"""Single records: as inspected, with a reference, and with the inferred drive."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.common.numerals import in_p
from breaker.figures import panels as p
from breaker.figures import style
from breaker.model.parameters import PARAMETERS
from breaker.model.quantities import EVENTS
from breaker.records.files import printable

if TYPE_CHECKING:
    from breaker.diagnosis.estimate import Estimate

MOTIONS = {"closing": style.CORRECTED, "opening": style.AMORTISED}  # colours
BAND = {"color": style.PRIOR, "alpha": 0.25, "lw": 0}  # look of tolerance bands
_MOST = 30  # most operations whose posteriors are drawn


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
    from breaker.diagnosis.sentences import say
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
