"""Probability that limits of the drive's state are exceeded, operation by operation."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.figures import style

__all__ = ["health"]

_MARGINAL = "#EBC48A"
_SOURCES = {"both": "from both motions", "record": "as measured"}
_FOOT = -0.05  # where unusable operations are ticked, on the axis of probability
_QUARTERS = (0.25, 0.75)  # something happens where a probability crosses one of these
_BEFORE = 0.5  # operations shown before that, share of those after it,
_LEAST = 0.05  # and at least this share of all


@style.styled
def health(health: xr.Dataset) -> Figure:
    """Draw one panel per limit: how probably it is exceeded, and where it counts as exceeded.

    The operations shown begin before the first at which a limit stirs; all of them, if none does.
    The product of the marginals is shown only where it is not the same, that is, for a limit of
    several parts. Operations that are not usable are ticked at the foot.

    Args:
        health: ``probability`` and ``marginal``, of single operations, ``level_probability``, by
            which limits are judged, nan where there is none, and ``exceeded``
            ``(operation, limit)``; ``since (limit)``, the operation at which the limit was
            exceeded, nan where it is not at the end, ``words`` and ``source`` ``(limit)``;
            coordinates ``operation`` and ``limit``; attributes ``raise`` and ``clear``.
    """
    first = _begin(health)
    shown = health.sel(operation=slice(first, None))
    titles = [str(words) for words in health["words"].values]
    figure, axes = style.limit_panels(shown, titles, "probability", height=2.7, above=1)
    for axis, limit in zip(axes, health["limit"].values, strict=True):
        one = shown.sel(limit=limit)
        _probabilities(axis, one)
        _exceeded(axis, one, health.attrs)
    axes[0].set(ylim=(-0.1, 1.05), yticks=np.linspace(0.0, 1.0, 6))
    axes[0].xaxis.set_major_formatter("{x:,.0f}")
    count, over = len(titles), int(health["since"].notnull().sum())
    words = f"limits exceeded: {over} of {count}" if over else "no limit is exceeded"
    if first > health["operation"].values[0]:
        words += f"; shown from operation {first:,}, nothing happened before"
    figure.suptitle(f"Health: probability that a limit is exceeded\n{words}")
    style.legend_below(figure, _handles(shown), columns=4 if count == 1 else 3)
    return figure


def _begin(health: xr.Dataset) -> int:
    """Return the operation from which on to draw: some before a limit first stirs."""
    operation, each = health["operation"].values, ("operation", "limit")
    tenth = len(operation) // 10
    quarter = np.digitize(health["level_probability"].transpose(*each).fillna(0.0), _QUARTERS)
    stirs = (quarter != np.median(quarter[: tenth + 1], axis=0)).any(axis=1)
    stirs[:tenth] = False  # what is known first is the prior, until there are records
    stirs |= health["exceeded"].transpose(*each).values.any(axis=1)
    if not stirs.any():
        return int(operation[0])
    begin = int(stirs.argmax())
    before = max(_BEFORE * (len(operation) - begin), _LEAST * len(operation))
    return int(operation[max(0, round(begin - before))])


def _probabilities(axis: Axes, one: xr.Dataset) -> None:
    """Draw single operations and what a limit is judged by, and what is not usable."""
    operation = one["operation"].values
    dots = {"ms": style.dot_size(operation.size), "mew": 0}
    if _differs(one):
        axis.plot(operation, one["marginal"], "D", color=_MARGINAL, zorder=1.9, **dots)
    axis.plot(operation, one["probability"], "o", color=style.MODEL, alpha=0.45, **dots)
    # The marker is as wide as the line: it keeps values in sight that have no neighbour.
    axis.plot(operation, one["level_probability"], ".-", color=style.MODEL, lw=1.8, ms=3.6, mew=0)
    missing = operation[one["probability"].isnull().values]
    axis.plot(missing, np.full(missing.shape, _FOOT), "|", color=style.REFERENCE, ms=6, mew=0.8)


def _exceeded(axis: Axes, one: xr.Dataset, levels: dict) -> None:
    """Draw levels, stretches in which the limit is exceeded, and since when it is, with words."""
    axis.axhline(levels["raise"], color=style.WARNING, lw=1.0, ls="--")
    axis.axhline(levels["clear"], color=style.REFERENCE, lw=1.0, ls="--")
    for start, stop in style.spans(one["operation"].values, one["exceeded"].values.astype(bool)):
        axis.axvspan(start, stop, color=style.WARNING, alpha=0.13, lw=0)
    since, source = one["since"].item(), one["source"].item()
    known = np.isfinite(since)
    if known:
        axis.axvline(since, color=style.WARNING, lw=1.4)
    above = {"xycoords": "axes fraction", "xytext": (0, 5), "textcoords": "offset points"}
    told = f"exceeded since {since:,.0f}" if known else "not exceeded"
    colour, weight = (style.WARNING, "bold") if known else (style.REFERENCE, "normal")
    axis.annotate(told, (0.0, 1.0), color=colour, weight=weight, **above)
    words = _SOURCES.get(source, f"from {source}")
    axis.annotate(words, (1.0, 1.0), ha="right", color=style.REFERENCE, **above)


def _differs(one: xr.Dataset) -> bool:
    """Whether a limit's marginal probability is another than that of the full posterior."""
    same = np.isclose(one["probability"], one["marginal"], rtol=0, atol=1e-12, equal_nan=True)
    return not bool(same.all())


def _handles(health: xr.Dataset) -> list:
    levels = health.attrs
    differ = any(_differs(health.sel(limit=limit)) for limit in health["limit"].values)
    independent = "single operations, as if parts were independent"
    missing = health["probability"].isnull().values.any()
    return [
        style.dot_key("single operations", style.MODEL, ms=5, alpha=0.6),
        style.line_key("the level, by which it is judged", style.MODEL, lw=1.8),
        differ and style.dot_key(independent, _MARGINAL, "D", ms=5),
        style.line_key(f"exceeded from {levels['raise']:g} on", style.WARNING, "--", lw=1.0),
        style.line_key(f"until {levels['clear']:g} again", ls="--", lw=1.0),
        health["exceeded"].values.any() and style.band_key("exceeded", style.WARNING, 0.13),
        health["since"].notnull().values.any() and style.line_key("exceeded since", style.WARNING),
        missing and style.dot_key("operation not usable", marker="|", ms=8),
    ]
