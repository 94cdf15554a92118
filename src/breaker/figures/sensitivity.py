"""How conclusions about a few operations move with the model's own error."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.figures import style
from breaker.figures.words import literal

__all__ = ["sensitivity"]

_SHADES = ("#C2185B", "#9DB2CF", "#4F78AE", "#12294D")  # of scales; first, the model is right
_MARKERS = ("s", "o", "D", "^")
_WIDTH = 0.6  # of the group of an operation
_FOOT = 1e-12  # p-values below it are drawn there
_PRIOR = 1.645  # prior sd, half the 90 % interval of the prior


@style.styled
def sensitivity(table: pd.DataFrame, *, motion: str, misfit_p_value: float) -> Figure:
    """Draw intervals, p-values and probabilities of limits, operation by operation.

    Args:
        table: From :func:`breaker.decisions.over_scales`.
        misfit_p_value: Predictive p-value below which a record counts as misfit.
    """
    parameters = table[(table.kind == "parameter") & (table.name != "onset")]
    limits = table[table.kind == "limit"]
    names, of_limits = parameters.name.unique(), limits.name.unique()
    count = len(names) + 1 + len(of_limits)
    figure, axes = style.panels(count, columns=4, width=3.5, height=2.8)
    for axis, name in zip(axes, names, strict=False):
        _intervals(axis, parameters[parameters.name == name])
        style.label_parameter(axis, name)
        axis.set_ylabel("prior sd from its median")
    _p_values(axes[len(names)], parameters[parameters.name == names[0]], misfit_p_value)
    for axis, name in zip(axes[len(names) + 1 :], of_limits, strict=True):
        _dots(axis, limits[limits.name == name], "probability")
        axis.set(ylim=(-0.04, 1.04), ylabel="probability")
        axis.set_title(f"limit: {literal(name)}", loc="left")
    operations = np.sort(table.operation.unique())
    for axis in axes:
        axis.set_xticks(range(len(operations)), [str(each) for each in operations], rotation=45)
        axis.set_xlabel("operation")
        axis.grid(axis="x", visible=False)
    style.heading(figure, motion, "how conclusions move with the model's own error s")
    style.legend_below(figure, _handles(table))
    return figure


def _groups(rows: pd.DataFrame):
    """Yield place on the axis, look and rows of each scale."""
    place = {each: i for i, each in enumerate(np.sort(rows.operation.unique()))}
    scales = np.sort(rows.scale.unique())
    for i, scale in enumerate(scales):
        one = rows[rows.scale == scale]
        shift = _WIDTH * (i / max(1, len(scales) - 1) - 0.5)
        yield one.operation.map(place).values + shift, _look(i), one


def _look(i: int) -> dict:
    return {"color": _SHADES[i % len(_SHADES)], "marker": _MARKERS[i % len(_MARKERS)]}


def _intervals(axis: Axes, rows: pd.DataFrame) -> None:
    axis.axhspan(-_PRIOR, _PRIOR, color=style.PRIOR, alpha=0.2, lw=0)
    axis.axhline(0.0, color=style.REFERENCE, lw=0.6)
    for x, look, one in _groups(rows):
        axis.vlines(x, one.lower_z, one.upper_z, color=look["color"], lw=1.4)
        _marks(axis, x, one.median_z, one.resolved, look)
    if "truth_z" in rows:
        one = rows[rows.scale == rows.scale.min()].sort_values("operation")
        place = np.arange(len(one))
        ends = place - 0.6 * _WIDTH, place + 0.6 * _WIDTH
        axis.hlines(one.truth_z, *ends, color=style.MEASURED, lw=1.4)


def _p_values(axis: Axes, rows: pd.DataFrame, misfit_p_value: float) -> None:
    axis.axhline(misfit_p_value, color=style.WARNING, lw=0.9, ls=":")
    _dots(axis, rows.assign(p_value=rows.p_value.clip(lower=_FOOT)), "p_value")
    lowest = max(_FOOT, min(rows.p_value.min(), misfit_p_value / 10))
    axis.set(yscale="log", ylim=(lowest / 3, 3.0), ylabel="predictive p-value")
    axis.set_title("does the record fit?", loc="left")


def _dots(axis: Axes, rows: pd.DataFrame, column: str) -> None:
    for x, look, one in _groups(rows):
        _marks(axis, x, one[column], one.resolved, look)


def _marks(axis: Axes, x: np.ndarray, y: pd.Series, resolved: pd.Series, look: dict) -> None:
    """Full where the exact posterior was reached, empty where it was not."""
    there = resolved.values.astype(bool)
    for chosen, face in ((there, look["color"]), (~there, "white")):
        axis.plot(x[chosen], y.values[chosen], ls="", ms=4, mfc=face, mec=look["color"], **look)


def _handles(table: pd.DataFrame) -> list:
    scales = np.sort(table.scale.unique())
    words = {0.0: "s = 0: the model is right"}
    labels = [words.get(scale, f"s = {scale:g}") for scale in scales]
    handles = [style.line_key(label, ms=5, **_look(i)) for i, label in enumerate(labels)]
    return [
        *handles,
        not table.resolved.all() and style.dot_key("not resolved", mfc="white", ms=5),
        "truth_z" in table and style.line_key("truth of the stand-in", style.MEASURED),
        style.band_key("90 % of the prior", style.PRIOR, 0.2),
        style.line_key("misfit below", style.WARNING, ":", lw=0.9),
    ]
