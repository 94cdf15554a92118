"""Numbers that texts state, from tables whose contents are known."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from breaker.common.randomness import generator
from breaker.model.parameters import PARAMETERS
from breaker.paper.run_numbers import numbers_of_life, numbers_of_motion

NAMES = [each.name for each in PARAMETERS]
OUTPUTS = [*NAMES, "onset"]


def quality():
    rows = []
    for posterior in ("amortised", "corrected"):
        for i, output in enumerate(OUTPUTS):
            rows.append(
                {
                    "posterior": posterior,
                    "output": output,
                    "calibration_p": 0.5,
                    "calibration_p_reader": 0.3 if output != "onset" else 0.004,
                    "z_sd": 0.98 + 0.01 * i,
                    "contraction": 0.1 * i + 0.004,
                    "shortfall": 0.001 * i,
                    "coverage_95": 0.93 + 0.004 * i,
                }
            )
    return pd.DataFrame(rows)


def draws(dimension, n, *, correlated=0.0, seed=1):
    """Log-normal draws; the first two parameters correlate, the eighth output is a time."""
    rng = generator(seed, "test numbers")
    normal = rng.standard_normal((n, 400, 8))
    normal[..., 1] = correlated * normal[..., 0] + np.sqrt(1 - correlated**2) * normal[..., 1]
    values = np.concatenate([np.exp(normal[..., :7]), normal[..., 7:]], axis=-1)
    return xr.Dataset({"draws": ((dimension, "draw", "output"), values)}, {"output": OUTPUTS})


@pytest.fixture(scope="module")
def tables():
    exactness = {"judged_curves": 200, "corrected_curves": 1000, "resolved": 0.999}
    exactness |= {"efficiency_median": 0.931, "efficiency_lowest": 0.57}
    exactness |= {"gap_nats": 0.0686, "gap_se": 0.0215, "c2st_median": 0.546}
    operations = draws("operation", 2000).assign(
        accepted=("operation", np.arange(2000) != 5),
        misfit=("operation", np.arange(2000) < 1240),
        travel=(("operation", "time"), np.array([[0.5, 0.5, 0.5, 3.0]]).repeat(2000, axis=0)),
    )
    prior = xr.Dataset({"travel": (("curve", "time"), np.linspace([0] * 4, [1] * 4, 50))})
    truth = np.ones((2000, 7))
    truth[-50:, 5] = 0.93
    simulated = {
        "value": (("operation", "parameter"), truth),
        "difference": ("operation", np.linspace(1.2, 1.58, 2000)),
    }
    operations, family = (
        each.assign_coords(operation=np.arange(2000))
        for each in (operations, draws("operation", 2000).sel(output=NAMES))
    )
    family["draws"] = family.draws + 100.0 * (np.arange(2000) >= 1000)[:, None, None]
    return {
        "quality": quality(),
        "exactness": pd.DataFrame([exactness]),
        "prior": prior,
        "validation": draws("curve", 100, correlated=-0.8),
        "operations": operations,
        "family": family,
        "predictive": xr.Dataset({"share_inside": ("stage", [0.97, 0.884, 1.0])}),
        "truth": xr.Dataset(simulated, {"operation": np.arange(2000), "parameter": list(NAMES)}),
    }


@pytest.fixture(scope="module")
def found(tables):
    return numbers_of_motion(**tables)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("contraction.k_b", "0.20"),
        ("z_sd.lowest", "0.98"),
        ("z_sd.highest", "1.05"),
        ("coverage_95.highest", "96"),
        ("shortfall", "0.01"),
        ("calibration_p", "1"),
        ("calibration_p_files", "0.032"),  # the least of eight times eight
        ("calibration_p_files.onset", "0.004"),
        ("gap", "0.07"),
        ("gap_se", "0.02"),
        ("c2st", "0.55"),
        ("efficiency_median", "93"),
        ("curves_resolved", "999"),
        ("misfit", "62"),
        ("paper_holds.f", "100"),
        ("family_holds.f", "50"),
        ("prior_inside", "75"),
        ("inside.lowest", "88"),
        ("inside.highest", "100"),
        ("true_change.f", "-7.0"),
        ("true_change.L", "0.0"),
        ("difference.highest", "1.6"),
    ],
)
def test_value(found, name, value):
    assert found[name] == value


def test_correlations_are_within_a_posterior_and_of_logarithms(found):
    # The median of a hundred estimates from 400 draws each is within 0.02 but for 1 in 1,000.
    assert float(found["correlation.mu.k_a"]) == pytest.approx(-0.8, abs=0.02)
    assert float(found["correlation.k_b.f"]) == pytest.approx(0.0, abs=0.02)


def test_measured_records_have_no_truth(found, tables):
    measured = numbers_of_motion(**tables | {"truth": None, "family": None})
    assert set(found) - set(measured) == {
        *("difference.lowest", "difference.highest"),
        *(f"{by}_change.{name}" for by in ("true", "paper", "family") for name in NAMES),
        *(f"{by}_holds.{name}" for by in ("paper", "family") for name in NAMES),
    }
    assert all(found[name] == value for name, value in measured.items())
    # Of the first and the last block with answers: of 100 more than once the last is.
    assert float(found["family_change.f"]) == pytest.approx(1e4, rel=0.1)
    assert abs(float(found["paper_change.f"])) < 10.0


def test_when_a_life_changed_and_what_was_decided():
    life = xr.Dataset({"noticed": ("change", [1824])})
    limits = pd.DataFrame({"limit": ["wide", "wide", "slow"], "certain": [25.0, 25.0, np.nan]})
    decisions = pd.DataFrame(
        {
            "operation": [1, 2, 3, 4],
            "state": ["ok", "planned", "planned", "due"],
            "service_by": [np.nan, 30.0, 20.0, 20.0],
        }
    )
    assert numbers_of_life(life, limits, decisions, {"wide": 18.0, "slow": np.nan}) == {
        "changes": "1",
        "change_1": "1,824",
        "wide.failure": "18",
        "wide.exceeded": "25",
        "first_plan": "2",
        "service_moves": "1",
    }
    nothing = decisions.assign(state="ok", service_by=np.nan)
    found = numbers_of_life(life.isel(change=[]), limits.iloc[:0], nothing, {})
    assert found == {"changes": "0"}
