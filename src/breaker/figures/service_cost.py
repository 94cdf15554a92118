"""What a service costs by its time: the least, how flat that is, and what is told."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.drive.life.first_page import about
from breaker.figures import marks, style

_TITLE = "Expected cost of a service, by its operation"
_FLAT = 0.1  # services, within which an operation is as good as the best
_TOP = 1.2  # services that a panel shows, of what a service costs more than at the best operation
_BEYOND = 1.6  # times the way to the last that is as good, shown
_BY = {"color": "#8A4B00", "lw": 1.6, "label": "service by"}
_LAST = {"color": style.WARNING, "lw": 1.2, "ls": "--", "label": "exceeded by 5 %"}


@style.styled
def service_cost(standing: xr.Dataset) -> Figure:
    """Draw one panel per limit that is known: what a service costs more than at the best time.

    Args:
        standing: What ``limit_states.standing`` returns; of the last operation.
    """
    last = standing.isel(operation=-1)
    over = last["certain"].notnull().values
    shown = (
        last["extra"].notnull().all("ahead").values & ~over & last["left"].notnull().all("quantile")
    )
    note = ", ".join(style.literal(name) for name in last["limit"].values[over])
    note = f"Exceeded, so service now: {note}." if note else ""
    if not shown.any():
        return marks.sentence(_TITLE, note or "Too little is known to draw.")
    last = last.isel(limit=np.flatnonzero(shown))
    titles = [_words(last.isel(limit=k)) for k in range(last.sizes["limit"])]
    figure, axes = style.limit_panels(last, titles, height=2.7, sharey=False)
    for k, axis in enumerate(axes):
        _limit(axis, last.isel(limit=k))
        axis.set_ylabel("services")
    ends = [_flat(last.isel(limit=k))[1] for k in range(last.sizes["limit"])]
    finite = [end for end in ends if end < float(last["ahead"][-1])]
    end = min(_BEYOND * max(finite, default=float(last["ahead"][-1])), float(last["ahead"][-1]))
    now = float(last["operation"])
    axes[0].set_xlim(now, now + max(end, 10.0))
    axes[0].xaxis.set_major_formatter("{x:,.0f}")
    figure.suptitle(f"{_TITLE}: beside the best one, as of operation {now:,.0f}")
    marks.legend(figure, columns=4)
    figure.legends[0].set_title(note)
    return figure


def _flat(one: xr.Dataset) -> tuple[float, float]:
    """First and last of the operations ahead that are as good as the best, next to it."""
    ahead, good = one["ahead"].values, one["extra"].values <= _FLAT
    best = int(one["extra"].values.argmin())
    before, after = np.flatnonzero(~good[:best]), np.flatnonzero(~good[best:])
    first = before[-1] + 1 if before.size else 0
    last = best + after[0] - 1 if after.size else len(ahead) - 1
    return float(ahead[first]), float(ahead[last])


def _words(one: xr.Dataset) -> str:
    """Say where the least is, and how flat."""
    ahead, (low, high) = one["ahead"].values, _flat(one)
    now, best = float(one["operation"]), float(ahead[int(one["extra"].values.argmin())])
    if one["left"].values[0] == 0.0:
        return "perhaps exceeded already, so service now"
    if best == ahead[-1]:
        return "nothing leads to it within the horizon"
    words = f"least at {about(now + best)}, within {_FLAT:g} from {about(now + low)}"
    rate = 1000.0 * one["rate"].item()
    words += f" to {about(now + high)}" if high < ahead[-1] else " on"
    return f"{words}; {rate:.2g} per 1,000 operations"


def _limit(axis: Axes, one: xr.Dataset) -> None:
    """Draw the cost, the operations that are as good as the best, and what is told."""
    now, ahead, extra = float(one["operation"]), one["ahead"].values, one["extra"].values
    look = {"color": style.MODEL, "lw": 1.8, "label": "cost beyond that of the best operation"}
    axis.plot(now + ahead, extra, **look)
    low, high = _flat(one)
    label = f"within {_FLAT:g} services of the least"
    axis.axvspan(now + low, now + high, color=style.CORRECTED, alpha=0.15, lw=0, label=label)
    for value, look in ((one["service_by"].item(), _BY), (now + one["left"].values[0], _LAST)):
        if np.isfinite(value):
            axis.axvline(value, **look)
    axis.set_ylim(0.0, _TOP)
