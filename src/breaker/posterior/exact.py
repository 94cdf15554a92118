"""Exact posteriors of measured operations without a network, of any drive.

Each record starts from draws about the mode of its posterior (``laplace``), which adaptive
importance sampling then makes exact (``corrections``). Neither needs torch.

Example:
    >>> from breaker.model import reference_model
    >>> model = reference_model("closing")
    >>> record = model.curves(np.append(model.prior.medians, 0.0)[None])
    >>> curves = xr.Dataset(
    ...     {"travel": (("operation", "time"), record), "accepted": ("operation", [True]),
    ...      "reason": ("operation", [""]), "file": ("operation", ["a.csv"])},
    ...     coords={"operation": [1], "time": model.sensor.times},
    ... )
    >>> settings = {"rounds": 20, "round_draws": 500, "draws": 2000, "efficiency": 0.6,
    ...             "fit_size": 100, "smallest_size": 400, "largest_k": 0.7}
    >>> found = infer_exactly(model, curves, settings, draws=500, seed=1, misfit_p_value=1e-3)
    >>> bool(found.resolved[0]), bool(found.misfit[0])
    (True, False)
    >>> found["median"].sel(output=["mu", "L"]).round(0).values
    array([[ 2., 10.]])
"""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from breaker.model import Model
from breaker.posterior.exactness import correct_each, judged_contacts, models_of, p_values
from breaker.posterior.laplace import approximate
from breaker.posterior.missing import check
from breaker.posterior.predictive import coordinates, summaries

__all__ = ["infer_exactly"]


def infer_exactly(
    model: Model,
    curves: xr.Dataset,
    settings: Mapping,
    *,
    draws: int,
    seed: int,
    misfit_p_value: float,
) -> xr.Dataset:
    """Infer measured operations.

    A record does not depend on those beside it, but on its number and the seed.

    Args:
        curves: Measured curves in the layout of ``records.read_curves``, on the model's grid;
            rejected ones stay in the result, as missing values with their reason, and so do those
            without any draws, such as a record without a sample.
        settings: The section ``correction`` of the configuration.
        misfit_p_value: Posterior predictive p-value below which a record counts as misfit.

    Returns:
        What ``correct_operations`` makes of a network's answer, but for what only a network says:
        ``distance``, ``outside_prior`` and ``completed``.

    Raises:
        ValueError: If the curves are on another grid.
    """
    measured = curves.travel.values.astype(np.float64)
    samples = model.sensor.samples
    if measured.shape[1:] != (samples,):
        raise ValueError(f"records must have the shape (o, {samples}), not {measured.shape}")
    models = models_of(model, curves)

    def start(i: int, rng: np.random.Generator) -> np.ndarray:
        check(measured[i : i + 1], samples, model.motion)
        return approximate(models[i], measured[i], draws, rng)

    accepted = curves.accepted.values
    values, found = correct_each(
        *(models, measured, start, accepted, curves.operation.values, settings),
        *((seed, "exact"), (draws, len(model.outputs))),
    )
    reasons = curves.reason.values.astype(object)
    for i in np.flatnonzero(accepted & np.isnan(values).any(axis=(1, 2))):
        reasons[i] = f"{curves.file.values[i]}: {found['why_unresolved'][i]}"
    by_operation = {name: ("operation", each) for name, each in found.items()} | {
        "reason": ("operation", reasons.astype(str)),
        "accepted": ("operation", reasons == ""),
    }
    by_operation |= judged_contacts(models, curves, values)
    drawn = summaries(model, values, p_values(model, measured, values), misfit_p_value)
    return curves.assign(by_operation | drawn).assign_coords(coordinates(model))
