"""The first page: is it healthy, what is wearing, how long has it left."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from breaker.decisions import states, until, wearing

__all__ = ["verdict"]


def verdict(
    health: xr.Dataset,
    trend: xr.Dataset,
    trends: Mapping[str, xr.Dataset],
    decisions: pd.DataFrame,
    settings: Mapping,
) -> xr.Dataset:
    """Return the first page: three sentences, and how each limit stands after the last operation.

    Returns:
        Dataset over ``limit`` and ``quantile``: ``way``, percent of the way from the value in the
        baseline to the limit, ``remaining``, ``trend`` (whether one leads there), ``state`` and
        ``words``; attributes ``healthy``, ``wearing`` and ``left``.
    """
    every = states(health, trend, settings["notice"], settings["toward"])
    last = trend.isel(operation=-1)
    leads = last.toward.values >= settings["toward"]
    row = decisions.iloc[-1]
    return xr.Dataset(
        {
            "way": (("limit", "quantile"), _way(trend, settings["baseline"])),
            "remaining": (
                ("limit", "quantile"),
                last.remaining.transpose("limit", "quantile").values,
            ),
            "trend": ("limit", leads),
            "state": ("limit", every[-1].astype(str)),
            "words": ("limit", health.words.values),
        },
        coords={"limit": health.limit.values, "quantile": trend["quantile"].values},
        attrs={
            "healthy": _healthy(health, every[-1]),
            "wearing": _wearing(decisions, wearing(trends, int(row.operation), most=3)),
            "left": _left(row),
            "operation": int(row.operation),
        },
    )


def _way(trend: xr.Dataset, baseline: int) -> np.ndarray:
    """Percent of the way to each limit, ``(limit, 3)``, of its part that is farthest from it."""
    begin = min(baseline, trend.sizes["operation"]) - 1
    start = trend.value.isel(operation=begin).sel(quantile=0.5).values
    now = trend.value.isel(operation=-1).transpose("part", "quantile").values
    way = 100.0 * (now - start[:, None]) / (trend.part_bound.values - start)[:, None]
    way = np.sort(way, axis=1)
    result = []
    for limit in trend.limit.values:
        mine = way[trend.part_limit.values == limit]
        result.append(mine[mine[:, 1].argmin()])
    return np.array(result)


def _healthy(health: xr.Dataset, states_now: np.ndarray) -> str:
    over = [str(n) for n, s in zip(health.limit.values, states_now, strict=True) if s == "alarm"]
    operation = int(health.operation.values[-1])
    if over:
        when = health.first_alarm.sel(limit=over).min().item()
        since = f", since operation {when:.0f}" if np.isfinite(when) else ""
        return f"Not healthy at operation {operation}: {', '.join(over)} exceeded{since}."
    if all(state == "unknown" for state in states_now):
        return f"Unknown at operation {operation}: no operation could be used."
    return f"Healthy at operation {operation}: no limit exceeded."


def _wearing(decisions: pd.DataFrame, drifts: str) -> str:
    if not drifts:
        return "Wearing: no parameter that a trend could tell from none."
    noted = decisions.change[decisions.change != ""]
    since = f" Last change noticed: {noted.iloc[-1]}." if len(noted) else ""
    return f"Wearing, in 1,000 operations: {drifts}.{since}"


def _left(row: pd.Series) -> str:
    if row.state == "alarm":
        return "Left: nothing; service now."
    if not row.next_limit:
        return "Left: no trend leads to a limit."
    return (
        f"Left: {row.remaining_median:.0f} operations to {row.next_limit} "
        f"({row.remaining_5:.0f} to {until(row.remaining_95)}, 90 %)."
    )
