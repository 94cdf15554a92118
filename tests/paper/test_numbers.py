"""Numbers that texts state, and blocks of operations, from tables whose contents are known."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from breaker.common.randomness import generator
from breaker.model.parameters import NAMES
from breaker.paper.run_numbers import blocks_of, held, moved, numbers_of_motion, truth_in_blocks

N, OUTPUTS = 400, [*NAMES, "onset"]
OPERATIONS = np.arange(N)


def draws(dimension, n, correlated=0.0):
    """Log-normal draws; the first two parameters correlate, the eighth output is a time."""
    normal = generator(1, "test numbers").standard_normal((n, 200, 8))
    normal[..., 1] = correlated * normal[..., 0] + np.sqrt(1 - correlated**2) * normal[..., 1]
    values = np.concatenate([np.exp(normal[..., :7]), normal[..., 7:]], axis=-1)
    where = {dimension: np.arange(n), "output": OUTPUTS}
    return xr.Dataset({"draws": ((dimension, "draw", "output"), values)}, where)


def tables():
    """Half of the family's posteriors, and a tenth of the true forces, are far from the others."""
    number, late = np.arange(8), OPERATIONS[:, None] >= N // 2
    columns = {"posterior": "amortised", "output": OUTPUTS, "calibration_p": 0.5 / (number + 1.0)}
    columns |= {"contraction": 0.1 * number + 0.004, "coverage_95": 0.93 + 0.004 * number}
    exactness = {"efficiency_median": 0.931, "efficiency_lowest": 0.57, "gap_nats": 0.0686}
    operations = draws("operation", N).assign(
        accepted=("operation", OPERATIONS != 5),
        misfit=("operation", OPERATIONS < 0.62 * N),
        travel=(("operation", "time"), np.tile([0.5, 0.5, 0.5, 3.0], (N, 1))),
    )
    family = draws("operation", N)
    truth = np.ones((N, 7))
    truth[-N // 10 :, 5] = 0.93
    where = {"operation": OPERATIONS, "parameter": list(NAMES)}
    return {
        "quality": pd.DataFrame(columns),
        "exactness": pd.DataFrame([exactness]),
        "prior": xr.Dataset({"travel": (("curve", "time"), np.linspace([0] * 4, [1] * 4, 50))}),
        "validation": draws("curve", 100, correlated=-0.8),
        "operations": operations,
        "family": family.assign(draws=family.draws + 100.0 * late[:, None]),
        "predictive": xr.Dataset({"share_inside": ("stage", [0.97, 0.884, 1.0])}),
        "truth": xr.Dataset({"value": (("operation", "parameter"), truth)}, where),
    }


def test_numbers_of_a_motion():
    """Correlations are within a posterior and of logarithms; measured records have no truth."""
    numbers = numbers_of_motion(**tables())
    # The median of a hundred estimates from 200 draws each is within 0.03 but for 1 in 1,000.
    assert float(numbers["correlation.mu.k_a"]) == pytest.approx(-0.8, abs=0.03)
    expected = {"contraction.k_b": "0.20", "coverage_95.highest": "96", "gap": "0.07"}
    expected |= {"calibration_p": "0.5", "efficiency_median": "93", "misfit": "62"}
    expected |= {"paper_holds.f": "100", "family_holds.f": "50", "prior_inside": "75"}
    expected |= {"inside.highest": "100", "true_change.f": "-7.0"}
    assert {name: numbers[name] for name in expected} == expected
    measured = numbers_of_motion(**tables() | {"truth": None, "family": None})
    assert measured.items() <= numbers.items()
    assert not any("change" in name or "holds" in name for name in measured)


def test_blocks_and_the_share_that_contains_the_truth():
    """One operation far off moves neither band nor median; pooled, it would widen the band."""
    centre = np.where(np.arange(400) < 100, 2.0, 0.0)
    centre[153] = 100.0
    values = centre[:, None, None] + np.linspace(-1.0, 1.0, 201)[:, None] * np.ones(8)
    values[155] = values[390:] = np.nan
    number = np.arange(1, 401)
    inferred = xr.Dataset(
        {"draws": (("operation", "draw", "output"), values)},
        {"operation": number, "output": ["onset", *NAMES]},
    )
    blocks = blocks_of(inferred)
    assert blocks["value"].shape == (40, 7, 3)
    np.testing.assert_allclose(blocks["value"][15], np.tile([-0.9, 0.0, 0.9], (7, 1)), atol=1e-12)
    assert np.isnan(blocks["value"][-1]).all()
    last = blocks.isel(block=-1)
    assert [last[name].item() for name in ("first", "last", "operation")] == [391, 400, 395.5]
    assert blocks.answered.values[[0, 15, -1]].tolist() == [10, 9, 0]
    few = blocks_of(inferred.isel(operation=slice(7)))
    assert few["first"].values.tolist() == few["last"].values.tolist() == [*range(1, 8)]
    # From the first block with a posterior to the last one.
    ends = [[np.nan], [2.0], [9.0], [3.0], [np.nan]]
    np.testing.assert_allclose(moved(np.array(ends)), [50.0])
    # Of 39 blocks with a posterior 10 are off; the truth is a mean over a block.
    wavy = 0.5 + np.resize([-5.0, 5.0], 400)[:, None] * np.ones(7)
    where = {"operation": number, "parameter": list(NAMES)}
    truth = xr.DataArray(wavy, where, ("operation", "parameter"))
    np.testing.assert_allclose(truth_in_blocks(blocks, truth), 0.5)
    np.testing.assert_allclose(held(blocks, truth), 29 / 39)
    np.testing.assert_allclose(held(blocks, 0.0 * truth + 0.95), 0.0)
    assert np.isnan(held(blocks.isel(block=[-1]), truth)).all()
