"""When the level of a drive whose truth is known is beyond its limits: the stand-in's lives."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from breaker.model.limits import Limit
from breaker.model.parameters import NAMES

_NEW = 50  # first operations, that changes are from


def failures(truth: xr.Dataset, limits: Sequence[Limit]) -> dict[str, float]:
    """Return the operations at which a drive's level is first beyond each limit, nan if never.

    Quantities are those of the model at the true parameters, what records without noise show, or
    changes of the true parameters since the first operations, as each limit says.
    """
    operations = truth.operation.values.astype(float)
    known = _Truth(truth)
    over = {limit.name: (limit.read(known) > 0).all(axis=-1) for limit in limits}
    return {
        name: float(operations[each.argmax()]) if each.any() else np.nan
        for name, each in over.items()
    }


@dataclass(frozen=True)
class _Truth:
    """How far each part of a limit is exceeded, ``(operation, parts)``, by the limit's source."""

    truth: xr.Dataset

    def of_model(self, limit: Limit) -> np.ndarray:
        """What the model does not have is beyond any limit."""
        return np.nan_to_num(limit.excess(limit.evaluate(self.truth.value.values)), nan=np.inf)

    def of_change(self, limit: Limit) -> np.ndarray:
        """In percent since the first operations."""
        value = self.truth.value.values[:, [NAMES.index(name) for name in limit.quantities]]
        return limit.excess(100.0 * (value / value[:_NEW].mean(axis=0) - 1.0))

    def of_record(self, limit: Limit) -> np.ndarray:
        """Of what no record shows, nothing is known."""
        seen = self.truth.measured.sel(motion=limit.motion, quantity=list(limit.quantities))
        return limit.excess(seen.transpose("operation", "quantity").values)


def held(life: xr.Dataset, failure: np.ndarray) -> list[float]:
    """Return how often the told lives of limits hold the truth: shares of operations, ``(limit,)``.

    The share of the operations asked, from when limits are told until the drive is beyond a limit,
    at which the 90 % interval holds the true number left; nan where there are none.

    Args:
        life: What ``life_results.follow_life`` returns.
        failure: Operations at which the drive is first beyond each limit, ``(limit,)``.
    """
    told = life.sel(asked=slice(life.attrs["told"], None))
    asked, remaining = told.asked.values, told.remaining.transpose("limit", "asked", "quantile")
    shares = []
    for end, values in zip(failure, remaining.values, strict=True):
        some = (asked < end) & np.isfinite(values[:, 0])
        left, low, high = end - asked[some], values[some, 0], values[some, 2]
        shares.append(float(((low <= left) & (left <= high)).mean()) if some.any() else np.nan)
    return shares
