"""What one call infers of a drive: records, parameters, and what the model leaves out."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.stats import gaussian_kde

from breaker.figures import style
from breaker.mechanism import NAMES

__all__ = ["answer"]

_COLOURS = {"closing": style.CORRECTED, "opening": style.AMORTISED}
_SWITCHING = {"closing": "touch", "opening": "parting"}
_POINTS = 200  # of a density
_PRIOR = 2.5  # times the width of the posterior, to which the prior is shown on either side


@style.styled
def answer(parts: Mapping[str, xr.Dataset]) -> Figure:
    """Draw answers.

    Above the first record of each motion with what its posterior predicts, and the time of the
    touch or the parting; below it the residual from the model, beside what the model leaves out of
    drives of the family; at the foot the parameters, of all records, beside the prior.

    Args:
        parts: By motion, what ``answers.shown`` returns; one of them at least has a posterior.
    """
    parts = {motion: each for motion, each in parts.items() if each.sizes["operation"]}
    figure = style.new_figure(12.0, 11.0)
    grid = figure.add_gridspec(4, 4, height_ratios=[1.9, 1.0, 1.0, 1.0])
    width = 4 // len(parts)
    for k, (motion, data) in enumerate(parts.items()):
        place = slice(k * width, (k + 1) * width)
        above = figure.add_subplot(grid[0, place])
        below = figure.add_subplot(grid[1, place], sharex=above)
        _record(above, data, motion)
        _residual(below, data)
    for k, name in enumerate(NAMES):
        _parameter(figure.add_subplot(grid[2 + k // 4, k % 4]), parts, name)
    last = figure.add_subplot(grid[3, 3])
    last.axis("off")
    last.legend(handles=_keys(parts), loc="center left")
    figure.suptitle(_title(parts))
    return figure


def _title(parts: Mapping[str, xr.Dataset]) -> str:
    counts = [f"{data.sizes['operation']} {motion}" for motion, data in parts.items()]
    return f"Drive as inferred from {' and '.join(counts)}"


def _record(axis: Axes, data: xr.Dataset, motion: str) -> None:
    low, middle, high = np.nanquantile(data.switching, [0.025, 0.5, 0.975])
    colour = _COLOURS[motion]
    if np.isfinite(middle):
        axis.axvspan(low, high, color=colour, alpha=0.25, lw=0)
        axis.axvline(middle, color=colour, lw=1.2)
        axis.annotate(
            f" {_SWITCHING[motion]} at {middle:.4g} ms\n ({low:.4g} to {high:.4g})",
            (high, 0.5),
            xycoords=("data", "axes fraction"),
            color=colour,
            va="center",
        )
    axis.fill_between(data.time, data.lower, data.upper, color=style.MODEL, alpha=0.3, lw=0)
    axis.plot(data.time, data["median"], color=style.MODEL, lw=1.0)
    axis.plot(data.time, data.record, "o", color=style.MEASURED, ms=2, mew=0)
    axis.set(ylabel=style.TRAVEL)
    axis.tick_params(labelbottom=False)
    axis.margins(x=0)
    file = str(data.file.values[0]).rpartition("/")[2]
    p_value = float(data.p_value.values[0])
    axis.set_title(f"{style.literal(file)}, {motion}\np = {p_value:.2g}", loc="left")


def _residual(axis: Axes, data: xr.Dataset) -> None:
    axis.fill_between(
        data.time, data.family_lower, data.family_upper, color=style.PRIOR, alpha=0.35, lw=0
    )
    axis.plot(data.time, data.left_out, color=style.WARNING, lw=1.2)
    axis.plot(data.time, data.residual, "o", color=style.MEASURED, ms=2, mew=0)
    axis.axhline(0.0, color=style.REFERENCE, lw=0.6)
    axis.set(xlabel="time after the first motion (ms)", ylabel="record less\nmodel (mm)")
    axis.margins(x=0)


def _parameter(axis: Axes, parts: Mapping[str, xr.Dataset], name: str) -> None:
    """Densities of a parameter: of each record, and of the prior."""
    k = NAMES.index(name)
    every = np.concatenate([data.draws.values[..., k].ravel() for data in parts.values()])
    low, middle, high = np.quantile(every, [0.001, 0.5, 0.999])
    prior = next(iter(parts.values())).prior.values[:, k]
    ends = np.quantile(prior, [0.005, 0.995])
    left = max(min(ends[0], low), middle - _PRIOR * (high - low), 0.0)
    right = min(max(ends[1], high), middle + _PRIOR * (high - low))
    at = np.linspace(left, right, _POINTS)
    axis.fill_between(at, _density(prior, at), color=style.PRIOR, alpha=0.35, lw=0)
    for motion, data in parts.items():
        for i, draws in enumerate(data.draws.values[..., k]):
            look = {"lw": 1.8} if i == 0 else {"lw": 0.6, "alpha": 0.6}
            axis.plot(at, _density(draws, at), color=_COLOURS[motion], **look)
    output = style.parameter(name)
    axis.set_title(output.meaning, loc="left", fontsize=9)
    axis.set(xlabel=output.label, yticks=[], xlim=(left, right))
    axis.set_ylim(bottom=0.0)


def _density(draws: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Density of positive draws ``(d,)`` at values ``(n,)``, smoothed in the logarithm."""
    inside = np.maximum(at, at[-1] * 1e-6)
    return gaussian_kde(np.log(draws))(np.log(inside)) / inside


def _keys(parts: Mapping[str, xr.Dataset]) -> list:
    several = any(data.sizes["operation"] > 1 for data in parts.values())
    rest = " (thin: other records)" if several else ""
    return [
        style.dot_key("record", style.MEASURED, ms=4),
        style.band_key("predicted, pointwise 95 %", style.MODEL, 0.3),
        style.line_key("left out by the model, inferred", style.WARNING),
        style.band_key(
            "the same of drives of the family,\n95 %; below: the prior", style.PRIOR, 0.35
        ),
        *(style.line_key(f"posterior of the {m}{rest}", _COLOURS[m], lw=1.8) for m in parts),
    ]
