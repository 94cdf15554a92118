"""Operations left until a limit is exceeded, over the life of the drive."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.drive.life.first_page import about, in_percent, span
from breaker.drive.life.limit_states import STATES
from breaker.figures import marks, style

_TRUTH = {"ls": "--", "label": "truth"}
_WITHOUT = {"ls": ":", "label": "truth without the change, until it comes"}
_SERVICE = {"color": "#8A4B00", "lw": 1.4, "drawstyle": "steps-post"}
_USUAL = 0.95  # share of the medians that a panel shows at least
_TITLE = "Operations left until a limit is exceeded"


@style.styled
def remaining_life(
    life: xr.Dataset, standing: xr.Dataset, truth: xr.Dataset | None = None
) -> Figure:
    """Draw one panel per limit: operations left, by when to service, and the true ones.

    Args:
        life: What ``life_results.follow_life`` returns.
        standing: What ``decisions.standing`` returns.
        truth: Of a stand-in, ``failure`` and ``failure_without`` ``(limit)``, the operation at
            which the drive is first beyond the limit, nan if it is not, and at which it would be
            without the change of its wear, nan where that is the same, and ``changed``, the
            operation of that change, nan without one, and ``held`` ``(limit)``, what
            ``failure_times.held`` returns; None for real measurements.
    """
    known = (standing["state"] > STATES.index("unknown")).any("operation").values
    vague = ", ".join(style.spoken(name) for name in standing["limit"].values[~known])
    note = f"Too little is known to draw: {vague}." if vague else ""
    if not known.any():
        return marks.sentence(_TITLE, note)
    told = life.sel(asked=slice(life.attrs["told"], None)).isel(limit=known)
    standing = standing.isel(limit=known)
    titles = told["words"].values.astype(object)
    if truth is not None:
        truth = truth.sel(limit=told["limit"].values)
        titles += [_held(truth.isel(limit=j)) for j in range(len(titles))]
    figure, axes = style.limit_panels(told, titles, height=3.0, sharey=False)
    for j, axis in enumerate(axes):
        lines = [] if truth is None else _truths(truth.isel(limit=j), life["operation"].values)
        _limit(axis, told["remaining"].isel(limit=j), standing.isel(limit=j), lines)
        axis.set_ylabel("operations left")
    axes[0].xaxis.set_major_formatter("{x:,.0f}")
    style.title(figure, f"{_TITLE}{_outcome(standing.isel(operation=-1), truth)}")
    marks.legend(figure, columns=4)
    figure.legends[0].set_title(note)
    return figure


def _held(one: xr.Dataset) -> str:
    """Say how often what is told of a limit holds the truth."""
    if np.isnan(one["failure"].item()):
        return "; in truth not reached"
    if np.isnan(one["held"].item()):
        return "\nexceeded before anything is told"
    return f"\nthe interval holds the truth at {in_percent(one['held'].item())} of the operations"


def _outcome(last: xr.Dataset, truth: xr.Dataset | None) -> str:
    """Say how well the truth is told, or which limit is the next."""
    if truth is not None and (shares := truth["held"].values[truth["held"].notnull()]).size:
        ends = " to ".join(in_percent(each) for each in (shares.min(), shares.max()))
        return f"\n90 % intervals hold the truth at {ends} of the operations, limit by limit"
    middle = last["left"].values[:, 1]
    if not np.isfinite(middle).any():
        return ""
    k = int(np.nanargmin(middle))
    low, _, high = last["left"].values[k]
    left = f"{about(middle[k])} ({span(low, high)})"
    return f"\nnext: {style.spoken(last['limit'].values[k])}, operations left: {left}"


def _truths(one: xr.Dataset, operation: np.ndarray) -> list[tuple[np.ndarray, np.ndarray, dict]]:
    """Return operations, what was left then, and looks: with the change, and without until it."""
    failure, without = one["failure"].item(), one["failure_without"].item()
    each = (failure, failure + 1, _TRUTH), (without, one["changed"].item(), _WITHOUT)
    there = [(end, operation[operation < to], look) for end, to, look in each if np.isfinite(end)]
    return [(before, end - before, look) for end, before, look in there]


def _limit(axis: Axes, told: xr.DataArray, standing: xr.Dataset, truths: list) -> None:
    """Draw band and median, by when to service, truths, and states at the foot."""
    low, middle, high = told.transpose("quantile", "asked").values
    usual = np.nanquantile(np.append(middle[np.isfinite(middle)], 1.0), _USUAL)
    top = 1.25 * max(usual, *(left.max(initial=0.0) for _, left, _ in truths), 1.0)
    low, high = (np.minimum(each, 10.0 * top) for each in (low, high))  # goes on past the panel
    look = {"color": style.CORRECTED, "label": "90 % interval"}
    axis.fill_between(told["asked"].values, low, high, lw=0.6, alpha=0.25, **look)
    look = {"lw": 1.8, "ms": 3.0, "mew": 0, "label": "median"}
    axis.plot(told["asked"], middle, ".-", color=style.CORRECTED, **look)
    operation, state = standing["operation"].values, standing["state"].values
    service = _service(standing)
    label = "until the service" if np.isfinite(service).any() else None
    axis.plot(operation, service, label=label, **_SERVICE)
    for at, left, line in truths:
        axis.plot(at, left, color=style.MEASURED, lw=1.2, zorder=2.5, **line)
    marks.state_strip(axis, operation, state)
    axis.set_ylim(-0.06 * top, top)
    if not np.isfinite(middle).any() and not truths:
        axis.set_yticks([])
        place = {"transform": axis.transAxes, "ha": "center", "color": style.REFERENCE}
        axis.text(0.5, 0.5, "beyond the horizon, or not told, at all operations", **place)
    axis.yaxis.set_major_formatter("{x:,.0f}")


def _service(standing: xr.Dataset) -> np.ndarray:
    """Return the operations until the service where one is planned and no limit exceeded yet."""
    ahead = np.maximum(standing["service_by"] - standing["operation"], 0.0)
    over = standing["left"].isel(quantile=-1) == 0.0
    return ahead.where(np.isfinite(ahead) & ~over).values
