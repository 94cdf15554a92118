"""Networks side by side, and posteriors of records with missing samples."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from breaker.calibration import Verdict
from breaker.figures.style import (
    AMORTISED,
    CORRECTED,
    PRIOR,
    REFERENCE,
    WARNING,
    colour,
    heading,
    legend_below,
    new_figure,
    panels,
    parameter,
    styled,
)

__all__ = ["missing", "networks"]

# Column, that of its standard error, words, and whether its axis is logarithmic.
_MEASURES = (
    ("held_out_log_density", "held_out_log_density_se", "held-out log density (nats)", False),
    ("gap_nats", "gap_se", "gap to the exact posterior (nats)", False),
    ("efficiency_median", None, "median efficiency", False),
    ("calibration_p", None, "calibration, p of all outputs", False),
    ("draws_per_second", None, "draws per second, one core", True),
    ("training_seconds", None, "training, s of processor time", True),
    ("weights", None, "weights", True),
)
_POOR = 0.01  # p-value below which a network counts as not calibrated


@styled
def networks(table: pd.DataFrame, *, motion: str) -> Figure:
    """Draw one panel a measure, one row a network.

    Args:
        table: Rows of ``network_table.row``.
        motion: Motion of the title.
    """
    figure, axes = panels(len(_MEASURES), columns=4, width=3.6, height=0.42 * len(table) + 1.4)
    rows = np.arange(len(table))[::-1]
    for i, (axis, (column, error, words, logarithmic)) in enumerate(
        zip(axes, _MEASURES, strict=True)
    ):
        values = table[column].to_numpy(dtype=float)
        if error is not None:
            axis.errorbar(values, rows, xerr=2 * table[error], fmt="none", color=REFERENCE, lw=1)
        poor = (values < _POOR) if column == "calibration_p" else np.zeros(len(rows), dtype=bool)
        axis.scatter(values, rows, c=[WARNING if bad else AMORTISED for bad in poor], s=36)
        if logarithmic:
            axis.set_xscale("log")
        axis.set(xlabel=words, ylim=(-0.6, len(rows) - 0.4))
        names = table.network.str.replace("_", " ") if i % 4 == 0 else [""] * len(rows)
        axis.set_yticks(rows, names)
        axis.margins(x=0.15)
        for row, value in zip(rows, values, strict=True):
            axis.annotate(
                f"{value:.3g}" if value < 1000 else f"{value:,.0f}",
                (value, row),
                xytext=(0, 7),
                textcoords="offset points",
                ha="center",
                fontsize=8,
            )
    _limits(axes)
    best = table.loc[table.held_out_log_density.idxmax(), "network"].replace("_", " ")
    heading(figure, motion, "networks side by side", f"highest held-out log density: {best}")
    line = Line2D([], [], color=REFERENCE, lw=1, label="two standard errors")
    legend_below(figure, [line])
    return figure


def _limits(axes: Sequence[Axes]) -> None:
    """Show the gap from zero and shares from 0 to 1."""
    low, high = axes[1].get_xlim()
    axes[1].set_xlim(min(low, 0.0), high)
    axes[1].axvline(0.0, color=REFERENCE, lw=0.9, ls="--")
    for axis in axes[2:4]:
        axis.set_xlim(-0.03, 1.03)


@styled
def missing(
    verdict: Verdict,
    amortised: np.ndarray,
    exact: np.ndarray,
    names: Sequence[str],
    *,
    motion: str,
    share: float,
) -> Figure:
    """Draw calibration, and how much wider posteriors are, with samples missing at random.

    Args:
        verdict: Of the ranks with missing samples.
        amortised, exact: Ratio of posterior sds with missing samples to those without, ``(n, q)``,
            of the network and of the exact posterior.
        names: Names of the ``q`` outputs.
        motion: Motion of the title.
        share: Share of the samples that is missing.
    """
    q = len(names)
    figure = new_figure(11.0, 5.2)
    left, right = figure.subplots(1, 2, width_ratios=[1.15, 1.0])
    band = verdict.band
    left.fill_between(band.grid, band.lower, band.upper, color=PRIOR, alpha=0.35, lw=0)
    for i, name in enumerate(names):
        left.plot(
            band.grid,
            verdict.difference[:, i],
            color=colour(name),
            drawstyle="steps-post",
            label=f"{parameter(name).symbol}, p = {verdict.p_values[i]:.2g}",
        )
    left.axhline(0.0, color=REFERENCE, lw=0.6)
    left.set(xlim=(0, 1), xlabel="rank of the truth / (draws + 1)", ylabel="ECDF difference")
    left.set_title("calibrated?", loc="left")
    left.legend(ncols=2, loc="best", fontsize=8)

    rows = np.arange(q)[::-1]
    for ratios, mark, shift in ((amortised, AMORTISED, 0.14), (exact, CORRECTED, -0.14)):
        low, middle, high = np.nanquantile(ratios, [0.05, 0.5, 0.95], axis=0)
        right.hlines(rows + shift, low, high, color=mark, lw=2, alpha=0.5)
        right.plot(middle, rows + shift, "o", color=mark, ms=6)
    right.axvline(1.0, color=REFERENCE, lw=0.9, ls="--")
    right.set_yticks(rows, [parameter(name).symbol for name in names])
    right.set(xlabel="posterior sd with missing samples / with all", ylim=(-0.6, q - 0.4))
    right.set_title("wider where it should be?", loc="left")

    outside = [parameter(n).symbol for n, bad in zip(names, verdict.outside, strict=True) if bad]
    words = f"outside the band: {', '.join(outside)}" if outside else "all outputs inside the band"
    heading(figure, motion, f"{share:.0%} of the samples missing at random", words)
    band_words = f"simultaneous {100 * (1 - verdict.alpha):g} % band"
    handles = [
        Patch(color=PRIOR, alpha=0.35, lw=0, label=band_words),
        Line2D([], [], color=AMORTISED, marker="o", lw=2, label="network: median, 5 to 95 %"),
        Line2D([], [], color=CORRECTED, marker="o", lw=2, label="exact posterior"),
    ]
    legend_below(figure, handles)
    return figure
