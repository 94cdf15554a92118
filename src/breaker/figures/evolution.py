"""Parameters over the operations of an endurance test (paper, Fig. 10)."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from breaker.figures.style import (
    MEASURED,
    REFERENCE,
    WARNING,
    colour,
    heading,
    legend_below,
    panels,
    parameter,
    styled,
)

__all__ = ["evolution"]

# Variable, colour and words of each flag, in the order of the strips from the bottom up.
_FLAGS = (
    ("misfit", "#C9A227", "does not fit the model"),
    ("outside_prior", WARNING, "outside what the prior can produce"),
    ("unresolved", "#3F51B5", "not resolved: exact posterior not reached"),
    ("rejected", MEASURED, "rejected by the reader"),
)
_STRIP = 0.028  # height of a strip, share of the panel


@styled
def evolution(
    inference: xr.Dataset, *, motion: str, effective: xr.DataArray | None = None
) -> Figure:
    """Draw median and bands of every output over the operations, flagged operations in strips.

    A strip at the foot of each panel has a tick for every operation that is flagged; a curve may
    leave the model at the end of its stroke at every operation, and then the strip is full while
    the panel stays readable. Rejected operations leave a gap.

    Args:
        inference: ``median (operation, output)``, ``interval_50`` and ``interval_95``
            ``(operation, output, bound)`` in physical units, flags ``misfit``, ``outside_prior``
            and ``accepted`` ``(operation)``; coordinates ``operation`` and ``output``. Where the
            posteriors were corrected, ``resolved (operation)`` gives one more flag: accepted
            operations whose exact posterior was not reached.
        motion: Motion of the title.
        effective: Effective values of the stand-in, ``(stage, output)``, with a coordinate
            ``operation (stage)``; None for real measurements. Outputs it lacks are left out.
    """
    names = [str(name) for name in inference["output"].values]
    flags = _flags(inference)
    figure, axes = panels(len(names), columns=2, width=6.2, height=2.5, sharex=True)
    for axis, name in zip(axes, names, strict=True):
        _bands(axis, inference.sel(output=name), name)
        if effective is not None and name in effective["output"].values:
            values = effective.sel(output=name)
            axis.plot(values["operation"], values, "D--", color=MEASURED, ms=3.5, lw=1.1)
        _strips(axis, inference["operation"].values, flags)
        axis.set_ylabel(parameter(name).label)
        axis.set_title(f"{parameter(name).symbol}   {parameter(name).meaning}", loc="left")
        if axis.xaxis.get_tick_params()["labelbottom"]:
            axis.set_xlabel("operation")
    axes[0].margins(x=0.01)
    heading(figure, motion, "evolution of the parameters over the endurance test")
    legend_below(figure, _handles(flags, effective is not None), columns=3)
    return figure


def _flags(inference: xr.Dataset) -> dict[str, np.ndarray]:
    """Return which operations are flagged ``(operation,)``, flag by flag."""
    accepted = inference["accepted"].values.astype(bool)
    flags = {
        "misfit": inference["misfit"].values.astype(bool),
        "outside_prior": inference["outside_prior"].values.astype(bool),
        "rejected": ~accepted,
    }
    if "resolved" in inference:
        flags["unresolved"] = accepted & ~inference["resolved"].values.astype(bool)
    return flags


def _bands(axis: Axes, one: xr.Dataset, name: str) -> None:
    operation = one["operation"]
    for interval, alpha in (("interval_95", 0.22), ("interval_50", 0.4)):
        low, high = one[interval].sel(bound="lower"), one[interval].sel(bound="upper")
        axis.fill_between(operation, low, high, color=colour(name), alpha=alpha, lw=0)
    size = 1.8 if operation.size > 500 else 3.5
    axis.plot(operation, one["median"], "o", color=colour(name), ms=size, mew=0)


def _strips(axis: Axes, operation: np.ndarray, flags: dict[str, np.ndarray]) -> None:
    """Mark flagged operations at the foot of the panel, in room made below the data."""
    low, high = axis.get_ylim()
    shown = [(flag, mark) for flag, mark, _ in _FLAGS if flag in flags]
    room = len(shown) * _STRIP
    axis.set_ylim(low - (high - low) * room / (1 - room), high)
    for i, (flag, mark) in enumerate(shown):
        axis.vlines(
            operation[flags[flag]],
            i * _STRIP,
            (i + 0.85) * _STRIP,
            color=mark,
            lw=0.8,
            transform=axis.get_xaxis_transform(),
        )


def _handles(flags: dict[str, np.ndarray], with_effective: bool) -> list:
    handles = [
        Line2D([], [], color=REFERENCE, ls="", marker="o", ms=4, label="posterior median"),
        Patch(color=REFERENCE, alpha=0.55, lw=0, label="50 % interval"),
        Patch(color=REFERENCE, alpha=0.22, lw=0, label="95 % interval"),
    ]
    if with_effective:
        label = "effective values of the stand-in"
        handles.append(Line2D([], [], color=MEASURED, ls="--", marker="D", ms=3.5, label=label))
    for flag, mark, words in _FLAGS:
        if flag in flags and (count := int(flags[flag].sum())):
            label = f"{words}: {count} of {flags[flag].size}"
            handles.append(Line2D([], [], color=mark, ls="", marker="|", ms=9, mew=2, label=label))
    return handles
