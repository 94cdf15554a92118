"""When a drive whose effective values are known exceeds its limits: the stand-in's truth."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from breaker.decisions import first
from breaker.mechanism import NAMES, Limit, evaluate

__all__ = ["failures"]


def failures(effective: Mapping[str, xr.DataArray], limits: Sequence[Limit]) -> dict[str, float]:
    """Return the operations at which effective values first exceed each limit, nan if never.

    Args:
        effective: Effective values ``(stage, output)`` of each motion, with a coordinate
            ``operation (stage)``; between stages, quantities are interpolated.
        limits: The limits.

    Example:
        >>> new = np.array([2.0, 0.045, 0.040, 0.30, 0.12, 0.80, 10.0])
        >>> worn = new * [1, 1, 1, 1, 1, 0.9, 1]  # f falls from 0.80 to 0.72
        >>> stages = {"operation": ("stage", [1, 801])}
        >>> values = xr.DataArray(np.stack([new, worn]), dims=("stage", "output"), coords=stages)
        >>> failures({"closing": values}, [Limit("weak", "closing", (("f", 0.77, False),))])
        {'weak': 302.0}
    """
    result = {}
    for limit in limits:
        values = effective[limit.motion]
        operations = values.operation.values.astype(float)
        quantities = evaluate(limit.quantities, values.values[:, : len(NAMES)], limit.motion)
        every = np.arange(operations[0], operations[-1] + 1)
        along = np.stack([np.interp(every, operations, each) for each in quantities.T], axis=-1)
        result[limit.name] = first(limit.exceeded(along), every)
    return result
