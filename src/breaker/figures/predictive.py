"""Curves and predictions of the prior and of posteriors (paper, Figs. 3, 8, 9)."""

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from breaker.common.numerals import in_p
from breaker.figures import panels as p
from breaker.figures import style

if TYPE_CHECKING:
    from breaker.paper.validation import PriorCheck

_SHOWN = 150  # first curves of the prior, which are drawn singly; more would hide each other
_BAND = {"color": style.MODEL, "lw": 0, "label": "pointwise 95 % band"}


@style.styled
def prior_predictive(
    curves: xr.Dataset, check: "PriorCheck", measured: xr.Dataset | None, *, motion: str
) -> Figure:
    """Draw curves of the prior with curves of the endurance test (paper, Fig. 3).

    ``curves`` has ``travel (curve, time)`` in mm and ``time`` in ms. ``measured`` has the same for
    a few operations, or is None. ``check`` compares all operations with the prior.
    """
    figure = style.new_figure(9.0, 5.8)
    axis = figure.subplots()
    single = curves["travel"].transpose("curve", "time").values[:_SHOWN]
    label = "single curves of the prior"
    axis.plot(curves["time"], single.T, color=style.PRIOR, lw=0.5, alpha=0.35, label=label)
    axis.fill_between(curves["time"], check.lower, check.upper, alpha=0.2, **_BAND)
    axis.plot(curves["time"], check.median, color=style.MODEL, lw=2, label="median")
    for i, operation in enumerate([] if measured is None else measured["operation"].values):
        curve = measured["travel"].sel(operation=operation).dropna("time")
        look = {"color": style.MEASURED, "ls": ("-", "--", ":", "-.")[i % 4]}
        axis.plot(curve["time"], curve, label=f"endurance test, operation {operation}", **look)
    axis.set(xlabel=style.TIME, ylabel=style.TRAVEL)
    axis.margins(x=0)
    about = f"{p.SOURCES[motion]}: prior predictive check"
    finding = "Curves of the prior, with their 95 % band"
    if measured is not None:
        few, least = int(np.sum(check.inside < check.least)), p.percent(check.least)
        about += f"\n{few} of {check.inside.size:,} operations are below {least}, "
        about += "which 95 % of the prior's own curves reach"
        inside = p.percent(check.inside.mean())
        finding = f"The prior's 95 % band contains {inside} of the endurance test's samples"
    style.title(figure, finding, about)
    p.legend_below(figure, columns=3)
    return figure


@style.styled
def posterior_predictive(predictive: xr.Dataset, *, motion: str) -> Figure:
    """Draw simulated records and predictions of their posteriors (paper, Fig. 8).

    ``predictive`` has ``measured``, ``median``, ``lower`` and ``upper``, each ``(curve, time)`` in
    mm, ``share_inside (curve)``, and the attribute ``noise_sd``, mm.
    """
    data = predictive.rename(curve="panel", measured="record")
    shares = data["share_inside"].values
    words = map(p.percent, shares)
    titles = [f"simulated record {i}: {share} in the band" for i, share in enumerate(words, 1)]
    figure = _checks(data, titles)
    inside = p.from_to([p.percent(shares.min()), p.percent(shares.max())])
    about = f"{p.SOURCES[motion]}: posterior predictive check on simulated records"
    style.title(figure, f"The 95 % band contains {inside} of the samples of a record", about)
    return figure


@style.styled
def endurance_predictive(predictive: xr.Dataset, *, motion: str) -> Figure:
    """Draw records at stages of the life and their predictions (paper, Fig. 9).

    ``predictive`` is as in :func:`posterior_predictive`, over ``stage`` instead of ``curve``, with
    ``main_motion_end`` in ms, ``p_value``, the flag ``misfit`` and ``operation``.
    """
    data = predictive.rename(stage="panel", travel="record")
    titles = []
    for i in range(data.sizes["panel"]):
        one = data.isel(panel=i)
        flag = "does NOT fit the model" if one["misfit"].item() else "fits the model"
        titles.append(
            f"operation {one['operation'].item():,}: {flag} ({in_p(one['p_value'].item())})\n"
            f"{p.percent(one['share_inside'].item())} of the main motion in the band"
        )
    figure = _checks(data, titles)
    flagged, count = int(data["misfit"].sum()), len(titles)
    finding = f"All {count} records of the endurance test fit the model"
    if flagged:
        finding = f"NOT fitting the model: {flagged} of {count} records of the endurance test"
    about = f"{p.SOURCES[motion]}: posterior predictive check, posterior of the paper's network"
    style.title(figure, finding, about, failed=flagged > 0)
    return figure


def _checks(data: xr.Dataset, titles: list[str]) -> Figure:
    """Draw one panel with residuals below it for each title, two panels in a row."""
    rows = -(-len(titles) // 2)
    figure = style.new_figure(11.0, 4.6 * rows + 0.9)
    places = figure.subfigures(rows, 2, squeeze=False).flat
    numbered = zip(places, enumerate(titles), strict=False)
    below = [_check(place, data.isel(panel=i), title) for place, (i, title) in numbered]
    limit = max(abs(bound) for axis in below for bound in axis.get_ylim())
    for axis in below:
        axis.set_ylim(-limit, limit)
    p.legend_below(figure)
    return figure


def _check(place: SubFigure, one: xr.Dataset, title: str) -> Axes:
    """Draw one curve with its prediction, residuals below; return the axes of the residuals."""
    above, below = place.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    for axis, shift, unit in ((above, 0.0, 1.0), (below, one["median"], one.attrs["noise_sd"])):
        low, middle, high, dots = (
            (one[name] - shift) / unit for name in ("lower", "median", "upper", "record")
        )
        axis.fill_between(one["time"], low, high, alpha=0.3, **_BAND)
        axis.plot(one["time"], middle, color=style.MODEL, lw=1.0, label="median")
        axis.plot(one["time"], dots, "o", color=style.MEASURED, ms=2, mew=0, label="record")
        if "main_motion_end" in one:
            look = {"ls": "--", "lw": 1.1, "label": "end of the main motion"}
            axis.axvline(one["main_motion_end"].item(), color=style.REFERENCE, **look)
        axis.margins(x=0)
    below.axhline(0.0, color=style.REFERENCE, lw=0.6)
    failed = "misfit" in one and one["misfit"].item()
    above.set_title(title, color=style.WARNING if failed else "black", fontsize=10)
    above.set_ylabel(style.TRAVEL)
    below.set(xlabel=style.TIME, ylabel="residual\n(noise sd)")
    return below
