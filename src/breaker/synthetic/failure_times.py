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
