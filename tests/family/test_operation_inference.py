"""What networks of families infer of measured operations, one by one."""

import numpy as np
import pytest
import xarray as xr

from breaker.family.networks import shipped_levels
from breaker.family.operation_inference import infer_operations
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS

TIMES, NOISE, COUNT = np.arange(-10.0, 70.0, 0.25), 0.05, 6
SETTINGS = {"draws": 200, "seed": 1, "misfit_p_value": 1e-3}
REJECTED, STILL, FOREIGN = 1, 3, 4  # by the reader, without a motion, and of no drive


def curves_of(prior, motion):
    """Operations of drives of the model, as ``read_curves`` returns them."""
    rng = np.random.default_rng(5)
    theta = prior.sample(COUNT, rng)
    record = travel(theta, TIMES, motion).travel + NOISE * rng.standard_normal((COUNT, TIMES.size))
    record[STILL] = NOISE * rng.standard_normal(TIMES.size)
    record[FOREIGN] += 3.0 * np.sin(TIMES) * (TIMES > 8.0) * (TIMES < 30.0)
    reasons = np.full(COUNT, "")
    reasons[REJECTED] = "x"
    item = {"rate": 4.0, "record_noise": NOISE, "record_colour": 0.0, "file": "a.csv"}
    item |= {"reason": reasons, "accepted": reasons == ""}
    values = {name: ("operation", np.broadcast_to(value, COUNT)) for name, value in item.items()}
    values["record"] = ("operation", "sample"), record
    return theta, xr.Dataset(values, {"operation": np.arange(10, 10 + COUNT)}, {"motion": motion})


@pytest.mark.parametrize("motion", MOTIONS)
def test_an_operation_has_an_estimate_or_a_reason_whatever_the_others_are(prior, motion):
    """Bit for bit: jobs may be cut anywhere. The number of an operation names its generator."""
    families = [*shipped_levels()]
    theta, curves = curves_of(prior, motion)
    inferred = infer_operations(curves, families, **SETTINGS)
    draws, numbers = inferred.draws.values, np.arange(COUNT)
    finite = np.isfinite(draws).all(axis=(1, 2))
    assert finite.tolist() == (~np.isin(numbers, [REJECTED, STILL, FOREIGN])).tolist()
    assert inferred.misfit.values.tolist() == (numbers == FOREIGN).tolist()
    assert (inferred.reason.values != "").tolist() == np.isin(numbers, [REJECTED, STILL]).tolist()
    # Physical units, and near the truth: within 6 of their sds of the logarithms.
    logs = np.log(draws[finite].astype(float))
    off = (logs.mean(axis=1) - np.log(theta[finite])) / logs.std(axis=1)
    assert np.abs(off).max() < 6.0
    part = infer_operations(curves.isel(operation=[5, 2]), families, **SETTINGS)
    xr.testing.assert_identical(part, inferred.isel(operation=[5, 2]))
    renamed = curves.isel(operation=[2]).assign_coords(operation=[99])
    for some, seed in ((renamed, 1), (curves.isel(operation=[2]), 2)):
        other = infer_operations(some, families, **SETTINGS | {"seed": seed})
        assert not np.any(other.draws.values == draws[2])
