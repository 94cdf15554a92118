"""From records to posteriors: draws, intervals, flags, stages, tables."""

import numpy as np
import pytest
import torch
import xarray as xr
from scipy.stats import chi2

from breaker.common.zarr_store import save
from breaker.model.parameters import NAMES, outputs
from breaker.paper.inference import (
    infer,
    predict,
    predict_stages,
    predictive_p_value,
    sample_records,
    validate,
)
from breaker.paper.validation import table
from breaker.records.curves import open_curves
from tests.networks_fixtures import exact_curves, frozen, operations_of, pin, simulated

DRAWS = 25


@pytest.fixture(scope="module")
def posterior():
    """A model of moderate width around the middle of the prior, some draws outside of it."""
    model = pin(frozen(curves=2048), 0.0, 2.0)
    # Records move its mean, so that draws of two operations are not the same.
    with torch.no_grad():
        weight = model.inference.head.weight
        rng = torch.Generator().manual_seed(4)
        weight[:8] = 0.3 * torch.randn((8, weight.shape[1]), generator=rng)
    model.solver_steps.fill_(2)
    model.density_solver_steps.fill_(2)
    return model


@pytest.fixture(scope="module")
def curves(posterior):
    """Seven measured operations as the reader hands them on: the second and last are rejected."""
    _, _, records = simulated(posterior, 7)
    accepted = np.array([True, False, True, True, True, True, False])
    reasons = ["", "line 40: travel is missing", "", "", "", "", "too short"]
    records[~accepted] = np.nan
    return operations_of(records, posterior.sensor.times).assign(
        accepted=("operation", accepted),
        reason=("operation", np.array(reasons)),
        first_motion=("operation", np.where(accepted, 20.0, np.nan)),
        operation=np.arange(3, 24, 3),
    )


@pytest.fixture(scope="module")
def inferred(posterior, curves):
    return infer(posterior, curves, draws=DRAWS, seed=1, misfit_p_value=1e-3)


# ---- inference of operations --------------------------------------------------------------------


def test_rejected_operations_stay_as_missing_values_with_their_reason(curves, inferred):
    rejected = ~curves.accepted.values
    for name in ("draws", "median", "interval_50", "interval_95", "p_value", "outside_support"):
        missing = np.isnan(inferred[name].values.reshape(7, -1))
        assert missing[rejected].all(), name
        assert not missing[~rejected].any(), name
    for name in ("misfit", "outside_prior"):
        assert inferred[name].dtype == bool
        assert not inferred[name].values[rejected].any()
    for name in ("travel", "accepted", "reason", "file", "first_motion", "operation"):
        np.testing.assert_array_equal(inferred[name].values, curves[name].values)


def test_intervals_and_shares_are_those_of_the_draws(posterior, curves, inferred):
    kept = inferred.isel(operation=np.flatnonzero(curves.accepted.values))
    draws = kept.draws.values.astype(np.float64)
    assert draws.shape == (5, DRAWS, 8)
    # Draws are stored in float32, the quantiles were taken before.
    for name, levels in (("interval_50", [0.25, 0.75]), ("interval_95", [0.025, 0.975])):
        expected = np.moveaxis(np.quantile(draws, levels, axis=1), 0, -1)
        np.testing.assert_allclose(kept[name], expected, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(kept["median"], np.median(draws, axis=1), rtol=1e-5, atol=1e-6)
    outside = (draws[..., 5] <= draws[..., 1] * draws[..., 6]).mean(axis=1)
    np.testing.assert_allclose(kept.outside_support.values, outside, rtol=0, atol=1e-12)
    assert 0 < outside.max() < 0.5
    assert kept.output.values.tolist() == [output.name for output in outputs(True)]
    assert kept.output_unit.values.tolist() == [output.unit for output in outputs(True)]
    for i, record in enumerate(kept.travel.values):
        p_value = predictive_p_value(posterior.model, record, draws[i])
        assert float(kept.p_value[i]) == pytest.approx(p_value, rel=1e-2, abs=1e-12)
    assert np.array_equal(kept.misfit.values, kept.p_value.values < 1e-3)


def test_chunks_give_the_draws_of_the_whole(posterior, curves, inferred, tmp_path):
    """Bit for bit, stored and read back: jobs may be cut anywhere, one of them all rejected."""
    stores = []
    for k, rows in enumerate((slice(0, 1), slice(1, 2), slice(2, 6), slice(6, 7))):
        part = infer(
            posterior, curves.isel(operation=rows), draws=DRAWS, seed=1, misfit_p_value=1e-3
        )
        stores.append(tmp_path / f"chunk_{k}.zarr")
        save(part, stores[-1])
    joined = open_curves(stores)
    assert set(joined.variables) == set(inferred.variables)
    for name in inferred.variables:
        np.testing.assert_array_equal(joined[name].values, inferred[name].values, err_msg=name)
    other = infer(posterior, curves.isel(operation=[0]), draws=DRAWS, seed=2, misfit_p_value=1e-3)
    assert not np.any(other.draws.values[0] == inferred.draws.values[0])


def test_flags_of_fit_and_prior(posterior, curves):
    """A certain model fits its own record, not one with a bump; a tripled curve is unlike all."""
    values, _, records = simulated(posterior, 1)
    certain = pin(frozen(curves=2048), posterior.model.standardise(values)[0], 1e-4)
    bump = 0.45 * np.exp(-np.square((posterior.sensor.times - 30) / 6))
    three = curves.isel(operation=[0, 2, 3]).copy(deep=True)
    three["travel"][:] = np.stack([records[0], records[0] + bump, 3 * records[0]])
    result = infer(certain, three, draws=DRAWS, seed=1, misfit_p_value=1e-3)
    assert result.misfit.values.tolist() == [False, True, True]
    assert result.outside_prior.values.tolist() == [False, False, True]
    np.testing.assert_allclose(result.distance, certain.distance(three.travel.values), rtol=1e-12)
    # The threshold is a setting: p-values do not depend on it.
    strict = infer(certain, three, draws=DRAWS, seed=1, misfit_p_value=0.999)
    np.testing.assert_array_equal(strict.p_value.values, result.p_value.values)
    assert strict.misfit.values.all()


@pytest.mark.parametrize(
    ("where", "kind"), [("distance", ValueError), ("sample", FloatingPointError)]
)
def test_an_operation_that_the_network_fails_on_leaves_the_rest(
    posterior, curves, inferred, monkeypatch, where, kind
):
    """It stays, with the reason; the others are as they were, bit for bit."""
    bad, right = curves.travel.values[3], getattr(posterior, where)

    def failing(measured, *more):
        if np.array_equal(measured[0], bad):
            raise kind("no answer for this one")
        return right(measured, *more)

    monkeypatch.setattr(posterior, where, failing)
    result = infer(posterior, curves, draws=DRAWS, seed=1, misfit_p_value=1e-3)
    assert result.reason.values[3] == "close_3.csv: no posterior: no answer for this one"
    assert not result.accepted.values[3]
    for name in ("draws", "median", "interval_95", "p_value", "outside_support"):
        assert np.isnan(result[name].values[3]).all(), name
    assert not result.misfit.values[3]
    # How far it is from the bank is known where that is not what failed.
    assert np.isnan(result.distance.values[3]) == (where == "distance")
    others = [0, 1, 2, 4, 5, 6]
    xr.testing.assert_identical(
        result.isel(operation=others).drop_vars("reason"),
        inferred.isel(operation=others).drop_vars("reason"),
    )
    assert result.reason.values[others].tolist() == inferred.reason.values[others].tolist()


# ---- validation ---------------------------------------------------------------------------------


@pytest.mark.parametrize(("motion", "onset"), [("closing", True), ("opening", False)])
def test_validation_pairs_truth_and_record(motion, onset):
    """Measured records lie around the exact curves of their truth: chi-square, exactly."""
    posterior = pin(frozen(motion=motion, onset=onset), 0.0, 0.5)
    data = validate(posterior, 60, 4, seed=11)
    q = 8 if onset else 7
    assert data.draws.dims == ("curve", "draw", "output")
    assert data.draws.shape == (60, 4, q)
    assert data.output.values.tolist() == [*NAMES, "onset"][:q]
    values, measured = data.truth.values, data.measured.values
    total = posterior.sensor.chi_square(measured, exact_curves(posterior, values)).sum()
    # The bank keeps curves in float32, which adds nothing here. False-alarm probability 1e-3.
    low, high = chi2.interval(1 - 1e-3, measured.size)
    assert low < total < high
    if onset:  # planted fault: the onset left out
        still = exact_curves(posterior, values[:, :7])
        assert posterior.sensor.chi_square(measured, still).sum() > high


def test_validation_follows_its_seed_and_nothing_else(posterior):
    data, again, other = (validate(posterior, 6, 5, seed=seed) for seed in (11, 11, 12))
    xr.testing.assert_identical(data, again)
    assert not np.any(data.truth.values == other.truth.values)
    assert (data.attrs["seed"], data.attrs["solver_steps"]) == (11, 2)
    # The draws of a record depend on its number and the seed, not on how many there are.
    part = sample_records(posterior, data.measured.values[:3], data.truth.values[:3], 5, 11)
    np.testing.assert_array_equal(part.draws.values, data.draws.values[:3])


# ---- stages ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("stages", "expected"), [(3, [3, 12, 18]), (1, [3]), (99, [3, 9, 12, 15, 18])]
)
def test_stages_are_accepted_operations_over_the_whole_life(posterior, inferred, stages, expected):
    result = predict_stages(posterior.model, inferred, stages=stages, seed=1)
    assert result.operation.values.tolist() == expected
    with pytest.raises(ValueError, match="no operation has a posterior"):
        predict_stages(posterior.model, inferred.sel(operation=[6, 21]), stages=2, seed=1)
    part = inferred.sel(operation=expected)
    np.testing.assert_array_equal(result.travel.values, part.travel.values)
    for name in ("p_value", "misfit"):
        np.testing.assert_array_equal(result[name].values, part[name].values)
    whole = predict(posterior.model, part.travel.values, part.draws.values, seed=1)
    for name in ("median", "lower", "upper"):
        np.testing.assert_array_equal(result[name].values, whole[name].values)


def test_share_inside_counts_the_main_motion_alone(posterior, curves):
    """Up to three quarters of the way of a closing; here by hand, from the exact curve."""
    values, exact, records = simulated(posterior, 1)
    certain = pin(frozen(curves=2048), posterior.model.standardise(values)[0], 1e-4)
    times = posterior.sensor.times
    first, after = (int(np.searchsorted(times, t)) for t in (0.0, 40.0))
    last = next(k for k, x in enumerate(exact[0]) if x >= 0.75 * exact[0, -1])
    odd = np.zeros((2, times.size))
    odd[0, first + 1], odd[1, after:] = 1.0, 0.5 * np.resize([1, -1], times.size - after)
    three = curves.isel(operation=[0, 2, 3]).copy(deep=True)
    three["travel"][:] = np.stack([records[0], *(records[0] + odd)])
    found = infer(certain, three, draws=100, seed=1, misfit_p_value=0.5)
    result = predict_stages(certain.model, found, stages=3, seed=1)
    travel = three.travel.values
    inside = (travel >= result.lower.values) & (travel <= result.upper.values)
    expected = inside[:, first:last].mean(axis=1)
    np.testing.assert_allclose(result.share_inside.values, expected, rtol=1e-12)
    assert result.main_motion_end.values[0] == times[last - 1]
    assert 0 < last - first < 10
    # Planted: one sample of the main motion is off, and many samples after it are.
    assert expected[1] < expected[0]
    assert expected[2] - inside[2].mean() > 0.1


# ---- table --------------------------------------------------------------------------------------


def test_table_is_tidy(inferred):
    rows = table(inferred)
    assert len(rows) == 7 * 8
    assert not rows.duplicated(["operation", "output"]).any()
    assert rows.columns.tolist() == [
        *("operation", "output", "unit", "median"),
        *("interval_50_lower", "interval_50_upper", "interval_95_lower", "interval_95_upper"),
        *("p_value", "misfit", "outside_prior", "outside_support", "accepted", "reason", "file"),
        "far_onset",
    ]
    assert rows.operation.tolist() == [k for k in range(3, 24, 3) for _ in range(8)]
    assert rows.output.tolist()[:8] == [*NAMES, "onset"]
    units = dict(zip(rows.output, rows.unit, strict=True))
    assert (units["L"], units["mu"], units["onset"]) == ("mm", "1", "ms")
    by_output = rows.set_index(["operation", "output"])
    for name, each in (
        ("median", inferred["median"]),
        ("interval_95_lower", inferred.interval_95.sel(bound="lower")),
        ("interval_50_upper", inferred.interval_50.sel(bound="upper")),
    ):
        np.testing.assert_array_equal(by_output[name].unstack()[inferred.output.values], each)
    for name in ("p_value", "misfit", "outside_prior", "accepted", "reason", "file"):
        np.testing.assert_array_equal(rows[name], np.repeat(inferred[name].values, 8))
    assert rows[rows.operation == 6]["median"].isna().all()


def test_what_is_known_of_operations_is_in_the_table_and_nothing_empty(inferred):
    known = {
        "breaker": [""] * 7,
        "date": ["2024-11-20", *[""] * 6],
        "temperature": [np.nan, 21.5, *[np.nan] * 5],
        "event": [*[""] * 6, "greased"],
    }
    rows = table(inferred.assign({name: ("operation", each) for name, each in known.items()}))
    added = [name for name in rows.columns if name not in table(inferred).columns]
    assert added == ["date", "temperature", "event"]
    first = rows.drop_duplicates("operation")
    assert first.event.tolist() == known["event"]
    assert first.date.tolist() == known["date"]
    np.testing.assert_array_equal(first.temperature, known["temperature"])
