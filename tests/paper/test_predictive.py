"""From records to posteriors: draws, intervals, flags, predictions, tables."""

import numpy as np
import pytest
import torch
import xarray as xr
from scipy.stats import chi2

from breaker.model.parameters import NAMES
from breaker.paper.inference import (
    infer,
    main_motion,
    predict,
    predict_stages,
    predictive_p_value,
    sample_records,
    validate,
)
from breaker.paper.validation import table
from tests.model.laws import covariance
from tests.networks_fixtures import exact_curves, frozen, noise_of, pin, simulated

HOW = {"draws": 25, "seed": 1, "misfit_p_value": 1e-3}
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
    columns = {"accepted": ACCEPTED, "reason": np.where(ACCEPTED, "", "too short")}
    columns["file"] = [f"close_{k}.csv" for k in range(7)]
    data = {name: ("operation", values) for name, values in columns.items()}
    data["travel"] = ("operation", "time"), records
    return xr.Dataset(data, {"operation": np.arange(3, 24, 3), "time": posterior.sensor.times})


@pytest.fixture(scope="module")
def inferred(posterior, curves):
    return infer(posterior, curves, **HOW)


def test_intervals_and_shares_are_those_of_the_draws(posterior, curves, inferred):
    """Rejected operations stay as missing values with their reason."""
    for name in ("draws", "median", "interval_50", "interval_95", "p_value"):
        missing = np.isnan(inferred[name].values.reshape(7, -1)).all(axis=1)
        assert np.array_equal(missing, ~ACCEPTED), name
    np.testing.assert_array_equal(inferred.reason, curves.reason)
    kept = inferred.isel(operation=np.flatnonzero(ACCEPTED))
    draws = kept.draws.values.astype(np.float64)
    # Draws are stored in float32, the quantiles were taken before.
    for name, levels in (("interval_50", [0.25, 0.75]), ("interval_95", [0.025, 0.975])):
        expected = np.moveaxis(np.quantile(draws, levels, axis=1), 0, -1)
        np.testing.assert_allclose(kept[name], expected, rtol=1e-5, atol=1e-6)
    rows = table(inferred)
    assert rows.operation.tolist() == [k for k in range(3, 24, 3) for _ in range(8)]
    assert rows.output.tolist() == [*NAMES, "onset"] * 7
    np.testing.assert_array_equal(rows["median"], inferred["median"].values.ravel())


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
    same = ~np.isin(np.arange(7), 3)
    np.testing.assert_array_equal(result.draws[same], inferred.draws[same])


def test_flags_of_fit_and_prior(posterior, curves):
    """A certain model fits its own record, not one with a bump; a tripled curve is unlike all."""
    values, _, (record,) = simulated(posterior, 1)
    model = pin(frozen(curves=2048), posterior.model.standardise(values)[0], 1e-4)
    bump = 0.45 * np.exp(-np.square((model.sensor.times - 30) / 6))
    chosen = curves.isel(operation=[0, 2, 3]).copy(deep=True)
    chosen["travel"][:] = np.stack([record, record + bump, 3 * record])
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


def test_validation_pairs_truth_and_record():
    """Measured records lie around the exact curves of their truth: chi-square, false alarm 1e-3;
    planted fault: the onset left out. Draws of a record depend on seed and number alone.
    """
    posterior = pin(frozen(), 0.0, 0.5)
    data, other = (validate(posterior, 60, 4, seed=seed) for seed in (11, 12))
    values, measured = data.truth.values, data.measured.values
    total, still = (
        posterior.sensor.chi_square(measured, exact_curves(posterior, values[:, :q])).sum()
        for q in (8, 7)
    )
    low, high = chi2.interval(1 - 1e-3, measured.size)
    assert low < total < high < still
    assert not np.any(values == other.truth.values)
    part = sample_records(posterior, measured[:3], values[:3], 4, 11)
    np.testing.assert_array_equal(part.draws.values, data.draws.values[:3])


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
    band, again = (predict(posterior.model, records, draws, seed=1) for _ in range(2))
    xr.testing.assert_identical(band, again)
    sensor, t = posterior.sensor, exact.shape[1]
    variance = 1 / (sensor.zero_sd**-2 + t * sensor.noise_sd**-2)
    zero = variance * t * sensor.noise_sd**-2 * (records - exact).mean(axis=1, keepdims=True)
    sd = np.sqrt(sensor.noise_sd**2 + variance)
    # A quantile of 2,000 replicates has a standard error of 2.7 sd / sqrt(2000), a median 1.25:
    # 3 x 31 numbers each within 4.4 of them is a false-alarm probability of 1e-3 each.
    for name, sds, error in (("median", 0, 1.25), ("lower", -1.96, 2.7), ("upper", 1.96, 2.7)):
        off = np.abs(band[name].values - (exact + zero + sds * sd)).max()
        assert off < 4.4 * error * sd / np.sqrt(2000), name


def test_stages_are_accepted_operations_over_the_whole_life(posterior, inferred):
    for stages, expected in ((3, [3, 12, 18]), (99, [3, 9, 12, 15, 18])):
        result = predict_stages(posterior.model, inferred, stages=stages, seed=1)
        assert result.operation.values.tolist() == expected
    with pytest.raises(ValueError, match="no operation has a posterior"):
        predict_stages(posterior.model, inferred.sel(operation=[6, 21]), stages=2, seed=1)


@pytest.mark.parametrize(("motion", "share"), [("closing", 0.75), ("opening", 0.85)])
def test_the_main_motion_is_a_share_of_the_way_from_the_onset_on(motion, share):
    times = np.arange(-10.0, 100.0)
    travel = 2.0 + 14.0 * np.clip(times / 40.0, 0.0, 1.0)
    travel = travel if motion == "closing" else 20.0 - travel
    expected = (times >= 0) & (times / 40.0 < share)
    np.testing.assert_array_equal(main_motion(travel, times, motion), expected)
