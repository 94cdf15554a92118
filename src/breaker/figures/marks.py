"""Marks that several figures of a life share: states, changes, and what is not told."""

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.common.numerals import first_of, in_digits
from breaker.drive.family.untold import APART, BEYOND, WITHHELD, as_sentence
from breaker.drive.life.limit_states import STATES
from breaker.figures import style

COLOURS = dict(zip(STATES, ("#5A5A5A", "#1B9E77", "#E08A00", style.WARNING), strict=True))
"""Colour of each state; the word always stands beside it."""

_CHANGE = "change, 90 % interval"
_LOOKS = {
    _CHANGE: {"color": "#7A35D0", "ls": "-", "label": _CHANGE},
    "known work": {"color": style.MEASURED, "ls": "--", "label": "known work"},
    "taken back": {"color": style.PRIOR, "ls": ":", "label": "change taken back"},
}
_NAMED = 4  # parameters in a title
_STRIP = 0.05  # height of the strip of states, share of the panel


def state_strip(axis: Axes, operation: np.ndarray, state: np.ndarray) -> None:
    """Colour the foot of a panel by the numbers of the states ``(o,)``."""
    for k, name in enumerate(STATES):
        look = {"ymax": _STRIP, "color": COLOURS[name], "label": f"state: {name}"}
        for start, stop in style.spans(operation, state == k):
            axis.axvspan(start, stop, lw=0, zorder=3, **look)


def legend(figure: Figure, *keys: Artist, columns: int) -> None:
    """Put one legend below the panels, of keys and of all that has a label, each once."""
    drawn = [axis.get_legend_handles_labels() for axis in figure.axes]
    found = {label: each for one in drawn for each, label in zip(*one, strict=True)}
    style.legend_below(figure, [*keys, *found.values()], columns=columns)


def change_lines(axis: Axes, life: xr.Dataset) -> None:
    """Draw the changes of a life with their 90 % intervals."""
    for k in range(life.sizes["change"]):
        change = life.isel(change=k)
        back, event = change["certainty"].item() < 0.0, change["kind"].item() == "event"
        look = _LOOKS["taken back" if back else "known work" if event else _CHANGE]
        axis.axvspan(change["earliest"], change["latest"], color=look["color"], alpha=0.15, lw=0)
        axis.axvline(change["start"].item(), lw=1.1, zorder=1.6, **look)


def untold(life: xr.Dataset) -> str:
    """Say why no change of a parameter is told; empty if some is."""
    if life["changed"].notnull().any():
        return ""
    alone = APART if life.attrs["agreement"] < 1.0 else WITHHELD
    why = BEYOND if life.attrs["family"] else alone
    return f"{as_sentence(why)}: changes of the parameters are not told."


def moved(life: xr.Dataset) -> str:
    """Say which parameters have changed for sure since new, and by how much, in percent."""
    low, middle, high = life["changed"].isel(asked=-1).transpose("quantile", ...).values
    sure = np.flatnonzero(low * high > 0.0)
    sure = sure[np.argsort(-np.abs(middle[sure]))]
    names = [style.OUTPUTS[str(name)].word for name in life["parameter"].values[sure]]
    values = [in_digits(value, 2, sign=True).replace("-", "−") for value in middle[sure]]
    each = [f"{name} {value} %" for name, value in zip(names, values, strict=True)]
    return first_of(each, _NAMED) or "no parameter has changed for sure"


def sentence(title: str, text: str) -> Figure:
    """Return a figure that says in one sentence why nothing is drawn."""
    figure = style.new_figure(10.0, 1.6)
    figure.suptitle(title)
    figure.text(0.5, 0.35, text, ha="center", fontsize=12)
    return figure
