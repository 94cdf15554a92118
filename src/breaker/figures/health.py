"""Probability that limits of the drive's state are exceeded, operation by operation."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.figures import style

__all__ = ["health"]

_MARGINAL = "#EBC48A"
_FOOT = -0.05  # where unusable operations are ticked, on the axis of probability


@style.styled
def health(health: xr.Dataset) -> Figure:
    """Draw one panel per limit: probability that it is exceeded, levels, and where it is exceeded.

    The product of the marginals is shown only where it is not the same, that is, for a limit of
    several parts. Operations that are not usable are ticked at the foot.

    Args:
        health: ``probability``, ``marginal`` and ``trend_probability`` ``(operation, limit)``, nan
            where there is none, ``exceeded (operation, limit)``, ``since (limit)``, an operation
            or nan, ``words`` and ``source`` ``(limit)``; coordinates ``operation`` and ``limit``;
            attributes ``raise``, ``clear`` and ``after``.
    """
    titles = [str(words) for words in health["words"].values]
    figure, axes = style.limit_panels(health, titles, "probability", height=2.7, above=1)
    for axis, limit in zip(axes, health["limit"].values, strict=True):
        one = health.sel(limit=limit)
        _probabilities(axis, one)
        _alarm(axis, one, health.attrs)
    axes[0].set(ylim=(-0.1, 1.05), yticks=np.linspace(0.0, 1.0, 6))
    count, over = len(titles), int(health["since"].notnull().sum())
    words = f"limits exceeded: {over} of {count}" if over else "no limit exceeded"
    figure.suptitle(f"Health: probability that a limit is exceeded\n{words}")
    style.legend_below(figure, _handles(health), columns=4 if count == 1 else 3)
    return figure


def _probabilities(axis: Axes, one: xr.Dataset) -> None:
    """Draw single operations and trend of a limit, and what is not usable."""
    operation = one["operation"].values
    dots = {"ms": style.dot_size(operation.size), "mew": 0}
    if _differs(one):
        axis.plot(operation, one["marginal"], "D", color=_MARGINAL, zorder=1.9, **dots)
    axis.plot(operation, one["probability"], "o", color=style.MODEL, alpha=0.45, **dots)
    # The marker is as wide as the line: it keeps values in sight that have no neighbour.
    axis.plot(operation, one["trend_probability"], ".-", color=style.MODEL, lw=1.8, ms=3.6, mew=0)
    missing = operation[one["probability"].isnull().values]
    axis.plot(missing, np.full(missing.shape, _FOOT), "|", color=style.REFERENCE, ms=6, mew=0.8)


def _alarm(axis: Axes, one: xr.Dataset, levels: dict) -> None:
    """Draw levels, stretches in which the limit is exceeded, and since when it is, with words."""
    axis.axhline(levels["raise"], color=style.WARNING, lw=1.0, ls="--")
    axis.axhline(levels["clear"], color=style.REFERENCE, lw=1.0, ls="--")
    for start, stop in style.spans(one["operation"].values, one["exceeded"].values.astype(bool)):
        axis.axvspan(start, stop, color=style.WARNING, alpha=0.13, lw=0)
    first, source = one["since"].item(), one["source"].item()
    known = np.isfinite(first)
    if known:
        axis.axvline(first, color=style.WARNING, lw=1.4)
    above = {"xycoords": "axes fraction", "xytext": (0, 5), "textcoords": "offset points"}
    alarm = f"exceeded since operation {first:,.0f}" if known else "not exceeded"
    colour, weight = (style.WARNING, "bold") if known else (style.REFERENCE, "normal")
    axis.annotate(alarm, (0.0, 1.0), color=colour, weight=weight, **above)
    words = "from both motions" if source == "both" else f"from {source}"
    axis.annotate(words, (1.0, 1.0), ha="right", color=style.REFERENCE, **above)


def _differs(one: xr.Dataset) -> bool:
    """Whether a limit's marginal probability is another than that of the full posterior."""
    same = np.isclose(one["probability"], one["marginal"], rtol=0, atol=1e-12, equal_nan=True)
    return not bool(same.all())


def _handles(health: xr.Dataset) -> list:
    levels = health.attrs
    up = f"exceeded from {levels['raise']:g}"
    handles = [
        style.dot_key("single operations", style.MODEL, ms=5, alpha=0.6),
        style.line_key("by the trend", style.MODEL, lw=1.8),
        style.line_key(up, style.WARNING, "--", lw=1.0),
        style.line_key(f"until {levels['clear']:g}", ls="--", lw=1.0),
    ]
    if any(_differs(health.sel(limit=limit)) for limit in health["limit"].values):
        label = "single operations, as if parts were independent"
        handles.insert(2, style.dot_key(label, _MARGINAL, "D", ms=5))
    if bool(health["exceeded"].any()):
        handles.append(style.band_key("limit exceeded", style.WARNING, 0.13))
    if bool(health["since"].notnull().any()):
        handles.append(style.line_key("exceeded since", style.WARNING))
    if bool(health["probability"].isnull().any()):
        handles.append(style.dot_key("operation not usable", marker="|", ms=8))
    return handles
