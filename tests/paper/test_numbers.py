"""Numbers that texts state, and blocks of a life, from tables whose contents are known."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from breaker.common.randomness import generator
from breaker.model.parameters import NAMES
from breaker.paper.run_numbers import (
    blocks_of,
    held,
    numbers_of_life,
    numbers_of_motion,
    truth_in_blocks,
)

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
    columns = {"posterior": "amortised", "output": OUTPUTS, "calibration_p": np.full(8, 0.5)}
    columns |= {"calibration_p_reader": np.where(number < 7, 0.3, 0.004)}
    columns |= {"z_sd": 0.98 + 0.01 * number, "contraction": 0.1 * number + 0.004}
    columns |= {"shortfall": 0.001 * number, "coverage_95": 0.93 + 0.004 * number}
    exactness = {"efficiency_median": 0.931, "efficiency_lowest": 0.57, "gap_nats": 0.0686}
    exactness |= {"gap_se": 0.02, "c2st_median": 0.5, "corrected_curves": 1000, "resolved": 0.999}
    operations = draws("operation", N).assign(
        accepted=("operation", OPERATIONS != 5),
        misfit=("operation", OPERATIONS < 0.62 * N),
        travel=(("operation", "time"), np.tile([0.5, 0.5, 0.5, 3.0], (N, 1))),
    )
    family = draws("operation", N)
    truth = {
        "value": (("operation", "parameter"), np.ones((N, 7))),
        "difference": ("operation", np.linspace(1.2, 1.58, N)),
    }
    truth["value"][1][-N // 10 :, 5] = 0.93
    return {
        "quality": pd.DataFrame(columns),
        "exactness": pd.DataFrame([exactness]),
        "prior": xr.Dataset({"travel": (("curve", "time"), np.linspace([0] * 4, [1] * 4, 50))}),
        "validation": draws("curve", 100, correlated=-0.8),
        "operations": operations,
        "family": family.assign(draws=family.draws + 100.0 * late[:, None]),
        "predictive": xr.Dataset({"share_inside": ("stage", [0.97, 0.884, 1.0])}),
        "truth": xr.Dataset(truth, {"operation": OPERATIONS, "parameter": list(NAMES)}),
    }


EXPECTED = {
    "contraction.k_b": "0.20",
    "z_sd.highest": "1.05",
    "coverage_95.highest": "96",
    "shortfall": "0.01",
    "calibration_p_files": "0.032",  # the least of eight times eight
    "calibration_p_files.onset": "0.004",
    "gap": "0.07",
    "efficiency_median": "93",
    "curves_resolved": "999",
    "misfit": "62",
    "paper_holds.f": "100",
    "family_holds.f": "50",
    "prior_inside": "75",
    "inside.highest": "100",
    "true_change.f": "-7.0",
    "difference.highest": "1.6",
}


def test_numbers_of_a_motion():
    """Correlations are within a posterior and of logarithms; measured records have no truth."""
    numbers = numbers_of_motion(**tables())
    assert {name: numbers[name] for name in EXPECTED} == EXPECTED
    # The median of a hundred estimates from 200 draws each is within 0.03 but for 1 in 1,000.
    assert float(numbers["correlation.mu.k_a"]) == pytest.approx(-0.8, abs=0.03)
    # From the first to the last block with answers: of 100 more than once the last is.
    assert float(numbers["family_change.f"]) == pytest.approx(1e4, rel=0.1)
    measured = numbers_of_motion(**tables() | {"truth": None, "family": None})
    assert measured.items() <= numbers.items()
    assert not any("change" in name or "holds" in name for name in measured)


def test_numbers_of_a_life():
    life = xr.Dataset({"noticed": ("change", [1824])})
    limits = pd.DataFrame({"limit": ["wide", "wide", "slow"], "certain": [25.0, 25.0, np.nan]})
    states = {"state": ["ok", "planned", "planned", "due"], "operation": [1, 2, 3, 4]}
    decisions = pd.DataFrame(states | {"service_by": [np.nan, 30.0, 20.0, 20.0]})
    assert numbers_of_life(life, limits, decisions, {"wide": 18.0, "slow": np.nan}) == {
        "changes": "1",
        "change_1": "1,824",
        "wide.failure": "18",
        "wide.exceeded": "25",
        "first_plan": "2",
        "service_moves": "1",
    }


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
    # Of 39 blocks with a posterior 10 are off; the truth is a mean over a block.
    wavy = 0.5 + np.resize([-5.0, 5.0], 400)[:, None] * np.ones(7)
    where = {"operation": number, "parameter": list(NAMES)}
    truth = xr.DataArray(wavy, where, ("operation", "parameter"))
    np.testing.assert_allclose(truth_in_blocks(blocks, truth), 0.5)
    np.testing.assert_allclose(held(blocks, truth), 29 / 39)
    np.testing.assert_allclose(held(blocks, 0.0 * truth + 0.95), 0.0)
    assert np.isnan(held(blocks.isel(block=[-1]), truth)).all()
