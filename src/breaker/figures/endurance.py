"""Parameters over the operations of an endurance test, by single operations (paper, Fig. 10)."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from breaker.figures import panels as p
from breaker.figures import style

_LOOKS = {"paper": ("paper's network", style.AMORTISED), "family": ("family", style.CORRECTED)}


@style.styled
def evolution(
    blocks: Mapping[str, xr.Dataset],
    truth: xr.DataArray | None = None,
    shares: Mapping[str, np.ndarray] | None = None,
    *,
    motion: str,
) -> Figure:
    """Draw parameters over the operations: median and 90 % band in blocks of operations.

    ``blocks`` and ``shares`` are results of ``run_numbers.blocks_of`` and ``held``, by "paper" and
    "family"; ``truth`` is ``(operation, parameter)``, if known.
    """
    names = [str(name) for name in blocks["paper"]["parameter"].values]
    figure, axes = p.panels(len(names), columns=2, width=6.4, height=2.3, sharex=True)
    shares = shares or {}
    for k, (axis, name) in enumerate(zip(axes, names, strict=True)):
        for by, block in blocks.items():
            values = block["value"].sel(parameter=name).transpose("quantile", "block").values
            low, middle, high = np.hstack([values, values[:, -1:]])
            ends = np.append(block["first"].values - 0.5, block["last"].values[-1] + 0.5)
            label, color = _LOOKS[by]
            look = {"color": color, "alpha": 0.25, "lw": 0, "label": f"{label}: 90 % interval"}
            axis.fill_between(ends, low, high, step="post", **look)
            look = {"color": color, "lw": 1.6, "label": f"{label}: median"}
            axis.plot(ends, middle, drawstyle="steps-post", **look)
        if truth is not None:
            look = {"color": style.MEASURED, "lw": 1.2, "ls": "--", "label": "truth"}
            axis.plot(truth["operation"], truth.sel(parameter=name), **look)
            words = ", ".join(f"{by} {p.percent(share[k])}" for by, share in shares.items())
            axis.set_title(f"truth in the band: {words}", loc="right", fontsize=9)
        axis.set_title(p.named(name), loc="left")
        axis.set_ylabel(p.OUTPUTS[name].label)
    first, last = (blocks["paper"][end].values for end in ("first", "last"))
    axes[0].set_xlim(first[0] - 0.5, last[-1] + 0.5)
    axes[0].xaxis.set_major_formatter("{x:,.0f}")
    p.label_outer(axes, "operation")
    inside = [
        f"{_LOOKS[by][0]} {p.from_to([p.percent(share.min()), p.percent(share.max())])}"
        for by, share in shares.items()
    ]
    finding = f"Blocks whose band contains the truth: {', '.join(inside)}"
    size = int(np.max(last - first)) + 1
    what = f"blocks of {size} operations" if size > 1 else "single operations"
    about = f"{p.SOURCES[motion]}: parameters in {what}"
    for by, block in blocks.items():
        lacking = 1.0 - float(block["answered"].sum() / block["count"].sum())
        about += f"\n{_LOOKS[by][0]}: no answer for {p.percent(lacking)} of them" * (lacking > 0)
    style.title(figure, finding if inside else "Parameters over the operations", about)
    p.legend_below(figure, columns=3)
    return figure
