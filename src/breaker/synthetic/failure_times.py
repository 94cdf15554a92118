"""When a drive whose true parameters are known exceeds its limits: the stand-in's truth."""

from collections.abc import Sequence

import xarray as xr

from breaker.decisions import first
from breaker.mechanism import Limit

__all__ = ["failures"]


def failures(truth: xr.DataArray, limits: Sequence[Limit]) -> dict[str, float]:
    """Return the operations at which a drive first exceeds each limit, nan if never.

    Quantities are those of the model at the true parameters, as they are everywhere.

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
        result[limit.name] = first(limit.exceeded(limit.evaluate(truth.values)), operations)
    return result
