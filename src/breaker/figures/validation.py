"""Calibration, sharpness and recovery on simulated curves (paper, Figs. 4, 5, 6)."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from breaker.common.numerals import in_digits, in_p
from breaker.figures import style
from breaker.paper.calibration import Calibration
from breaker.paper.validation import Recovery, Scores, contraction_words, percent, recovery_words

_Z_LIMIT = 3.0


@style.styled
def sbc(
    calibration: Calibration,
    names: Sequence[str],
    *,
    motion: str,
    subject: str = "simulation-based calibration",
    of: str = style.MODELLED,
) -> Figure:
    """Draw the ECDF difference of the ranks in its simultaneous band (paper, Fig. 4).

    Args:
        calibration: From ``calibration.judge_ranks``.
        names: Names of the ``q`` outputs.
        of: Which drives the records are of.
    """
    figure, axes = style.panels(len(names), sharex=True, sharey=True)
    band = calibration.band
    for i, (axis, name) in enumerate(zip(axes, names, strict=True)):
        axis.fill_between(band.grid, band.lower, band.upper, color=style.PRIOR, alpha=0.35, lw=0)
        axis.axhline(0.0, color=style.REFERENCE, lw=0.6)
        look = {"color": style.OUTPUTS[name].colour, "drawstyle": "steps-post"}
        axis.plot(band.grid, calibration.difference[:, i], **look)
        axis.set(xlim=(0, 1))
        outside = bool(calibration.outside[i])
        words = f"outside by {calibration.excess[i]:.3f}" if outside else "inside"
        title = f"{style.OUTPUTS[name].symbol}   {words}, {in_p(calibration.p_values[i])}"
        axis.set_title(title, color=style.WARNING if outside else "black")
    style.label_outer(axes, "rank of the truth / (draws + 1)", "ECDF difference")
    title = style.heading(figure, motion, subject, calibration.words(style.symbols(names)), of=of)
    if calibration.outside.any():
        title.set_color(style.WARNING)
    share = f"{in_digits(100 * (1 - calibration.alpha), 4)} %"
    label = f"simultaneous {share} band, all {len(names)} outputs together"
    line = style.line_key("observed ranks (colour of the parameter)")
    style.legend_below(figure, [line, style.band_key(label, style.PRIOR, 0.35)])
    return figure


@style.styled
def contraction(
    scores: Scores,
    names: Sequence[str],
    *,
    motion: str,
    limit: np.ndarray | None = None,
    of: str = style.MODELLED,
) -> Figure:
    """Draw z-score against contraction, one dot per curve (paper, Fig. 5).

    Args:
        scores: From ``diagnostics.scores``.
        names: Names of the ``q`` outputs.
        limit: Mean contraction of the exact posterior, linearised, ``(q,)``, if known.
        of: Which drives the records are of.
    """
    figure, axes = style.panels(len(names), sharex=True, sharey=True)
    for i, (axis, name) in enumerate(zip(axes, names, strict=True)):
        dots = {"ms": 2.5, "mew": 0, "alpha": 0.45, "rasterized": True}
        dots["color"] = style.OUTPUTS[name].colour
        axis.plot(scores.contraction[:, i], scores.z[:, i], "o", **dots)
        for level in (-_Z_LIMIT, _Z_LIMIT):
            axis.axhline(level, color=style.REFERENCE, lw=0.9, ls=":")
        axis.axhline(0.0, color=style.REFERENCE, lw=0.6)
        words = f"mean {scores.mean_contraction[i]:.2f}"
        if limit is not None:
            axis.axvline(limit[i], color=style.MEASURED, lw=1.2, ls="--")
            words += f", limit {limit[i]:.2f}"
        symbol = style.OUTPUTS[name].symbol
        axis.set_title(f"{symbol}   {words}\nz-score sd {scores.z_sd[i]:.2f}")
    largest = max(4.2, 1.05 * abs(scores.z).max())
    lowest = scores.contraction.min()
    if lowest < -1.0:  # a few that know less than the prior does would hide all others
        lowest = np.quantile(scores.contraction, 0.002)
    left = int((scores.contraction < lowest).sum())
    axes[0].set(xlim=(min(0.0, 1.05 * lowest), 1.02), ylim=(-largest, largest))
    style.label_outer(axes, "contraction", "z-score")
    outcome = contraction_words(scores, style.symbols(names), limit)
    style.heading(figure, motion, "z-score against contraction", outcome, of=of)
    handles = [
        style.dot_key(f"one simulated curve{f'; {left} left of the axes' * (left > 0)}", ms=4),
        style.line_key("z-score ±3", ls=":", lw=0.9),
        limit is not None
        and style.line_key("mean, linearised limit", style.MEASURED, "--", lw=1.2),
    ]
    style.legend_below(figure, handles)
    return figure


@style.styled
def recovery(
    summary: Recovery, names: Sequence[str], *, motion: str, of: str = style.MODELLED
) -> Figure:
    """Draw posterior median and 95 % interval against the truth (paper, Fig. 6).

    Args:
        summary: From ``diagnostics.recovery``.
        names: Names of the ``q`` outputs.
        of: Which drives the records are of.
    """
    figure, axes = style.panels(len(names), height=3.2)
    for i, (axis, name) in enumerate(zip(axes, names, strict=True)):
        truth, low, high = summary.truth[:, i], *summary.interval_95[:, i].T
        output = style.OUTPUTS[name]
        axis.vlines(truth, low, high, color=output.colour, lw=0.7, alpha=0.13, rasterized=True)
        dots = {"ms": 3.2, "mec": "white", "mew": 0.3, "rasterized": True}
        axis.plot(truth, summary.median[:, i], "o", color=output.colour, **dots)
        # All truths and medians; the longest intervals may end outside, not to dwarf the rest.
        centres = np.concatenate([truth, summary.median[:, i]])
        least, most = centres.min(), centres.max()
        room = 0.06 * (most - least)
        ends = least - room, most + room
        axis.plot(ends, ends, color=style.MEASURED, lw=1.0, ls="--")
        axis.set(xlim=ends, ylim=ends, box_aspect=1)
        axis.set(xlabel=f"true {output.label}", ylabel=f"inferred {output.label}")
        covered = f"{percent(summary.covered_95[i])}, in 50 %: {percent(summary.covered_50[i])}"
        words = f"correlation {summary.correlation[i]:.2f}\ntruth in 95 %: {covered}"
        axis.set_title(f"{output.symbol}   {words}", fontsize=10)
    outcome = recovery_words(summary)
    style.heading(figure, motion, "recovery of the true parameters", outcome, of=of)
    handles = [
        style.dot_key("posterior median", ms=4),
        style.line_key("95 % interval", alpha=0.5),
        style.line_key("inferred = true", style.MEASURED, "--", lw=1.0),
    ]
    style.legend_below(figure, handles)
    return figure
