"""How figures over the operations show the truth of the stand-in."""

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from breaker.figures.style import MEASURED

__all__ = ["TRUTH", "draw_truth", "truth_key"]

TRUTH = "truth"  # by which its marks are found
_TRUTH = {"color": MEASURED, "ls": "", "marker": "o", "mfc": "none", "ms": 4.5, "mew": 0.8}
_TRUTHS = 24  # marks


def truth_key() -> Line2D:
    """Return the mark of :func:`draw_truth` for a legend."""
    return Line2D([], [], label="truth of the stand-in", **_TRUTH)


def draw_truth(axis: Axes, truth: xr.DataArray | None, name: str) -> None:
    """Draw the true values ``(operation, parameter)`` of a parameter, if there are any."""
    if truth is not None and name in truth["parameter"].values:
        values = truth.sel(parameter=name)
        every = max(1, values.sizes["operation"] // _TRUTHS)
        axis.plot(values["operation"], values, markevery=every, gid=TRUTH, **_TRUTH)
