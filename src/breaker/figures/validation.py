"""Calibration, sharpness and recovery on simulated curves (paper, Figs. 4, 5, 6)."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from breaker.figures.style import (
    MEASURED,
    PRIOR,
    REFERENCE,
    WARNING,
    colour,
    heading,
    legend_below,
    panels,
    parameter,
    styled,
)
from breaker.validation import Recovery, Scores, Verdict

__all__ = ["contraction", "recovery", "sbc"]

_Z_LIMIT = 3.0


@styled
def sbc(
    verdict: Verdict,
    names: Sequence[str],
    *,
    motion: str,
    subject: str = "simulation-based calibration",
) -> Figure:
    """Draw the ECDF difference of the ranks in its simultaneous band (paper, Fig. 4).

    Args:
        verdict: From :func:`breaker.validation.calibration.verdict`.
        names: Names of the ``q`` outputs.
        motion: Motion of the title.
        subject: What was calibrated, for the title.
    """
    figure, axes = panels(len(names), sharex=True, sharey=True)
    band = verdict.band
    for i, (axis, name) in enumerate(zip(axes, names, strict=True)):
        axis.fill_between(band.grid, band.lower, band.upper, color=PRIOR, alpha=0.35, lw=0)
        axis.axhline(0.0, color=REFERENCE, lw=0.6)
        axis.plot(band.grid, verdict.difference[:, i], color=colour(name), drawstyle="steps-post")
        outside = bool(verdict.outside[i])
        words = f"outside by {verdict.excess[i]:.3f}" if outside else "inside"
        axis.set_title(
            f"{parameter(name).symbol}   {words}, p = {verdict.p_values[i]:.2g}",
            color=WARNING if outside else "black",
        )
        axis.set(xlim=(0, 1))
    _outer_labels(axes, "rank of the truth / (draws + 1)", "ECDF difference")
    share = f"{100 * (1 - verdict.alpha):g} %"
    heading(figure, motion, subject, _words(verdict, names, share))
    line = Line2D([], [], color=REFERENCE, label="observed ranks (colour of the parameter)")
    label = f"simultaneous {share} band, all {verdict.panels} panels together"
    legend_below(figure, [line, Patch(color=PRIOR, alpha=0.35, lw=0, label=label)])
    return figure


@styled
def contraction(
    scores: Scores, names: Sequence[str], *, motion: str, limit: np.ndarray | None = None
) -> Figure:
    """Draw z-score against contraction, one dot per curve (paper, Fig. 5).

    Args:
        scores: From :func:`breaker.validation.diagnostics.scores`.
        names: Names of the ``q`` outputs.
        motion: Motion of the title.
        limit: Mean contraction of the exact posterior, ``(q,)``, if known.
    """
    figure, axes = panels(len(names), sharex=True, sharey=True)
    limits = [None] * len(names) if limit is None else list(limit)
    for i, (axis, name, exact) in enumerate(zip(axes, names, limits, strict=True)):
        x, y = scores.contraction[:, i], scores.z[:, i]
        axis.plot(x, y, "o", color=colour(name), ms=2.5, mew=0, alpha=0.45, rasterized=True)
        for level in (-_Z_LIMIT, _Z_LIMIT):
            axis.axhline(level, color=REFERENCE, lw=0.9, ls=":")
        axis.axhline(0.0, color=REFERENCE, lw=0.6)
        words = f"mean {scores.mean_contraction[i]:.3f}"
        if exact is not None:
            axis.axvline(exact, color=MEASURED, lw=1.2, ls="--")
            words += f", exact {exact:.3f}"
        axis.set_title(f"{parameter(name).symbol}   {words}\nz-score sd {scores.z_sd[i]:.2f}")
    largest = max(4.2, 1.05 * abs(scores.z).max())
    axes[0].set(xlim=(min(0.0, 1.05 * scores.contraction.min()), 1.02), ylim=(-largest, largest))
    _outer_labels(axes, "contraction", "z-score")
    heading(figure, motion, "z-score against contraction")
    handles = [
        Line2D([], [], color=REFERENCE, ls="", marker="o", ms=4, label="one simulated curve"),
        Line2D([], [], color=REFERENCE, lw=0.9, ls=":", label="z-score ±3"),
    ]
    if limit is not None:
        label = "mean contraction of the exact posterior"
        handles.append(Line2D([], [], color=MEASURED, lw=1.2, ls="--", label=label))
    legend_below(figure, handles)
    return figure


@styled
def recovery(summary: Recovery, names: Sequence[str], *, motion: str) -> Figure:
    """Draw posterior median and 95 % interval against the truth (paper, Fig. 6).

    Args:
        summary: From :func:`breaker.validation.diagnostics.recovery`.
        names: Names of the ``q`` outputs.
        motion: Motion of the title.
    """
    figure, axes = panels(len(names), height=3.2)
    for i, (axis, name) in enumerate(zip(axes, names, strict=True)):
        truth, low, high = summary.truth[:, i], *summary.interval_95[:, i].T
        axis.vlines(truth, low, high, color=colour(name), lw=0.7, alpha=0.13, rasterized=True)
        dots = {"ms": 3.2, "mec": "white", "mew": 0.3, "rasterized": True}
        axis.plot(truth, summary.median[:, i], "o", color=colour(name), **dots)
        # All truths and medians; the longest intervals may end outside, not to dwarf the rest.
        centres = np.concatenate([truth, summary.median[:, i]])
        least, most = centres.min(), centres.max()
        room = 0.06 * (most - least)
        ends = least - room, most + room
        axis.plot(ends, ends, color=MEASURED, lw=1.0, ls="--")
        axis.set(xlim=ends, ylim=ends, box_aspect=1)
        label = parameter(name).label
        axis.set_xlabel(f"true {label}")
        axis.set_ylabel(f"inferred {label}")
        axis.set_title(f"{parameter(name).symbol}   correlation {summary.correlation[i]:.3f}")
    heading(figure, motion, "recovery of the true parameters")
    handles = [
        Line2D([], [], color=REFERENCE, ls="", marker="o", ms=4, label="posterior median"),
        Line2D([], [], color=REFERENCE, alpha=0.5, label="95 % interval"),
        Line2D([], [], color=MEASURED, lw=1.0, ls="--", label="inferred = true"),
    ]
    legend_below(figure, handles)
    return figure


def _words(verdict: Verdict, names: Sequence[str], share: str) -> str:
    """Say in words which outputs leave the band."""
    symbols = [
        parameter(name).symbol for name, out in zip(names, verdict.outside, strict=True) if out
    ]
    if not symbols:
        return f"all {len(names)} outputs inside the simultaneous {share} bands"
    return f"outside the simultaneous {share} bands: {', '.join(symbols)}"


def _outer_labels(axes: Sequence[Axes], xlabel: str, ylabel: str) -> None:
    """Label shared axes on the left and on the lowest panel of each column."""
    for axis in axes:
        place = axis.get_subplotspec()
        if place.is_first_col():
            axis.set_ylabel(ylabel)
        if axis.xaxis.get_tick_params()["labelbottom"]:
            axis.set_xlabel(xlabel)
