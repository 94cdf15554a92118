"""What each motion lets one know of each parameter, and what is reached of it."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from breaker.figures.style import (
    AMORTISED,
    CORRECTED,
    MEASURED,
    PRIOR,
    REFERENCE,
    heading,
    legend_below,
    new_figure,
    parameter,
    styled,
)
from breaker.validation import VERDICTS, identifiability_words

__all__ = ["identifiability"]

# Shift from the middle of the row downwards, marker and colour.
_POSTERIORS = {"amortised": (-0.13, "o", AMORTISED), "corrected": (0.13, "D", CORRECTED)}
_COLUMNS = {"limit": 0.07, "amortised": 0.25, "corrected": 0.48}  # places in the table
_WORDS = {"amortised": "amortised (network alone)", "corrected": "corrected (exact posterior)"}
_VERDICT = 0.62
_HALF = 0.36  # half the height of a limit's band, in rows


@styled
def identifiability(reached: xr.Dataset, *, motion: str) -> Figure:
    """Draw contraction of each output: the exact limit, and what both posteriors reach.

    Args:
        reached: From :func:`breaker.validation.comparison.reached`; outputs are drawn in its order.
        motion: Motion of the title.
    """
    names = [str(name) for name in reached["output"].values]
    figure = new_figure(13.6, 0.52 * len(names) + 2.4)
    axis, table = figure.subplots(1, 2, sharey=True, width_ratios=(1.6, 1.0))
    rows = np.arange(len(names))
    _limit(axis, rows, reached.sel(source="limit"))
    for source, (shift, marker, colour) in _POSTERIORS.items():
        one = reached.sel(source=source)
        axis.hlines(rows + shift, one["lower"], one["upper"], color=colour, lw=1.4)
        axis.plot(one["mean"], rows + shift, marker, color=colour, mec="white", mew=0.8, ms=8)
    labels = [f"{parameter(name).meaning}   {parameter(name).symbol}" for name in names]
    axis.set_yticks(rows, labels)
    axis.tick_params(axis="y", labelsize=10, length=0)
    axis.set(xlim=(min(0.0, axis.get_xlim()[0]), 1.0), ylim=(len(rows) - 0.45, -1.0))
    axis.grid(axis="y", visible=False)
    axis.set_xlabel("contraction   (0: nothing learnt, the prior stays;  1: known exactly)")
    _table(table, rows, reached)
    text = "what the curve tells of each parameter"
    heading(figure, motion, text, identifiability_words(reached))
    legend_below(figure, _handles(reached), columns=2)
    return figure


def _limit(axis: Axes, rows: np.ndarray, limit: xr.Dataset) -> None:
    width = limit["upper"] - limit["lower"]
    axis.barh(rows, width, 2 * _HALF, left=limit["lower"], color=PRIOR, alpha=0.35, lw=0)
    for least, _ in VERDICTS[:-1]:
        axis.axvline(least, color=REFERENCE, lw=0.9, ls=":")
    axis.vlines(limit["mean"], rows - _HALF, rows + _HALF, color=MEASURED, lw=1.6, ls="--")


def _table(axis: Axes, rows: np.ndarray, reached: xr.Dataset) -> None:
    """Write mean contractions and the verdict beside each row."""
    axis.set_axis_off()
    axis.set_xlim(0, 1)
    for source, x in _COLUMNS.items():
        colour = _POSTERIORS[source][2] if source in _POSTERIORS else MEASURED
        axis.text(x, -0.8, source, ha="center", va="center", color=colour, weight="bold")
        for row, value in zip(rows, reached["mean"].sel(source=source).values, strict=True):
            axis.text(x, row, f"{value:.3f}", ha="center", va="center")
    for row, words in zip(rows, reached["verdict"].values, strict=True):
        axis.text(_VERDICT, row, str(words), va="center")


def _handles(reached: xr.Dataset) -> list:
    count = dict(zip(reached["source"].values.tolist(), reached["curves"].values, strict=True))
    between = " and ".join(f"{least:g}" for least, _ in VERDICTS[-2::-1])
    band = f"exact limit: 90 % of {count['limit']} draws of the prior"
    handles = [
        Patch(color=PRIOR, alpha=0.35, lw=0, label=band),
        Line2D([], [], color=MEASURED, ls="--", lw=1.6, label="exact limit: mean"),
        Line2D([], [], color=REFERENCE, ls=":", lw=0.9, label=f"{between}: where verdicts change"),
    ]
    for source, (_, marker, colour) in _POSTERIORS.items():
        label = f"{_WORDS[source]}: mean and 90 % of {count[source]} simulated curves"
        handles.append(Line2D([], [], color=colour, marker=marker, ms=8, mec="white", label=label))
    return handles
