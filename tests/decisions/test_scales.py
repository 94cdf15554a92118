"""Conclusions at several scales of the model's own error."""

import numpy as np
import pytest
import xarray as xr

from breaker.decisions import over_scales, spread
from breaker.mechanism import NAMES, Limit
from breaker.model.randomness import generator
from breaker.posterior.exactness import correct_operations
from breaker.posterior.predictive import infer
from tests.corrections import SETTINGS
from tests.networks_fixtures import MARKS, bank_of, frozen, left_out, one_thread  # noqa: F401

pytestmark = MARKS

CORRECTION = SETTINGS | {"round_draws": 400, "draws": 400, "smallest_size": 100}
LIMITS = [
    Limit("wide", "closing", (("L", 10.0, True),)),
    Limit("slow", "opening", (("opening_speed", 1.4, False),)),
]
COMMON = {"seed": 1, "misfit_p_value": 1e-3}


@pytest.fixture(scope="module")
def posterior():
    return frozen(discrepancy=left_out(size=0.6))


@pytest.fixture(scope="module")
def curves(posterior):
    """Three operations, the second of which was rejected; records of the model itself."""
    bank = bank_of(posterior, 3, seed=7)
    records = posterior.sensor.corrupt(bank.travel.values, generator(1, "test records"))
    accepted = np.array([True, False, True])
    return xr.Dataset(
        {
            "travel": (("operation", "time"), np.where(accepted[:, None], records, np.nan)),
            "accepted": ("operation", accepted),
            "reason": ("operation", np.array(["", "too short", ""])),
            "file": ("operation", np.array(list("abc"))),
        },
        coords={"operation": [5, 6, 9], "time": posterior.sensor.times},
    )


@pytest.fixture(scope="module")
def table(posterior, curves):
    return over_scales(posterior, curves, [0.0, 1.0], LIMITS, CORRECTION, draws=300, **COMMON)


def test_a_few_operations_are_spread_over_those_accepted(curves):
    many = xr.Dataset(
        {"accepted": ("operation", np.arange(10) != 9)}, {"operation": np.arange(11, 21)}
    )
    assert spread(many, 3).operation.values.tolist() == [11, 15, 19]
    assert spread(many, 50).operation.values.tolist() == list(range(11, 20))
    assert spread(curves, 2).operation.values.tolist() == [5, 9]
    assert spread(many.isel(operation=[9]), 3).sizes["operation"] == 0


def test_rows_are_those_of_the_exact_posteriors(posterior, curves, table):
    """Of each scale, by hand; operations without a record have none."""
    at = posterior.at(1.0)
    exact = correct_operations(
        at.model, infer(at, curves, draws=300, **COMMON), CORRECTION, **COMMON
    )
    rows = table[(table.scale == 1.0) & (table.operation == 9)].set_index("name")
    assert rows.index.tolist() == [*NAMES, "onset", "wide"]
    draws = exact.draws.sel(operation=9).values.astype(np.float64)
    expected = np.quantile(draws, [0.05, 0.5, 0.95], axis=0)
    outputs = rows[rows.kind == "parameter"]
    found = outputs[["lower", "median", "upper"]].to_numpy().T
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    z = outputs[["lower_z", "median_z", "upper_z"]].to_numpy().T
    np.testing.assert_allclose(z, posterior.standardise(expected), atol=1e-3)
    assert outputs.unit.tolist()[-2:] == ["mm", "ms"]
    assert rows.probability["wide"] == pytest.approx((draws[:, 6] > 10.0).mean())
    assert rows.p_value.unique() == pytest.approx([float(exact.p_value.sel(operation=9))])
    rejected = table[table.operation == 6]
    assert rejected[["median", "lower_z", "probability", "p_value"]].isna().all(axis=None)
    assert not rejected.resolved.any()
    assert "truth" not in table


def test_the_truth_of_a_stand_in_stands_beside(posterior, curves):
    """Of every operation; the onset has none."""
    values = np.arange(1.0, 36.0).reshape(5, 7)
    coords = {"operation": [1, 5, 6, 7, 9], "parameter": list(NAMES)}
    truth = xr.DataArray(values, dims=("operation", "parameter"), coords=coords)
    common = COMMON | {"draws": 300, "truth": truth}
    few = curves.isel(operation=[0, 2])
    table = over_scales(posterior, few, [1.0], LIMITS, CORRECTION, **common)
    for operation, row in ((5, values[1]), (9, values[4])):
        rows = table[(table.operation == operation) & (table.kind == "parameter")]
        np.testing.assert_array_equal(rows.truth, [*row, np.nan])
        z = posterior.standardise(np.append(row, 0.0))[:7]
        np.testing.assert_allclose(rows.truth_z.iloc[:7], z)
