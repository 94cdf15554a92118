"""Corrected posteriors of many records, and the judge, against posteriors known in closed form.

The curves of ``Linear`` are linear in the standardised outputs, so that posteriors, evidences, and
the divergence and efficiency of a Gaussian too wide or too narrow are formulas.
"""

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy.stats import multivariate_normal, norm
from scipy.stats import t as student

from breaker.mechanism.curves import Motion
from breaker.mechanism.parameters import MOTIONS, NAMES
from breaker.model.joint import Model
from breaker.model.prior import Prior
from breaker.model.randomness import generator
from breaker.model.sensor import Sensor
from breaker.posterior.exactness import correct_operations, correct_validation, judge
from breaker.posterior.predictive import predictive_p_value, summaries, validate
from breaker.posterior.tables import beside, choose, summary, table, table_of_both
from breaker.records.opened import open_curves
from breaker.stores import describe, save
from breaker.validation.calibration import calibration_p_values, family_p_value, ranks
from tests.corrections import SETTINGS, errors_p_value, from_prior, means_p_value
from tests.networks_fixtures import MARKS, frozen, pin

pytestmark = MARKS

UNREACHED = SETTINGS | {"smallest_size": 2000, "rounds": 1}  # no weights are that even
HOW = {
    "resolved": bool,
    "why_unresolved": str,
    "rounds": int,
    "effective_size": float,
    "efficiency": float,
    "pareto_k": float,
    "faulty_weights": int,
    "log_evidence": float,
    "log_evidence_se": float,
}
Q, SAMPLES = 8, 15
SLOPES = 0.12 * generator(1, "test exactness", "slopes").standard_normal((SAMPLES, Q))
SENSOR = Sensor(start=-2.0, stop=54.0, samples=SAMPLES, noise_sd=0.1, onset_sd=0.3, zero_sd=0.1)
NOISE = 0.1**2 * np.eye(SAMPLES) + 0.1**2
SCALES = {
    "log_sds": np.array([0.20, 0.15, 0.20, 0.20, 0.40, 0.10, 0.05]),
    "medians": np.array([2.0, 0.045, 0.040, 0.30, 0.12, 5.0, 10.0]),
}


class Linear(Model):
    """The condition f > k_a L is 13 prior sds away, so that its posteriors are Gaussian."""

    def expected(self, values):
        return Motion(self.standardise(values) @ SLOPES.T, np.full(len(values), np.inf), None)

    def exact(self, record):
        """Mean, covariance and log evidence, of the samples that are there."""
        there = ~np.isnan(record)
        slopes, noise, seen = SLOPES[there], NOISE[np.ix_(there, there)], record[there]
        covariance = np.linalg.inv(np.eye(Q) + slopes.T @ np.linalg.solve(noise, slopes))
        mean = covariance @ slopes.T @ np.linalg.solve(noise, seen)
        law = multivariate_normal(np.zeros(seen.size), slopes @ slopes.T + noise)
        return mean, covariance, law.logpdf(seen)


MODEL = Linear(Prior(**SCALES), SENSOR, "closing")
# The condition cuts posteriors in two: their exact forms are not known, their support is.
CUT = Linear(
    Prior(SCALES["medians"] * [1, 1, 1, 1, 1, 0.11, 1], SCALES["log_sds"]), SENSOR, "closing"
)


def records_of(model, n, name):
    """Truth ``(n, q)``, physical units, and records ``(n, t)``."""
    rng = generator(1, "test exactness", name)
    values = from_prior(model, n, rng)
    return values, model.sensor.corrupt(model.curves(values), rng)


def gaussian_draws(model, records, draws, name, *, shift=0.0, width=1.0):
    """Draws ``(n, d, q)`` of exact posteriors, moved and widened by so many of their sds."""
    rng = generator(1, "test exactness", name, "draws")
    found = []
    for record in records:
        mean, covariance, _ = Linear.exact(model, record)
        off = shift * np.sqrt(np.diag(covariance))
        e = rng.standard_normal((draws, Q)) @ np.linalg.cholesky(covariance).T
        found.append(model.destandardise(mean + off + width * e))
    return np.array(found)


def validation(n, name, *, model=MODEL, draws=300, missing=0, **fault):
    """In the layout of ``validate``: exact posteriors, or with a fault."""
    truth, records = records_of(model, n, name)
    records[:, generator(1, name).permutation(SAMPLES)[:missing]] = np.nan
    return xr.Dataset(
        {
            "draws": (
                ("curve", "draw", "output"),
                gaussian_draws(model, records, draws, name, **fault),
            ),
            "truth": (("curve", "output"), truth),
            "measured": (("curve", "time"), records, {"unit": "mm"}),
        },
        coords={"output": model.names, "time": model.sensor.times},
        attrs={"motion": "closing", "seed": 1},
    )


def moments_p_value(data):
    """Of means, and of squares, of draws in units of the exact posterior: Student's t.

    Records are independent, so their scatter is the Monte-Carlo error. Weights of effective size
    1200 shift a mean by about 1 / 1200, a tenth of the error over 30 records.
    """
    found = []
    for record, draws in zip(data.measured.values, data.draws.values, strict=True):
        mean, covariance, _ = MODEL.exact(record)
        centred = MODEL.standardise(draws) - mean
        e = np.linalg.solve(np.linalg.cholesky(covariance), centred.T)
        found.append(np.r_[e.mean(axis=1), np.square(e).mean(axis=1) - 1.0])
    return means_p_value(found)


def evidence_p_value(data):
    """Of the log evidence."""
    expected = np.array([MODEL.exact(record)[2] for record in data.measured.values])
    return errors_p_value(data.log_evidence.values - expected, data.log_evidence_se.values)


# ---- simulated records ---------------------------------------------------------------------------


@pytest.mark.parametrize("missing", [0, 6])
def test_draws_that_are_off_are_brought_back(missing):
    """Moments and evidence: false alarm 1e-3 each. Uncorrected, the same test fails."""
    data = validation(30, f"shifted {missing}", missing=missing, shift=1.0, width=1.4)
    corrected = correct_validation(MODEL, data, SETTINGS, seed=1)
    assert corrected.resolved.values.all()
    assert moments_p_value(corrected) > 1e-3
    assert evidence_p_value(corrected) > 1e-3
    assert moments_p_value(data) < 1e-9
    # A narrow fault, in the other direction: the evidence of the next record.
    wrong = corrected.assign(log_evidence=corrected.log_evidence.roll(curve=1))
    assert evidence_p_value(wrong) < 1e-9


@pytest.fixture(scope="module")
def shifted():
    return validation(6, "few", shift=1.0)


@pytest.fixture(scope="module")
def corrected(shifted):
    return correct_validation(MODEL, shifted, SETTINGS, seed=1)


def test_what_is_added_and_what_stays(shifted, corrected):
    assert set(corrected.data_vars) == {"draws", "truth", "measured", *HOW}
    for name, kind in HOW.items():
        assert corrected[name].dims == ("curve",)
        assert np.issubdtype(corrected[name].dtype, np.dtype(kind).type), name
    xr.testing.assert_identical(
        corrected[["truth", "measured"]].drop_attrs(deep=False),
        shifted[["truth", "measured"]].drop_attrs(deep=False),
    )
    assert corrected.attrs == shifted.attrs
    assert corrected.draws.dims == shifted.draws.dims
    assert corrected.draws.shape == shifted.draws.shape
    assert not np.any(corrected.draws.values == shifted.draws.values)
    assert (corrected.why_unresolved == "").all()
    assert (corrected.rounds >= 1).all()
    np.testing.assert_allclose(corrected.efficiency, corrected.effective_size / 2000, rtol=1e-12)
    assert (corrected.effective_size > 400).all()
    assert (corrected.pareto_k < 0.7).all()
    assert (corrected.faulty_weights == 0).all()


def test_a_record_does_not_depend_on_those_beside_it(shifted, corrected):
    """Bit for bit; and the same again, but not with another seed."""
    part = correct_validation(MODEL, shifted.isel(curve=slice(4)), SETTINGS, seed=1)
    xr.testing.assert_identical(part, corrected.isel(curve=slice(4)))
    again = correct_validation(MODEL, shifted, SETTINGS, seed=1)
    xr.testing.assert_identical(again, corrected)
    other = correct_validation(MODEL, shifted.isel(curve=[0]), SETTINGS, seed=2)
    assert not np.any(other.draws.values == corrected.draws.values[:1])
    # Another motion has generators of its own.
    motion = Linear(MODEL.prior, SENSOR, "opening")
    opening = correct_validation(motion, shifted.isel(curve=[0]), SETTINGS, seed=1)
    assert not np.any(opening.draws.values == corrected.draws.values[:1])


def test_unresolved_records_stay_with_their_reason(shifted, tmp_path):
    """Finite draws where weights are poor, nan where there is no map, and both in a store."""
    data = shifted.copy(deep=True)
    data.draws[1] = data.draws[1, 0]
    result = correct_validation(MODEL, data, UNREACHED, seed=1)
    assert not result.resolved.any()
    lost = np.arange(6) == 1
    assert np.isnan(result.draws.values[lost]).all()
    assert np.isfinite(result.draws.values[~lost]).all()
    assert result.why_unresolved.values[1].startswith("no map: ")
    for i in np.flatnonzero(~lost):
        size = float(result.effective_size[i])
        assert result.why_unresolved.values[i] == f"effective size {size:.0f}, 2000 are needed"
    for name in ("effective_size", "efficiency", "pareto_k", "log_evidence", "log_evidence_se"):
        assert np.isnan(result[name].values).tolist() == lost.tolist(), name
    assert result.rounds.values.tolist() == [1, 0, 1, 1, 1, 1]
    save(describe(result, "test"), tmp_path / "store.zarr")
    stored = xr.open_zarr(tmp_path / "store.zarr", chunks=None).load()
    for name in result.variables:
        np.testing.assert_array_equal(stored[name].values, result[name].values, err_msg=name)


@pytest.mark.parametrize("motion", MOTIONS)
def test_the_breaker_itself(defaults, motion):
    """Default model and settings, crude draws: resolved, with the truth where it should be.

    Ranks of eight outputs in four records: false alarm 1e-3. The crude draws, which lie half a
    prior sd above the truth, fail.
    """
    model = Model.from_settings({**defaults, "motion": motion})
    truth, records = records_of(model, 4, motion)
    rng = generator(1, "test exactness", "crude", motion)
    z = model.standardise(truth)[:, None] + 0.5 + 0.2 * rng.standard_normal((4, 100, Q))
    data = xr.Dataset(
        {
            "draws": (("curve", "draw", "output"), model.destandardise(z)),
            "truth": (("curve", "output"), truth),
            "measured": (("curve", "time"), records),
        }
    )
    result = correct_validation(model, data, defaults["correction"], seed=1)
    assert result.resolved.all()
    assert model.prior.supported(result.draws.values[..., : len(NAMES)]).all()
    p_values = calibration_p_values(ranks(result.draws.values, truth), 100)
    assert family_p_value(p_values) > 1e-3
    assert family_p_value(calibration_p_values(ranks(data.draws.values, truth), 100)) < 1e-4


# ---- operations ----------------------------------------------------------------------------------

OPERATIONS = np.arange(4, 25, 4)
REJECTED, FAILED, BUMP = 1, 3, 4  # by the reader, by the network, and one that fits no curve


def summarised(model, travel, draws, misfit_p_value):
    """What ``infer`` makes of draws."""
    p_value = np.array(
        [predictive_p_value(model, *each) for each in zip(travel, draws, strict=True)]
    )
    return summaries(model, draws, p_value, misfit_p_value)


@pytest.fixture(scope="module")
def inferred():
    """Six operations in the layout of ``infer``, from a network that is one sd off."""
    _, travel = records_of(CUT, 6, "endurance")
    travel[BUMP, 7] += 1.5
    draws = gaussian_draws(CUT, travel, 100, "endurance", shift=1.0)
    draws[[REJECTED, FAILED]] = np.nan
    travel[REJECTED] = np.nan
    reasons = np.array(["", "line 40: travel is missing", "", "close_16.csv: no posterior", "", ""])
    distance = np.where(np.arange(6) == REJECTED, np.nan, [0.4, 0.0, 0.7, 2.0, 1.3, 0.2])
    return xr.Dataset(
        {
            "travel": (("operation", "time"), travel),
            "accepted": ("operation", reasons == ""),
            "reason": ("operation", reasons),
            "file": ("operation", np.array([f"close_{k}.csv" for k in OPERATIONS])),
            "first_motion": ("operation", np.where(np.arange(6) == REJECTED, np.nan, 20.0)),
            "distance": ("operation", distance),
            "outside_prior": ("operation", distance > 1.0),
            **summarised(CUT, travel, draws, 1e-3),
        },
        coords={
            "operation": OPERATIONS,
            "time": SENSOR.times,
            "output": CUT.names,
            "output_unit": ("output", [output.unit for output in CUT.outputs]),
        },
        attrs={"motion": "closing", "title": "test"},
    )


def correct_these(data, *, seed=1, settings=SETTINGS, misfit_p_value=1e-3):
    return correct_operations(CUT, data, settings, seed=seed, misfit_p_value=misfit_p_value)


@pytest.fixture(scope="module")
def operations(inferred):
    return correct_these(inferred)


def test_operations_without_a_posterior_stay_so(operations):
    absent = np.isin(np.arange(6), [REJECTED, FAILED])
    for name in ("draws", "median", "interval_50", "interval_95", "p_value", "outside_support"):
        missing = np.isnan(operations[name].values.reshape(6, -1))
        assert missing[absent].all(), name
        assert not missing[~absent].any(), name
    assert operations.resolved.values.tolist() == (~absent).tolist()
    assert (operations.rounds.values > 0).tolist() == (~absent).tolist()
    assert np.isnan(operations.effective_size.values).tolist() == absent.tolist()
    # Nobody tried: what is wrong with them stands in ``reason``.
    assert (operations.why_unresolved == "").all()
    assert not operations.misfit.values[absent].any()


def test_what_does_not_follow_from_draws_stays(inferred, operations):
    for name in ("travel", "accepted", "reason", "file", "first_motion", "distance"):
        np.testing.assert_array_equal(operations[name].values, inferred[name].values)
    np.testing.assert_array_equal(operations.outside_prior, inferred.outside_prior)
    assert set(operations.variables) == {*inferred.variables, *HOW}
    assert operations.attrs == inferred.attrs


def test_all_that_follows_from_draws_is_of_the_corrected_ones(inferred, operations):
    """Recomputed from the corrected draws, which are stored in float32."""
    kept = operations.isel(operation=np.flatnonzero(operations.accepted.values))
    before = inferred.sel(operation=kept.operation)
    draws = kept.draws.values.astype(np.float64)
    by_hand = {
        "median": np.median(draws, axis=1),
        "interval_50": np.moveaxis(np.quantile(draws, [0.25, 0.75], axis=1), 0, -1),
        "interval_95": np.moveaxis(np.quantile(draws, [0.025, 0.975], axis=1), 0, -1),
        "p_value": [
            predictive_p_value(CUT, *each) for each in zip(kept.travel.values, draws, strict=True)
        ],
    }
    for name, expected in by_hand.items():
        np.testing.assert_allclose(kept[name], expected, rtol=1e-4, atol=1e-6, err_msg=name)
        assert not np.any(kept[name].values == before[name].values), name
    # The network's draws leave the support, weighted ones cannot.
    assert before.outside_support.max() > 0.2
    assert (kept.outside_support == 0).all()
    assert kept.misfit.values.tolist() == [False, False, True, False]
    assert kept.resolved.values.all()  # an exact posterior of a curve that the model cannot make
    strict = correct_these(inferred.isel(operation=[0]), misfit_p_value=1.0)
    assert strict.misfit.item()
    assert strict.p_value.item() == kept.p_value.values[0]


def test_an_operation_does_not_depend_on_those_beside_it(inferred, operations):
    """Bit for bit, in any order; its number names its generator."""
    rows = [4, 1, 2]
    xr.testing.assert_identical(
        correct_these(inferred.isel(operation=rows)), operations.isel(operation=rows)
    )
    renamed = inferred.isel(operation=[2]).assign_coords(operation=[99])
    assert not np.any(correct_these(renamed).draws.values == operations.draws.values[2])
    other = correct_these(inferred.isel(operation=[2]), seed=2)
    assert not np.any(other.draws.values == operations.draws.values[2])


def test_unresolved_operations_keep_what_follows_from_their_best_draws(inferred):
    data = inferred.copy(deep=True)
    data.draws[0] = data.draws[0, 0]
    result = correct_these(data, settings=UNREACHED)
    assert not result.resolved.any()
    tried = np.array(["effective size" in why for why in result.why_unresolved.values])
    # The first has draws of no map, and is reached from the mode of its posterior alone.
    assert tried.tolist() == [True, False, True, False, True, True]
    assert np.isfinite(result["median"].values).all(axis=1).tolist() == tried.tolist()
    assert np.isfinite(result.p_value.values).tolist() == tried.tolist()
    assert result.accepted.values.tolist() == data.accepted.values.tolist()


def test_chunks_through_stores_are_the_whole(inferred, operations, tmp_path):
    """Jobs may be cut anywhere, even around operations of which none has a posterior."""
    stores = []
    for k, rows in enumerate(([0], [1], [2, 3], [4, 5])):
        stores.append(tmp_path / f"{k}.zarr")
        save(correct_these(inferred.isel(operation=rows)), stores[-1])
    joined = open_curves(stores)
    assert set(joined.variables) == set(operations.variables)
    for name in operations.variables:
        np.testing.assert_array_equal(joined[name].values, operations[name].values, err_msg=name)


# ---- both posteriors -----------------------------------------------------------------------------

DRAWN = ["draws", "median", "interval_50", "interval_95", "p_value", "misfit", "outside_support"]
DRAWN += ["far_onset"]


@pytest.fixture(scope="module")
def both(inferred, operations):
    return beside(inferred, operations)


def test_beside_doubles_what_follows_from_draws_alone(inferred, operations, both):
    assert both.posterior.values.tolist() == ["amortised", "corrected"]
    assert set(both.variables) == {*operations.variables, "posterior"}
    for name in both.data_vars:
        doubled = name in DRAWN
        assert ("posterior" in both[name].dims) == doubled, name
        if doubled:
            assert both[name].dims == ("posterior", *operations[name].dims)
            assert both[name].dtype == operations[name].dtype
            np.testing.assert_array_equal(both[name][0], inferred[name])
            np.testing.assert_array_equal(both[name][1], operations[name])
        else:
            xr.testing.assert_identical(both[name], operations[name])
    assert both.attrs == operations.attrs


def test_other_operations_are_not_put_beside(inferred, operations):
    with pytest.raises(ValueError, match="operation"):
        beside(inferred.isel(operation=slice(4)), operations)


def test_choose_gives_back_either(inferred, operations, both):
    for posterior, expected in (("amortised", inferred), ("corrected", operations)):
        found = choose(both, posterior)
        assert found.posterior.item() == posterior
        xr.testing.assert_identical(found.drop_vars("posterior"), expected)
    with pytest.raises(KeyError):
        choose(both, "exact")


def test_both_survive_a_store(both, tmp_path):
    save(both, tmp_path / "both.zarr")
    stored = xr.open_zarr(tmp_path / "both.zarr").load()
    assert set(stored.variables) == set(both.variables)
    for name in both.variables:
        assert stored[name].dims == both[name].dims
        np.testing.assert_array_equal(stored[name].values, both[name].values, err_msg=name)
    pd.testing.assert_frame_equal(table_of_both(stored), table_of_both(both))


def test_table_of_both_is_tidy(inferred, operations, both):
    rows = table_of_both(both)
    assert rows.columns.tolist() == [
        *("operation", "posterior", "output", "unit", "median"),
        *("interval_50_lower", "interval_50_upper", "interval_95_lower", "interval_95_upper"),
        *("p_value", "misfit", "outside_prior", "outside_support", "accepted", "reason", "file"),
        *("far_onset", "resolved", "effective_size", "pareto_k"),
    ]
    assert rows.operation.tolist() == np.repeat(OPERATIONS, 2 * Q).tolist()
    assert rows.posterior.tolist() == 6 * (Q * ["amortised"] + Q * ["corrected"])
    assert rows.output.tolist() == 12 * MODEL.names
    for posterior, alone in (("amortised", inferred), ("corrected", operations)):
        part = rows[rows.posterior == posterior].drop(columns="posterior").reset_index(drop=True)
        expected = table(alone)
        pd.testing.assert_frame_equal(part[expected.columns], expected, check_dtype=False)
    amortised = rows[rows.posterior == "amortised"]
    assert amortised[["resolved", "effective_size", "pareto_k"]].isna().all(axis=None)
    corrected = rows[rows.posterior == "corrected"]
    assert corrected.resolved.tolist() == np.repeat(operations.resolved.values, Q).tolist()


# ---- the judge -----------------------------------------------------------------------------------

JUDGED, WIDE, NARROW = 60, 1.2, 0.85


def divergence_of(width):
    """KL(N(m, C) | N(m, width^2 C)) in q dimensions."""
    return Q * (np.log(width) + 0.5 / width**2 - 0.5)


def efficiency_of(width):
    """Of weights from N(m, width^2 C) to N(m, C): 1 over the mean square weight."""
    return (np.sqrt(2 - width**-2) / width) ** Q


class Gaussian:
    """A network: the exact posterior with a width that is off by a factor, and a density too."""

    def __init__(self, width, *, nats=0.0, nan_at=None):
        self.model, self.width, self.nats, self.nan_at = MODEL, width, nats, nan_at

    def log_prob(self, values, measured):
        assert values.ndim == 3
        assert measured.shape == (len(values), SAMPLES)
        density = np.empty(values.shape[:2])
        for i, (points, record) in enumerate(zip(values, measured, strict=True)):
            mean, covariance, _ = MODEL.exact(record)
            law = multivariate_normal(mean, self.width**2 * covariance)
            density[i] = law.logpdf(MODEL.standardise(points)) + MODEL.log_scaling(points)
        if self.nan_at is not None:
            density[:, self.nan_at] = np.nan
        return density + self.nats


def of_width(width, n=JUDGED):
    """Draws of a network, and what a correction that cannot be better makes of them."""
    data = validation(n, f"judged {width}", draws=500, width=width)
    evidence = [MODEL.exact(record)[2] for record in data.measured.values]
    known = {"log_evidence": ("curve", evidence), "resolved": ("curve", np.ones(n, dtype=bool))}
    return data, data.assign(known)


@pytest.fixture(scope="module", params=[WIDE, NARROW])
def judged(request):
    data, exact = of_width(request.param)
    return request.param, data, judge(Gaussian(request.param), data, exact)


def test_the_gap_is_that_of_the_truth(judged):
    """Curve by curve a formula of the truth, and on average the divergence: false alarm 1e-3."""
    width, data, result = judged
    e = []
    for record, truth in zip(data.measured.values, data.truth.values, strict=True):
        mean, covariance, _ = MODEL.exact(record)
        e.append(np.linalg.solve(np.linalg.cholesky(covariance), MODEL.standardise(truth) - mean))
    square = np.square(e).sum(axis=1)
    expected = Q * np.log(width) - 0.5 * square * (1 - width**-2)
    np.testing.assert_allclose(result.gap, expected, atol=1e-8)
    error = np.abs(1 - width**-2) * np.sqrt(Q / 2 / JUDGED)
    assert abs(result.gap.values.mean() - divergence_of(width)) < norm.isf(0.5e-3) * error


def test_weights_give_divergence_efficiency_and_evidence(judged):
    """False alarm 1e-3 each, by the scatter over curves."""
    width, data, result = judged
    evidence = np.array([MODEL.exact(record)[2] for record in data.measured.values])
    for found, expected, bias in (
        (result.divergence, divergence_of(width), 0.01),
        (result.efficiency, efficiency_of(width), 0.03),
        # The log of a mean is below it by half of its relative variance, 1 / 680 at most.
        (result.log_evidence - evidence, 0.0, 0.003),
    ):
        values = found.values
        error = values.std(ddof=1) / np.sqrt(JUDGED)
        assert error < 0.02
        assert abs(values.mean() - expected) < student(JUDGED - 1).isf(0.5e-3) * error + bias
    assert (result.faulty_weights == 0).all()
    if width == WIDE:  # bounded weights
        assert (result.pareto_k < 0.7).all()


def test_the_layout_of_a_judgement(judged):
    width, data, result = judged
    assert set(result.data_vars) == {
        *("efficiency", "pareto_k", "faulty_weights", "divergence", "log_evidence"),
        *("truth_log_density", "gap", "resolved"),
    }
    assert all(result[name].dims == ("curve",) for name in result)
    assert result.sizes["curve"] == JUDGED
    assert result.attrs == {"motion": "closing"}
    z = MODEL.standardise(data.truth.values)
    for i in (0, JUDGED - 1):
        mean, covariance, _ = MODEL.exact(data.measured.values[i])
        expected = multivariate_normal(mean, width**2 * covariance).logpdf(z[i])
        assert result.truth_log_density.values[i] == pytest.approx(expected, abs=1e-9)


def test_a_density_that_is_not_normalised_shows():
    """Planted: 0.3 nats too much. The gap is lower by that, and the evidence; weights are not."""
    data, exact = of_width(WIDE, 5)
    right, wrong = (judge(Gaussian(WIDE, nats=nats), data, exact) for nats in (0.0, 0.3))
    for name in ("gap", "log_evidence"):
        np.testing.assert_allclose(wrong[name], right[name] - 0.3, atol=1e-9)
    for name in ("efficiency", "divergence"):
        np.testing.assert_allclose(wrong[name], right[name], atol=1e-9)


def test_faulty_weights_are_counted_and_leave_nothing_else():
    data, exact = of_width(WIDE, 3)
    result = judge(Gaussian(WIDE, nan_at=[3, 70, 71]), data, exact)
    assert result.faulty_weights.values.tolist() == [3, 3, 3]
    for name in ("efficiency", "pareto_k", "divergence", "log_evidence"):
        assert np.isnan(result[name]).all(), name
    assert np.isfinite(result.gap).all()  # the truth is a point of its own
    result = judge(Gaussian(WIDE, nan_at=[500]), data, exact)  # which comes last
    assert result.faulty_weights.values.tolist() == [0, 0, 0]
    assert np.isnan(result.gap).all()
    assert np.isfinite(result.efficiency).all()


def test_a_part_of_the_corrected_curves_may_be_judged():
    data, exact = of_width(WIDE, 6)
    exact.resolved[1] = False
    whole = judge(Gaussian(WIDE), data, exact)
    part = judge(Gaussian(WIDE), data.isel(curve=slice(4)), exact)
    xr.testing.assert_identical(part, whole.isel(curve=slice(4)))
    assert part.resolved.values.tolist() == [True, False, True, True]


def test_correction_and_judge_together():
    """The corrected evidence is as good as the exact one: within 4 of its standard errors."""
    data, exact = of_width(NARROW, 5)
    corrected = correct_validation(MODEL, data, SETTINGS, seed=1)
    found, expected = (judge(Gaussian(NARROW), data, each) for each in (corrected, exact))
    error = (found.gap - expected.gap).values / corrected.log_evidence_se.values
    assert np.abs(error).max() < 4.0  # false alarm 3e-4
    assert np.abs(error).max() > 0


def test_a_network_is_such_a_density():
    """A new one whose posterior is the standard normal of standardised outputs, thus poor."""
    posterior = pin(frozen(), 0.0, 1.0)
    data = validate(posterior, 3, 60, seed=3)
    exact = data.assign(log_evidence=("curve", np.zeros(3)), resolved=("curve", np.ones(3) > 0))
    result = judge(posterior, data, exact)
    z = posterior.model.standardise(data.truth.values)
    expected = norm.logpdf(z).sum(axis=1)
    np.testing.assert_allclose(result.truth_log_density, expected, atol=1e-4)
    joint = [
        posterior.model.log_joint(*each)[0]
        for each in zip(z[:, None], data.measured.values, strict=True)
    ]
    np.testing.assert_allclose(result.gap, joint - expected, rtol=1e-4)
    assert (result.efficiency < 0.2).all()


# ---- in one row ----------------------------------------------------------------------------------


def judgement(**changes):
    """Six judged curves and eight corrected ones, numbers easy to sum up."""
    numbers = {
        "efficiency": np.array([0.5, 0.6, 0.7, 0.8, 0.9, 1.0]),
        "pareto_k": np.array([0.1, 0.8, -np.inf, 0.2, np.inf, np.nan]),
        "faulty_weights": np.zeros(6, dtype=int),
        "divergence": np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]),
        "truth_log_density": np.arange(6.0),
        "gap": np.array([-1.0, 0.0, 1.0, 2.0, 3.0, 40.0]),
        "resolved": np.array([True, True, True, True, True, False]),
    }
    judged = xr.Dataset(
        {name: ("curve", value) for name, value in (numbers | changes).items()},
        attrs={"motion": "opening"},
    )
    corrected = xr.Dataset(
        {
            "efficiency": ("curve", [0.1, 0.2, 0.3, 0.6, 0.7, 0.8, 0.9, np.nan]),
            "rounds": ("curve", [1, 1, 2, 2, 3, 3, 4, 0]),
            "resolved": ("curve", np.arange(8) < 6),
        }
    )
    return judged, corrected


def test_summary_by_hand():
    row = summary(*judgement()).iloc[0]
    expected = {
        "motion": "opening",
        "judged_curves": 6,
        "faulty_curves": 0,
        "efficiency_median": 0.75,
        "efficiency_10_percent": 0.55,
        "efficiency_lowest": 0.5,
        "pareto_k_below_0.7": 0.5,  # infinite and unknown ones are not
        "gap_curves": 5,  # 40 is of a curve that is not resolved
        "gap_nats": 1.0,
        "gap_se": np.sqrt(2.5 / 5),
        "divergence_nats": 0.35,
        "truth_log_density": 2.5,
        "corrected_curves": 8,
        "resolved": 0.75,
        "corrected_efficiency_median": 0.45,  # the unknown one counts as none
        "rounds_mean": 2.0,
    }
    assert row.index.tolist() == list(expected)
    for name, value in expected.items():
        assert row[name] == (value if isinstance(value, str) else pytest.approx(value)), name


def test_faulty_curves_are_left_out_and_counted():
    nan = np.where(np.arange(6) == 5, np.nan, 0.0)
    usual = judgement()[0]
    row = summary(
        *judgement(
            faulty_weights=np.array([0, 0, 0, 0, 0, 7]),
            efficiency=usual.efficiency.values + nan,
            divergence=usual.divergence.values + nan,
        )
    ).iloc[0]
    assert (row.judged_curves, row.faulty_curves) == (6, 1)
    assert row.efficiency_median == pytest.approx(0.7)
    assert row.divergence_nats == pytest.approx(0.3)
    assert row.gap_curves == 5


def test_nothing_to_sum_up_is_nan_without_a_warning():
    """Warnings are errors here: no curve resolved, all weights faulty, or one curve alone."""
    nothing = np.full(6, np.nan)
    row = summary(
        *judgement(
            resolved=np.zeros(6, dtype=bool),
            faulty_weights=np.full(6, 60),
            efficiency=nothing,
            divergence=nothing,
            pareto_k=nothing,
        )
    ).iloc[0]
    assert (row.gap_curves, row.faulty_curves) == (0, 6)
    unknown = ["gap_nats", "gap_se", "efficiency_median", "efficiency_10_percent"]
    unknown += ["efficiency_lowest", "divergence_nats"]
    assert row[unknown].isna().all()
    assert row["pareto_k_below_0.7"] == 0
    row = summary(*judgement(resolved=np.arange(6) == 3)).iloc[0]
    assert (row.gap_curves, row.gap_nats) == (1, 2.0)
    assert np.isnan(row.gap_se)
    judged, corrected = judgement()
    corrected["efficiency"] = ("curve", np.full(8, np.nan))
    assert summary(judged, corrected).corrected_efficiency_median.item() == 0


def test_unusable_gaps_are_not_counted():
    gap = np.array([-1.0, np.nan, 1.0, 2.0, 3.0, 40.0])
    row = summary(*judgement(gap=gap)).iloc[0]
    assert row.gap_curves == 4
    assert row.gap_nats == pytest.approx(1.25)
