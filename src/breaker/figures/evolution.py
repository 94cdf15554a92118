"""Parameters over the operations of an endurance test (paper, Fig. 10)."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.figures import style
from breaker.figures.truth import draw_truth, truth_key

__all__ = ["FLAGS", "evolution"]

FLAGS = {
    "misfit": ("#9AA84F", "does not fit the model"),
    "outside_prior": (style.WARNING, "outside what the prior can produce"),
    "unresolved": ("#1A237E", "not resolved: exact posterior not reached"),
    "rejected": (style.MEASURED, "rejected by the reader"),
}
"""Colour and words of each flag, in the order of the strips from the bottom up."""

_STRIP = 0.028  # height of a strip, share of the panel


@style.styled
def evolution(inference: xr.Dataset, *, motion: str, truth: xr.DataArray | None = None) -> Figure:
    """Draw median and bands of every output over the operations, flagged operations in strips.

    A strip at the foot of each panel has a tick for every operation that is flagged; where every
    operation is, the strip is full while the panel stays readable. Rejected operations leave a gap.

    Args:
        inference: ``median (operation, output)``, ``interval_50`` and ``interval_95``
            ``(operation, output, bound)`` in physical units, flags ``misfit``, ``outside_prior``
            and ``accepted`` ``(operation)``; coordinates ``operation`` and ``output``. Where the
            posteriors were corrected, ``resolved (operation)`` gives one more flag: accepted
            operations whose exact posterior was not reached.
        truth: True parameters of the stand-in, ``(operation, parameter)``; None for real
            measurements.
    """
    names = [str(name) for name in inference["output"].values]
    flags = _flags(inference)
    figure, axes = style.panels(len(names), columns=2, width=6.2, height=2.5, sharex=True)
    for axis, name in zip(axes, names, strict=True):
        _bands(axis, inference.sel(output=name), name)
        draw_truth(axis, truth, name)
        _strips(axis, inference["operation"].values, flags)
        style.label_parameter(axis, name)
    style.label_outer(axes, "operation")
    axes[0].margins(x=0.01)
    style.heading(figure, motion, "evolution of the parameters over the endurance test")
    style.legend_below(figure, _handles(flags, truth is not None), columns=3)
    return figure


def _flags(inference: xr.Dataset) -> dict[str, np.ndarray]:
    """Return which operations are flagged ``(operation,)``, flag by flag, in the order of FLAGS."""
    accepted = inference["accepted"].values.astype(bool)
    resolved = inference["resolved"].values.astype(bool) if "resolved" in inference else accepted
    known = {name: inference[name].values.astype(bool) for name in ("misfit", "outside_prior")}
    return known | {"unresolved": accepted & ~resolved, "rejected": ~accepted}


def _bands(axis: Axes, one: xr.Dataset, name: str) -> None:
    operation, colour = one["operation"], style.colour(name)
    for interval, alpha in (("interval_95", 0.22), ("interval_50", 0.4)):
        low, high = one[interval].sel(bound="lower"), one[interval].sel(bound="upper")
        axis.fill_between(operation, low, high, color=colour, alpha=alpha, lw=0)
    axis.plot(operation, one["median"], "o", color=colour, ms=style.dot_size(len(operation)), mew=0)


def _strips(axis: Axes, operation: np.ndarray, flags: dict[str, np.ndarray]) -> None:
    """Mark flagged operations at the foot of the panel, in room made below the data."""
    low, high = axis.get_ylim()
    room = len(flags) * _STRIP
    axis.set_ylim(low - (high - low) * room / (1 - room), high)
    place = {"transform": axis.get_xaxis_transform(), "lw": 0.8}
    for i, (flag, flagged) in enumerate(flags.items()):
        foot, top = i * _STRIP, (i + 0.85) * _STRIP
        axis.vlines(operation[flagged], foot, top, color=FLAGS[flag][0], **place)


def _handles(flags: dict[str, np.ndarray], with_truth: bool) -> list:
    handles = [
        style.dot_key("posterior median", ms=4),
        style.band_key("50 % interval", style.REFERENCE, 0.55),
        style.band_key("95 % interval", style.REFERENCE, 0.22),
        with_truth and truth_key(),
    ]
    for flag, flagged in flags.items():
        mark, words = FLAGS[flag]
        if count := int(flagged.sum()):
            label = f"{words}: {count} of {flagged.size}"
            handles.append(style.dot_key(label, mark, "|", ms=9, mew=2))
    return handles
