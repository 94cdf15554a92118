"""Parameters over the operations of an endurance test, by single operations (paper, Fig. 10)."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.figures import style
from breaker.model.parameters import NAMES
from breaker.paper.validation import percent

_LOOKS = {"paper": ("the paper's network", style.AMORTISED), "family": ("family", style.CORRECTED)}
_TRUTH = {"color": style.MEASURED, "lw": 1.2, "ls": "--"}


@style.styled
def evolution(
    blocks: Mapping[str, xr.Dataset],
    truth: xr.DataArray | None = None,
    shares: Mapping[str, np.ndarray] | None = None,
    *,
    motion: str,
) -> Figure:
    """Draw every parameter over the operations: median and 90 % band in blocks of them.

    Args:
        blocks: Of "paper" and "family", what ``operation_blocks.blocks_of`` returns.
        truth: True values of the stand-in, ``(operation, parameter)``; None for real measurements.
        shares: Of "paper" and "family", what ``operation_blocks.held`` returns, with a truth.
    """
    figure, axes = style.panels(len(NAMES), columns=2, width=6.4, height=2.3, sharex=True)
    shares = shares or {}
    for k, (axis, name) in enumerate(zip(axes, NAMES, strict=True)):
        for by, one in blocks.items():
            _band(axis, one.sel(parameter=name), _LOOKS[by][1])
        if truth is not None:
            axis.plot(truth["operation"], truth.sel(parameter=name), **_TRUTH)
            said = ", ".join(f"{by} {percent(share[k])}" for by, share in shares.items())
            axis.set_title(f"truth in the band: {said}", loc="right", fontsize=9)
        output = style.OUTPUTS[name]
        axis.set_title(f"{output.symbol}   {output.meaning}", loc="left", fontsize=10)
        axis.set_ylabel(f"{output.symbol} ({output.unit})" if output.unit != "1" else output.symbol)
    first, last = (blocks["paper"][end].values for end in ("first", "last"))
    axes[0].set_xlim(first[0] - 0.5, last[-1] + 0.5)
    axes[0].xaxis.set_major_formatter("{x:,.0f}")
    style.label_outer(axes, "operation")
    size = int(np.max(last - first)) + 1
    of = f"blocks of {size} operations" if size > 1 else "single operations"
    style.heading(figure, motion, f"evolution of the parameters, {of}", _outcome(blocks, shares))
    keys = [style.line_key("truth of the stand-in", _TRUTH["color"], "--")] if shares else []
    for label, colour in _LOOKS.values():
        keys += [style.line_key(f"{label}: median", colour, lw=1.6)]
        keys += [style.band_key("90 % interval", colour, 0.25)]
    style.legend_below(figure, [*keys[-4:], *keys[:-4]], columns=3)
    return figure


def _band(axis: Axes, one: xr.Dataset, colour: str) -> None:
    """Draw median and band of a parameter, a step for each block."""
    values = one["value"].transpose("quantile", "block").values
    low, middle, high = np.hstack([values, values[:, -1:]])
    edges = np.append(one["first"].values - 0.5, one["last"].values[-1] + 0.5)
    axis.fill_between(edges, low, high, step="post", color=colour, alpha=0.25, lw=0)
    axis.plot(edges, middle, drawstyle="steps-post", color=colour, lw=1.6)


def _outcome(blocks: Mapping[str, xr.Dataset], shares: Mapping[str, np.ndarray]) -> str:
    """State how often the truth is held, and of how many operations there is no posterior."""
    held = []
    for by, share in shares.items():
        ends = dict.fromkeys(percent(each) for each in (share.min(), share.max()))
        held.append(f"{_LOOKS[by][0]} {' to '.join(ends)}")
    lines = [f"blocks whose band holds the truth: {', '.join(held)}"] if held else []
    lacking = {
        by: 1.0 - float(one["answered"].sum() / one["count"].sum()) for by, one in blocks.items()
    }
    said = [f"{_LOOKS[by][0]} {percent(share)}" for by, share in lacking.items() if share]
    lines += [f"operations without an answer: {', '.join(said)}"] if said else []
    return "\n".join(lines)
