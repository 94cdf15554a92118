"""Remaining operations until a limit is exceeded, over life."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from breaker.figures.changepoint import source_words
from breaker.figures.health import limit_title, spans
from breaker.figures.style import (
    CORRECTED,
    MEASURED,
    REFERENCE,
    legend_below,
    panels,
    styled,
)

__all__ = ["remaining_life"]

_BEYOND = 4.0  # the axis ends at this multiple of the horizon
_ROOM = 0.14  # share of the panel that a stretch without trend needs for the words
_NO_TREND = {"facecolor": "#F0F0F0", "edgecolor": "#CFCFCF", "hatch": "////", "lw": 0}
_CONE = "#F2C14E"


@styled
def remaining_life(
    trend: xr.Dataset, *, truth: Mapping[str, float] | None = None, alpha: float = 0.2
) -> Figure:
    """Draw a panel a limit: predicted remaining operations, and the true ones where known.

    The axis is linear near 0 and logarithmic above. Its top strip, past the horizon, stands for all
    that is beyond; a band that runs into it is open. Where there is no trend towards the limit, no
    remaining life is drawn.

    Args:
        trend: ``remaining (operation, limit, quantile)`` at 0.05, 0.5 and 0.95, inf beyond the
            horizon, nan where there is none, ``toward (operation, limit)`` and ``words (limit)``;
            coordinates ``operation`` and ``limit``; attributes ``horizon``, ``notice``,
            ``toward_level`` and ``source``.
        truth: Operation at which each limit is exceeded in truth, nan if it is not; None for real
            measurements.
        alpha: Half width of the cone around the truth, share of it.
    """
    count, horizon = trend.sizes["limit"], float(trend.attrs["horizon"])
    size = {"columns": 2, "width": 6.4} if count > 1 else {"columns": 1, "width": 10.0}
    figure, axes = panels(count, height=3.1, sharex=True, sharey=True, **size)
    for axis, limit in zip(axes, trend["limit"].values, strict=True):
        one = trend.sel(limit=limit)
        failure = np.nan if truth is None else float(truth.get(str(limit), np.nan))
        _truth(axis, one["operation"].values, failure, alpha)
        _prediction(axis, one, horizon, trend.attrs["toward_level"])
        axis.axhline(trend.attrs["notice"], color=REFERENCE, lw=0.9, ls=":")
        axis.axhline(horizon, color=REFERENCE, lw=0.6)
        words = one["words"].item()
        if truth is not None and not np.isfinite(failure):
            words += " (in truth not reached)"
        limit_title(axis, str(limit), words, room=int(size["width"] * 11.5))
        axis.set_ylabel("remaining operations")
        if axis.xaxis.get_tick_params()["labelbottom"]:
            axis.set_xlabel("operation")
    _scale(axes[0], horizon)
    axes[0].margins(x=0.01)
    source = source_words(trend.attrs["source"])
    figure.suptitle(f"{source}: remaining operations until a limit is exceeded")
    legend_below(
        figure, _handles(trend.attrs, truth, alpha), columns=4 if count == 1 or truth is None else 3
    )
    return figure


def _truth(axis: Axes, operation: np.ndarray, failure: float, alpha: float) -> None:
    if not failure > operation[0]:  # nor where there is none
        return
    before = np.linspace(operation[0], min(failure, operation[-1]), 500)
    left = failure - before
    axis.fill_between(before, (1 - alpha) * left, (1 + alpha) * left, color=_CONE, alpha=0.45, lw=0)
    axis.plot(before, left, color=MEASURED, lw=1.2, ls="--", zorder=2.5)


def _prediction(axis: Axes, one: xr.Dataset, horizon: float, level: float) -> None:
    """Draw band and median where there is a trend, and say where there is none."""
    operation = one["operation"].values
    none = ~(one["toward"].values >= level)  # nan: nothing is known that leads there
    low, middle, high = (one["remaining"].sel(quantile=q).values for q in (0.05, 0.5, 0.95))
    nothing = none | np.isnan(middle)
    low, middle, high = (np.where(nothing, np.nan, each) for each in (low, middle, high))
    top = _BEYOND * horizon
    for start, stop in spans(operation, ~nothing):  # a run of one operation has a width as well
        inside = (operation > start) & (operation < stop)
        at = np.concatenate([[start], operation[inside], [stop]])
        lower, upper = (np.pad(each[inside], 1, mode="edge") for each in (low, high))
        lower, upper = np.minimum(lower, horizon), np.where(upper > horizon, top, upper)
        axis.fill_between(at, lower, upper, color=CORRECTED, alpha=0.25, lw=0)
    drawn = np.where(middle > horizon, np.sqrt(_BEYOND) * horizon, middle)
    axis.plot(operation, drawn, ".-", color=CORRECTED, lw=1.8, ms=3.6, mew=0)
    length = max(float(operation[-1] - operation[0]), 1.0)
    for start, stop in spans(operation, none):
        axis.axvspan(start, stop, zorder=0.5, **_NO_TREND)
        if stop - start >= _ROOM * length:
            axis.annotate(
                "no trend",
                ((start + stop) / 2, 0.13),
                xycoords=axis.get_xaxis_transform(),
                ha="center",
                va="center",
                color=REFERENCE,
                zorder=4,
                bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 2},
            )


def _scale(axis: Axes, horizon: float) -> None:
    """Make an axis that is linear up to 10 operations, with the strip beyond the horizon."""
    linear = min(10.0, horizon / 10)
    axis.set_yscale("symlog", linthresh=linear, linscale=0.5)
    decades = linear * 10.0 ** np.arange(np.ceil(np.log10(horizon / (2 * linear))))
    beyond = np.sqrt(_BEYOND) * horizon
    ticks = [0.0, *decades, horizon, beyond]
    axis.set_yticks(ticks, [*(f"{tick:,g}" for tick in ticks[:-1]), "beyond"])
    axis.set_ylim(0.0, _BEYOND * horizon)


def _handles(attrs: Mapping, truth: Mapping | None, alpha: float) -> list:
    notice = f"notice: {attrs['notice']:g} operations"
    handles = [
        Line2D([], [], color=CORRECTED, lw=1.8, label="predicted, median"),
        Patch(color=CORRECTED, alpha=0.25, lw=0, label="predicted, 90 % interval"),
    ]
    if truth is not None:
        cone = f"truth ± {100 * alpha:g} %"
        handles += [
            Line2D([], [], color=MEASURED, lw=1.2, ls="--", label="truth"),
            Patch(color=_CONE, alpha=0.45, lw=0, label=cone),
        ]
    handles += [
        Patch(**_NO_TREND, label="no trend towards the limit"),
        Line2D([], [], color=REFERENCE, lw=0.9, ls=":", label=notice),
    ]
    return handles
