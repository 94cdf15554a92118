"""How far a network is from the exact posterior, and what the correction makes of it."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.figures import style
from breaker.paper.validation import exactness_words, percent, plus_minus

_LARGEST_K = 0.7  # of Pareto's tail, from which importance weights do not settle
_BODY = 0.97  # share of the curves that the panel of the gap has room for
_ABOVE = {"loc": "lower left", "bbox_to_anchor": (-0.02, 0.99), "fontsize": 9, "labelspacing": 0.2}
_PAD = 44.0  # points between a panel of the first row and its title, for the words in between
_ROWS = {"amortised": (-0.17, style.AMORTISED), "corrected": (0.17, style.CORRECTED)}


@style.styled
def exactness(
    judged: xr.Dataset,
    corrected: xr.Dataset,
    examples: xr.Dataset,
    summary: Mapping[str, float],
    *,
    motion: str,
) -> Figure:
    """Draw efficiency, tail, gap and rounds over curves, and three curves with both posteriors.

    Args:
        judged: Over ``curve``: ``efficiency``, ``pareto_k`` and ``divergence`` (nats) of the
            network's own draws, from ``exact_judge.judge``.
        corrected: Over ``curve``: ``efficiency``, ``pareto_k``, ``rounds`` and ``resolved``, from
            ``exact_judge.correct_validation``.
        examples: From ``amortised_against_exact.examples``; without any, their row is left out.
        summary: The row of ``posterior_tables.summary``.
    """
    count = examples.sizes["example"]
    figure = style.new_figure(14.0, 10.2 if count else 5.0)
    rows = figure.subfigures(2 if count else 1, 1, height_ratios=(1.0, 1.3)[: 1 + bool(count)])
    above, *below = np.atleast_1d(rows)
    axes = above.subplots(1, 4)
    _efficiency(axes[0], judged, corrected, summary)
    _tail(axes[1], judged, corrected)
    _gap(axes[2], judged, summary)
    _rounds(axes[3], corrected)
    for axis in axes:
        axis.legend(**_ABOVE)
    for place in below:
        grid = place.subplots(1, count, sharey=True, squeeze=False)
        for i, axis in enumerate(grid.flat):
            _example(axis, examples.isel(example=i))
    text = "the network against the exact posterior"
    style.heading(figure, motion, text, exactness_words(summary))
    style.legend_below(figure, _handles(), columns=3)
    return figure


def _efficiency(axis: Axes, judged: xr.Dataset, corrected: xr.Dataset, summary: Mapping) -> None:
    for data, colour, words, key in (
        (judged, style.AMORTISED, "network", "efficiency_median"),
        (corrected, style.CORRECTED, "correction", "corrected_efficiency_median"),
    ):
        label = f"{words}: median {percent(summary[key])}"
        _shares(axis, 100 * data["efficiency"].values, colour, label, above=True)
    axis.set(xlabel="efficiency (%)", ylabel="curves at or above (%)", xlim=(0, 100))
    axis.set_title("efficiency of the weights", pad=_PAD)


def _tail(axis: Axes, judged: xr.Dataset, corrected: xr.Dataset) -> None:
    both = ((judged, style.AMORTISED, "network"), (corrected, style.CORRECTED, "correction"))
    for data, colour, words in both:
        k = data["pareto_k"].values
        label = f"{words}: {np.sum(k < _LARGEST_K)} of {k.size} below {_LARGEST_K}"
        _shares(axis, k, colour, label)
    low, high = axis.get_xlim()
    high = max(high, _LARGEST_K + 0.3)
    label = f"from {_LARGEST_K} on weights do not settle"
    axis.axvline(_LARGEST_K, color=style.WARNING, lw=1.2, ls="--", label=label)
    axis.axvspan(_LARGEST_K, high, color=style.WARNING, alpha=0.08, lw=0)
    axis.set(xlabel="Pareto k", ylabel="curves at or below (%)", xlim=(low, high))
    axis.set_title("tail of the weights", pad=_PAD)


def _gap(axis: Axes, judged: xr.Dataset, summary: Mapping) -> None:
    mean, error = summary["gap_nats"], summary["gap_se"]
    divergence = judged["divergence"].values
    label = f"each curve (weights): up to {np.nanmax(divergence, initial=-np.inf):.2f}"
    _shares(axis, divergence, style.AMORTISED, label)
    label = f"mean (true values): {plus_minus(mean, error)}"
    axis.plot([mean, mean], [0, 103], color=style.MEASURED, lw=1.2, label=label)
    axis.fill_betweenx([0, 103], mean - error, mean + error, color=style.MEASURED, alpha=0.15, lw=0)
    axis.axvline(0.0, color=style.REFERENCE, lw=1.2, ls="--", label="exact: 0")
    # The last few curves, far away, would dwarf all others; the legend says how far.
    shown = np.sort(divergence[np.isfinite(divergence)])
    shown = [0.1, mean + error, *shown[: int(np.ceil(_BODY * shown.size))]]
    axis.set_xlim(right=1.2 * max(x for x in shown if np.isfinite(x)))
    axis.set(xlabel="divergence (nats)", ylabel="curves at or below (%)")
    axis.set_title("gap to the exact posterior", pad=_PAD)


def _rounds(axis: Axes, corrected: xr.Dataset) -> None:
    """Count the curves by the rounds that they took, those not resolved apart."""
    resolved = corrected["resolved"].values.astype(bool)
    kinds, counts = np.unique(corrected["rounds"].values[resolved], return_counts=True)
    places = np.arange(len(kinds) + 1)
    for at, values, colour, words in (
        (places[:-1], counts, style.CORRECTED, "resolved"),
        (places[-1:], [np.sum(~resolved)], style.WARNING, "not resolved"),
    ):
        label = f"{words}: {np.sum(values):.0f} of {resolved.size}"
        bars = axis.bar(at, values, color=colour, width=0.7, label=label)
        axis.bar_label(bars, padding=2, color=colour)
    axis.set_xticks(places, [*(str(kind) for kind in kinds), "not\nresolved"])
    axis.margins(y=0.12)
    axis.yaxis.get_major_locator().set_params(integer=True)
    axis.grid(axis="x", visible=False)
    axis.set(xlabel="rounds of adaptation", ylabel="curves")
    axis.set_title("rounds of the correction", pad=_PAD)


def _shares(
    axis: Axes, values: np.ndarray, colour: str, label: str, *, above: bool = False
) -> None:
    """Draw the share of all curves at or below, or above, each value; nan counts as neither."""
    known = np.sort(values[~np.isnan(values)])
    if missing := values.size - known.size:
        label += f", {missing} without"
    steps = 100 * np.arange(known.size + 1) / values.size
    if above:
        x, y, kind = np.append(known, known[-1:]), steps[::-1], "steps-pre"
    else:
        x, y, kind = np.append(known[:1], known), steps, "steps-post"
    axis.plot(x, y, color=colour, drawstyle=kind, label=label, lw=1.8)
    axis.set_ylim(0, 103)


def _example(axis: Axes, one: xr.Dataset) -> None:
    """Draw both posteriors of a curve, output by output from the top down."""
    rows = np.arange(one.sizes["output"])
    for posterior, (shift, colour) in _ROWS.items():
        each, at = one.sel(posterior=posterior), rows + shift
        for interval, width in (("interval_95", 1.4), ("interval_50", 5.0)):
            low, high = (each[interval].sel(bound=bound).values for bound in ("lower", "upper"))
            axis.hlines(at, low, high, color=colour, lw=width)
        axis.plot(each["median"], at, "o", color=colour, mec="white", mew=0.8, ms=6)
    axis.plot(one["truth"], rows, "|", color=style.MEASURED, ms=17, mew=1.8)
    axis.axvline(0.0, color=style.REFERENCE, lw=0.6)
    axis.set_yticks(rows, style.symbols(one["output"].values.tolist()))
    axis.set_ylim(len(rows) - 0.45, -0.55)
    limit = max(3.5, *np.abs(axis.get_xlim()))
    axis.set_xlim(-limit, limit)
    axis.tick_params(axis="y", labelsize=11)
    axis.grid(axis="y", visible=False)
    axis.set_xlabel("difference from the corrected median (corrected sd)")
    resolved, k = bool(one["resolved"]), float(one["pareto_k"])
    words = f"{one['place'].item()} efficiency: simulated curve {int(one['curve']) + 1}\n"
    words += f"efficiency {percent(float(one['efficiency']))}, "
    words += f"k {k:.2f}" if np.isfinite(k) else "k not known"
    words += "" if resolved else ", not resolved"
    axis.set_title(words, color="black" if resolved else style.WARNING)


def _handles() -> list:
    return [
        style.line_key("amortised: the network alone", style.AMORTISED, lw=3),
        style.line_key("corrected by importance sampling", style.CORRECTED, lw=3),
        style.dot_key("truth", style.MEASURED, "|", ms=13, mew=1.8),
        style.dot_key("posterior median", ms=6),
        style.line_key("50 % interval", lw=5),
        style.line_key("95 % interval"),
    ]
