"""What one call infers of a drive: records, parameters, and what the model leaves out."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.stats import gaussian_kde

from breaker.figures import style
from breaker.figures.words import literal

__all__ = ["answer"]

_COLOURS = {"closing": style.CORRECTED, "opening": style.AMORTISED}
_SWITCHING = {"closing": "touch", "opening": "parting"}
_CORNER = {"closing": (0.97, 0.08, "bottom"), "opening": (0.97, 0.95, "top")}  # without a curve
_POINTS = 200  # of a density
_PRIOR = 1.0  # times the width of the posterior, to which the prior is shown on either side
_COLUMNS = 4
_BAND = {"color": style.PRIOR, "alpha": 0.35, "lw": 0}


@style.styled
def answer(parts: Mapping[str, xr.Dataset]) -> Figure:
    """Draw answers.

    Above the first record of each motion with what its posterior predicts, and the time of the
    touch or the parting; below it the residual from the model, beside what the model leaves out of
    drives of the family; at the foot the parameters and the wipe, of all records, beside the prior.

    Args:
        parts: By motion, what ``answers.shown`` returns; one of them at least has a posterior.
    """
    parts = {motion: each for motion, each in parts.items() if each.sizes["operation"]}
    figure = style.new_figure(12.0, 11.0)
    above, below = figure.subfigures(2, 1, height_ratios=[1.35, 1.0])
    grid = above.subplots(2, len(parts), height_ratios=[2, 1], sharex="col", squeeze=False)
    for (motion, data), (record, residual) in zip(parts.items(), grid.T, strict=True):
        _record(record, data, motion)
        _residual(residual, data)
    names = next(iter(parts.values()))["shown"].values.tolist()
    axes = below.subplots(-(-len(names) // _COLUMNS), _COLUMNS).flat
    for axis, name in zip(axes, names, strict=True):
        _density_panel(axis, {m: data.sel(shown=name) for m, data in parts.items()}, name)
    figure.suptitle(_title(parts))
    style.legend_below(figure, _keys(parts), columns=3)
    return figure


def _title(parts: Mapping[str, xr.Dataset]) -> str:
    files = {_name(file) for data in parts.values() for file in data.file.values}
    if len(files) == 1:
        return f"Drive as inferred from {files.pop()}"
    sizes = {motion: data.sizes["operation"] for motion, data in parts.items()}
    counts = [f"{size} {motion}{'s' * (size > 1)}" for motion, size in sizes.items()]
    return f"Drive as inferred from {' and '.join(counts)}"


def _name(file: object) -> str:
    return literal(str(file).rpartition("/")[2])


def _record(axis: Axes, data: xr.Dataset, motion: str) -> None:
    """The first record, what its posterior predicts, and when the contact switches."""
    switching = data.switching.values[np.isfinite(data.switching.values)]
    colour = _COLOURS[motion]
    if switching.size:
        low, middle, high = np.quantile(switching, [0.025, 0.5, 0.975])
        axis.axvspan(low, high, color=colour, alpha=0.25, lw=0)
        axis.axvline(middle, color=colour, lw=1.2)
        x, y, side = _CORNER[motion]
        said = f"{_SWITCHING[motion]} at {middle:.1f} ms\n95 %: {low:.1f} to {high:.1f} ms"
        look = {"color": colour, "ha": "right", "va": side, "transform": axis.transAxes}
        axis.text(x, y, said, **look)
    axis.fill_between(data.time, data.lower, data.upper, color=style.MODEL, alpha=0.3, lw=0)
    axis.plot(data.time, data["median"], color=style.MODEL, lw=1.0)
    axis.plot(data.time, data.record, "o", color=style.MEASURED, ms=2, mew=0)
    axis.set_ylabel(style.TRAVEL)
    axis.margins(x=0)
    misfit, far = bool(data.misfit.values[0]), bool(data.far_from_prior.values[0])
    what, name = ("prior", "prior_p_value") if far and not misfit else ("model", "p_value")
    fits = "does NOT fit" if misfit or far else "fits"
    words = f"{fits} the {what}, p = {float(data[name].values[0]):.2g}"
    look = {"color": style.WARNING if misfit or far else "black", "loc": "left"}
    axis.set_title(f"{motion} in {_name(data.file.values[0])}: {words}", **look)


def _residual(axis: Axes, data: xr.Dataset) -> None:
    """The first record less the model alone, and what the model leaves out."""
    axis.fill_between(data.time, data.family_lower, data.family_upper, **_BAND)
    axis.plot(data.time, data.left_out, color=style.WARNING, lw=1.2)
    axis.plot(data.time, data.residual, "o", color=style.MEASURED, ms=2, mew=0)
    axis.axhline(0.0, color=style.REFERENCE, lw=0.6)
    axis.set(xlabel="time after the first motion (ms)", ylabel="record minus\nmodel (mm)")


def _density_panel(axis: Axes, parts: Mapping[str, xr.Dataset], name: str) -> None:
    """Densities of a parameter or quantity: of each record, and of the prior."""
    every = np.concatenate([_finite(data.values_shown) for data in parts.values()])
    low, high = np.quantile(every, [0.001, 0.999])
    first = next(iter(parts.values()))
    prior = _finite(first.prior_shown)
    ends = np.quantile(prior, [0.005, 0.995])
    left = max(min(ends[0], low), low - _PRIOR * (high - low))
    right = min(max(ends[1], high), high + _PRIOR * (high - low))
    at = np.linspace(left, right, _POINTS)
    axis.fill_between(at, gaussian_kde(prior)(at), **_BAND)
    for motion, data in parts.items():
        for i, values in enumerate(data.values_shown.transpose("operation", "draw").values):
            look = {"lw": 1.8} if i == 0 else {"lw": 0.6, "alpha": 0.6}
            axis.plot(at, gaussian_kde(_finite(values))(at), color=_COLOURS[motion], **look)
    unit = first.shown_unit.item()
    axis.set_title(literal(first.shown_meaning.item()), loc="left", fontsize=9)
    label = f"{first.shown_symbol.item()}{'' if unit == '1' else f' ({unit})'}"
    axis.set(xlabel=label, yticks=[], xlim=(left, right), ylim=(0.0, None))


def _finite(values: xr.DataArray | np.ndarray) -> np.ndarray:
    values = np.ravel(values)
    return values[np.isfinite(values)]


def _keys(parts: Mapping[str, xr.Dataset]) -> list:
    several = any(data.sizes["operation"] > 1 for data in parts.values())
    rest = "s, the first thick" if several else ""
    return [
        style.dot_key("record", style.MEASURED, ms=4),
        style.band_key("predicted, pointwise 95 %", style.MODEL, 0.3),
        style.line_key("left out by the model, inferred", style.WARNING),
        style.band_key("drives of the family, 95 %; the prior", style.PRIOR, 0.35),
        *(style.line_key(f"posterior of the {m}{rest}", _COLOURS[m], lw=1.8) for m in parts),
    ]
