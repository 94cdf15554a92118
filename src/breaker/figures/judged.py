"""Trends and alarms held against the truth of rigs that the model does not fit."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.figures import style
from breaker.mechanism import NAMES

__all__ = ["judged"]

_SETS = {
    "held_back": ("family, held back", style.CORRECTED),
    "foreign": ("with foreign elements", style.AMORTISED),
    "tuning": ("family, for tuning", "#8A8A8A"),
}
_RANGE = (85.0, 95.0)  # percent, where the coverage of 90 % intervals is to be
_POWER = 95.0  # percent, of the faults that are to be reported
_TARGET = {"color": "#009E73", "alpha": 0.15, "lw": 0}
_STEP = 0.16  # between sets and scales, on the axis


@style.styled
def judged(lives: pd.DataFrame, faults: pd.DataFrame) -> Figure:
    """Draw coverage by quantity, set and scale, and the power for each fault.

    Args:
        lives, faults: What ``synthetic.score_lives`` and ``score_power`` return; shares with their
            95 % intervals.
    """
    figure, axes = style.panels(4, columns=2, width=5.6, height=3.6)
    _power(axes[0], faults)
    for axis, score, title in (
        (axes[1], "level", "level of the trend"),
        (axes[2], "slope", "drift of the trend"),
    ):
        _coverage(axis, lives[lives.score == f"coverage, {score}"], title, NAMES)
    rest = lives[lives.score == "coverage, remaining"]
    _coverage(axes[3], rest, "remaining life", list(rest.quantity.unique()))
    axes[3].set_xlabel("share of the way from change to end")
    for axis, letter in zip(axes, "abcd", strict=True):
        axis.set_title(f"({letter}) {axis.get_title(loc='left')}", loc="left")
    used = [look for name, look in _SETS.items() if name in set(lives.set)]
    handles = [style.dot_key(label, color) for label, color in used]
    handles += [
        style.dot_key("the same without an error of the model", mfc="white"),
        style.band_key("target", _TARGET["color"], _TARGET["alpha"]),
    ]
    style.legend_below(figure, handles)
    figure.suptitle("90 % intervals and faults, on rigs that the model does not fit")
    return figure


def _coverage(axis: Axes, rows: pd.DataFrame, title: str, names: Sequence) -> None:
    """Draw the coverage of 90 % intervals of quantities, for each set and scale."""
    axis.axhspan(*_RANGE, **_TARGET)
    looks = [(name, scale) for scale in (True, False) for name in _SETS if name in set(rows.set)]
    for k, (name, scale) in enumerate(looks):
        some = rows[(rows.set == name) & ((rows.scale > 0) == scale)].set_index("quantity")
        some = some.reindex(names)
        places = np.arange(len(names)) + _STEP * (k - (len(looks) - 1) / 2)
        color = _SETS[name][1]
        axis.vlines(places, 100.0 * some.lower_95, 100.0 * some.upper_95, color=color, lw=1.0)
        axis.plot(
            places, 100.0 * some.value, "o", color=color, mfc=color if scale else "white", ms=5
        )
    words = [
        style.parameter(name).symbol if name in NAMES else str(name).replace("_", "\n")
        for name in names
    ]
    axis.set_xticks(np.arange(len(names)), words)
    axis.set(ylim=(-3.0, 103.0), ylabel="coverage (%)")
    axis.set_title(title, loc="left")


def _power(axis: Axes, rows: pd.DataFrame) -> None:
    """Draw the share of each fault that is reported."""
    some = rows[rows.score == "reported"]
    axis.axvspan(_POWER, 100.0, **_TARGET)
    places = np.arange(len(some))
    axis.barh(places, 100.0 * some.value, color=style.MODEL, alpha=0.6, height=0.6)
    axis.hlines(places, 100.0 * some.lower_95, 100.0 * some.upper_95, color=style.REFERENCE)
    axis.set_yticks(places, some.quantity + " (" + some.n.astype(str) + ")")
    axis.invert_yaxis()
    axis.set(xlim=(0.0, 101.0), xlabel="reported within 3 records (%)")
    axis.set_title("faults at one operation", loc="left")
