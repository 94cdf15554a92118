"""What networks of families infer of measured operations, one by one."""

import numpy as np
import pytest
import xarray as xr

from breaker.family.networks import shipped_networks
from breaker.family.operations import infer_operations
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS, NAMES

TIMES, NOISE, COUNT = np.arange(-10.0, 70.0, 0.25), 0.05, 6
SETTINGS = {"draws": 200, "seed": 1, "misfit_p_value": 1e-3}
REJECTED, STILL, FOREIGN = 1, 3, 4  # by the reader, without a motion, and of no drive


@pytest.fixture(scope="module")
def families():
    return [levels for (levels,) in shipped_networks("levels")]


def curves_of(prior, motion):
    """Operations of drives of the model, as ``curve_reader.read_curves`` returns them."""
    rng = np.random.default_rng(5)
    theta = prior.sample(COUNT, rng)
    record = travel(theta, TIMES, motion).travel + NOISE * rng.standard_normal((COUNT, TIMES.size))
    record[REJECTED] = np.nan
    record[STILL] = NOISE * rng.standard_normal(TIMES.size)
    record[FOREIGN] += 3.0 * np.sin(TIMES) * (TIMES > 8.0) * (TIMES < 30.0)
    reasons = np.array(
        ["line 40: travel is missing" if i == REJECTED else "" for i in range(COUNT)]
    )
    item = {"rate": 4.0, "record_noise": NOISE, "record_colour": 0.0}
    curves = xr.Dataset(
        {
            "record": (("operation", "sample"), record),
            "travel": (("operation", "time"), record[:, ::2]),
            "reason": ("operation", reasons),
            "accepted": ("operation", reasons == ""),
            "file": ("operation", [f"{i}.csv" for i in range(COUNT)]),
            **{name: ("operation", np.full(COUNT, value)) for name, value in item.items()},
        },
        {"operation": np.arange(10, 10 + COUNT)},
        {"motion": motion},
    )
    return theta, curves


@pytest.mark.parametrize("motion", MOTIONS)
def test_an_operation_has_an_estimate_or_a_reason(prior, families, motion):
    theta, curves = curves_of(prior, motion)
    inferred = infer_operations(curves, families, **SETTINGS)
    assert inferred.output.values.tolist() == list(NAMES)
    draws, family, reason = (inferred[n].values for n in ("draws", "family", "reason"))
    finite, numbers = np.isfinite(draws).all(axis=(1, 2)), np.arange(COUNT)
    assert finite.tolist() == (~np.isin(numbers, [REJECTED, STILL, FOREIGN])).tolist()
    assert inferred.misfit.values.tolist() == (numbers == FOREIGN).tolist()
    assert (reason != "").tolist() == np.isin(numbers, [REJECTED, STILL]).tolist()
    assert reason[REJECTED] == curves.reason.values[REJECTED]
    assert inferred.accepted.values.tolist() == (reason == "").tolist()
    assert set(family[finite]) <= {"medium_voltage", "any"}
    assert not {"record", "travel"} & set(inferred.variables)
    # Physical units, and near the truth: within 6 of their sds of the logarithms.
    logs = np.log(draws[finite].astype(float))
    off = (logs.mean(axis=1) - np.log(theta[finite])) / logs.std(axis=1)
    assert np.abs(off).max() < 6.0


def test_an_operation_does_not_depend_on_the_others(prior, families):
    """Bit for bit: jobs may be cut anywhere. Its number names its generator."""
    _, curves = curves_of(prior, "closing")
    whole = infer_operations(curves, families, **SETTINGS)
    part = infer_operations(curves.isel(operation=[5, 2]), families, **SETTINGS)
    xr.testing.assert_identical(part, whole.isel(operation=[5, 2]))
    renamed = curves.isel(operation=[2]).assign_coords(operation=[99])
    for some, settings in (
        (renamed, SETTINGS),
        (curves.isel(operation=[2]), SETTINGS | {"seed": 2}),
    ):
        other = infer_operations(some, families, **settings)
        assert not np.any(other.draws.values == whole.draws.values[2])
