"""Curves and what the model predicts for them, before and after data (paper, Figs. 3, 8, 9)."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from breaker.common.numerals import in_p
from breaker.figures import style
from breaker.paper.validation import PriorCheck, percent

_SHOWN = 150  # curves of the prior that are drawn one by one, the first ones
_DASHES = ("-", (0, (5, 2)), (0, (1.2, 1.5)), (0, (5, 2, 1.2, 2)))
_END = {"color": style.REFERENCE, "ls": (0, (4, 3)), "lw": 1.1}
_BAND = style.band_key("pointwise 95 % band", style.MODEL, 0.3)
_MEDIAN = style.line_key("median", style.MODEL, lw=2)


@style.styled
def prior_predictive(
    curves: xr.Dataset, check: PriorCheck, measured: xr.Dataset, *, motion: str
) -> Figure:
    """Draw curves of the prior beside curves of the endurance test (paper, Fig. 3).

    Args:
        curves: Prior predictive curves: ``travel (curve, time)`` in mm, coordinate ``time`` in ms.
        check: All operations held against these curves, ``diagnostics.prior_check``.
        measured: A few operations: ``travel (operation, time)``, coordinates ``operation`` and
            ``time``.
    """
    figure = style.new_figure(9.0, 5.8)
    axis = figure.subplots()
    single = curves["travel"].transpose("curve", "time").values[:_SHOWN]
    axis.plot(curves["time"], single.T, color=style.PRIOR, lw=0.5, alpha=0.35)
    axis.fill_between(curves["time"], check.lower, check.upper, color=style.MODEL, alpha=0.2, lw=0)
    axis.plot(curves["time"], check.median, color=style.MODEL, lw=2)
    handles = [style.line_key("single curves of the prior", style.PRIOR, lw=1), _MEDIAN, _BAND]
    for i, operation in enumerate(measured["operation"].values):
        curve = measured["travel"].sel(operation=operation).dropna("time")
        dashes = _DASHES[i % len(_DASHES)]
        label = f"endurance test, operation {operation}"
        handles += axis.plot(curve["time"], curve, color=style.MEASURED, ls=dashes, label=label)
    axis.set(xlabel=style.TIME, ylabel=style.TRAVEL)
    axis.margins(x=0)
    few = int(np.sum(check.inside < check.least))
    outcome = (
        f"{percent(check.inside.mean())} of all samples of the endurance test in the 95 % band\n"
        f"{few} of {check.inside.size} operations below the {percent(check.least)} "
        "that 95 % of prior curves reach"
    )
    style.heading(figure, motion, "prior predictive check", outcome)
    style.legend_below(figure, handles, columns=3)
    return figure


@style.styled
def posterior_predictive(predictive: xr.Dataset, *, motion: str) -> Figure:
    """Draw simulated curves and what their own posteriors predict (paper, Fig. 8).

    Args:
        predictive: ``measured``, ``median``, ``lower``, ``upper``, each ``(curve, time)`` in mm,
            the bounds pointwise 95 % of noisy predicted curves; ``share_inside (curve)``, the
            share of the samples inside; coordinate ``time`` in ms; attribute ``noise_sd``, that of
            a sample, mm: the unit of the residuals.
    """
    data = predictive.rename(curve="panel", measured="record")
    shares = enumerate(data["share_inside"].values, start=1)
    titles = [f"simulated record {i}: {percent(share)} in the band" for i, share in shares]
    figure = _checks(data, titles, "simulated record")
    ends = [percent(each(data["share_inside"].values)) for each in (np.min, np.max)]
    outcome = f"{' to '.join(dict.fromkeys(ends))} of the samples of a record in the 95 % band"
    style.heading(figure, motion, "posterior predictive check on simulated records", outcome)
    return figure


@style.styled
def endurance_predictive(predictive: xr.Dataset, *, motion: str) -> Figure:
    """Draw records at stages of the life and what is predicted for them (paper, Fig. 9).

    Args:
        predictive: ``travel``, ``median``, ``lower``, ``upper``, each ``(stage, time)`` in mm, as
            in :func:`posterior_predictive`; over ``stage`` ``share_inside``, the share of the main
            motion inside the band, ``main_motion_end`` in ms, ``p_value`` and the flag ``misfit``;
            coordinates ``time`` in ms and ``operation (stage)``.
    """
    data = predictive.rename(stage="panel", travel="record")
    titles = [_stage_words(data.isel(panel=i)) for i in range(data.sizes["panel"])]
    figure = _checks(data, titles, "record of the endurance test")
    flagged = int(data["misfit"].sum())
    outcome = f"{flagged or 'none'} of {len(titles)} flagged as not fitting the model"
    checked = "posterior predictive check of the endurance test by the paper's network"
    style.heading(figure, motion, checked, outcome)
    return figure


def _stage_words(one: xr.Dataset) -> str:
    """State what came out of a record: does it fit, how much of the main motion is in the band."""
    flag = "does NOT fit the model" if one["misfit"].item() else "fits the model"
    return (
        f"operation {one['operation'].item():,}: {flag} ({in_p(one['p_value'].item())})\n"
        f"{percent(one['share_inside'].item())} of the main motion in the band"
    )


def _checks(data: xr.Dataset, titles: list[str], key: str) -> Figure:
    """Draw one panel with residuals below it for each of ``titles``, two in a row."""
    rows = -(-len(titles) // 2)
    figure = style.new_figure(11.0, 4.6 * rows + 0.9)
    places = figure.subfigures(rows, 2, squeeze=False).flat
    numbered = zip(places, enumerate(titles), strict=False)
    below = [_check(place, data.isel(panel=i), title) for place, (i, title) in numbered]
    limit = max(abs(bound) for axis in below for bound in axis.get_ylim())
    for axis in below:
        axis.set_ylim(-limit, limit)
    end = "main_motion_end" in data and style.line_key("end of the main motion", **_END)
    style.legend_below(figure, [style.dot_key(key, style.MEASURED, ms=4), _MEDIAN, _BAND, end])
    return figure


def _check(place: SubFigure, one: xr.Dataset, title: str) -> Axes:
    """Draw one curve with its prediction, residuals below; return the axes of the residuals."""
    above, below = place.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    noise_sd = one.attrs["noise_sd"]
    for axis, shift, unit in ((above, 0.0, 1.0), (below, one["median"], noise_sd)):
        low, middle, high, dots = (
            (one[name] - shift) / unit for name in ("lower", "median", "upper", "record")
        )
        axis.fill_between(one["time"], low, high, color=style.MODEL, alpha=0.3, lw=0)
        axis.plot(one["time"], middle, color=style.MODEL, lw=1.0)
        axis.plot(one["time"], dots, "o", color=style.MEASURED, ms=2, mew=0)
        if "main_motion_end" in one:
            axis.axvline(one["main_motion_end"].item(), **_END)
    below.axhline(0.0, color=style.REFERENCE, lw=0.6)
    failed = "misfit" in one and one["misfit"].item()
    above.set_title(title, color=style.WARNING if failed else "black", fontsize=10)
    above.set_ylabel(style.TRAVEL)
    above.margins(x=0)
    below.margins(x=0)
    below.set(xlabel=style.TIME, ylabel="residual\n(noise sd)")
    return below
