"""The first page: is it healthy, what is wearing, how long has it left, is the model close?"""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from breaker.decisions.table import in_doubt, states, until, wearing
from breaker.decisions.trust import trust_sentence

__all__ = ["verdict"]


def verdict(
    health: xr.Dataset,
    trend: xr.Dataset,
    trends: Mapping[str, xr.Dataset],
    decisions: pd.DataFrame,
    trust: pd.DataFrame,
    settings: Mapping,
) -> xr.Dataset:
    """Return the first page: four sentences, and the state of each limit after the last operation.

    Args:
        health, trend, trends: As of ``decide``.
        decisions: What ``decide`` returns.
        trust: What ``trust_table`` returns.
        settings: The section ``wear_model`` of the configuration.

    Returns:
        Dataset over ``limit`` and ``quantile``: ``way``, percent of the way from the value in the
        baseline to the limit, ``remaining``, ``trend`` (whether one leads there), ``state`` and
        ``words``; attributes ``healthy``, ``wearing``, ``left`` and ``trust``.
    """
    every = states(health, trend, settings["toward"])
    last = trend.isel(operation=-1)
    leads = last.toward.values >= settings["toward"]
    row, doubts = decisions.iloc[-1], in_doubt(health, trends, settings["notice"])
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
            "healthy": _healthy(health, every[-1], doubts[-1]),
            "wearing": _wearing(decisions, wearing(trends, [int(row.operation)], most=3)[0], row),
            "left": _left(row),
            "trust": trust_sentence(trust),
            "operation": int(row.operation),
        },
    )


def _way(trend: xr.Dataset, baseline: int) -> np.ndarray:
    """Percent of the way to each limit, ``(limit, 3)``, of its part that is farthest from it."""
    begin = min(baseline, trend.sizes["operation"]) - 1
    medians = trend.value.isel(operation=slice(begin, None)).sel(quantile=0.5)
    known = medians.transpose("operation", "part").values
    start = known[np.isfinite(known).argmax(axis=0), np.arange(known.shape[1])]
    now = trend.value.isel(operation=-1).transpose("part", "quantile").values
    bound = trend.part_bound.values
    way = 100.0 * (now - start[:, None]) / (bound - start)[:, None]
    # There is no way from beyond a limit to it: it is gone, as long as the drive is beyond.
    sign = np.where(trend.part_upper.values, 1.0, -1.0)
    gone = np.where(sign[:, None] * (now - bound[:, None]) > 0, 100.0, 0.0)
    way = np.sort(np.where((sign * (start - bound) > 0)[:, None], gone, way), axis=1)
    result = []
    for limit in trend.limit.values:
        mine = way[trend.part_limit.values == limit]
        result.append(mine[mine[:, 1].argmin()])
    return np.array(result)


def _healthy(health: xr.Dataset, states_now: np.ndarray, doubts: str) -> str:
    over = [str(n) for n, s in zip(health.limit.values, states_now, strict=True) if s == "alarm"]
    operation = int(health.operation.values[-1])
    if over:
        raised = [when for name in over if (when := _raised(health.sel(limit=name))) is not None]
        since = f", since operation {min(raised)}" if raised else ""
        return f"Not healthy at operation {operation}: {', '.join(over)} exceeded{since}."
    if doubts:
        return f"In doubt at operation {operation}: {doubts}."
    unknown = [n for n, s in zip(health.limit.values, states_now, strict=True) if s == "unknown"]
    if len(unknown) == health.sizes["limit"]:
        return f"Unknown at operation {operation}: no operation could be used."
    but = f"; nothing is known of {', '.join(unknown)}" if unknown else ""
    return f"Healthy at operation {operation}: no limit exceeded{but}."


def _raised(one: xr.Dataset) -> int | None:
    """Operation at which the alarm that is on now was raised, None if none is on."""
    on = one.alarm.values
    if not on[-1]:
        return None
    off = np.flatnonzero(~on)
    return int(one.operation.values[off[-1] + 1 if off.size else 0])


def _wearing(decisions: pd.DataFrame, drifts: str, row: pd.Series) -> str:
    if row.state == "unknown":
        return "Wearing: unknown."
    told = [each for cell in decisions.change for each in cell.split("; ")]
    noted = [each for each in told if each and "took back" not in each]
    since = f" Last change noticed: {noted[-1]}." if noted else ""
    if not drifts:
        return f"Wearing: no parameter that a trend could tell from none.{since}"
    return f"Wearing, in 1,000 operations: {drifts}.{since}"


def _left(row: pd.Series) -> str:
    if row.state == "alarm":
        return "Left: nothing; service now."
    if row.state == "unknown":
        return "Left: unknown."
    if not row.next_limit:
        return "Left: no trend leads to a limit."
    return (
        f"Left: {until(row.remaining_median)} operations to {row.next_limit} "
        f"({row.remaining_5:.0f} to {until(row.remaining_95)}, 90 %)."
    )
