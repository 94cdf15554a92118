"""Each limit over the operations: chunks and sources joined, probabilities and alarms.

Joins the probabilities of single operations (``conditions``) with the trends. A limit is read from
the trend of both motions if there is one, that is if they agree on the parameters in the
reference, and from the trend of its own motion otherwise.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from breaker.decisions.alarms import first, raised
from breaker.decisions.changes import with_changes, with_steps
from breaker.mechanism import Limit

__all__ = ["complete", "health", "join", "remaining"]


def join(parts: Sequence[xr.Dataset]) -> xr.Dataset:
    """Put the chunks of a series into one dataset."""
    return xr.concat(
        parts, dim="operation", data_vars="minimal", join="exact", combine_attrs="override"
    )


def complete(trend: xr.Dataset, settings: Mapping, source: str) -> xr.Dataset:
    """Add the changes and steps that a whole trend found.

    Args:
        trend: What ``Follower.follow`` returns, all operations.
        settings: The section ``wear_model`` of the configuration.
        source: "closing", "opening" or "both".

    Returns:
        ``trend`` with the changes of ``with_changes`` over ``change``, the steps of ``with_steps``
        over ``jump``, and the settings that its figures show.
    """
    return with_changes(with_steps(trend)).assign_attrs(
        source=source,
        alarm_level=settings["alarm_level"],
        horizon=settings["horizon"],
        notice=settings["notice"],
        toward_level=settings["toward"],
    )


def remaining(trends: Mapping[str, xr.Dataset], limits: Sequence[Limit]) -> xr.Dataset:
    """Return the predictions of each limit, from the trend that it is read from.

    Args:
        trends: Trends by source: that of "both", or those of all motions.
        limits: The limits.

    Returns:
        Dataset over ``operation``, ``limit``, ``part`` and ``quantile``: ``remaining``, ``toward``,
        ``beyond`` and ``value`` of trends, and ``source (limit)``.
    """
    chosen = []
    for limit in limits:
        source = "both" if "both" in trends else limit.motion
        one = trends[source][["remaining", "toward", "beyond", "value"]].sel(limit=[limit.name])
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


def health(condition: xr.Dataset, trend: xr.Dataset, alarm: Mapping) -> xr.Dataset:
    """Return probabilities of limits and alarms over the operations.

    Args:
        condition: What ``condition`` returns, all operations.
        trend: What ``remaining`` returns.
        alarm: The section ``alarm`` of the configuration.

    Returns:
        Dataset over ``operation`` and ``limit``: ``probability`` and ``marginal`` by single
        operations, ``trend_probability`` and ``alarm``; ``first_alarm``, ``words`` and ``source``
        of each limit.
    """
    data = condition[["probability", "marginal"]].transpose("operation", "limit")
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
