"""Probability that limits are exceeded, operation by operation, and the state of each."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.drive.life.first_page import exceeded, in_percent
from breaker.drive.life.limit_states import STATES
from breaker.figures import marks, style

_QUARTERS = (0.25, 0.75)  # something happens where a probability crosses one of these
_BEFORE = 0.5  # operations shown before that, share of those after it,
_LEAST = 0.05  # and at least this share of all
_OVER = {"color": style.WARNING, "lw": 1.4}


@style.styled
def health(life: xr.Dataset, standing: xr.Dataset) -> Figure:
    """Draw one panel per limit: how probably it is exceeded, and its state in a strip below.

    The operations shown begin a little before anything happens; all of them, if nothing does.

    Args:
        life: What ``life_results.follow_life`` returns.
        standing: What ``decisions.standing`` returns.
    """
    operation, first = standing["operation"].values, _begin(life, standing)
    shown = standing.isel(operation=slice(first, None))
    titles = [str(words) for words in life["words"].values]
    figure, axes = style.limit_panels(shown, titles, height=2.5, above=1)
    for j, axis in enumerate(axes):
        _limit(axis, shown.isel(limit=j))
        axis.set_ylabel("probability")
    axes[0].set(ylim=(-0.13, 1.05), yticks=np.linspace(0.0, 1.0, 6))
    axes[0].xaxis.set_major_formatter("{x:,.0f}")
    over = int(standing["certain"].notnull().sum())
    count = f"{over} of {len(axes)} limits are exceeded" if over else "no limit is exceeded"
    words = f"Health: {count} after operation {operation[-1]:,}\nprobability that each is exceeded"
    if first:
        words += f", from operation {operation[first]:,}; nothing happened before"
    style.title(figure, words)
    marks.legend(figure, columns=4)
    return figure


def _begin(life: xr.Dataset, standing: xr.Dataset) -> int:
    """Return the index of the operation from which on to draw."""
    operation = standing["operation"].values
    told = operation >= life.attrs["told"]
    quarter = np.digitize(standing["beyond"].fillna(0.0), _QUARTERS)
    stirs = (quarter != quarter[told.argmax()]) | (standing["state"].values >= STATES.index("plan"))
    stirs = stirs.any(axis=1) & told
    if not stirs.any():
        return 0
    begin, count = int(stirs.argmax()), len(operation)
    return max(0, round(begin - max(_BEFORE * (count - begin), _LEAST * count)))


def _limit(axis: Axes, one: xr.Dataset) -> None:
    """Draw probability, state, and since when the limit is exceeded."""
    operation, state = one["operation"].values, one["state"].values
    look = {"lw": 1.8, "ms": 2.0, "mew": 0, "label": "probability"}
    axis.plot(operation, one["beyond"], ".-", color=style.MODEL, **look)
    marks.state_strip(axis, operation, state)
    certain, crossed = one["certain"].item(), one["crossed"].item()
    name, beyond = STATES[state[-1]], one["beyond"].values[-1]
    words = f"{name}: {in_percent(beyond)} beyond it" if np.isfinite(beyond) else name
    if np.isfinite(certain):
        axis.axvline(crossed, ls=":", label="crossed: likelier than not from here on", **_OVER)
        axis.axvline(certain, label="certain from here on", **_OVER)
        words = exceeded(certain, crossed)
    above = {"xycoords": "axes fraction", "xytext": (0, 5), "textcoords": "offset points"}
    axis.annotate(words, (0.0, 1.0), color=marks.COLOURS[name], weight="bold", **above)
