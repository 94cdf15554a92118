"""How far conclusions about a drive depend on what the model is held to leave out.

The same few operations, each inferred and corrected at several scales of the model's own error: a
conclusion that moves with the scale rests on the model.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from breaker.decisions.conditions import condition
from breaker.mechanism import Limit

if TYPE_CHECKING:
    from breaker.posterior import Posterior

__all__ = ["over_scales", "spread"]

_LEVELS = {"median": 0.5, "lower": 0.05, "upper": 0.95}


def spread(curves: xr.Dataset, count: int) -> xr.Dataset:
    """Return a few of the accepted operations, evenly spread, first and last included."""
    accepted = np.flatnonzero(curves.accepted.values)
    chosen = np.unique(np.linspace(0, accepted.size - 1, count).round().astype(int))
    return curves.isel(operation=accepted[chosen] if accepted.size else [])


def over_scales(
    posterior: "Posterior",
    curves: xr.Dataset,
    scales: Sequence[float],
    limits: Sequence[Limit],
    correction: Mapping,
    *,
    draws: int,
    seed: int,
    misfit_p_value: float,
    truth: xr.DataArray | None = None,
) -> pd.DataFrame:
    """Infer and correct operations at several scales of what the model leaves out.

    Args:
        curves: A few measured operations, as ``records.read_curves`` returns them.
        limits: Limits of any motion; those of the posterior's are judged.
        correction: The section ``correction`` of the configuration.
        draws: Draws from the posterior of each operation.
        misfit_p_value: Predictive p-value below which a record counts as misfit.
        truth: True parameters of a stand-in, ``(operation, parameter)``.

    Returns:
        One row for each scale, operation and ``name``. ``kind`` "parameter": ``median``, ``lower``
        and ``upper`` of the 90 % interval in ``unit``, and again with ``_z``, as distances from the
        prior's median in prior sd; ``truth`` and ``truth_z`` if given. ``kind`` "limit":
        ``probability`` that it is exceeded. In all rows ``p_value`` and ``resolved`` of the
        operation at that scale.
    """
    from breaker.posterior import correct_operations, infer  # loads torch

    common = {"seed": seed, "misfit_p_value": misfit_p_value}
    own = [limit for limit in limits if limit.motion == posterior.motion]
    tables = []
    for scale in scales:
        at = posterior.at(scale)
        found = infer(at, curves, draws=draws, **common)
        found = correct_operations(at.model, found, correction, **common)
        rows = pd.concat([_parameters(found, at, truth), _limits(found, own, posterior.motion)])
        of_operation = found[["p_value", "resolved"]].to_dataframe()[["p_value", "resolved"]]
        rows = rows.merge(of_operation.reset_index(), on="operation")
        rows.insert(0, "scale", scale)
        tables.append(rows)
    return pd.concat(tables, ignore_index=True)


def _parameters(
    found: xr.Dataset, posterior: "Posterior", truth: xr.DataArray | None
) -> pd.DataFrame:
    """Median and 90 % interval of every output, in its unit and in prior sd."""
    draws = found.draws.values.astype(np.float64)
    columns = {}
    for suffix, values in (("", draws), ("_z", posterior.standardise(draws))):
        for name, level in _LEVELS.items():
            columns[f"{name}{suffix}"] = np.quantile(values, level, axis=1).ravel()
    operations, names = found.operation.values, found.output.values
    if truth is not None:  # it has no onset
        known = truth.reindex(operation=operations, parameter=names).values
        columns |= {"truth": known.ravel(), "truth_z": posterior.standardise(known).ravel()}
    return pd.DataFrame(
        {
            "operation": np.repeat(operations, len(names)),
            "kind": "parameter",
            "name": np.tile(names, len(operations)),
            "unit": np.tile(found.output_unit.values, len(operations)),
            **columns,
        }
    )


def _limits(found: xr.Dataset, limits: Sequence[Limit], motion: str) -> pd.DataFrame:
    """Probability of every limit."""
    judged = condition({motion: found}, limits).probability
    return pd.DataFrame(
        {
            "operation": np.repeat(judged.operation.values, len(limits)),
            "kind": "limit",
            "name": np.tile([limit.name for limit in limits], judged.sizes["operation"]),
            "probability": judged.values.ravel(),
        }
    )
