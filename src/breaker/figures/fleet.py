"""A fleet at a glance: how far each drive is off its type, parameter by parameter."""

from collections.abc import Mapping, Sequence
from itertools import cycle, islice

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from breaker.drive.answers.type_model import TypeOfBreaker
from breaker.drive.fleet.drive_document import DIFFERENT
from breaker.figures import style
from breaker.model.parameters import NAMES

_NAMED = 12  # odd drives whose names are written
_WIDTH = 0.7  # of the strip of a parameter
_FARTHEST = 60.0  # percent, that is drawn
# Types have shades and shapes: colours mean parameters, in every figure.
_SHADES, _SHAPES = ("#000000", "#6A6A6A", "#A8A8A8"), "o^sDv"


@style.styled
def fleet(
    table: pd.DataFrame,
    drives: Sequence[tuple[str, str]],
    types: Mapping[str, tuple[np.ndarray, TypeOfBreaker]],
) -> Figure:
    """Draw every drive's parameters off the median of its type, percent; odd ones by name, and
    those that were measured differently as crosses.

    Args:
        table: What ``ranking.fleet_table`` returns.
        drives: Breaker and phase of each, which indices of ``types`` count.
        types: What ``ranking.learn_types`` returns.
    """
    figure = style.new_figure(11.0, 5.5)
    axis = figure.subplots()
    odd = {(e.breaker, e.phase): e.odd for e in table.itertuples() if e.odd}
    unlike = {(e.breaker, e.phase) for e in table.itertuples() if e.state == DIFFERENT}
    count = max(len(types), 1)
    looks = list(islice(zip(cycle(_SHADES), cycle(_SHAPES)), len(types)))
    for t, (where, learned) in enumerate(types.values()):
        shade, shape = looks[t]
        for k, parameter in enumerate(NAMES):
            spread = np.linspace(-0.4, 0.4, len(where)) / count
            x = k + _WIDTH * (spread + (t + 0.5) / count - 0.5)
            y = np.clip(100.0 * learned.off[:, k], -_FARTHEST, _FARTHEST)
            look = {"color": shade, "alpha": 0.7, "ls": ""}
            crossed = np.array([drives[i] in unlike for i in where], bool)
            axis.plot(x[~crossed], y[~crossed], marker=shape, ms=4.0, mew=0, **look)
            axis.plot(x[crossed], y[crossed], marker="x", ms=5.0, mew=1.2, **look)
            for i, drive in enumerate(where):
                of = drives[drive]
                if odd.get(of) == parameter:
                    axis.plot(x[i], y[i], "o", mfc="none", mec=style.WARNING, ms=9, mew=1.6)
                    if len(odd) <= _NAMED:
                        said = style.literal(" ".join(filter(None, of)))
                        axis.annotate(said, (x[i], y[i]), (6, 3), textcoords="offset points")
    axis.axhline(0.0, color=style.REFERENCE, lw=0.8)
    axis.set(xticks=range(len(NAMES)), ylabel="off the median of the type (%)")
    axis.set_xticklabels(style.symbols(NAMES))
    style.title(figure, f"{len(table)} drives beside their type: {len(odd)} odd")
    keys = [
        style.dot_key(style.literal(name or "all drives"), *look)
        for name, look in zip(types, looks, strict=True)
    ]
    ring = Line2D([], [], ls="", marker="o", mfc="none", mec=style.WARNING, mew=1.6, label="odd")
    cross = Line2D([], [], ls="", marker="x", color=style.REFERENCE, label=DIFFERENT)
    style.legend_below(figure, [*keys, *[ring] * bool(odd), *[cross] * bool(unlike)])
    return figure
