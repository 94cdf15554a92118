"""Calibration, contraction and recovery on simulated curves (paper, Figs. 4, 5, 6).

``names`` are the names of ``q`` outputs; ``about`` states motion, posterior and drives in words.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from breaker.common.numerals import first_of, in_digits, in_p
from breaker.figures import panels as p
from breaker.figures import style

if TYPE_CHECKING:
    from breaker.paper.calibration import Calibration
    from breaker.paper.validation import Recovery


@style.styled
def sbc(calibration: "Calibration", names: Sequence[str], *, about: str) -> Figure:
    """Draw the ECDF difference of the ranks in its simultaneous band (paper, Fig. 4)."""
    figure, axes = p.panels(len(names), sharex=True, sharey=True)
    band, share = calibration.band, f"{in_digits(100 * (1 - calibration.alpha), 4)} %"
    for i, (axis, name) in enumerate(zip(axes, names, strict=True)):
        look = {"color": style.PRIOR, "alpha": 0.35, "lw": 0}
        look["label"] = f"simultaneous {share} band, all {len(names)} outputs together"
        axis.fill_between(band.grid, band.lower, band.upper, step="post", **look)
        axis.axhline(0.0, color=style.REFERENCE, lw=0.6)
        look = {"color": p.OUTPUTS[name].colour, "label": "observed ranks"}
        axis.plot(band.grid, calibration.difference[:, i], drawstyle="steps-post", **look)
        axis.set(xlim=(0, 1))
        outside = bool(calibration.outside[i])
        words = f"outside by {calibration.excess[i]:.3f}" if outside else "inside"
        words = f"{p.named(name)}\n{words}, {in_p(calibration.p_values[i])}"
        axis.set_title(words, color=style.WARNING if outside else "black")
    p.label_outer(axes, "rank of the truth / (draws + 1)", "ECDF difference")
    failed = [p.word(name) for name, out in zip(names, calibration.outside, strict=True) if out]
    finding = f"No miscalibration detected: all {len(names)} outputs inside the {share} band"
    if failed:
        finding = f"NOT calibrated: {first_of(failed, 3)} outside the {share} band"
    least = int(np.argmin(calibration.p_values))
    about += f"\nsmallest {in_p(calibration.p_values[least])} ({p.word(names[least])}), "
    about += f"of {len(names)} outputs together {in_p(calibration.p_value)}"
    style.title(figure, finding, about, failed=bool(failed))
    p.legend_below(figure)
    return figure


@style.styled
def contraction(
    z: np.ndarray,
    known: np.ndarray,
    names: Sequence[str],
    *,
    about: str,
    limit: np.ndarray | None = None,
) -> Figure:
    """Draw z-scores against contractions ``(n, q)``, one dot per curve (paper, Fig. 5).

    ``limit`` is the mean contraction of the exact posterior, linearised, ``(q,)``, if known.
    """
    figure, axes = p.panels(len(names), sharex=True, sharey=True)
    mean, z_sd = known.mean(axis=0), z.std(axis=0, ddof=1)
    for i, (axis, name) in enumerate(zip(axes, names, strict=True)):
        dots = {"ms": 2.5, "mew": 0, "alpha": 0.45, "rasterized": True}
        dots |= {"color": p.OUTPUTS[name].colour, "label": "one simulated curve"}
        axis.plot(known[:, i], z[:, i], "o", **dots)
        for level in (-3.0, 3.0):
            axis.axhline(level, color=style.REFERENCE, lw=0.9, ls=":", label="z-score ±3")
        axis.axhline(0.0, color=style.REFERENCE, lw=0.6)
        words = f"mean {mean[i]:.2f}"
        if limit is not None:
            look = {"lw": 1.2, "ls": "--", "label": "mean, linearised limit"}
            axis.axvline(limit[i], color=style.MEASURED, **look)
            words += f", limit {limit[i]:.2f}"
        axis.set_title(f"{p.named(name)}\n{words}, z-score sd {z_sd[i]:.2f}", fontsize=10)
    largest = max(4.2, 1.05 * abs(z).max())
    lowest = known.min()
    if lowest < -1.0:  # a few posteriors far wider than the prior would compress all others
        lowest = np.quantile(known, 0.002)
    left = int((known < lowest).sum())
    axes[0].set(xlim=(min(0.0, 1.05 * lowest), 1.02), ylim=(-largest, largest))
    p.label_outer(axes, "contraction", "z-score")
    best, least = mean.argmax(), mean.argmin()
    finding = f"Best known: {p.word(names[best])} (contraction {mean[best]:.2f})"
    if least != best:
        finding += f"; least: {p.word(names[least])} ({mean[least]:.2f})"
    about += f"\nz-score sd {z_sd.min():.2f} to {z_sd.max():.2f}"
    about += f"; {left} curves left of the axes" * (left > 0)
    if limit is not None:
        short = (limit - mean).max()
        short = f"at most {in_digits(short, 1)}" if short > 0 else "not"
        about += f"; contraction {short} below its limit"
    style.title(figure, finding, about)
    p.legend_below(figure)
    return figure


@style.styled
def recovery(summary: "Recovery", truth: np.ndarray, names: Sequence[str], *, about: str) -> Figure:
    """Draw posterior median and 95 % interval against the truth ``(n, q)`` (paper, Fig. 6)."""
    figure, axes = p.panels(len(names), height=3.7)
    for i, (axis, name) in enumerate(zip(axes, names, strict=True)):
        true, low, high = truth[:, i], *summary.interval_95[:, i].T
        output = p.OUTPUTS[name]
        look = {"lw": 0.7, "alpha": 0.13, "rasterized": True, "label": "95 % interval"}
        axis.vlines(true, low, high, color=output.colour, **look)
        dots = {"ms": 3.2, "mec": "white", "mew": 0.3, "label": "posterior median"}
        axis.plot(true, summary.median[:, i], "o", color=output.colour, **dots)
        # Show all true values and medians; the longest intervals may end outside the axes.
        centres = np.concatenate([true, summary.median[:, i]])
        room = 0.06 * np.ptp(centres)
        ends = centres.min() - room, centres.max() + room
        axis.plot(ends, ends, color=style.MEASURED, lw=1.0, ls="--", label="inferred = true")
        axis.set(xlim=ends, ylim=ends)
        axis.set(xlabel=f"true {output.label}", ylabel=f"inferred {output.label}")
        covered = f"{p.percent(summary.covered_95[i])}, in 50 %: {p.percent(summary.covered_50[i])}"
        words = f"correlation {summary.correlation[i]:.2f}\ntruth in 95 %: {covered}"
        axis.set_title(f"{p.named(name)}\n{words}", fontsize=10)
    wide, half = (
        p.from_to([p.percent(column.min()), p.percent(column.max())])
        for column in (summary.covered_95, summary.covered_50)
    )
    finding = f"95 % intervals contain {wide} of the true values, 50 % intervals {half}"
    style.title(figure, finding, about)
    p.legend_below(figure)
    return figure
