"""Changes of the parameters since new, over the operations, as the drive's own curves tell them."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.drive.life.first_page import in_percent
from breaker.figures import marks, style

_TRUTH = {"color": style.MEASURED, "ls": "", "marker": "o", "mfc": "none", "ms": 4.5, "mew": 0.8}
_TRUTH |= {"label": "truth of the stand-in"}
_TRUTHS = 24  # marks
_LEAST = 0.5  # percent, room above and below what is drawn
_TITLE = "Changes of the parameters, percent since new"


@style.styled
def changes(life: xr.Dataset, truth: xr.DataArray | None = None) -> Figure:
    """Draw the change of every parameter since new: median and 90 % band over the operations.

    Args:
        life: What ``life_results.follow_life`` returns.
        truth: True changes of the stand-in, ``(operation, parameter)``, percent; None for real
            measurements.
    """
    if words := marks.untold(life):
        return marks.sentence(_TITLE, words)
    names = [str(name) for name in life["parameter"].values]
    figure, axes = style.panels(len(names), columns=2, width=6.4, height=2.3, sharex=True)
    for axis, name in zip(axes, names, strict=True):
        _parameter(axis, life.sel(parameter=name), name, truth)
        marks.change_lines(axis, life)
    ends = style.edges(life["operation"].values)
    axes[0].set_xlim(ends[0], ends[-1])
    axes[0].xaxis.set_major_formatter("{x:,.0f}")
    style.label_outer(axes, "operation", "% since new")
    style.title(figure, f"{_TITLE}\n{marks.moved(life)}")
    keys = [style.line_key("median", lw=1.6), style.band_key("90 % interval", style.REFERENCE, 0.3)]
    marks.legend(figure, *keys, columns=3)
    return figure


def _parameter(axis: Axes, one: xr.Dataset, name: str, truth: xr.DataArray | None) -> None:
    """Draw band, median and truth of a parameter on an axis as large as these."""
    asked, output = one["asked"].values, style.OUTPUTS[name]
    low, middle, high = one["changed"].transpose("quantile", "asked").values
    axis.fill_between(asked, low, high, color=output.colour, alpha=0.3, lw=0)
    axis.plot(asked, middle, color=output.colour, lw=1.6)
    drawn = [low, high]
    if truth is not None:
        values = truth.sel(parameter=name)
        every = max(1, values.sizes["operation"] // _TRUTHS)
        axis.plot(values["operation"], values, markevery=every, **_TRUTH)
        drawn.append(values.values)
    least, most = (f(np.append(np.concatenate(drawn), 0.0)) for f in (np.nanmin, np.nanmax))
    room = 0.08 * (most - least) + _LEAST
    axis.set_ylim(least - room, most + room)
    axis.set_title(f"{output.symbol}   {output.meaning}", loc="left", fontsize=10)
    unchanged = one["unchanged"].values[-1]
    if np.isfinite(unchanged):
        axis.set_title(f"no change: {in_percent(unchanged)} probable", loc="right", fontsize=9)
