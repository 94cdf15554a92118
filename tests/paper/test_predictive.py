"""From records to posteriors: draws, intervals, flags, predictions, tables."""

import numpy as np
import pytest
import torch
import xarray as xr
from scipy.stats import chi2

from breaker.model.parameters import NAMES
from breaker.paper.inference import (
    infer,
    predict,
    predict_stages,
    predictive_p_value,
    sample_records,
    validate,
)
from breaker.paper.validation import table
from tests.model.laws import covariance
from tests.networks_fixtures import exact_curves, frozen, noise_of, operations_of, pin, simulated

DRAWS = 25
HOW = {"draws": DRAWS, "seed": 1, "misfit_p_value": 1e-3}
ACCEPTED = np.array([True, False, True, True, True, True, False])


@pytest.fixture(scope="module")
def posterior():
    """A model of moderate width around the middle of the prior."""
    model = pin(frozen(curves=2048), 0.0, 2.0)
    # Records move its mean, so that draws of two operations are not the same.
    with torch.no_grad():
        weight = model.inference.head.weight
        rng = torch.Generator().manual_seed(4)
        weight[:8] = 0.3 * torch.randn((8, weight.shape[1]), generator=rng)
    return model


@pytest.fixture(scope="module")
def curves(posterior):
    """Seven measured operations as the reader hands them on: the second and last are rejected."""
    _, _, records = simulated(posterior, 7)
    records[~ACCEPTED] = np.nan
    return operations_of(records, posterior.sensor.times).assign(
        accepted=("operation", ACCEPTED),
        reason=("operation", np.where(ACCEPTED, "", "too short")),
        operation=np.arange(3, 24, 3),
    )


@pytest.fixture(scope="module")
def inferred(posterior, curves):
    return infer(posterior, curves, **HOW)


@pytest.fixture(scope="module")
def certain(posterior):
    """A truth ``(8,)``, its exact curve and record ``(t,)``, and a model certain of it."""
    values, exact, records = simulated(posterior, 1)
    model = pin(frozen(curves=2048), posterior.model.standardise(values)[0], 1e-4)
    return exact[0], records[0], model


def three(curves, *records):
    """Three operations with other records."""
    chosen = curves.isel(operation=[0, 2, 3]).copy(deep=True)
    chosen["travel"][:] = np.stack(records)
    return chosen


# ---- inference of operations --------------------------------------------------------------------


def test_intervals_and_shares_are_those_of_the_draws(posterior, curves, inferred):
    """Rejected operations stay as missing values with their reason."""
    for name in ("draws", "median", "interval_50", "interval_95", "p_value"):
        missing = np.isnan(inferred[name].values.reshape(7, -1)).all(axis=1)
        assert np.array_equal(missing, ~ACCEPTED), name
    for name in ("travel", "accepted", "reason", "file", "operation"):
        np.testing.assert_array_equal(inferred[name].values, curves[name].values)
    kept = inferred.isel(operation=np.flatnonzero(ACCEPTED))
    draws = kept.draws.values.astype(np.float64)
    # Draws are stored in float32, the quantiles were taken before.
    for name, levels in (("interval_50", [0.25, 0.75]), ("interval_95", [0.025, 0.975])):
        expected = np.moveaxis(np.quantile(draws, levels, axis=1), 0, -1)
        np.testing.assert_allclose(kept[name], expected, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(kept["median"], np.median(draws, axis=1), rtol=1e-5, atol=1e-6)
    for i, record in enumerate(kept.travel.values):
        p_value = predictive_p_value(posterior.model, record, draws[i])
        assert float(kept.p_value[i]) == pytest.approx(p_value, rel=1e-2, abs=1e-12)


def test_an_operation_depends_on_no_other(posterior, curves, inferred, monkeypatch):
    """Bit for bit: jobs may be cut anywhere, one of them all rejected. A network that fails on one
    leaves the rest, and says why."""
    parts = [curves.isel(operation=rows) for rows in (slice(0, 1), slice(1, 2), slice(2, 7))]
    joined = xr.concat([infer(posterior, part, **HOW) for part in parts], "operation")
    xr.testing.assert_identical(joined, inferred)
    other = infer(posterior, curves.isel(operation=[0]), **HOW | {"seed": 2})
    assert not np.any(other.draws.values[0] == inferred.draws.values[0])
    bad, right = curves.travel.values[3], posterior.sample

    def failing(measured, *more):
        if np.array_equal(measured[0], bad):
            raise FloatingPointError("no answer for this one")
        return right(measured, *more)

    monkeypatch.setattr(posterior, "sample", failing)
    result = infer(posterior, curves, **HOW)
    assert result.reason.values[3] == "close_3.csv: no posterior: no answer for this one"
    assert not (result.accepted | result.misfit).values[3]
    assert np.isnan(result.draws.values[3]).all()
    others = [0, 1, 2, 4, 5, 6]
    one, other = (item.isel(operation=others).drop_vars("reason") for item in (result, inferred))
    xr.testing.assert_identical(one, other)


def test_flags_of_fit_and_prior(certain, curves):
    """A certain model fits its own record, not one with a bump; a tripled curve is unlike all."""
    _, record, model = certain
    bump = 0.45 * np.exp(-np.square((model.sensor.times - 30) / 6))
    chosen = three(curves, record, record + bump, 3 * record)
    result = infer(model, chosen, **HOW)
    assert result.misfit.values.tolist() == [False, True, True]
    assert result.outside_prior.values.tolist() == [False, False, True]
    np.testing.assert_allclose(result.distance, model.distance(chosen.travel.values), rtol=1e-12)


def test_records_that_a_network_does_not_accept_are_refused(series):
    posterior, good = series
    infinite, gaps = good.copy(), good.copy()
    infinite[2, 3], gaps[:2, 4] = -np.inf, np.nan
    faults = {"1 of 5 .* infinite": infinite, "2 of 5 .* missing": gaps, r"\(5, 16\)": good[:, ::2]}
    for words, records in faults.items():
        for refuse in (
            lambda some: posterior.sample(some, noise_of(posterior, 5, 2)),
            lambda some: posterior.log_prob(np.ones((5, 1, 8)), some),
            posterior.distance,
        ):
            with pytest.raises(ValueError, match=words):
                refuse(records)


@pytest.mark.parametrize(("motion", "onset"), [("closing", True), ("opening", False)])
def test_validation_pairs_truth_and_record(motion, onset):
    """Measured records lie around the exact curves of their truth: chi-square, exactly. All follows
    from the seed; the draws of a record depend on its number, not on how many there are."""
    posterior = pin(frozen(motion=motion, onset=onset), 0.0, 0.5)
    data, other = (validate(posterior, 60, 4, seed=seed) for seed in (11, 12))
    assert data.draws.shape == (60, 4, 8 if onset else 7)
    assert data.output.values.tolist() == [*NAMES, "onset"][: 8 if onset else 7]
    values, measured = data.truth.values, data.measured.values
    total = posterior.sensor.chi_square(measured, exact_curves(posterior, values)).sum()
    # The bank keeps curves in float32, which adds nothing here. False-alarm probability 1e-3.
    low, high = chi2.interval(1 - 1e-3, measured.size)
    assert low < total < high
    if onset:  # planted fault: the onset left out
        still = exact_curves(posterior, values[:, :7])
        assert posterior.sensor.chi_square(measured, still).sum() > high
    assert not np.any(values == other.truth.values)
    part = sample_records(posterior, measured[:3], values[:3], 4, 11)
    np.testing.assert_array_equal(part.draws.values, data.draws.values[:3])


# ---- predictions --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("motion", "onset", "every"), [("closing", True, 3), ("opening", False, 1)]
)
def test_p_value_is_in_closed_form(motion, onset, every):
    """In matrices, of the samples that are there; and the mean over draws."""
    posterior = frozen(motion=motion, onset=onset)
    values, exact, records = simulated(posterior, 40)
    there = np.arange(records.shape[1]) % every == 0
    records[:, ~there] = np.nan
    pairs = zip(records, values, strict=True)
    p_values = [predictive_p_value(posterior.model, record, row[None]) for record, row in pairs]
    residual, left = (records - exact)[:, there], covariance(posterior.sensor)[np.ix_(there, there)]
    squares = np.einsum("nt,nt->n", residual, np.linalg.solve(left, residual.T).T)
    np.testing.assert_allclose(p_values, chi2.sf(squares, there.sum()), rtol=1e-9, atol=1e-12)
    # Of three draws the truth alone explains the record.
    together = predictive_p_value(posterior.model, records[0], values[:3])
    assert together == pytest.approx(p_values[0] / 3, rel=1e-3)


def test_band_width_is_that_of_noise_and_zero(posterior):
    """By its own moments: half width 1.96 sd, with the zero's part that the record leaves open."""
    values, exact, records = simulated(posterior, 3)
    draws = np.repeat(values[:, None], 2000, axis=1)
    band, again, other = (predict(posterior.model, records, draws, seed=i) for i in (1, 1, 2))
    xr.testing.assert_identical(band, again)
    assert not np.any(band["median"].values == other["median"].values)
    sensor, t = posterior.sensor, exact.shape[1]
    prior_precision, data_precision = sensor.zero_sd**-2, t * sensor.noise_sd**-2
    variance = 1 / (prior_precision + data_precision)
    zero = variance * data_precision * (records - exact).mean(axis=1, keepdims=True)
    half_width = 1.959964 * np.sqrt(sensor.noise_sd**2 + variance)
    # A quantile of 2,000 replicates has a standard error of 2.7 sd / sqrt(2000), a median 1.25:
    # 3 x 31 numbers each within 4.4 of them is a false-alarm probability of 1e-3 each.
    unit = np.sqrt((sensor.noise_sd**2 + variance) / 2000)
    for name, expected, error in (
        ("median", exact + zero, 1.25),
        ("lower", exact + zero - half_width, 2.7),
        ("upper", exact + zero + half_width, 2.7),
    ):
        assert np.abs(band[name].values - expected).max() < 4.4 * error * unit, name


def test_stages_are_accepted_operations_over_the_whole_life(posterior, inferred):
    for stages, expected in ((3, [3, 12, 18]), (99, [3, 9, 12, 15, 18])):
        result = predict_stages(posterior.model, inferred, stages=stages, seed=1)
        assert result.operation.values.tolist() == expected
    known = inferred.sel(operation=expected)
    bands = predict(posterior.model, known.travel.values, known.draws.values, seed=1)
    np.testing.assert_array_equal(result.upper.values, bands.upper.values)
    with pytest.raises(ValueError, match="no operation has a posterior"):
        predict_stages(posterior.model, inferred.sel(operation=[6, 21]), stages=2, seed=1)


def test_share_inside_counts_the_main_motion_alone(certain, curves):
    """Up to three quarters of the way of a closing; here by hand, from the exact curve."""
    exact, record, model = certain
    times = model.sensor.times
    first, after = (int(np.searchsorted(times, t)) for t in (0.0, 40.0))
    last = next(k for k, x in enumerate(exact) if x >= 0.75 * exact[-1])
    odd = np.zeros((2, times.size))
    odd[0, first + 1], odd[1, after:] = 1.0, 0.5 * np.resize([1, -1], times.size - after)
    answer = infer(model, three(curves, record, *(record + odd)), **HOW | {"draws": 100})
    result = predict_stages(model.model, answer, stages=3, seed=1)
    travel = result.travel.values
    inside = (travel >= result.lower.values) & (travel <= result.upper.values)
    expected = inside[:, first:last].mean(axis=1)
    np.testing.assert_allclose(result.share_inside.values, expected, rtol=1e-12)
    assert result.main_motion_end.values[0] == times[last - 1]
    # Planted: one sample of the main motion is off, and many samples after it are.
    assert expected[1] < expected[0]
    assert expected[2] - inside[2].mean() > 0.1


def test_a_table_has_a_row_for_each_output(inferred):
    rows = table(inferred)
    assert rows.operation.tolist() == [k for k in range(3, 24, 3) for _ in range(8)]
    assert rows.output.tolist() == [*NAMES, "onset"] * 7
    np.testing.assert_array_equal(rows["median"], inferred["median"].values.ravel())
    lower = inferred.interval_95.sel(bound="lower").values
    np.testing.assert_array_equal(rows.interval_95_lower, lower.ravel())
