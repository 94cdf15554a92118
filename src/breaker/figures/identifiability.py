"""How well each motion determines each parameter, and how much of it posteriors reach."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.figures import style
from breaker.paper.validation import KNOWLEDGE, identifiability_words

# Shift from the middle of the row downwards, marker and colour of each posterior.
_POSTERIORS = {
    "amortised": (-0.13, "o", style.AMORTISED),
    "corrected": (0.13, "D", style.CORRECTED),
}
_COLUMNS = {"limit": 0.05, "amortised": 0.23, "corrected": 0.44}  # of the table
_WORDS = {
    "amortised": "amortised (network alone): mean and 90 % of {} simulated curves",
    "corrected": "corrected (exact posterior): mean and 90 % of {} simulated curves",
}
_KNOWN = 0.64  # place of the words in the table
_HALF = 0.36  # half the height of a limit's band, in rows


@style.styled
def identifiability(reached: xr.Dataset, *, motion: str) -> Figure:
    """Draw contraction of each output: its linearised limit, and what posteriors reach.

    Args:
        reached: From ``amortised_against_exact.reached``; outputs are drawn in its order.
    """
    names = [str(name) for name in reached["output"].values]
    figure = style.new_figure(14.6, 0.56 * len(names) + 2.8)
    axis, table = figure.subplots(1, 2, sharey=True, width_ratios=(1.6, 1.2))
    rows = np.arange(len(names))
    _limit(axis, rows, reached.sel(source="limit"))
    for source, (shift, marker, color) in _POSTERIORS.items():
        if source in reached["source"].values:
            one = reached.sel(source=source)
            values = (one["lower"], one["mean"], one["upper"])
            style.draw_intervals(axis, rows + shift, values, color=color, marker=marker, lw=1.4)
    labels = [f"{style.OUTPUTS[name].meaning}   {style.OUTPUTS[name].symbol}" for name in names]
    axis.set_yticks(rows, labels)
    axis.tick_params(axis="y", labelsize=10, length=0)
    axis.set(xlim=(min(0.0, axis.get_xlim()[0]), 1.0), ylim=(len(rows) - 0.45, -1.0))
    axis.grid(axis="y", visible=False)
    axis.set_xlabel("contraction   (0: nothing learnt, the prior stays;  1: known exactly)")
    _table(table, rows, reached)
    text = "how well the curve determines each parameter"
    style.heading(figure, motion, text, identifiability_words(reached))
    style.legend_below(figure, _handles(reached), columns=2)
    return figure


def _limit(axis: Axes, rows: np.ndarray, limit: xr.Dataset) -> None:
    width = limit["upper"] - limit["lower"]
    axis.barh(rows, width, 2 * _HALF, left=limit["lower"], color=style.PRIOR, alpha=0.35, lw=0)
    for least, _ in KNOWLEDGE[:-1]:
        axis.axvline(least, color=style.REFERENCE, lw=0.9, ls=":")
    ends = rows - _HALF, rows + _HALF
    axis.vlines(limit["mean"], *ends, color=style.MEASURED, lw=1.6, ls="--")


def _table(axis: Axes, rows: np.ndarray, reached: xr.Dataset) -> None:
    """Write mean contractions beside each row, and what the limit means."""
    axis.set_axis_off()
    axis.set_xlim(0, 1)
    for source in reached["source"].values:
        color = _POSTERIORS[source][2] if source in _POSTERIORS else style.MEASURED
        x = _COLUMNS[source]
        axis.text(x, -0.8, source, ha="center", va="center", color=color, weight="bold")
        for row, value in zip(rows, reached["mean"].sel(source=source).values, strict=True):
            axis.text(x, row, f"{value:.3f}", ha="center", va="center")
    axis.text(_KNOWN, -0.8, "over the prior", va="center", weight="bold")
    for row, words in zip(rows, reached["known"].values, strict=True):
        axis.text(_KNOWN, row, str(words), va="center")


def _handles(reached: xr.Dataset) -> list:
    count = dict(zip(reached["source"].values.tolist(), reached["curves"].values, strict=True))
    between = " and ".join(f"{least:g}" for least, _ in KNOWLEDGE[-2::-1])
    band = f"linearised limit: 90 % of {count['limit']} draws of the prior"
    handles = [
        style.band_key(band, style.PRIOR, 0.35),
        style.line_key("linearised limit: mean", style.MEASURED, "--", lw=1.6),
        style.line_key(f"{between}: from partly known on, from known on", ls=":", lw=0.9),
    ]
    for source, (_, marker, color) in _POSTERIORS.items():
        if source in count:
            look = {"marker": marker, "ms": 7, "mec": "white"}
            handles.append(style.line_key(_WORDS[source].format(count[source]), color, **look))
    return handles
