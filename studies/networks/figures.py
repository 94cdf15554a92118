"""Networks side by side, and posteriors of records with missing samples."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullFormatter, StrMethodFormatter

from breaker.figures import style
from breaker.figures.validation import draw_ranks, rank_keys
from breaker.paper.validation.calibration import Calibration

__all__ = ["missing", "networks"]

# Column, that of its standard error, words, and how its axis runs: as the values do, from 0 (large
# numbers), over the share from 0 to 1, or logarithmically.
_MEASURES = (
    ("held_out_log_density", "held_out_log_density_se", "held-out log density (nats)", "free"),
    ("gap_nats", "gap_se", "gap to the exact posterior (nats)", "free"),
    ("efficiency_median", None, "median efficiency", "share"),
    ("calibration_p", None, "calibration, p of all outputs", "share"),
    ("draws_per_second", None, "draws per second, one core", "logarithmic"),
    ("training_seconds", None, "training, s of processor time", "from 0"),
    ("weights", None, "weights", "from 0"),
)


@style.styled
def networks(table: pd.DataFrame, *, motion: str) -> Figure:
    """Draw one panel a measure, one row a network.

    Args:
        table: Rows of ``table.network_row``. What is nan in it is "not known" in the figure.
    """
    figure, axes = style.panels(len(_MEASURES), width=3.6, height=0.42 * len(table) + 1.4)
    names = table.network.str.replace("_", " ").to_numpy()
    rows = np.arange(len(table))[::-1]
    poor = ~table.calibrated.to_numpy(dtype=bool)
    for i, (axis, (column, error, words, run)) in enumerate(zip(axes, _MEASURES, strict=True)):
        values = table[column].to_numpy(dtype=float)
        if error is not None:
            error = {"xerr": 2 * table[error], "fmt": "none"}
            axis.errorbar(values, rows, color=style.REFERENCE, lw=1, **error)
        warned = poor & (column == "calibration_p")
        marks = np.where(warned, style.WARNING, style.AMORTISED)
        axis.scatter(values, rows, c=marks, s=36, zorder=3)
        if column == "gap_nats":
            axis.axvline(0.0, color=style.REFERENCE, lw=0.9, ls="--")
        _run(axis, values, run)
        axis.set(xlabel=words, ylim=(-0.6, len(rows) - 0.4))
        axis.set_yticks(rows, names if i % 4 == 0 else [""] * len(rows))
        _numbers(axis, values, rows)
    density = table.held_out_log_density.fillna(-np.inf).to_numpy()
    best = names[density.argmax()] if np.isfinite(density).any() else "not known"
    style.heading(figure, motion, "networks side by side", f"highest held-out log density: {best}")
    warned = poor.any() and style.dot_key("not calibrated", style.WARNING, ms=6)
    handles = [style.line_key("two standard errors", lw=1), style.line_key("no gap", ls="--")]
    style.legend_below(figure, [*handles, warned])
    return figure


def _run(axis: Axes, values: np.ndarray, run: str) -> None:
    """Scale an axis of values, with room for the numbers at its ends."""
    known = values[np.isfinite(values)]
    if not known.size:
        axis.set(xlim=(-0.1, 1.1), xticks=[])
    elif run == "share":
        axis.set(xlim=(-0.1, 1.1), xticks=np.linspace(0.0, 1.0, 6))
    elif run == "logarithmic":
        axis.set_xscale("log")
        axis.set_xlim(known.min() / 4, 4 * known.max())  # at least one power of ten
        axis.xaxis.set_minor_formatter(NullFormatter())
    elif run == "from 0":
        axis.set_xlim(-0.1 * known.max(), 1.2 * known.max())
        axis.xaxis.set_major_locator(MaxNLocator(4))
        axis.xaxis.set_major_formatter(StrMethodFormatter("{x:,.0f}"))
    else:
        axis.margins(x=0.15)


def _numbers(axis: Axes, values: np.ndarray, rows: np.ndarray) -> None:
    """Write each value above its mark, and where there is none, that it is not known."""
    above = {"xytext": (0, 7), "textcoords": "offset points", "ha": "center", "fontsize": 8}
    for row, value in zip(rows, values, strict=True):
        if np.isfinite(value):
            axis.annotate(_number(value), (value, row), **above)
        else:
            words = "not known" if np.isnan(value) else f"{value}"
            axis.annotate(words, (0.5, row), xycoords=axis.get_yaxis_transform(), **above)


def _number(value: float) -> str:
    size = abs(value)
    if size >= 99.5:
        return f"{value:,.0f}"
    if size >= 1.0:
        return f"{value:#.3g}"
    return f"{value:.2f}" if size >= 0.1 else f"{value:.2g}"


@style.styled
def missing(
    calibration: Calibration,
    amortised: np.ndarray,
    exact: np.ndarray,
    names: Sequence[str],
    *,
    motion: str,
    share: float,
) -> Figure:
    """Draw calibration, and how much wider posteriors are, with samples missing at random.

    Args:
        calibration: Of the ranks with missing samples.
        amortised, exact: Ratio of posterior sds with missing samples to those without, of the
            network and of the exact posterior: 5 %, 50 % and 95 % over curves and the number of
            curves, ``(4, q)``; the number is 0 where there is none.
        names: Names of the ``q`` outputs.
        share: Share of the samples that is missing.
    """
    q = len(names)
    figure = style.new_figure(12.0, 5.2)
    left, right = figure.subplots(1, 2, width_ratios=[1.3, 1.0])
    draw_ranks(left, calibration, dict(enumerate(names)))
    left.set(xlabel="rank of the truth / (draws + 1)", ylabel="ECDF difference")
    left.set_title("calibrated?", loc="left")
    left.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=9)  # beside all lines

    rows = np.arange(q)[::-1]
    handles = rank_keys(calibration)[1:]
    for ratios, mark, shift, whose in (
        (amortised, style.AMORTISED, 0.14, "network"),
        (exact, style.CORRECTED, -0.14, "exact posterior"),
    ):
        style.draw_intervals(right, rows + shift, ratios[:3], color=mark, lw=2, alpha=0.5)
        label = f"{whose}: median, 5 to 95 % ({ratios[3].min():.0f} curves)"
        handles.append(style.line_key(label, mark, marker="o", lw=2))
    right.axvline(1.0, color=style.REFERENCE, lw=0.9, ls="--")
    right.set_yticks(rows, style.symbols(names))
    right.set(xlabel="posterior sd with missing samples / with all", ylim=(-0.6, q - 0.4))
    right.set_title("wider where it should be?", loc="left")

    text = f"{100 * share:g} % of the samples missing at random"
    title = style.heading(figure, motion, text, calibration.words(style.symbols(names)))
    if calibration.outside.any():
        title.set_color(style.WARNING)
    style.legend_below(figure, handles)
    return figure
