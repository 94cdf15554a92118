"""The condition of the drive at single operations: how probably each limit is exceeded.

From the operation alone, in the motion that a limit is about: from its posterior, with all
correlations, or from what its record itself shows. What came before is for trends.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from breaker.mechanism import NAMES, Limit

__all__ = ["align", "condition", "usable"]


def align(parts: Sequence[xr.Dataset], operations: np.ndarray) -> xr.Dataset:
    """Return the operations of given numbers of one motion, from chunks that hold them.

    Numbers that no chunk has are there as missing values, not accepted.
    """
    whole = xr.concat(parts, dim="operation", join="exact", combine_attrs="override")
    whole = whole.sel(operation=whole.operation.isin(operations))
    flags = ("accepted", "resolved")
    names = ["travel", "draws", *flags, *(n for n in ("measured", "measured_sd") if n in whole)]
    filled = whole[names].reindex(
        operation=operations, fill_value={name: False for name in flags} | {"travel": np.nan}
    )
    return filled.assign({name: filled[name].astype(bool) for name in flags})


def usable(data: xr.Dataset) -> np.ndarray:
    """Say which operations have an exact posterior, ``(o,)``; an unresolved one does not count."""
    found = np.isfinite(data.draws.values).all(axis=(1, 2))
    return data.accepted.values & data.resolved.values & found


def condition(data: Mapping[str, xr.Dataset], limits: Sequence[Limit]) -> xr.Dataset:
    """Judge operations by their own posteriors.

    Args:
        data: What ``align`` returns, of each motion, for the same operations.
        limits: Limits of these motions.

    Returns:
        Dataset over ``operation`` and ``limit``: ``probability`` that a limit is exceeded,
        ``marginal``, the same as if its quantities were independent, and ``undefined``, the share
        of draws in which one of them does not exist; all nan where there is no posterior. Of a
        limit on measured quantities, whose errors are taken for independent, ``probability`` and
        ``marginal`` are the same, and nan where the record does not show one of them.

    Example:
        >>> wide = Limit("wide", "opening", (("L", 10.0, True),))
        >>> draws = np.ones((1, 4, 7))  # of one operation
        >>> draws[..., 6] = [9.9, 10.1, 10.2, 10.3]  # mm
        >>> data = xr.Dataset(
        ...     {"draws": (("operation", "draw", "output"), draws)}
        ...     | dict.fromkeys(("accepted", "resolved"), ("operation", [True])),
        ...     {"operation": [1]},
        ... )
        >>> condition({"opening": data}, [wide]).probability.item()
        0.75
    """
    operations = next(iter(data.values())).operation.values
    names = ("probability", "marginal", "undefined")
    found = {name: np.full((len(operations), len(limits)), np.nan) for name in names}
    for j, limit in enumerate(limits):
        one = data[limit.motion]
        if limit.of == "record":
            found["probability"][:, j] = found["marginal"][:, j] = _measured(one, limit)
            continue
        there = usable(one)
        draws = one.draws.values[there].astype(np.float64)[..., : len(NAMES)]
        values = limit.evaluate(draws.reshape(-1, len(NAMES)))
        exceedance = limit.exceedance(values.reshape(*draws.shape[:2], len(limit.parts)))
        for name, each in zip(names, exceedance, strict=True):
            found[name][there, j] = each
    return xr.Dataset(
        {name: (("operation", "limit"), each) for name, each in found.items()},
        coords={
            "operation": operations,
            "limit": [limit.name for limit in limits],
            "words": ("limit", [limit.words for limit in limits]),
        },
    )


def _measured(data: xr.Dataset, limit: Limit) -> np.ndarray:
    """Probability that measured values of operations are beyond a limit, ``(o,)``."""
    if "measured" not in data:
        return np.full(data.sizes["operation"], np.nan)
    own = data[["measured", "measured_sd"]].sel(quantity=list(limit.quantities))
    own = own.where(data.accepted).transpose("operation", "quantity")
    return limit.measured_exceedance(own.measured.values, own.measured_sd.values)
