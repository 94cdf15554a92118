"""What a service costs by its time: the least, how flat that is, and what is told."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.common.numerals import first_of
from breaker.figures import marks, style

_TITLE = "What a service costs, by the operation at which it is done"
_FLAT = 0.1  # services, within which an operation is as good as the best
_TOP = 1.2  # services that a panel shows, of what a service costs more than at the best operation
_BEYOND = 1.6  # times the way to the last that is as good, shown,
_LEAST = 20.0  # and at least so many operations
_BY = {"color": "#8A4B00", "lw": 1.6, "label": "service by"}
_LAST = {"color": style.WARNING, "lw": 1.2, "ls": "--", "label": "exceeded by here with 5 %"}


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
    note = ", ".join(style.spoken(name) for name in last["limit"].values[over])
    note = f"Exceeded, so service now: {note}." if note else ""
    if not shown.any():
        return marks.sentence(_TITLE, note or "Too little is known to draw.")
    last = last.isel(limit=np.flatnonzero(shown))
    each = [last.isel(limit=k) for k in range(last.sizes["limit"])]
    titles = [_words(one) for one in each]
    figure, axes = style.limit_panels(last, titles, height=2.7, sharex=False, sharey=False)
    for axis, one in zip(axes, each, strict=True):
        _limit(axis, one)
    for axis in (axis for axis in axes if axis.get_subplotspec().is_first_col()):
        axis.set_ylabel("services beyond the least")
    style.title(figure, f"{_TITLE}\n{_outcome(each)}")
    marks.legend(figure, columns=4)
    figure.legends[0].set_title(note)
    return figure


def _perhaps_exceeded(one: xr.Dataset) -> bool:
    """Whether a limit is exceeded already with 5 %: then service is due, whatever waiting costs."""
    return one["left"].values[0] == 0.0


def _best(one: xr.Dataset) -> float:
    """Operations ahead at which a service costs least; inf beyond the horizon."""
    ahead = one["ahead"].values
    best = float(ahead[int(one["extra"].values.argmin())])
    return np.inf if best == ahead[-1] else best


def _outcome(each: Sequence[xr.Dataset]) -> str:
    """Say which limit wants a service first, and when."""
    if due := [style.spoken(one["limit"].item()) for one in each if _perhaps_exceeded(one)]:
        return f"service now: {first_of(due, 2)} perhaps exceeded already"
    first = min(each, key=_best)
    now, best = float(first["operation"]), _best(first)
    if np.isinf(best):
        return f"as of operation {now:,.0f} nothing leads to a limit within the horizon"
    name, until = style.spoken(first["limit"].item()), now + _flat(first)[1]
    words = f"first is {name}: least at operation {now + best:,.0f}"
    return f"{words}; waiting until {until:,.0f} costs at most {_FLAT:g} services more"


def _flat(one: xr.Dataset) -> tuple[float, float]:
    """First and last of the operations ahead that are as good as the best, next to it."""
    ahead, good = one["ahead"].values, one["extra"].values <= _FLAT
    best = int(one["extra"].values.argmin())
    before, after = np.flatnonzero(~good[:best]), np.flatnonzero(~good[best:])
    first = before[-1] + 1 if before.size else 0
    last = best + after[0] - 1 if after.size else len(ahead) - 1
    return float(ahead[first]), float(ahead[last])


def _words(one: xr.Dataset) -> str:
    """Say where the least is, how flat, what operations cost then, and whether it is due."""
    ahead, (low, high), best = one["ahead"].values, _flat(one), _best(one)
    now, by = float(one["operation"]), one["service_by"].item()
    if _perhaps_exceeded(one):
        due = f"\ndue since {by:,.0f}" if by <= now else ""
        return f"perhaps exceeded already, so service now{due}"
    if np.isinf(best):
        return "nothing leads to it within the horizon"
    words, due = f"least at {now + best:,.0f}", f"due since {by:,.0f}; " if by <= now else ""
    if high < ahead[-1]:
        words += f"; {now + low:,.0f} to {now + high:,.0f} cost at most {_FLAT:g} more"
    return f"{words}\n{due}{1000.0 * one['rate'].item():.2g} services per 1,000 operations"


def _limit(axis: Axes, one: xr.Dataset) -> None:
    """Draw the cost, the operations that are as good as the best, and what is told."""
    now, ahead, extra = float(one["operation"]), one["ahead"].values, one["extra"].values
    look = {"color": style.MODEL, "lw": 1.8, "label": "cost beyond that of the best operation"}
    axis.plot(now + ahead, extra, **look)
    low, high = _flat(one)
    label = f"within {_FLAT:g} services of the least"
    axis.axvspan(now + low, now + high, color=style.CORRECTED, alpha=0.15, lw=0, label=label)
    for value, look in ((one["service_by"].item(), _BY), (now + one["left"].values[0], _LAST)):
        if now < value < np.inf:
            axis.axvline(value, **look)
    end = high * _BEYOND if high < ahead[-1] else ahead[-1]
    axis.set(xlim=(now, now + max(end, _LEAST)), ylim=(0.0, _TOP))
    axis.xaxis.get_major_locator().set_params(integer=True)
    axis.xaxis.set_major_formatter("{x:,.0f}")
