"""Remaining operations until a limit is exceeded, over life."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from breaker.figures import style

__all__ = ["remaining_life"]

_BEYOND = 4.0  # the axis ends at this multiple of the horizon
_ROOM = 0.14  # share of the panel that a stretch without trend needs for the words
_NO_TREND = {"facecolor": "#F0F0F0", "edgecolor": "#CFCFCF", "hatch": "////", "lw": 0}
_CONE = "#F2C14E"


@style.styled
def remaining_life(
    trend: xr.Dataset, *, truth: Mapping[str, float] | None = None, alpha: float = 0.2
) -> Figure:
    """Draw one panel per limit: predicted remaining operations, and the true ones where known.

    The axis is linear near 0 and logarithmic above. Its top strip, past the horizon, stands for all
    that is beyond; a band that runs into it is open. Where there is no trend towards the limit, no
    remaining life is drawn.

    Args:
        trend: ``told (operation, limit, quantile)`` at 0.05, 0.5 and 0.95, operations left: 0 where
            exceeded, inf beyond the horizon, nan where no trend leads to the limit, and
            ``words (limit)``; coordinates ``operation`` and ``limit``; attributes ``horizon``,
            ``notice`` and ``source``.
        truth: Operation at which each limit is exceeded in truth, nan if it is not; None for real
            measurements.
        alpha: Half width of the cone around the truth, share of it.
    """
    limits = [str(limit) for limit in trend["limit"].values]
    horizon = float(trend.attrs["horizon"])
    failures = [np.nan if truth is None else float(truth.get(limit, np.nan)) for limit in limits]
    titles = [
        str(words) + ("" if truth is None or np.isfinite(failure) else " (in truth not reached)")
        for words, failure in zip(trend["words"].values, failures, strict=True)
    ]
    figure, axes = style.limit_panels(trend, titles, "remaining operations", height=3.1)
    for axis, limit, failure in zip(axes, limits, failures, strict=True):
        one = trend.sel(limit=limit)
        _truth(axis, one["operation"].values, failure, alpha)
        _prediction(axis, one, horizon)
        axis.axhline(trend.attrs["notice"], color=style.REFERENCE, lw=0.9, ls=":")
        axis.axhline(horizon, color=style.REFERENCE, lw=0.6)
    _scale(axes[0], horizon)
    text = "remaining operations until a limit is exceeded"
    style.heading(figure, trend.attrs["source"], text)
    columns = 4 if len(limits) == 1 or truth is None else 3
    style.legend_below(figure, _handles(trend.attrs, truth, alpha), columns=columns)
    return figure


def _truth(axis: Axes, operation: np.ndarray, failure: float, alpha: float) -> None:
    if not failure > operation[0]:  # nor where there is none
        return
    before = np.linspace(operation[0], min(failure, operation[-1]), 500)
    left = failure - before
    axis.fill_between(before, (1 - alpha) * left, (1 + alpha) * left, color=_CONE, alpha=0.45, lw=0)
    axis.plot(before, left, color=style.MEASURED, lw=1.2, ls="--", zorder=2.5)


def _prediction(axis: Axes, one: xr.Dataset, horizon: float) -> None:
    """Draw band and median where there is a trend, and name the stretches without one."""
    operation = one["operation"].values
    low, middle, high = (one["told"].sel(quantile=q).values for q in (0.05, 0.5, 0.95))
    none = np.isnan(middle)
    known = ~none
    top = _BEYOND * horizon
    for start, stop in style.spans(operation, known):  # one operation alone has a width as well
        inside = (operation > start) & (operation < stop)
        at = np.concatenate([[start], operation[inside], [stop]])
        lower, upper = (np.pad(each[inside], 1, mode="edge") for each in (low, high))
        lower, upper = np.minimum(lower, horizon), np.where(upper > horizon, top, upper)
        axis.fill_between(at, lower, upper, color=style.CORRECTED, alpha=0.25, lw=0)
    drawn = np.where(middle > horizon, np.sqrt(_BEYOND) * horizon, middle)
    drawn = np.where(known, drawn, np.nan)
    axis.plot(operation, drawn, ".-", color=style.CORRECTED, lw=1.8, ms=3.6, mew=0)
    length = max(float(operation[-1] - operation[0]), 1.0)
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 2}
    words = {"ha": "center", "va": "center", "color": style.REFERENCE, "zorder": 4, "bbox": box}
    for start, stop in style.spans(operation, none):
        axis.axvspan(start, stop, zorder=0.5, **_NO_TREND)
        if stop - start >= _ROOM * length:
            place = ((start + stop) / 2, 0.13)
            axis.annotate("no trend", place, xycoords=axis.get_xaxis_transform(), **words)


def _scale(axis: Axes, horizon: float) -> None:
    """Make an axis that is linear up to 10 operations, with the strip beyond the horizon."""
    linear = min(10.0, horizon / 10)
    axis.set_yscale("symlog", linthresh=linear, linscale=0.5)
    decades = linear * 10.0 ** np.arange(np.ceil(np.log10(horizon / (2 * linear))))
    ticks = [0.0, *decades, horizon, np.sqrt(_BEYOND) * horizon]
    axis.set_yticks(ticks, [*(f"{tick:,g}" for tick in ticks[:-1]), "beyond"])
    axis.set_ylim(0.0, _BEYOND * horizon)


def _handles(attrs: Mapping, truth: Mapping | None, alpha: float) -> list:
    handles = [
        style.line_key("predicted, median", style.CORRECTED, lw=1.8),
        style.band_key("predicted, 90 % interval", style.CORRECTED, 0.25),
    ]
    if truth is not None:
        handles += [
            style.line_key("truth", style.MEASURED, "--", lw=1.2),
            style.band_key(f"truth ± {100 * alpha:g} %", _CONE, 0.45),
        ]
    return [
        *handles,
        Patch(**_NO_TREND, label="no trend towards the limit"),
        style.line_key(f"notice: {attrs['notice']:g} operations", ls=":", lw=0.9),
    ]
