"""Two visits to a drive on one page: what is measured then and now, and what is inferred of it."""

from collections.abc import Mapping, Sequence
from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.common.numerals import in_digits
from breaker.drive.answers.visit_changes import QuantityChange
from breaker.drive.answers.visit_document import VisitDocument, visits_said
from breaker.drive.family.untold import WITHHELD
from breaker.figures import style

_WORDS, _FACES = {"not told": "? cannot be told"}, {"not told": "white"}
_COLOURS = {"changed": style.WARNING, "not told": style.PRIOR, "did not change": style.CORRECTED}
_LEFT = {"before": 0.76, "today": 0.98}  # of the texts beside the changes
_MEANING = 0.4
_RIGHT = {"unchanged": 0.28, "beyond": 0.6, "worse": 1.0}
_TITLES = {
    "told": "inferred",
    "apart": "inferred of each motion alone; they contradict each other",
    "withheld": f"parameters are withheld: {WITHHELD}",
}
_WIDEST = 4.0  # shares, that the axis shows at least
_MOST = 40.0  # percent, that it shows at most
_GOES_ON = style.dot_key("goes on beyond the axis", marker=">", ms=7)
_ROW, _LINE = 0.29, 0.2  # inches


@style.styled
def visits(document: VisitDocument) -> Figure:
    """Draw a comparison.

    A row for each quantity that is measured, then for each parameter and time that is inferred: the
    change with its 90 % interval, and how probable it is that there is none, that it is beyond the
    share, and that it is beyond it to the worse. Of what is measured also the values.
    """
    share, rows = 100.0 * document.settings.share, document.changes
    first = len(document.measured)
    places = {y + 1 + (y >= first): row for y, row in enumerate(rows)}
    titles = {0: "measured", first + 1: _TITLES.get(document.parameters, "no parameter is told")}
    said, about = visits_said(document)
    headline = "\n".join(fill(style.literal(each), 112) for each in said)
    trust = "\n".join(fill(style.literal(each), 145) for each in about)
    head = _LINE * (0.95 * headline.count("\n") + 0.8 * trust.count("\n") + 2.6)
    body = _ROW * (len(rows) + 4.0) + 0.9
    figure = style.new_figure(11.5, head + body)
    above, below = figure.subfigures(2, 1, height_ratios=[head, body])
    above.text(0.01, 0.97, headline, va="top", weight="bold", fontsize=10.5)
    above.text(0.01, 0.03, trust, va="bottom", fontsize=9)
    left, middle, right = below.subplots(1, 3, width_ratios=[1.9, 2.2, 0.9])
    for axis in (left, middle, right):
        axis.set(yticks=[], ylim=(len(rows) + 1.6, -1.6))
    for axis in (left, right):
        axis.set(xlim=(0.0, 1.0), xticks=[])
        axis.spines[:].set_visible(False)
    for y, title in titles.items():
        left.text(0.0, y, title, va="center", weight="bold")
        for axis in (left, middle, right):
            axis.axhline(y - 0.5, color=style.REFERENCE, lw=0.6)
    _changes(middle, places, share)
    _texts(left, right, places, share)
    middle.set_xlabel("change since the first visit (%)")
    cut = [line for line in middle.lines if line.get_marker() in ("<", ">")]
    style.legend_below(figure, [*_keys(share), *[_GOES_ON] * bool(cut)])
    return figure


def _changes(axis: Axes, places: Mapping[int, QuantityChange], share: float) -> None:
    """Changes with their intervals."""
    axis.axvspan(-share, share, color=style.PRIOR, alpha=0.15, lw=0)
    axis.axvline(0.0, color=style.REFERENCE, lw=0.8)
    farthest = 1.08 * max((abs(x) for row in places.values() for x in row.change), default=0.0)
    extent = min(max(farthest, _WIDEST * share), max(_MOST, _WIDEST * share))
    for y, row in places.items():
        low, middle, high = np.clip(row.change, -extent, extent)
        colour, marker = _COLOURS[row.verdict], "s" if row.measured else "o"
        axis.hlines(y, low, high, color=colour, lw=2.4)
        if abs(row.change[1]) <= extent:
            edges = {"mfc": "white"} if _alone(row) or _vague(row) else {"mec": "white"}
            axis.plot(middle, y, marker, color=colour, ms=11 if _vague(row) else 7, **edges)
            if _vague(row):
                look = {"fontsize": 7.5, "weight": "bold", "color": style.REFERENCE}
                axis.text(middle, y, "?", ha="center", va="center_baseline", **look)
        _clipped(axis, y, row.change, extent, colour)
    axis.set_xlim(-extent, extent)


def _vague(row: QuantityChange) -> bool:
    """Whether it cannot be told if it changed."""
    return row.verdict == "not told"


def _clipped(axis: Axes, y: int, change: Sequence[float], extent: float, colour: str) -> None:
    """Point to what is beyond the axis, and say how far."""
    low, middle, high = change
    sides = [-1] * (low < -extent) + [1] * (high > extent)
    for sign in sides:
        marker = "<" if sign < 0 else ">"
        axis.plot(sign * extent, y, marker, color=colour, ms=8, clip_on=False, zorder=3)
    if sides:
        at = sides[-1] if middle > 0.0 else sides[0]
        said = f"{middle:+.0f} % ({low:+.0f} to {high:+.0f})".replace("-", "−")
        place = {"xytext": (-7 * at, 4), "textcoords": "offset points"}
        axis.annotate(said, (at * extent, y), ha="left" if at < 0 else "right", fontsize=8, **place)


def _alone(row: QuantityChange) -> bool:
    """Whether it is of one motion, which the other contradicts."""
    return row.kind == "parameter" and bool(row.motion)


def _texts(left: Axes, right: Axes, places: Mapping[int, QuantityChange], share: float) -> None:
    """Names and values on the left, probabilities on the right."""
    _cells(left, -1, {"before": "before", "today": "today"}, _LEFT, weight="bold")
    titles = {"unchanged": "P same", "beyond": f"P>{in_digits(share, 4)} %", "worse": "P worse"}
    _cells(right, -1, titles, _RIGHT, weight="bold")
    for y, row in places.items():
        bold = {"weight": "bold"} if row.sure and not _alone(row) else {}
        of = f", {row.of}" if row.of else ""
        unit = f" ({row.unit})" if row.measured else ""
        name = style.literal(f"{row.name}{of}{unit}")
        left.text(0.03, y, name, va="center", fontsize=9, **bold)
        if row.measured:
            _cells(left, y, {key: in_digits(getattr(row, key), 4) for key in _LEFT}, _LEFT)
        else:
            left.text(_MEANING, y, row.meaning, va="center", fontsize=8)
        values = {key: getattr(row, key) for key in _RIGHT}
        known = {key: f"{each:.2f}" for key, each in values.items() if each is not None}
        _cells(right, y, known, _RIGHT, **bold)


def _cells(axis: Axes, y: float, texts: Mapping, places: Mapping, **look: object) -> None:
    for key, text in texts.items():
        axis.text(places[key], y, text, ha="right", va="center", fontsize=9, **look)


def _keys(share: float) -> Sequence:
    look = {"marker": "o", "lw": 2.4}
    keys = [
        style.line_key(_WORDS.get(each, each), colour, mfc=_FACES.get(each, colour), **look)
        for each, colour in _COLOURS.items()
    ]
    return [*keys, style.band_key(f"within {in_digits(share, 4)} %", style.PRIOR, 0.15)]
