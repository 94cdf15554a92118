"""Curves and what the model predicts for them, before and after data (paper, Figs. 3, 8, 9)."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from breaker.figures.style import (
    MEASURED,
    MODEL,
    PRIOR,
    REFERENCE,
    TIME,
    TRAVEL,
    heading,
    legend_below,
    new_figure,
    styled,
)

__all__ = ["endurance_predictive", "posterior_predictive", "prior_predictive"]

_DASHES = ("-", (0, (5, 2)), (0, (1.2, 1.5)), (0, (5, 2, 1.2, 2)))
_BAND = Patch(color=MODEL, alpha=0.3, lw=0, label="pointwise 95 % band")
_MEDIAN = Line2D([], [], color=MODEL, lw=2, label="median")


@styled
def prior_predictive(
    curves: xr.Dataset,
    band: tuple[np.ndarray, np.ndarray, np.ndarray],
    measured: xr.Dataset,
    *,
    motion: str,
    shown: int = 150,
) -> Figure:
    """Draw what the prior holds possible beside measured curves (paper, Fig. 3).

    Args:
        curves: Prior predictive curves: ``travel (curve, time)`` in mm, coordinate ``time`` in ms.
        band: Median, lower and upper bound ``(t,)`` of the curves, mm.
        measured: A few measured curves: ``travel (operation, time)``, coordinates ``operation``
            and ``time``.
        motion: Motion of the title.
        shown: How many curves are drawn one by one, the first ones.
    """
    figure = new_figure(9.0, 5.6)
    axis = figure.subplots()
    median, lower, upper = band
    single = curves["travel"].transpose("curve", "time").values[:shown]
    axis.plot(curves["time"], single.T, color=PRIOR, lw=0.5, alpha=0.35)
    axis.fill_between(curves["time"], lower, upper, color=MODEL, alpha=0.2, lw=0)
    axis.plot(curves["time"], median, color=MODEL, lw=2)
    handles = [Line2D([], [], color=PRIOR, lw=1, label="single prior curves"), _MEDIAN, _BAND]
    for i, operation in enumerate(measured["operation"].values):
        curve = measured["travel"].sel(operation=operation)
        dashes = _DASHES[i % len(_DASHES)]
        label = f"measured, operation {operation}"
        handles += axis.plot(measured["time"], curve, color=MEASURED, ls=dashes, label=label)
    axis.set(xlabel=TIME, ylabel=TRAVEL)
    axis.margins(x=0)
    heading(figure, motion, "prior predictive check")
    legend_below(figure, handles, columns=3)
    return figure


@styled
def posterior_predictive(predictive: xr.Dataset, *, motion: str, noise_sd: float) -> Figure:
    """Draw simulated curves and what their own posteriors predict (paper, Fig. 8).

    Args:
        predictive: ``measured``, ``median``, ``lower``, ``upper``, each ``(curve, time)`` in mm,
            the bounds pointwise 95 % of noisy predicted curves; coordinate ``time`` in ms.
        motion: Motion of the title.
        noise_sd: Noise sd of a sample, mm: the unit of the residuals.
    """
    data = predictive.rename(curve="panel")
    titles = [f"simulated curve {i + 1}" for i in range(data.sizes["panel"])]
    text = "posterior predictive check on simulated curves"
    return _checks(data, "measured", titles, text, motion=motion, noise_sd=noise_sd)


@styled
def endurance_predictive(predictive: xr.Dataset, *, motion: str, noise_sd: float) -> Figure:
    """Draw measured curves at stages of the life and what is predicted for them (paper, Fig. 9).

    Args:
        predictive: ``travel``, ``median``, ``lower``, ``upper``, each ``(stage, time)`` in mm, as
            in :func:`posterior_predictive`; ``share_inside (stage)``, the share of the main motion
            inside the band; coordinates ``time`` in ms and ``operation (stage)``.
        motion: Motion of the title.
        noise_sd: Noise sd of a sample, mm: the unit of the residuals.
    """
    data = predictive.rename(stage="panel")
    shares = zip(data["operation"].values, data["share_inside"].values, strict=True)
    titles = [
        f"operation {operation}: {100 * share:.0f} % of the main motion in the band"
        for operation, share in shares
    ]
    text = "posterior predictive check of the endurance test"
    return _checks(data, "travel", titles, text, motion=motion, noise_sd=noise_sd)


def _checks(
    data: xr.Dataset, measured: str, titles: list[str], text: str, *, motion: str, noise_sd: float
) -> Figure:
    """Draw one panel with residuals below it for each of ``titles``, two in a row."""
    if not noise_sd > 0:
        raise ValueError(f"residuals need a noise sd above zero, got {noise_sd}")
    rows = -(-len(titles) // 2)
    figure = new_figure(11.0, 4.2 * rows + 0.9)
    places = figure.subfigures(rows, 2, squeeze=False).flat
    below: list[Axes] = []
    for place, title, i in zip(places, titles, range(len(titles)), strict=False):
        one = data.isel(panel=i)
        below.append(_check(place, one, one[measured], title, noise_sd))
    limit = max(abs(bound) for axis in below for bound in axis.get_ylim())
    for axis in below:
        axis.set_ylim(-limit, limit)
    heading(figure, motion, text)
    dots = Line2D([], [], color=MEASURED, ls="", marker="o", ms=4, label="measured")
    legend_below(figure, [dots, _MEDIAN, _BAND])
    return figure


def _check(
    place: SubFigure, one: xr.Dataset, curve: xr.DataArray, title: str, noise_sd: float
) -> Axes:
    """Draw one curve with its prediction, residuals below; return the axes of the residuals."""
    above, below = place.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    for axis, shift, unit in ((above, 0.0, 1.0), (below, one["median"], noise_sd)):
        low, middle, high, dots = (
            (values - shift) / unit for values in (one["lower"], one["median"], one["upper"], curve)
        )
        axis.fill_between(one["time"], low, high, color=MODEL, alpha=0.3, lw=0)
        axis.plot(one["time"], middle, color=MODEL, lw=1.0)
        axis.plot(one["time"], dots, "o", color=MEASURED, ms=2, mew=0)
    below.axhline(0.0, color=REFERENCE, lw=0.6)
    above.set(title=title, ylabel=TRAVEL)
    above.margins(x=0)
    below.set(xlabel=TIME, ylabel="residual\n(noise sd)")
    return below
