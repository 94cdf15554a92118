"""Each limit over the operations: chunks and sources joined.

A limit is read from the trend of both motions if there is one, that is if they agree on the
parameters in the reference, and from the trend of its own motion otherwise.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from breaker.decisions.changes import with_changes, with_steps
from breaker.mechanism import Limit

__all__ = ["complete", "join", "remaining"]


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


def remaining(
    trends: Mapping[str, xr.Dataset], limits: Sequence[Limit], operations: np.ndarray
) -> xr.Dataset:
    """Return the predictions of each limit, from the trend that it is read from.

    Args:
        trends: Trends by source. A limit is read from the first that has it.
        operations: Numbers of the operations; nan where a trend has none.

    Returns:
        Dataset over ``operation``, ``limit``, ``part`` and ``quantile``: ``remaining``, ``toward``,
        ``beyond`` and ``value`` of trends, and ``source`` and ``of`` of each limit; coordinate
        ``part_unit``.
    """
    chosen = []
    for limit in limits:
        source = next(name for name, one in trends.items() if limit.name in one.limit.values)
        one = trends[source][["remaining", "toward", "beyond", "value"]].sel(limit=[limit.name])
        one = one.isel(part=np.flatnonzero(one.part_limit.values == limit.name))
        about = {"source": source, "of": limit.of}
        one = one.assign({name: ("limit", [each]) for name, each in about.items()})
        units = dict(zip(limit.quantities, limit.units, strict=True))
        units = [units[str(quantity)] for quantity in one.part_quantity.values]
        one = one.assign_coords(part_unit=("part", units))
        chosen.append(one.reindex(operation=operations))
    parts = xr.concat(
        [one[["value"]].drop_dims("limit", errors="ignore") for one in chosen], "part"
    )
    rest = xr.concat([one.drop_dims("part") for one in chosen], "limit")
    sources = {str(each) for each in rest.source.values if each != "record"}
    attrs = dict(next(iter(trends.values())).attrs)
    return rest.merge(parts).assign_attrs(
        attrs | {"source": sources.pop() if len(sources) == 1 else "separate"}
    )
