"""What networks of families infer of measured operations, one by one."""

import numpy as np
import pytest
import xarray as xr

from breaker.family.network_files import shipped_networks
from breaker.family.operations import infer_operations
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS, NAMES
from breaker.paper.validation import intervals, table

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
    each = {"rate": 4.0, "record_noise": NOISE, "record_colour": 0.0}
    curves = xr.Dataset(
        {
            "record": (("operation", "sample"), record),
            "travel": (("operation", "time"), record[:, ::2]),
            "reason": ("operation", reasons),
            "accepted": ("operation", reasons == ""),
            "file": ("operation", [f"{i}.csv" for i in range(COUNT)]),
            **{name: ("operation", np.full(COUNT, value)) for name, value in each.items()},
        },
        {"operation": np.arange(10, 10 + COUNT)},
        {"motion": motion},
    )
    return theta, curves


@pytest.mark.parametrize("motion", MOTIONS)
def test_each_operation_is_answered_or_says_why_not(prior, families, motion):
    theta, curves = curves_of(prior, motion)
    found = infer_operations(curves, families, **SETTINGS)
    assert found.output.values.tolist() == list(NAMES)
    assert found.draws.shape == (COUNT, 200, 7)
    answered = np.isfinite(found.draws.values).all(axis=(1, 2))
    expected = ~np.isin(np.arange(COUNT), [REJECTED, STILL, FOREIGN])
    assert answered.tolist() == expected.tolist()
    assert found.misfit.values.tolist() == (np.arange(COUNT) == FOREIGN).tolist()
    reasons = [curves.reason.values[REJECTED], "3.csv: shows no motion from one rest to another"]
    assert found.reason.values[[REJECTED, STILL]].tolist() == reasons
    assert found.accepted.values.tolist() == (found.reason.values == "").tolist()
    assert set(found.family.values[answered]) <= {"medium_voltage", "any"}
    assert not {"record", "travel"} & set(found.variables)
    # Physical units, and near the truth: within 6 of their sds of the logarithms.
    logs = np.log(found.draws.values[answered].astype(float))
    off = (logs.mean(axis=1) - np.log(theta[answered])) / logs.std(axis=1)
    assert np.abs(off).max() < 6.0


def test_an_operation_does_not_depend_on_those_beside_it(prior, families):
    """Bit for bit: jobs may be cut anywhere. Its number names its generator, as the seed does."""
    _, curves = curves_of(prior, "closing")
    whole = infer_operations(curves, families, **SETTINGS)
    part = infer_operations(curves.isel(operation=[5, 2]), families, **SETTINGS)
    xr.testing.assert_identical(part, whole.isel(operation=[5, 2]))
    renamed = curves.isel(operation=[2]).assign_coords(operation=[99])
    other = infer_operations(renamed, families, **SETTINGS)
    assert not np.any(other.draws.values == whole.draws.values[2])
    again = infer_operations(curves.isel(operation=[2]), families, **(SETTINGS | {"seed": 2}))
    assert not np.any(again.draws.values == whole.draws.values[2])


def test_answers_are_rows_of_the_table_of_operations(prior, families):
    _, curves = curves_of(prior, "opening")
    found = infer_operations(curves, families, **SETTINGS)
    rows = table(found.assign(intervals(found.draws.values))).set_index(["operation", "output"])
    assert len(rows) == COUNT * len(NAMES)
    middle = np.median(found.draws.values[0], axis=0)
    np.testing.assert_allclose(rows.loc[10, "median"].loc[list(NAMES)], middle, rtol=1e-6)
    assert rows.loc[10, "family"].tolist() == [found.family.values[0]] * len(NAMES)
    assert rows.loc[10 + FOREIGN, "median"].isna().all()
