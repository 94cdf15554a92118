"""Change points of the wear and steps: what is followed, since when it wears so, alarms."""

from textwrap import wrap

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.figures import style
from breaker.figures.truth import TRUTH, draw_truth, truth_key
from breaker.figures.words import symbolic

__all__ = ["change_words", "changepoint"]

_CHANGE = "#7A35D0"
_TITLE = "change points of the wear"
_FOLLOWED = "followed: the level of each parameter, without the scatter of single operations"
_NOT_FOLLOWED = (
    "Not followed together: closing and opening have different parameters at the beginning."
)
_STEP = {"color": style.MEASURED, "ls": ":", "lw": 1.6}
_LINES, _WIDTH = 12, 46  # lines beside the panels that describe steps and changes; characters


@style.styled
def changepoint(trend: xr.Dataset, *, source: str, truth: xr.DataArray | None = None) -> Figure:
    """Draw the levels that are followed with their changes, and how long the wear has been so.

    Args:
        trend: ``level`` and, of one motion, ``median`` ``(operation, parameter)``,
            ``level_interval (operation, parameter, bound)``, ``start_interval (operation,
            quantile)`` at 0.05, 0.5 and 0.95, when the present wear began, nan while no change is
            known, ``change_probability`` and ``alarm`` ``(operation)``; of each change
            ``change_alarm``, ``change_start`` and ``change_parameters``, what changed, ``(change)``
            and ``change_interval (change, bound)``, of each step ``jump_noticed``, ``jump_from``
            and ``jump_words`` ``(jump)``; attribute ``alarm_level``.
        source: Where the series come from: "closing", "opening" or "both".
        truth: True parameters of the stand-in, ``(operation, parameter)``; None for real
            measurements.

    Without an operation, the figure says so.
    """
    if trend.sizes["operation"] == 0:
        figure = style.new_figure(14.4, 2.2)
        style.heading(figure, source, _TITLE)
        figure.text(0.5, 0.4, _NOT_FOLLOWED, ha="center", fontsize=12)
        return figure
    names = [str(name) for name in trend["parameter"].values]
    rows = -(-(len(names) + 1) // 4)  # one place more, for the words
    figure = style.new_figure(14.4, 2.6 * rows + 4.9)
    grid = figure.add_gridspec(rows + 2, 4, height_ratios=(*[1.0] * rows, 0.75, 0.75))
    upper = [figure.add_subplot(grid[i // 4, i % 4]) for i in range(len(names))]
    words = figure.add_subplot(grid[len(names) // 4, len(names) % 4])
    ages = figure.add_subplot(grid[rows, :])
    probability = figure.add_subplot(grid[rows + 1, :])
    for axis, name in zip(upper, names, strict=True):
        _series(axis, trend.sel(parameter=name), name)
        draw_truth(axis, truth, name)
        _zoom(axis, trend.sel(parameter=name))
    _ages(ages, trend)
    _probability(probability, trend)
    ends = style.edges(trend["operation"].values)
    for axis in (*upper, ages, probability):
        _changes(axis, trend)
        axis.set(xlim=(ends[0], ends[-1]), xlabel="operation")
        axis.xaxis.set_major_formatter("{x:,.0f}")
    ages.set_xlabel("")
    ages.tick_params(labelbottom=False)
    _tell(words, trend)
    changes, steps = trend.sizes["change"], trend.sizes["jump"]
    found = f"{changes or 'no'} change{'s' * (changes > 1)} found"
    found += f", {steps} step{'s' * (steps > 1)}" if steps else ""
    style.heading(figure, source, _TITLE, f"{_FOLLOWED}\n{found}")
    style.legend_below(figure, _handles(trend, truth is not None), columns=5)
    return figure


def change_words(change: xr.Dataset) -> tuple[str, str]:
    """Describe a change: operation with its 90 % interval, and what changed."""
    lower, upper = change["change_interval"].values
    if not np.isfinite(change["change_start"].item()):
        return f"noticed at {change['change_alarm'].item():,}", "taken back by later operations"
    where = f"operation {change['change_start'].item():,.0f} ({lower:,.0f} to {upper:,.0f})"
    return where, symbolic(change["change_parameters"].item())


def _series(axis: Axes, one: xr.Dataset, name: str) -> None:
    operation, colour = one["operation"].values, style.colour(name)
    if "median" in one:
        dots = {"alpha": 0.3, "mew": 0, "ms": style.dot_size(operation.size)}
        axis.plot(operation, one["median"], "o", color=colour, **dots)
    low, high = (one["level_interval"].sel(bound=bound) for bound in ("lower", "upper"))
    axis.fill_between(operation, low, high, color=colour, alpha=0.3, lw=0)
    axis.plot(operation, one["level"], color=colour, lw=1.6)
    style.label_parameter(axis, name, fontsize=9.0)


def _changes(axis: Axes, trend: xr.Dataset) -> None:
    for i in range(trend.sizes["change"]):
        one = trend.isel(change=i)
        lower, upper = one["change_interval"].values
        axis.axvspan(lower, upper, color=_CHANGE, alpha=0.15, lw=0)
        axis.axvline(one["change_start"].item(), color=_CHANGE, lw=1.0, zorder=1.6)
    for operation in trend["jump_from"].values:
        axis.axvline(operation, **_STEP, zorder=1.7)


def _zoom(axis: Axes, one: xr.Dataset) -> None:
    """Show level, band and truth; dots, and the first band, which is the prior, may be cut off."""
    band = one["level_interval"].values
    drawn = [np.nanquantile(band, [0.02, 0.98]), one["level"].values]
    drawn += [line.get_ydata() for line in axis.lines if line.get_gid() == TRUTH]
    values = np.concatenate([np.asarray(each, dtype=float) for each in drawn])
    low, high = np.nanmin(values), np.nanmax(values)
    room = 0.06 * (high - low) or 1e-3 * abs(high) or 1.0
    axis.set_ylim(low - room, high + room)


def _ages(axis: Axes, trend: xr.Dataset) -> None:
    """Draw for how many operations the wear has been as it is, as was known at each operation."""
    operation = trend["operation"].values
    start = trend["start_interval"].transpose("operation", "quantile").values.copy()
    first_known = np.append(np.flatnonzero(np.isfinite(start[:, 1])), len(start))[0]
    start[:first_known] = operation[0]  # no change known: as from the beginning
    oldest, middle, youngest = (operation[:, None] - start).T
    axis.fill_between(operation, youngest, oldest, color=style.WARNING, alpha=0.2, lw=0)
    axis.plot(operation, middle, color=style.WARNING, lw=1.5)
    axis.set(ylim=(0.0, None), ylabel="operations")
    axis.yaxis.set_major_formatter("{x:,.0f}")
    axis.set_title("how long the wear has been as it is, as known at each operation", loc="left")


def _probability(axis: Axes, trend: xr.Dataset) -> None:
    axis.plot(trend["operation"], trend["change_probability"], color=style.MEASURED, lw=1.2)
    axis.axhline(trend.attrs["alarm_level"], color=style.REFERENCE, lw=1.0, ls="--")
    alarms = trend["operation"].values[trend["alarm"].values.astype(bool)]
    axis.plot(alarms, np.full(alarms.shape, 1.1), "v", color=style.WARNING, ms=8, mec="white")
    steps = trend["jump_noticed"].values
    axis.plot(steps, np.full(steps.shape, 1.32), "D", color=style.MEASURED, ms=7, mec="white")
    axis.set(ylim=(-0.05, 1.45 if steps.size else 1.2), yticks=[0.0, 0.5, 1.0])
    axis.set_ylabel("probability")
    axis.set_title("changed since the last alarm?", loc="left")


def _tell(axis: Axes, trend: xr.Dataset) -> None:
    """Write steps and changes in words, the first ones where there are many."""
    axis.set_axis_off()
    told = []
    for words in trend["jump_words"].values:
        first, *rest = wrap(str(words), _WIDTH)
        told.append([(first, "bold"), *((f"   {line}", "normal") for line in rest)])
    for i in range(trend.sizes["change"]):
        one = trend.isel(change=i)
        where, what = change_words(one)
        alarm = f"alarm at {one['change_alarm'].item():,.0f}"
        told.append([(where, "bold"), (f"   {what}; {alarm}" if what else f"   {alarm}", "normal")])
    lengths = np.cumsum([len(each) for each in told])
    shown = int((lengths <= _LINES).sum())
    lines = [line for each in told[:shown] for line in each] or [("No change found.", "normal")]
    if shown < len(told):
        lines.append((f"and {len(told) - shown} more", "normal"))
    place = {"xycoords": "axes fraction", "textcoords": "offset points", "va": "top"}
    for i, (text, weight) in enumerate(lines):
        below = (0, -13.5 * i)
        axis.annotate(text, (0.0, 1.0), xytext=below, weight=weight, fontsize=9, **place)


def _handles(trend: xr.Dataset, with_truth: bool) -> list:
    dots = "median of a single operation (pulled to the prior)"
    changes, steps = trend.sizes["change"], trend.sizes["jump"]
    return [
        "median" in trend and style.dot_key(dots, ms=4, alpha=0.4),
        style.line_key("level by the trend", lw=1.6),
        style.band_key("90 % interval of the level", style.REFERENCE, 0.3),
        with_truth and truth_key(),
        changes and style.line_key("change", _CHANGE, lw=1.0),
        changes and style.band_key("90 % interval of the change", _CHANGE, 0.15),
        steps and style.line_key("step", **_STEP),
        steps and style.dot_key("step noticed", style.MEASURED, "D", ms=7),
        style.line_key("operations since the last change", style.WARNING, lw=1.5),
        style.band_key("its 90 % interval", style.WARNING, 0.2),
        style.line_key(f"alarm level {trend.attrs['alarm_level']:g}", ls="--", lw=1.0),
        trend["alarm"].values.any() and style.dot_key("alarm", style.WARNING, "v", ms=8),
    ]
