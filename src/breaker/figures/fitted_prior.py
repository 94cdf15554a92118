"""The fitted prior of a type of breaker, beside its breakers and the default prior."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.drive.answers.type_prior import FittedPrior
from breaker.figures import style
from breaker.model.parameters import NAMES

_WIDE = 3.0  # log-sds to each side of the wider prior that a panel shows
_POINTS = 300
_SHARE = 0.6  # of a panel's height that the densities have; below are the breakers
_NAMED = 12  # breakers that are named beside their intervals


@style.styled
def fitted_prior(fitted: FittedPrior) -> Figure:
    """Draw a panel for each parameter: densities of both priors, and the breakers' intervals."""
    intervals, breakers = fitted.intervals, len(fitted.names)
    height = 2.6 + 0.09 * min(breakers, _NAMED)
    figure, axes = style.panels(len(NAMES), columns=4, width=3.9, height=height)
    for k, (axis, name) in enumerate(zip(axes, NAMES, strict=True)):
        both = [(np.log(e.medians[k]), e.log_sds[k]) for e in (fitted.prior, fitted.reference)]
        _panel(axis, both, intervals[..., k], fitted.names)
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


def _panel(
    axis: Axes,
    both: Sequence[tuple[float, float]],
    intervals: np.ndarray,
    breakers: Sequence[str],
) -> None:
    """Draw one parameter; densities are per unit of the logarithm, the fitted's highest 1.

    Args:
        both: Logarithm of the median, and log-sd, of the fitted and the default prior.
        intervals: Of the breakers, ``(3, b)``.
    """
    low = min(np.log(intervals[0]).min(), *(middle - _WIDE * sd for middle, sd in both))
    high = max(np.log(intervals[2]).max(), *(middle + _WIDE * sd for middle, sd in both))
    x = np.linspace(low, high, _POINTS)
    fitted, default = (np.exp(-0.5 * ((x - middle) / sd) ** 2) / sd for middle, sd in both)
    top = max(fitted.max(), default.max())
    axis.fill_between(np.exp(x), fitted / top, color=style.CORRECTED, alpha=0.35, lw=0)
    axis.plot(np.exp(x), default / top, color=style.PRIOR, ls="--", lw=1.6)
    count = len(breakers)
    rows = -(np.arange(count) + 1.0) / (count + 0.5) * (1.0 / _SHARE - 1.0)
    style.draw_intervals(axis, rows, intervals, color=style.MODEL, lw=1.2)
    axis.set_ylim(rows.min() - 0.1, 1.05)
    axis.axhline(0.0, color=style.REFERENCE, lw=0.8)
    named = count <= _NAMED
    axis.set_yticks(rows if named else [], [*map(style.literal, breakers)] if named else [])
