"""Two visits to a drive on one page: before, today, and the change of everything."""

from collections.abc import Mapping, Sequence
from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.figures import style

__all__ = ["visits"]

_WORDS = {"not told": "cannot be told"}
_COLOURS = {"changed": style.WARNING, "not told": style.PRIOR, "did not change": style.CORRECTED}
_LEFT = {"before": 0.72, "today": 0.98}  # of the texts beside the changes
_RIGHT = {"beyond": 0.5, "worse": 0.98}
_WIDEST = 4.0  # shares, that the axis shows at least
_MOST = 40.0  # percent, that it shows at most
_ROW, _LINE = 0.29, 0.2  # inches


@style.styled
def visits(document: Mapping) -> Figure:
    """Draw a comparison: see ``answers.visits_document``.

    A row for each parameter and quantity: medians before and today, the change with its 90 %
    interval, and how probable it is beyond the share, and to the worse. Closing and opening have a
    panel each where they are compared apart.
    """
    parts, share = document["comparisons"], 100.0 * document["settings"]["share"]
    rows = [[row for row in each["changes"] if row["change"][1] is not None] for each in parts]
    headline = fill(style.literal(document["headline"]), 108)
    about = [*document["trust"], _counted(document["records"])]
    trust = "\n".join(fill(style.literal(each), 140) for each in about)
    lines = 1.3 * (headline.count("\n") + 1) + trust.count("\n") + 2
    heights = [_ROW * (len(each) + 3.0) for each in rows]
    figure = style.new_figure(11.5, _LINE * lines + sum(heights) + 0.9)
    head, body = figure.subfigures(2, 1, height_ratios=[_LINE * lines, sum(heights) + 0.9])
    head.text(0.01, 0.97, headline, va="top", weight="bold", fontsize=11)
    head.text(0.01, 0.03, trust, va="bottom", fontsize=9)
    look = {"height_ratios": heights, "width_ratios": [1.5, 2.4, 0.6], "squeeze": False}
    prior = document["settings"]["prior_beyond"]
    for axes, each, of_part in zip(body.subplots(len(parts), 3, **look), parts, rows, strict=True):
        _changes(axes[1], of_part, share)
        _texts(axes, of_part, share, prior)
        axes[0].set_title(" and ".join(each["motions"]), loc="left")
        axes[1].set_xlabel("change since the first visit (%; over-travel, rebound: of the stroke)")
    style.legend_below(figure, _keys(share))
    return figure


def _changes(axis: Axes, rows: Sequence[Mapping], share: float) -> None:
    """Changes with their intervals, and as measured; parameters above quantities."""
    axis.axvspan(-share, share, color=style.PRIOR, alpha=0.15, lw=0)
    axis.axvline(0.0, color=style.REFERENCE, lw=0.8)
    farthest = 1.08 * max(max(map(abs, row["change"])) for row in rows)
    extent = min(max(farthest, _WIDEST * share), max(_MOST, _WIDEST * share))
    for y, row in enumerate(rows):
        low, middle, high = np.clip(row["change"], -extent, extent)
        axis.hlines(y, low, high, color=_COLOURS[row["verdict"]], lw=2.4)
        if abs(row["change"][1]) <= extent:
            axis.plot(middle, y, "o", color=_COLOURS[row["verdict"]], mec="white", ms=7)
        else:
            side = ("<", "left", 0.02) if middle < 0.0 else (">", "right", -0.02)
            axis.plot(middle, y, side[0], color=_COLOURS[row["verdict"]], ms=7, clip_on=False)
            said = f"{row['change'][1]:+.0f} %"
            axis.text(middle + 2 * side[2] * extent, y, said, ha=side[1], va="bottom", fontsize=8)
        measured = (row["measured"] or {}).get("change")
        if measured and abs(measured[1]) <= extent:
            axis.plot(measured[1], y, "x", color=style.MEASURED, ms=6, mew=1.4)
    axis.set_xlim(-extent, extent)


def _texts(axes: Sequence[Axes], rows: Sequence[Mapping], share: float, prior: float) -> None:
    """Names and values on the left, probabilities on the right."""
    left, _, right = axes
    first = sum(row["kind"] == "parameter" for row in rows)
    for axis in axes:
        axis.axhline(first - 0.5, color=style.REFERENCE, lw=0.6)
        axis.set(yticks=[], ylim=(len(rows) - 0.4, -1.6))
    for axis in (left, right):
        axis.set(xlim=(0.0, 1.0), xticks=[])
        axis.spines[:].set_visible(False)
    _cells(left, -1, {"before": "before", "today": "today"}, _LEFT, weight="bold")
    _cells(right, -1, {"beyond": f"P>{share:g} %", "worse": "P worse"}, _RIGHT, weight="bold")
    for y, row in enumerate(rows):
        bold = {"weight": "bold"} if row["verdict"] == "changed" else {}
        of = f", {row['motion']}" if row["name"] == "travel_time" else ""
        unit = "" if row["unit"] == "1" else f" ({row['unit']})"
        left.text(0.0, y, style.literal(f"{row['name']}{of}{unit}"), va="center", **bold)
        _cells(left, y, {key: f"{row[key][1]:.4g}" for key in ("before", "today")}, _LEFT)
        known = {key: row[key] for key in ("beyond", "worse") if row[key] is not None}
        _cells(right, y, {key: f"{each:.2f}" for key, each in known.items()}, _RIGHT, **bold)
    right.set_xlabel(f"a priori {prior:.2f}", fontsize=8)


def _cells(axis: Axes, y: float, texts: Mapping, places: Mapping, **look: object) -> None:
    for key, text in texts.items():
        axis.text(places[key], y, text, ha="right", va="center", fontsize=9, **look)


def _counted(records: Mapping) -> str:
    counts = [f"{m} {each['before']} before, {each['today']} today" for m, each in records.items()]
    return f"records: {'; '.join(counts)}"


def _keys(share: float) -> list:
    keys = [
        style.line_key(_WORDS.get(each, each), colour, marker="o", lw=2.4)
        for each, colour in _COLOURS.items()
    ]
    measured = style.dot_key("as measured", style.MEASURED, marker="x")
    return [*keys, measured, style.band_key(f"within {share:g} %", style.PRIOR, 0.15)]
