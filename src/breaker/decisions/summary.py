"""The first page: what to do, what is wearing, how long has it left, is the model close?"""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from breaker.decisions.actions import recent
from breaker.decisions.alarms import latest
from breaker.decisions.dates import FARTHEST
from breaker.decisions.trust import beyond_family, trust_sentence, untold
from breaker.decisions.wearing import drifts, rates
from breaker.decisions.wording import about, and_so_on, span

__all__ = ["verdict"]

_NAMED = 4  # limits in a sentence


def verdict(
    judged: xr.Dataset,
    left: xr.Dataset,
    trends: Mapping[str, xr.Dataset],
    decisions: pd.DataFrame,
    trust: pd.DataFrame,
    *,
    baseline: int,
) -> xr.Dataset:
    """Return the first page: four sentences, and the state of each limit after the last operation.

    Args:
        judged, left, trust: As of ``decide``.
        trends: As of ``drifts``.
        decisions: What ``decide`` returns.
        baseline: First operations, after which the way to a limit begins.

    Returns:
        Dataset over ``limit`` and ``quantile``: ``way``, percent of the way from the value in the
        baseline to the limit, ``remaining``, as told, ``state``, ``since`` and ``words``;
        attributes ``headline``, ``wearing``, ``left``, ``trust`` and ``operation``.
    """
    last, row = judged.isel(operation=-1, drop=True), decisions.iloc[-1]
    noted = recent(decisions.change, judged.operation.values, within=np.inf)[-1]
    return xr.Dataset(
        {
            "way": (("limit", "quantile"), _way(left, baseline)),
            "remaining": last.told,
            "state": last.state.astype(str),
            "since": last.since,
            "words": last.words,
        },
        attrs={
            "headline": _headline(row, judged, trust, noted),
            "wearing": _wearing(row, trends, judged.operation.values, noted),
            "left": _left(judged, row),
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
    values = trend.value.transpose("operation", "part", "quantile").values
    last = latest(np.isfinite(values[..., 1]))[-1]
    now = values[np.maximum(last, 0), np.arange(known.shape[1])]
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


def _headline(row: pd.Series, judged: xr.Dataset, trust: pd.DataFrame, noted: str) -> str:
    """Say what to do, what cannot be told, and whether the model can be relied on."""
    words = row.to_do[0].upper() + row.to_do[1:]
    if row.action in ("none", "watch"):
        words = f"{row.state.capitalize()}: {row.to_do}"
    else:
        words = words.removesuffix(f"; {noted}")  # the next sentence ends with it
    doubts = [each for each in untold(judged)[-1] if each.rsplit(" (", 1)[0] != row.limit]
    cannot = f" Cannot tell {and_so_on(doubts, _NAMED)}." if doubts and row.limit else ""
    unlike = " Intervals cannot be relied on: see trust." if beyond_family(trust) else ""
    return f"{words}.{cannot}{unlike} As of operation {row.operation:,}."


def _wearing(
    row: pd.Series, trends: Mapping[str, xr.Dataset], operations: np.ndarray, noted: str
) -> str:
    """Say what wears, how fast, and what was last noticed."""
    if row.state == "unknown":
        return "Wearing: unknown."
    since = f" Last change noticed: {noted}." if noted else ""
    steepest = rates(trends, drifts(trends, operations))
    if not steepest:
        return f"Wearing: nothing that a trend could tell from none.{since}"
    return f"Wearing, in 1,000 operations: {steepest}.{since}"


def _left(judged: xr.Dataset, row: pd.Series) -> str:
    """Say how many operations are left to the limits that trends lead to, the next one first."""
    if row.state == "unknown":
        return "Left: unknown."
    told, names = judged.told.isel(operation=-1).values, judged.limit.values
    over = judged.exceeded.values[-1]
    order = np.lexsort((told[:, 1], told[:, 0]))
    coming = [
        f"{names[j]} {about(told[j, 1])} ({span(told[j, 0], told[j, 2])})"
        for j in order
        if not over[j] and not np.isnan(told[j, 1])
    ]
    nothing = "nothing to the limits exceeded" if over.any() else ""
    words = "; ".join(filter(None, [nothing, and_so_on(coming, _NAMED)]))
    if not words:
        return "Left: no trend leads to a limit."
    days = ""
    if 0 < row.days_left < FARTHEST:
        between = span(row.days_left_5, row.days_left_95)
        days = f" At the recent rate {row.limit} in {about(row.days_left)} days ({between})."
    return f"Left, operations (90 %): {words}.{days}"
