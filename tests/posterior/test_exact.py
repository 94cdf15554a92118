"""Exact posteriors without a network: what comes out, for whom, and that it does not wander."""

import numpy as np
import pytest
import xarray as xr

from breaker.mechanism.parameters import MOTIONS
from breaker.model.joint import Model
from breaker.model.randomness import generator
from breaker.posterior.exact import infer_exactly
from breaker.posterior.exactness import correct_operations
from breaker.posterior.tables import table

NUMBERS = np.array([3, 5, 7, 9, 11, 12])
REJECTED, EMPTY, INFINITE, BUMP = 1, 2, 4, 5
POOR = [REJECTED, EMPTY, INFINITE]


def curves_of(model, records, numbers=NUMBERS):
    reasons = np.array(["line 40: travel is missing" if k == 5 else "" for k in numbers])
    return xr.Dataset(
        {
            "travel": (("operation", "time"), records),
            "accepted": ("operation", reasons == ""),
            "reason": ("operation", reasons),
            "remarks": ("operation", np.full(len(numbers), "")),
            "file": ("operation", np.array([f"close_{k}.csv" for k in numbers])),
        },
        coords={"operation": numbers, "time": model.sensor.times},
        attrs={"motion": model.motion},
    )


@pytest.fixture(scope="module", params=MOTIONS)
def model(request, prior, sensor):
    return Model(prior, sensor, request.param)


@pytest.fixture(scope="module")
def curves(model):
    """Six records: one rejected, one without samples, one infinite, one that fits no curve."""
    rng = generator(1, "test exact", model.motion)
    onset = model.sensor.onset_sd * rng.standard_normal((6, 1))
    values = np.hstack([model.prior.sample(6, rng), onset])
    records = model.sensor.corrupt(model.curves(values), rng)
    records[[REJECTED, EMPTY]] = np.nan
    records[INFINITE, 3] = np.inf
    records[BUMP, 60:70] += 3.0
    records[3, ::3] = np.nan  # fewer samples are no obstacle
    return curves_of(model, records)


@pytest.fixture(scope="module")
def exactly(defaults):
    def infer(model, curves, *, draws=100, seed=1, misfit_p_value=1e-3):
        options = {"draws": draws, "seed": seed, "misfit_p_value": misfit_p_value}
        return infer_exactly(model, curves, defaults["correction"], **options)

    return infer


@pytest.fixture(scope="module")
def result(model, curves, exactly):
    return exactly(model, curves)


def test_every_record_has_a_row_and_poor_ones_a_reason(result, curves):
    good = ~np.isin(np.arange(6), POOR)
    assert result.accepted.values.tolist() == good.tolist()
    assert result.resolved.values.tolist() == good.tolist()
    for name in ("draws", "median", "interval_95", "p_value", "outside_support"):
        assert np.isfinite(result[name].values.reshape(6, -1)).all(axis=1).tolist() == good.tolist()
    reasons = result.reason.values
    assert reasons[REJECTED] == curves.reason.values[REJECTED]
    assert reasons[EMPTY] == (
        "close_7.csv: no exact posterior: ValueError: 1 of 1 records have no sample"
    )
    assert reasons[INFINITE].endswith("have infinite samples")
    assert (reasons[good] == "").all()
    assert result.misfit.values.tolist() == (np.arange(6) == BUMP).tolist()


def test_tables_take_it(result):
    rows = table(result)
    assert len(rows) == 6 * 8
    assert {"resolved", "effective_size", "pareto_k", "remarks"} <= set(rows.columns)
    assert not {"outside_prior", "completed", "distance"} & set(rows.columns)


def test_it_has_what_a_corrected_answer_of_a_network_has(model, result, curves, defaults):
    """Same variables, dtypes and dims, so that nothing downstream tells them apart."""
    start = xr.Dataset({"draws": result.draws.fillna(np.nan)}).merge(curves)
    options = {"seed": 1, "misfit_p_value": 1e-3}
    corrected = correct_operations(model, start, defaults["correction"], **options)
    assert set(result.data_vars) == set(corrected.data_vars)
    for name in corrected.data_vars:
        assert result[name].dims == corrected[name].dims, name
        assert result[name].dtype.kind == corrected[name].dtype.kind, name


def test_a_record_does_not_depend_on_those_beside_it(model, curves, result, exactly):
    rows = [5, 0]
    part = exactly(model, curves.isel(operation=rows))
    xr.testing.assert_identical(part, result.isel(operation=rows))
    other = exactly(model, curves.isel(operation=[0]), seed=2)
    assert not np.any(other.draws.values == result.draws.values[0])


def test_curves_on_another_grid_are_refused(model, curves, exactly):
    with pytest.raises(ValueError, match=r"must have the shape \(o, 151\), not \(6, 150\)"):
        exactly(model, curves.isel(time=slice(150)))
