"""Changes of a life: what is found, how clear it was, and which records do not follow."""

from textwrap import wrap

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.common.numerals import in_digits
from breaker.figures import marks, style

_KINDS = {
    "rate": "the wear changed its rate",
    "step": "a sudden fault",
    "event": "known work",
}
_LINES, _WIDTH = 34, 42  # lines beside the panels that describe changes; characters


@style.styled
def changepoint(life: xr.Dataset) -> Figure:
    """Draw parameters that moved, the evidence for a change, weights of records, and changes.

    Args:
        life: What ``life_results.follow_life`` returns.
    """
    figure = style.new_figure(14.4, 8.2)
    grid = figure.add_gridspec(3, 2, height_ratios=(1.2, 1.2, 0.8), width_ratios=(3.2, 1.0))
    top = figure.add_subplot(grid[0, 0])
    evidence, weight = (figure.add_subplot(grid[i, 0], sharex=top) for i in (1, 2))
    _parameters(top, life)
    _evidence(evidence, life)
    operation = life["operation"].values
    weight.plot(operation, life["weight"], "o", color=style.MODEL, ms=2.2, mew=0, alpha=0.6)
    weight.set(ylim=(0.0, None), ylabel="weight", xlabel="operation")
    weight.set_title("weight of each record: low where it is off the path", loc="left")
    for axis in (top, evidence, weight):
        marks.change_lines(axis, life)
    for k, start in enumerate(life["start"].values):
        place = {"xycoords": top.get_xaxis_transform(), "ha": "center", "va": "bottom"}
        top.annotate(f"{k + 1}", (start, 1.0), weight="bold", **place)
    ends = style.edges(operation)
    top.set_xlim(ends[0], ends[-1])
    top.xaxis.set_major_formatter("{x:,.0f}")
    for axis in (top, evidence):
        axis.tick_params(labelbottom=False)
    _tell(figure.add_subplot(grid[:, 1]), life)
    figure.suptitle(f"Changes of the drive: {_outcome(life)}")
    marks.legend(figure, columns=5)
    return figure


def _outcome(life: xr.Dataset) -> str:
    """Say how many changes were found that nobody knew of, and the last of them."""
    found = (life["certainty"].values >= 0.0) & (life["kind"].values != "event")
    last = life.isel(change=found)
    if not last.sizes["change"]:
        return f"none is found in {life.sizes['operation']:,} operations"
    last, count = last.isel(change=-1), last.sizes["change"]
    words = f"{_KINDS[last['kind'].item()]} at operation {last['start'].item():,}"
    return words if count == 1 else f"{count} are found, the last: {words}"


def _parameters(axis: Axes, life: xr.Dataset) -> None:
    """Draw the medians of the parameters whose 90 % interval is off zero at the end."""
    axis.set_title("parameters that changed for sure", loc="left", pad=16.0)
    axis.set_ylabel("% since new")
    low, _, high = life["changed"].isel(asked=-1).transpose("quantile", ...).values
    moved = life["parameter"].values[low * high > 0.0]
    for name in moved:
        one = life["changed"].sel(parameter=name).isel(quantile=1)
        axis.plot(life["asked"], one, color=style.OUTPUTS[name].colour)
    if len(moved):
        axis.legend(axis.lines, style.symbols(moved), loc="upper left", ncols=len(moved))
        return
    words = marks.untold(life.isel(asked=[-1])) or "No parameter changed for sure."
    axis.text(0.5, 0.5, words, transform=axis.transAxes, ha="center", fontsize=11)


def _evidence(axis: Axes, life: xr.Dataset) -> None:
    """Draw the evidence for a change, linear up to the threshold and logarithmic from there."""
    threshold = life.attrs["threshold"]
    axis.plot(life["operation"], life["evidence"], color=style.MEASURED, lw=1.0)
    look = {"ls": "--", "label": f"threshold {in_digits(threshold, 4)} nats"}
    axis.axhline(threshold, color=style.REFERENCE, lw=1.0, **look)
    noticed = life["noticed"].values[life["kind"].values != "event"]
    look = {"ms": 9, "mec": "w", "label": "change noticed" if noticed.size else None}
    axis.plot(noticed, np.full(noticed.shape, threshold), "v", color=style.WARNING, **look)
    axis.set_yscale("symlog", linthresh=threshold)
    axis.set_ylim(top=max(2.0 * threshold, 1.2 * life["evidence"].max().item()))
    axis.yaxis.set_major_formatter("{x:g}")
    axis.set_ylabel("evidence (nats)")
    axis.set_title("evidence for a change that is not noticed yet", loc="left")


def _tell(axis: Axes, life: xr.Dataset) -> None:
    """Write the changes in words, the first ones where there are many."""
    axis.set_axis_off()
    told = [_words(life.isel(change=k), k + 1) for k in range(life.sizes["change"])]
    shown = int((np.cumsum([len(each) for each in told]) <= _LINES).sum())
    lines = [line for each in told[:shown] for line in each] or ["No change is found."]
    if shown < len(told):
        lines.append(f"and {len(told) - shown} more")
    place = {"xycoords": "axes fraction", "textcoords": "offset points", "va": "top"}
    for i, line in enumerate(lines):
        weight = "normal" if line.startswith(" ") else "bold"
        axis.annotate(line, (0.0, 1.0), xytext=(0, -13.5 * i), weight=weight, fontsize=9, **place)


def _words(change: xr.Dataset, number: int) -> list[str]:
    """Describe a change, line by line: when, of which kind and of what, and when noticed."""
    start, earliest, latest, noticed = (
        f"{change[name].item():,}" for name in ("start", "earliest", "latest", "noticed")
    )
    kind, names = change["kind"].item(), change["change_names"].item()
    what = f"{_KINDS[kind]}: {names}" if names else _KINDS[kind]
    lines = [f"{number}  operation {start}", *wrap(style.spoken(what), _WIDTH)]
    if kind != "event":
        lines += [f"90 %: {earliest} to {latest}", f"noticed at {noticed}"]
    if change["certainty"].item() < 0.0:
        lines.append("taken back by later records")
    return [lines[0], *(f"    {line}" for line in lines[1:])]
