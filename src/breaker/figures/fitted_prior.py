"""The fitted prior of a type of breaker, beside its breakers and the default prior."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.figures import style

_WIDE = 3.0  # log-sds to each side of the wider prior that a panel shows
_POINTS = 300
_SHARE = 0.6  # of a panel's height that the densities have; below are the breakers
_NAMED = 12  # breakers that are named beside their intervals


@style.styled
def fitted_prior(data: xr.Dataset) -> Figure:
    """Draw a panel for each parameter: densities of both priors, and the breakers' intervals.

    Args:
        data: From ``typical.FittedPrior.to_dataset``.
    """
    names = [str(name) for name in data["parameter"].values]
    breakers = data.sizes["breaker"]
    height = 2.6 + 0.09 * min(breakers, _NAMED)
    figure, axes = style.panels(len(names), columns=4, width=3.9, height=height)
    for axis, name in zip(axes, names, strict=True):
        _panel(axis, data.sel(parameter=name))
        output = style.OUTPUTS[name]
        axis.set_title(f"{output.symbol}   {output.meaning}", loc="left", fontsize=10)
        axis.set_xlabel(output.label)
        axis.set_ylabel("density" if axis.get_subplotspec().is_first_col() else "")
    count = "one breaker" if breakers == 1 else f"{breakers} breakers"
    alone = "\nits spread from breaker to breaker is a guess" if breakers == 1 else ""
    look = {"color": style.WARNING if alone else "black"}
    figure.suptitle(f"Prior of a type of breaker, from {count}{alone}", **look)
    handles = [
        style.band_key("fitted prior", style.CORRECTED, 0.35),
        style.line_key("default prior, scaled to the size", style.PRIOR, "--", lw=1.6),
        style.line_key("each breaker by itself: median and 90 % interval", style.MODEL, marker="o"),
    ]
    style.legend_below(figure, handles)
    return figure


def _panel(axis: Axes, one: xr.Dataset) -> None:
    """Draw one parameter; densities are per unit of the logarithm, the fitted's highest 1."""
    median, log_sd = one["median"], one["log_sd"]
    low = min(float(each.min()) for each in (np.log(median) - _WIDE * log_sd, np.log(one["low"])))
    high = max(float(each.max()) for each in (np.log(median) + _WIDE * log_sd, np.log(one["high"])))
    x = np.linspace(low, high, _POINTS)
    heights = {}
    for kind in ("fitted", "default"):
        sd, middle = log_sd.sel(kind=kind).item(), np.log(median.sel(kind=kind).item())
        heights[kind] = np.exp(-0.5 * ((x - middle) / sd) ** 2) / sd
    top = max(each.max() for each in heights.values())
    axis.fill_between(np.exp(x), heights["fitted"] / top, color=style.CORRECTED, alpha=0.35, lw=0)
    axis.plot(np.exp(x), heights["default"] / top, color=style.PRIOR, ls="--", lw=1.6)
    count = one.sizes["breaker"]
    rows = -(np.arange(count) + 1.0) / (count + 0.5) * (1.0 / _SHARE - 1.0)
    values = (one["low"], one["middle"], one["high"])
    style.draw_intervals(axis, rows, values, color=style.MODEL, lw=1.2)
    axis.set_ylim(rows.min() - 0.1, 1.05)
    axis.axhline(0.0, color=style.REFERENCE, lw=0.8)
    named = len(rows) <= _NAMED
    words = [style.literal(name) for name in one["breaker"].values] if named else []
    axis.set_yticks(rows if named else [], words)
