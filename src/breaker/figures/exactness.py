"""Divergence of a network from the exact posterior, and the parameters that a curve determines."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.common.numerals import first_of
from breaker.figures import panels as p
from breaker.figures import style

_LARGEST_K = 0.7  # limit of reliable Pareto-smoothed weights (Vehtari et al. 2024)
# Downward shift from the middle of the row, marker and colour of a posterior.
_POSTERIORS = {
    "amortised": (-0.15, "o", style.AMORTISED),
    "corrected": (0.15, "D", style.CORRECTED),
}


@style.styled
def exactness(
    judged: xr.Dataset, corrected: xr.Dataset, summary: Mapping[str, float], *, motion: str
) -> Figure:
    """Draw sizes and tail of weights, and divergences.

    ``judged`` and ``corrected`` are from ``correction``, ``summary`` from ``validation``.
    """
    figure = style.new_figure(14.0, 5.0)
    efficiency, tail, divergence = figure.subplots(1, 3)
    medians = summary["efficiency_median"], summary["corrected_efficiency_median"]
    _weights(efficiency, tail, (judged, corrected), medians)
    _divergence(divergence, judged, summary)
    for axis in figure.axes:
        look = {"bbox_to_anchor": (-0.02, 0.99), "fontsize": 9, "labelspacing": 0.2}
        axis.legend(loc="lower left", **look)
        axis.set_title(axis.get_title(), pad=44.0)  # room for the legend's three lines
    gap = f"{summary['gap_nats']:.2f} ± {summary['gap_se']:.2f} nats"
    resolved = corrected["resolved"].values.astype(bool)
    counts = zip(*np.unique(corrected["rounds"].values[resolved], return_counts=True), strict=True)
    about = (
        f"{p.SOURCES[motion]}: the correction resolves {resolved.sum()} of {resolved.size} curves, "
    )
    about += ", ".join(f"{count} in {kind} rounds" for kind, count in counts)
    style.title(figure, f"Mean divergence of the network from the exact posterior: {gap}", about)
    return figure


def _weights(efficiency: Axes, tail: Axes, both: Sequence, medians: Sequence[float]) -> None:
    """Draw the relative effective sample size of weights, and Pareto k of their tail."""
    looks = (style.AMORTISED, "network"), (style.CORRECTED, "correction")
    for data, (colour, words), median in zip(both, looks, medians, strict=True):
        k = data["pareto_k"].values
        label = f"{words}: median {p.percent(median)}"
        _shares(efficiency, 100 * data["efficiency"].values, colour, label)
        label = f"{words}: {np.sum(k < _LARGEST_K)} of {k.size} below {_LARGEST_K}"
        _shares(tail, k, colour, label)
    low, high = tail.get_xlim()
    high = max(high, _LARGEST_K + 0.3)
    tail.axvline(_LARGEST_K, color=style.WARNING, lw=1.2, ls="--", label="weights do not settle")
    tail.axvspan(_LARGEST_K, high, color=style.WARNING, alpha=0.08, lw=0)
    title = "relative effective sample size"
    efficiency.set(xlabel="relative sample size (%)", xlim=(0, 100), title=title)
    tail.set(xlabel="Pareto k", xlim=(low, high), title="tail of the weights")


def _divergence(axis: Axes, judged: xr.Dataset, summary: Mapping) -> None:
    mean, error = summary["gap_nats"], summary["gap_se"]
    values = judged["divergence"].values
    label = f"each curve (weights): up to {np.nanmax(values, initial=-np.inf):.2f}"
    _shares(axis, values, style.AMORTISED, label)
    label = f"mean (true values): {mean:.2f} ± {error:.2f} nats"
    axis.plot([mean, mean], [0, 103], color=style.MEASURED, lw=1.2, label=label)
    axis.fill_betweenx([0, 103], mean - error, mean + error, color=style.MEASURED, alpha=0.15, lw=0)
    axis.axvline(0.0, color=style.REFERENCE, lw=1.2, ls="--", label="exact: 0")
    # The axis omits the last 3 % of the curves, which are far away; the legend states the largest.
    most = np.quantile(values[np.isfinite(values)], 0.97)
    axis.set_xlim(right=1.2 * max(x for x in (0.1, mean + error, most) if np.isfinite(x)))
    axis.set(xlabel="divergence (nats)", title="divergence from the exact posterior")


def _shares(axis: Axes, values: np.ndarray, colour: str, label: str) -> None:
    """Draw the share of all curves at or below each value; nan is above all values."""
    known = np.sort(values[~np.isnan(values)])
    if missing := values.size - known.size:
        label += f", {missing} without"
    x, steps = np.append(known[:1], known), 100 * np.arange(known.size + 1) / values.size
    axis.plot(x, steps, color=colour, drawstyle="steps-post", label=label, lw=1.8)
    axis.set(ylim=(0, 103), ylabel="curves at or below (%)")


@style.styled
def identifiability(reached: xr.Dataset, *, motion: str) -> Figure:
    """Draw the contraction of each output: its linearised limit, and values of posteriors."""
    names = [str(name) for name in reached["output"].values]
    figure = style.new_figure(14.6, 0.56 * len(names) + 3.0)
    axis = figure.subplots()
    rows, limit = np.arange(len(names)), reached.sel(source="limit")
    width = limit["upper"] - limit["lower"]
    count = dict(zip(reached["source"].values.tolist(), reached["curves"].values, strict=True))
    look = {"color": style.PRIOR, "alpha": 0.35, "lw": 0}
    look["label"] = f"linearised limit: 90 % of {count['limit']} draws of the prior"
    axis.barh(rows, width, 0.72, left=limit["lower"], **look)
    look = {"color": style.MEASURED, "lw": 1.6, "ls": "--", "label": "linearised limit: mean"}
    axis.vlines(limit["mean"], rows - 0.36, rows + 0.36, **look)
    for least in (0.5, 0.8):  # thresholds of validation.KNOWLEDGE
        label = "0.5 and 0.8: from partly known on, from known on"
        axis.axvline(least, color=style.REFERENCE, lw=0.9, ls=":", label=label)
    for source in (name for name in _POSTERIORS if name in count):
        shift, marker, color = _POSTERIORS[source]
        one = reached.sel(source=source)
        ends = one["lower"], one["mean"], one["upper"]
        label = f"{source} posterior: mean and 90 % of {count[source]} simulated curves"
        p.draw_intervals(axis, rows + shift, ends, label=label, color=color, marker=marker)
    known = reached["known"].values.tolist()
    values = zip(reached["mean"].transpose("output", "source").values, known, strict=True)
    texts = [f"{'  '.join(f'{mean:.3f}' for mean in means)}   {words}" for means, words in values]
    p.rows_of_words(axis, [*map(p.named, names)], texts)
    axis.set(xlim=(min(0.0, axis.get_xlim()[0]), 1.0))
    axis.set_xlabel("contraction   (0: nothing learnt, the prior stays;  1: known exactly)")
    prior = [p.word(name) for name, words in zip(names, known, strict=True) if "prior" in words]
    partly = [p.word(name) for name, words in zip(names, known, strict=True) if "partly" in words]
    finding = f"The prior decides {first_of(prior, 4) or 'no parameter'}"
    finding += f"; partly known: {first_of(partly, 4)}" if partly else ""
    about = f"{p.SOURCES[motion]}: what a curve determines, over the prior. On the right: mean "
    style.title(figure, finding, f"{about} contraction of {', '.join(count)}")
    p.legend_below(figure, columns=2)
    return figure
