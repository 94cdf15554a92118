"""When the level of a drive whose truth is known is beyond its limits: the stand-in's lives."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from breaker.decisions import first
from breaker.mechanism import Limit

__all__ = ["failures", "true_lives"]


def failures(truth: xr.DataArray, limits: Sequence[Limit]) -> dict[str, float]:
    """Return the operations at which a drive's level is first beyond each limit, nan if never.

    Quantities are those of the model at the true parameters, as they are everywhere; of what
    records show, nothing is known here, nan.

    Args:
        truth: True parameters ``(operation, parameter)``, with a coordinate ``operation``.
        limits: The limits.

    Example:
        >>> import numpy as np
        >>> new = np.array([2.0, 0.045, 0.040, 0.30, 0.12, 0.80, 10.0])
        >>> worn = new * [1, 1, 1, 1, 1, 0.9, 1]  # f falls from 0.80 to 0.72
        >>> operations = {"operation": np.arange(1, 802)}
        >>> values = np.linspace(new, worn, 801)
        >>> truth = xr.DataArray(values, dims=("operation", "parameter"), coords=operations)
        >>> failures(truth, [Limit("weak", "closing", (("f", 0.77, False),))])
        {'weak': 302.0}
    """
    operations = truth.operation.values.astype(float)
    result = {}
    for limit in limits:
        if limit.of == "model":
            over = limit.exceeded(limit.evaluate(truth.values))
            result[limit.name] = first(over, operations)
        else:
            result[limit.name] = np.nan
    return result


def true_lives(
    truth: xr.Dataset, limits: Sequence[Limit]
) -> dict[str, tuple[tuple[str, ...], list[float]]]:
    """Return ``failure`` and ``failure_without`` of each limit, to be assigned to a dataset.

    Args:
        truth: What ``truth_of`` returns.
        limits: The limits.

    Returns:
        Operations at which the level is first beyond each limit, and at which it would be if the
        wear had gone on as it began; the latter nan where it is the same.
    """
    ends = failures(truth.value, limits)
    steady = failures(truth.without_change.rename(longer="operation"), limits)
    without = [np.nan if steady[name] == end else steady[name] for name, end in ends.items()]
    return {"failure": (("limit",), list(ends.values())), "failure_without": (("limit",), without)}
