"""What the model leaves out of a motion: how large, of which shape, and what it costs."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.figures import style

__all__ = ["discrepancy"]

_EXAMPLE = {"color": style.REFERENCE, "lw": 0.7, "alpha": 0.7}
_COMPONENTS = 4  # drawn, the largest
_ERRORS = {  # marker, colour and words of each, from the top of a row down
    "noise": ("o", style.PRIOR, "noise alone"),
    "zero": ("s", style.REFERENCE, "and the offset of a record"),
    "onset": ("^", style.MEASURED, "and the onset"),
    "left out": ("D", style.MODEL, "and what the model leaves out"),
}


@style.styled
def discrepancy(learned: xr.Dataset, cost: xr.Dataset, *, motion: str, noise_sd: float) -> Figure:
    """Draw band, examples and components of what the model leaves out, and its cost.

    Args:
        learned: From :func:`breaker.synthetic.learn`, of one motion.
        cost: From :func:`breaker.synthetic.contraction_by_error`.
        noise_sd: Noise of a sample, mm.
    """
    figure = style.new_figure(13.6, 9.4)
    (new, change), (components, costs) = figure.subplots(2, 2)
    examples = learned["examples"]
    of_change = examples.sel(condition="worn") - examples.sel(condition="new")
    mean, spread = learned["mean"], learned["spread"]
    _band(new, mean, spread.sel(condition="new"), examples.sel(condition="new"))
    new.set_title("new drives: their curve less the model's at their true parameters")
    _band(change, 0.0 * mean, spread.sel(condition="worn"), of_change)
    change.set_title("how the difference changes while a drive wears out")
    for k, row in enumerate(learned["factor"].values[:_COMPONENTS]):
        sign = np.sign(row[np.abs(row).argmax()])
        components.plot(learned["time"], sign * row, lw=1.8 - 0.3 * k, label=f"component {k + 1}")
    components.axhspan(-noise_sd, noise_sd, color=style.REFERENCE, alpha=0.25, lw=0)
    components.legend(loc="upper right")
    components.set_title(f"largest components, one sd each (grey: noise of {noise_sd:g} mm)")
    for axis in (new, change, components):
        axis.set(xlabel="time (ms)", ylabel="difference (mm)")
        axis.margins(x=0.01)
    _costs(costs, cost)
    largest = float(np.sqrt(np.square(mean) + np.square(spread.sel(condition="new"))).max())
    outcome = f"root mean square over drives up to {largest:.2f} mm"
    style.heading(figure, motion, "what the model leaves out", outcome)
    handles = [
        style.line_key("single drives", style.REFERENCE, lw=0.9),
        style.band_key("mean ± 2 sd", style.MODEL, 0.25),
        *(style.dot_key(words, color, marker) for marker, color, words in _ERRORS.values()),
    ]
    style.legend_below(figure, handles, columns=3)
    return figure


def _band(axis: Axes, mean: xr.DataArray, spread: xr.DataArray, examples: xr.DataArray) -> None:
    time = examples["time"]
    axis.plot(time, examples.transpose("time", "drive"), **_EXAMPLE)
    ends = mean - 2 * spread, mean + 2 * spread
    axis.fill_between(time, *ends, color=style.MODEL, alpha=0.25, lw=0, zorder=3)
    axis.plot(time, mean, color=style.MODEL, zorder=3)


def _costs(axis: Axes, cost: xr.Dataset) -> None:
    """Contraction of each parameter, error by error."""
    names = [str(name) for name in cost["parameter"].values]
    rows = np.arange(len(names))
    shifts = np.linspace(-0.27, 0.27, len(_ERRORS))
    for shift, (error, (marker, color, _)) in zip(shifts, _ERRORS.items(), strict=True):
        values = cost["contraction"].sel(error=error)
        axis.plot(values, rows + shift, marker, color=color, ms=6)
    axis.set_yticks(rows, [f"{style.parameter(name).symbol}" for name in names])
    axis.set(xlim=(-0.03, 1.03), ylim=(len(rows) - 0.5, -0.5))
    axis.set_xlabel("contraction   (0: nothing learnt, the prior stays;  1: known exactly)")
    axis.set_title("what each error costs a single record (exact limit)")
