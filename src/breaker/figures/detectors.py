"""How early changes of wear are noticed, and for how many false alarms, by the model and others."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.figures import style

__all__ = ["detectors"]

_OTHERS = (("s", style.AMORTISED), ("^", "#4E9A9A"), ("D", "#A0569B"), ("v", "#5B7FB8"))
_PANELS = {
    "found_from_5": "(a) found, ratio from 5",
    "found_3_to_5": "(b) found, ratio 3 to 5",
    "delay_from_5": "(c) delay, ratio from 5",
}
_RAW = ", "  # in the name of what watches the raw time of one motion
_RAW_WORDS = "raw times,\nseveral charts"
_RAW_LOOK = {"color": style.PRIOR, "lw": 1.1, "marker": ".", "ms": 4, "zorder": 1.5}
_FINEST = 0.25  # false alarms in 10,000 operations, down to which the axis is logarithmic
_MOST = 12.0
_APART = 0.085  # of an axis, between labels


@style.styled
def detectors(table: pd.DataFrame, *, lives: int, alarm_level: float) -> Figure:
    """Draw share found and delay over the rate of false alarms, a line for each detector.

    Args:
        table: What ``synthetic.compare_detectors`` returns.
        alarm_level: Level of the model from which it reports a change.

    Raises:
        ValueError: If there are more detectors than markers.
    """
    looks = _looks([str(name) for name in table.detector.unique()])
    figure = style.new_figure(14.5, 5.4)
    axes = figure.subplots(1, 3, sharex=True)
    for axis, (column, title) in zip(axes, _PANELS.items(), strict=True):
        for name, rows in table.groupby("detector", sort=False):
            axis.plot(rows.false_alarms, _values(rows, column), **looks[name])
        own = table[(table.detector == "model") & np.isclose(table.level, alarm_level)]
        ring = {"ms": 14, "mfc": "none", "mec": style.MODEL, "mew": 1.8, "zorder": 4}
        axis.plot(own.false_alarms, _values(own, column), "o", **ring)
        _prepare(axis, column)
        axis.set_title(title, loc="left")
    axes[1].set_xlabel("false alarms in 10,000 operations")
    _label(axes[2], table, looks)
    figure.suptitle(
        f"Noticing a change of wear: the model beside other detectors\n{lives} simulated lives; "
        f"ring: the model as it is set, at {alarm_level:g}"
    )
    return figure


def _looks(names: list[str]) -> dict[str, dict]:
    """Look of the line of each detector."""
    others = [name for name in names if name != "model" and _RAW not in name]
    if len(others) > len(_OTHERS):
        raise ValueError(f"there are markers for {len(_OTHERS)} detectors, not {len(others)}")
    looks = dict.fromkeys(names, _RAW_LOOK)
    looks["model"] = {"color": style.MODEL, "lw": 2.4, "marker": "o", "ms": 6, "zorder": 3}
    for name, (marker, mark) in zip(others, _OTHERS, strict=False):
        looks[name] = {"color": mark, "lw": 1.7, "marker": marker, "ms": 6, "zorder": 2.5}
    return looks


def _values(rows: pd.DataFrame, column: str) -> np.ndarray:
    """Percent, or operations; where fewer than half are noticed, nothing is drawn."""
    values = rows[column].replace(np.inf, np.nan).to_numpy(float)
    return 100 * values if column.startswith("found") else values


def _prepare(axis: Axes, column: str) -> None:
    axis.set_xscale("symlog", linthresh=_FINEST, linscale=0.5)
    axis.set_xticks([0, 0.25, 0.5, 1, 2, 4, 8], ["0", "0.25", "0.5", "1", "2", "4", "8"])
    axis.set_xlim(-0.03, _MOST)
    if column.startswith("found"):
        axis.set(ylim=(-3, 103), ylabel="found within 3 % of life (%)")
        return
    axis.set(yscale="log", ylim=(15, 1200), ylabel="operations, median")
    axis.set_yticks([20, 50, 100, 200, 500, 1000], ["20", "50", "100", "200", "500", "1000"])
    axis.set_yticks([], minor=True)


def _label(axis: Axes, table: pd.DataFrame, looks: Mapping[str, Mapping]) -> None:
    """Write names beside the right ends of lines, apart from each other, the raw times together.

    What is never noticed has its name on top.
    """
    shown = table[table.false_alarms <= _MOST]
    ends = shown.sort_values("false_alarms").groupby("detector", sort=False).delay_from_5.last()
    raw = [name for name in ends.index if _RAW in name]
    names = ends.drop(raw)
    if raw:
        names[_RAW_WORDS] = ends[raw].max()
    to_axis = axis.transData + axis.transAxes.inverted()
    lowest = 0.0
    for name, value in names.sort_values(kind="stable").items():
        place = to_axis.transform((1.0, min(value, axis.get_ylim()[1])))[1]
        height = max(place, lowest)
        mark = looks[name]["color"] if name in looks else style.REFERENCE
        axis.text(1.03, height, name, color=mark, transform=axis.transAxes, va="center")
        lowest = height + _APART
