"""What each error of a record costs, what the model leaves out among them."""

from dataclasses import replace

import numpy as np
import xarray as xr

from breaker.mechanism import NAMES
from breaker.model import Model, limit_over_prior

__all__ = ["contraction_by_error"]


def contraction_by_error(model: Model, n: int, seed: int) -> xr.Dataset:
    """Return what each error of a record costs: the limit of contraction, error by error.

    Args:
        model: Model of the motion, with what it leaves out.
        n: Draws from the prior; the same for all errors.

    Returns:
        Dataset over ``error`` (noise; zero, onset and left out each with all before it) and
        ``parameter``: mean ``contraction`` over the draws.
    """
    sensor = model.sensor
    sensors = {
        "noise": replace(sensor, zero_sd=0.0, onset_sd=0.0, discrepancy=None),
        "zero": replace(sensor, onset_sd=0.0, discrepancy=None),
        "onset": replace(sensor, discrepancy=None),
        "left out": sensor,
    }
    rows = []
    for each in sensors.values():
        limit = limit_over_prior(replace(model, sensor=each), n, np.random.default_rng(seed))
        rows.append(limit.contraction.sel(output=list(NAMES)).mean("curve").values)
    return xr.Dataset(
        {"contraction": (("error", "parameter"), np.array(rows))},
        coords={"error": list(sensors), "parameter": list(NAMES)},
    )
