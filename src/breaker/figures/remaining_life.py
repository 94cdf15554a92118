"""Operations left until the level of the drive is beyond a limit, over its life."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.figures import style

__all__ = ["remaining_life"]

_TRUTH = {"color": style.MEASURED, "lw": 1.2, "ls": "--"}
_WITHOUT = {"color": style.MEASURED, "lw": 1.2, "ls": ":"}
_NOTICE = {"color": style.PRIOR, "lw": 0.9}
_FOOT = 0.025  # height of the strip at the foot, share of the panel
_END = 0.1  # operations shown once more, share of all,
_FEWEST = 20  # and at least so many
_NEAR = 0.4  # of no use if it shows a larger share of the panel's height
_WIDTHS = (7.0, 3.0)  # of a whole life and its end, relative


@style.styled
def remaining_life(left: xr.Dataset) -> Figure:
    """Draw one panel per limit: operations left as told, and the true ones where they are known.

    Axes are linear, with the last operations before the limit once more beside them. A strip at the
    foot marks where no number is told: the limit is exceeded, or no trend leads there.

    Args:
        left: ``told (operation, limit, quantile)`` at 0.05, 0.5 and 0.95: 0 where the limit is
            exceeded, inf beyond the horizon, nan where no trend leads there; ``words (limit)``; of
            a stand-in ``failure`` and ``failure_without`` ``(limit)``, the operation at which the
            true level is first beyond the limit, nan if it is not, and at which it would be without
            the change of its wear, nan where that is the same, and ``changed``, the operation of
            that change, nan without one; coordinates ``operation`` and ``limit``; attributes
            ``horizon``, ``notice`` and ``source``.
    """
    known = "failure" in left
    titles = []
    for words, limit in zip(left["words"].values, left["limit"].values, strict=True):
        reached = not known or np.isfinite(left["failure"].sel(limit=limit).item())
        titles.append(str(words) + ("" if reached else " (in truth not reached)"))
    figure, axes = style.limit_panels(left, titles, "operations left", height=3.3, sharey=False)
    axes[0].xaxis.set_major_formatter("{x:,.0f}")
    axes[0].locator_params(axis="x", nbins=5)
    for axis, limit in zip(axes, left["limit"].values, strict=True):
        one = left.sel(limit=limit)
        told = one["told"].transpose("operation", "quantile").values
        truths = _truths(one) if known else []
        finite = told[np.isfinite(told[:, 1]), 1]
        largest = max(each.max(initial=0.0) for each in (finite, *(line[1] for line in truths)))
        top = 1.25 * max(largest, 1.5 * one.attrs["notice"])
        _draw(axis, one, told, truths, top)
        axis.set_ylim(0.0, top)
        axis.yaxis.set_major_formatter("{x:,.0f}")
        _end(axis, one, told, truths)
    style.heading(figure, left.attrs["source"], "operations left until a limit is exceeded")
    style.legend_below(figure, _handles(left, known), columns=4 if len(titles) == 1 else 3)
    return figure


def _truths(one: xr.Dataset) -> list[tuple[np.ndarray, np.ndarray, dict]]:
    """Return operations, what was left then, and looks: with the change, and without until it."""
    operation, failure = one["operation"].values, one["failure"].item()
    lines = []
    if np.isfinite(failure):
        before = operation[operation <= failure]
        lines.append((before, failure - before, _TRUTH))
    without = one["failure_without"].item()
    if np.isfinite(without):
        before = operation[operation < one["changed"].item()]
        lines.append((before, without - before, _WITHOUT))
    return lines


def _draw(axis: Axes, one: xr.Dataset, told: np.ndarray, truths: list, top: float) -> None:
    """Draw band and median where they are told, truths, the notice, and the strip at the foot."""
    operation = one["operation"].values
    known = ~np.isnan(told[:, 1]) & (told[:, 2] > 0)
    low, middle, high = np.where(known[:, None], told, np.nan).T
    high = np.where(np.isinf(high), 10.0 * top, high)  # goes on beyond the panel
    low = np.where(np.isinf(low), 10.0 * top, low)
    # The lines around the band keep stretches of one operation in sight.
    look = {"color": style.CORRECTED, "lw": 0.6, "alpha": 0.25}
    axis.fill_between(operation, low, high, **look)
    axis.plot(operation, middle, ".-", color=style.CORRECTED, lw=1.8, ms=3.0, mew=0)
    for at, left, line in truths:
        axis.plot(at, left, zorder=2.5, **line)
    axis.axhline(one.attrs["notice"], **_NOTICE)
    strip = {"ymax": _FOOT, "lw": 0, "zorder": 3}
    for start, stop in style.spans(operation, np.isnan(told[:, 1])):
        axis.axvspan(start, stop, color=style.PRIOR, **strip)
    for start, stop in style.spans(operation, told[:, 2] == 0):
        axis.axvspan(start, stop, color=style.WARNING, **strip)


def _end(axis: Axes, one: xr.Dataset, told: np.ndarray, truths: list) -> None:
    """Show the operations around the limit once more, if anything is near it."""
    operation, top = one["operation"].values, 1.5 * one.attrs["notice"]
    count = max(_FEWEST, round(_END * len(operation)))
    if len(operation) <= 2 * count or top > _NEAR * axis.get_ylim()[1]:
        return
    over = operation[(told[:, 2] == 0) | _reached(one)]  # truth included
    last = int(np.searchsorted(operation, over[0])) if over.size else len(operation) - 1
    last = min(last + count // 3, len(operation) - 1)
    near = slice(max(0, last - count), last + 1)
    if not (_reached(one)[near].any() or (told[near, 1] < top).any()):
        return
    places = axis.get_subplotspec().subgridspec(1, 2, width_ratios=_WIDTHS)
    axis.set_subplotspec(places[0])
    small = axis.figure.add_subplot(places[1])
    _draw(small, one, told, truths, axis.get_ylim()[1])
    small.set(xlim=operation[[near.start, last]], ylim=(0.0, top))
    small.locator_params(nbins=3)
    small.tick_params(labelsize=8)
    small.set_xlabel("near the limit", fontsize=9)
    small.xaxis.set_major_formatter("{x:,.0f}")
    small.yaxis.set_major_formatter("{x:,.0f}")


def _reached(one: xr.Dataset) -> np.ndarray:
    """Where the true level is beyond the limit, ``(o,)``; nowhere, where no truth is known."""
    failure = one["failure"].item() if "failure" in one else np.nan
    return one["operation"].values >= failure


def _handles(left: xr.Dataset, known: bool) -> list:
    told, without = left["told"].values, "truth without the change, until it happens"
    apart = known and left["failure_without"].notnull().values.any()
    return [
        style.line_key("told, median", style.CORRECTED, lw=1.8),
        style.band_key("told, 90 % interval", style.CORRECTED, 0.25),
        known and style.line_key("truth", **_TRUTH),
        apart and style.line_key(without, **_WITHOUT),
        np.isnan(told).any() and style.band_key("no trend leads to the limit", style.PRIOR, 1.0),
        (told == 0).any() and style.band_key("exceeded", style.WARNING, 1.0),
        style.line_key(f"notice: {left.attrs['notice']:,g} operations", **_NOTICE),
    ]
