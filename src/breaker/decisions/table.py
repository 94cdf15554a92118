"""From trends and probabilities to decisions: is it healthy, what is wearing, how long has it left.

Joins what single operations say (``condition``) with what trends say (``trend``). A limit is read
from both motions where they agree on the parameters in the baseline, and from its own motion
otherwise; once decided, for the whole series.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import xarray as xr

from breaker.decisions.alarms import first, raised
from breaker.mechanism import Limit

__all__ = [
    "STATES",
    "complete",
    "decide",
    "health",
    "in_doubt",
    "join",
    "remaining",
    "states",
    "until",
    "wearing",
]

_SETTLED = 100  # operations after its alarm at which a change is told
_SURE = 2.69 / 1.645  # of half a 90 % interval: 5 % for seven parameters together
MAY_BE, _IS = 0.05, 0.95  # probability that a limit is exceeded by the trend, to say so

STATES = ("unknown", "healthy", "wearing", "alarm")


def join(parts: Sequence[xr.Dataset]) -> xr.Dataset:
    """Put the chunks of a series into one dataset."""
    return xr.concat(
        parts, dim="operation", data_vars="minimal", join="exact", combine_attrs="override"
    )


def complete(trend: xr.Dataset, medians: np.ndarray, settings: Mapping, source: str) -> xr.Dataset:
    """Add what a whole trend tells of its changes.

    Args:
        trend: What ``trend.Follower.follow`` returns, all operations.
        medians: Posterior medians of single operations, ``(o, p)``, nan where there is none.
        settings: The section ``wear_model`` of the configuration.
        source: "closing", "opening" or "both".

    Returns:
        ``trend`` with ``median``; over ``change``: ``change_alarm``, ``change_start``,
        ``change_interval (change, bound)`` and ``change_kind (change, kind)``, as known a hundred
        operations after its alarm, or before the next.
    """
    found = np.flatnonzero(trend.alarm.values)
    last = np.append(found[1:] - 1, trend.sizes["operation"] - 1)[: found.size]
    last = np.minimum(last, found + _SETTLED)  # later ones are told apart less and less
    starts = trend.start_interval.values[last]
    return trend.assign(
        median=(("operation", "parameter"), medians),
        change_alarm=("change", trend.operation.values[found]),
        change_start=("change", starts[:, 1]),
        change_interval=(("change", "bound"), starts[:, [0, 2]]),
        change_kind=(("change", "kind"), trend.kind_probability.values[last]),
    ).assign_attrs(
        source=source,
        alarm_level=settings["alarm_level"],
        horizon=settings["horizon"],
        notice=settings["notice"],
        toward_level=settings["toward"],
    )


def remaining(
    trends: Mapping[str, xr.Dataset], limits: Sequence[Limit], *, fused: bool
) -> xr.Dataset:
    """Return what trends say of each limit, from the source that it is read from.

    Returns:
        Dataset over ``operation``, ``limit``, ``part`` and ``quantile``: ``remaining``, ``toward``,
        ``beyond`` and ``value`` of trends, and ``source (limit)``.
    """
    names = ["remaining", "toward", "beyond", "value"]
    chosen = []
    for limit in limits:
        source = "both" if fused else limit.motion
        one = trends[source][names].sel(limit=[limit.name])
        one = one.isel(part=np.flatnonzero(one.part_limit.values == limit.name))
        chosen.append(one.assign(source=("limit", [source])))
    every = sorted(set().union(*(one.operation.values.tolist() for one in chosen)))
    chosen = [one.reindex(operation=every) for one in chosen]
    parts = xr.concat(
        [one[["value"]].drop_dims("limit", errors="ignore") for one in chosen], "part"
    )
    rest = xr.concat([one.drop_dims("part") for one in chosen], "limit")
    sources = {str(each) for each in rest.source.values}
    attrs = dict(next(iter(trends.values())).attrs)
    return rest.merge(parts).assign_attrs(
        attrs | {"source": sources.pop() if len(sources) == 1 else "separate"}
    )


def health(condition: xr.Dataset, trend: xr.Dataset, alarm: Mapping, *, fused: bool) -> xr.Dataset:
    """Return probabilities of limits and alarms over the operations.

    Args:
        condition: What ``condition.condition`` returns, all operations.
        trend: What ``remaining`` returns.
        alarm: The section ``alarm`` of the configuration.
        fused: Whether limits are read from both motions.

    Returns:
        Dataset over ``operation`` and ``limit``: ``probability``, ``marginal``,
        ``trend_probability`` and ``alarm``; ``first_alarm``, ``words`` and ``source`` of each
        limit. An operation whose motions do not agree counts by the limit's own motion.
    """
    own = condition.sel(evidence="own")
    data = own[["probability", "marginal"]]
    if fused:
        both = condition.sel(evidence="both")[["probability", "marginal"]]
        data = xr.where(condition.agree & both.probability.notnull(), both, data)
    data = data.transpose("operation", "limit").drop_vars("evidence", errors="ignore")
    on = np.stack(
        [
            raised(column, raise_at=alarm["raise"], clear_at=alarm["clear"], after=alarm["after"])
            for column in data.probability.values.T
        ],
        axis=-1,
    )
    operations = data.operation.values
    beyond = trend.beyond.reindex(operation=operations)
    return data.assign(
        trend_probability=beyond.transpose("operation", "limit"),
        alarm=(("operation", "limit"), on),
        first_alarm=("limit", np.array([first(column, operations) for column in on.T])),
        words=("limit", condition.words.values),
        source=("limit", trend.source.values),
    ).assign_attrs(alarm)


# ---- what to do ------------------------------------------------------------------------------


def states(health: xr.Dataset, trend: xr.Dataset, toward: float) -> np.ndarray:
    """Return the state of each limit after each operation, ``(o, limit)``, one of ``STATES``."""
    operations = health.operation.values
    trend = trend.reindex(operation=operations)
    early = trend.remaining.isel(quantile=0).transpose("operation", "limit").values
    leads = trend.toward.transpose("operation", "limit").values >= toward
    known = np.isfinite(trend.beyond.transpose("operation", "limit").values)
    beyond = trend.beyond.transpose("operation", "limit").values
    result = np.where(known, "healthy", "unknown").astype(object)
    result[known & leads & np.isfinite(early)] = "wearing"
    result[beyond >= MAY_BE] = "wearing"
    result[health.alarm.values | (beyond >= _IS)] = "alarm"
    return result


def decide(
    health: xr.Dataset,
    trend: xr.Dataset,
    trends: Mapping[str, xr.Dataset],
    curves: Mapping[str, xr.Dataset],
    settings: Mapping,
) -> pd.DataFrame:
    """Return one row an operation: what is known, what changed, what to do when.

    Args:
        health: What ``health`` returns.
        trend: What ``remaining`` returns.
        trends: Whole trends by source, those that limits are read from.
        curves: Results of each motion, with ``accepted`` and ``resolved``.
        settings: The section ``wear_model`` of the configuration.
    """
    operations = health.operation.values
    every = states(health, trend, settings["toward"])
    left = trend.reindex(operation=operations)
    quantiles = left.remaining.transpose("operation", "limit", "quantile").values
    leads = left.toward.transpose("operation", "limit").values >= settings["toward"]
    names = health.limit.values
    early, median = (
        np.where(leads & np.isfinite(each), each, np.inf)
        for each in np.moveaxis(quantiles, -1, 0)[:2]
    )
    soonest = early.argmin(axis=1)
    nearest = np.where(np.isfinite(median.min(axis=1)), median.argmin(axis=1), soonest)
    drifts = wearing(trends, operations)
    doubtful = in_doubt(health)
    rows = []
    noted = _changes(trends, operations)
    used = {key: _flags(data, operations) for key, data in curves.items()}
    for i, operation in enumerate(operations):
        state = max(every[i], key=STATES.index)
        limit, first_to_come = names[nearest[i]], soonest[i]
        has_life = np.isfinite(early[i, nearest[i]])
        ends = quantiles[i, nearest[i]] if has_life else np.full(3, np.nan)
        over = [str(name) for name, each in zip(names, every[i], strict=True) if each == "alarm"]
        rows.append(
            {
                "operation": operation,
                "state": state,
                "limits_exceeded": "; ".join(over),
                "next_limit": limit if has_life else "",
                "remaining_5": ends[0],
                "remaining_median": ends[1],
                "remaining_95": ends[2],
                "wearing": drifts[i],
                "change": noted[i],
                "action": _action(
                    state,
                    *(over, doubtful[i], limit if has_life else "", ends),
                    *(names[first_to_come], early[i, first_to_come], settings["notice"]),
                ),
                "not_used": "; ".join(f"{m}: {flags[i]}" for m, flags in used.items() if flags[i]),
            }
        )
    return pd.DataFrame(rows)


def wearing(
    trends: Mapping[str, xr.Dataset], operations: Sequence[int], *, most: int | None = None
) -> list[str]:
    """Say which parameters drift at each operation, by percent in 1,000 operations.

    Those whose slope is not none at 5 % for all parameters together, the steepest ones first,
    in each source at most ``most``.
    """
    words = [[] for _ in operations]
    for source, trend in trends.items():
        place = {int(number): i for i, number in enumerate(trend.operation.values)}
        names, slopes = trend.parameter.values, trend.slope.values
        half = np.diff(trend.slope_interval.values, axis=-1)[..., 0] / 2.0
        sure = np.abs(slopes) > _SURE * half
        order = np.argsort(-np.abs(slopes), axis=-1, kind="stable")
        for told, operation in zip(words, operations, strict=True):
            if (i := place.get(int(operation))) is None:
                continue
            drifts = [f"{names[j]} {_percent(slopes[i, j])}" for j in order[i] if sure[i, j]]
            if drifts:
                told.append(f"{source}: {', '.join(drifts[:most])}")
    return ["; ".join(told) for told in words]


def _percent(value: float) -> str:
    return f"{value:+.0f} %" if abs(value) >= 10 else f"{value:+.2g} %"


def _changes(trends: Mapping[str, xr.Dataset], operations: np.ndarray) -> list[str]:
    """What changed, noted at the operation of the alarm, ``(o,)``."""
    noted = {int(operation): [] for operation in operations}
    for source, trend in trends.items():
        for k, operation in enumerate(trend.change_alarm.values):
            kind = trend.change_kind.values[k]
            low, high = trend.change_interval.values[k]
            if not np.isfinite(trend.change_start.values[k]):
                noted[int(operation)].append(f"{source}: a change that later ones took back")
                continue
            name = trend.kind.values[kind.argmax()]
            noted[int(operation)].append(
                f"{source}: change of {name} at about {trend.change_start.values[k]:.0f} "
                f"({low:.0f} to {high:.0f})"
            )
    return ["; ".join(words) for words in noted.values()]


def _flags(data: xr.Dataset, operations: np.ndarray) -> list[str]:
    """Why an operation says nothing, or less, ``(o,)``; empty where all is well."""
    by_number = {int(number): i for i, number in enumerate(data.operation.values)}
    words = []
    for operation in operations:
        i = by_number.get(int(operation))
        if i is None:
            words.append("no record")
        elif not data.accepted.values[i]:
            words.append("rejected")
        elif not data.resolved.values[i]:
            words.append("not resolved")
        else:
            words.append("")
    return words


def _action(
    state: str,
    over: Sequence[str],
    doubtful: Sequence[str],
    limit: str,
    ends: np.ndarray,
    soonest: str,
    earliest: float,
    notice: float,
) -> str:
    """Say what to do: of the limit that may come first, of the one that is to come first."""
    if state == "alarm":
        return f"service now: {', '.join(over)} exceeded"
    if state == "unknown":
        return "cannot tell: no usable operation yet"
    if earliest <= notice:
        return f"plan service within {max(earliest, 0):.0f} operations, before {soonest}"
    if doubtful:
        return f"look closer: {', '.join(doubtful)} may be exceeded"
    if state == "wearing" and limit:
        span = f"{ends[0]:.0f} to {until(ends[2])}"
        return f"go on; {limit} in {until(ends[1])} operations ({span})"
    return "go on"


def in_doubt(health: xr.Dataset) -> list[list[str]]:
    """Limits that may be exceeded by the trend, though it is not certain, of each operation."""
    beyond = health.trend_probability.transpose("operation", "limit").values
    names = health.limit.values
    return [[str(n) for n in names[(row >= MAY_BE) & (row < _IS)]] for row in beyond]


def until(value: float) -> str:
    """Write a number of operations that may be beyond the horizon."""
    return f"{value:.0f}" if np.isfinite(value) else "beyond the horizon"
