"""Corrected posteriors of many records, and the judge, against posteriors known in closed form.

The curves of ``Linear`` are linear in the standardised outputs, so that posteriors, evidences, and
the divergence and efficiency of a Gaussian too wide or too narrow are formulas.
"""

import numpy as np
import pytest
import xarray as xr
from scipy.stats import multivariate_normal

from breaker.common.randomness import generator
from breaker.model.prior import Prior
from breaker.model.sensor import Sensor
from breaker.paper.correction import correct, correct_validation, importance, judge
from breaker.paper.joint_model import Model
from breaker.paper.validation import summary
from tests.corrections import errors_p_value, from_prior, means_p_value

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

    def curves(self, values):
        return self.standardise(values) @ SLOPES.T

    def exact(self, record):
        """Mean, covariance and log evidence, of the samples that are there."""
        there = ~np.isnan(record)
        slopes, noise, seen = SLOPES[there], NOISE[np.ix_(there, there)], record[there]
        covariance = np.linalg.inv(np.eye(Q) + slopes.T @ np.linalg.solve(noise, slopes))
        mean = covariance @ slopes.T @ np.linalg.solve(noise, seen)
        law = multivariate_normal(np.zeros(seen.size), slopes @ slopes.T + noise)
        return mean, covariance, law.logpdf(seen)


MODEL = Linear(Prior(**SCALES), SENSOR, "closing")


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
    corrected = correct_validation(MODEL, data, seed=1)
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
    return correct_validation(MODEL, shifted, seed=1)


def test_what_is_added_and_what_stays(shifted, corrected):
    added = set(corrected.variables) - set(shifted.variables)
    assert added == {
        *("resolved", "why_unresolved", "rounds", "effective_size", "efficiency"),
        *("pareto_k", "faulty_weights", "log_evidence", "log_evidence_se"),
    }
    rest = corrected.drop_vars([*added, "draws"])
    xr.testing.assert_identical(rest, shifted.drop_vars("draws"))
    assert corrected.draws.dims == shifted.draws.dims
    assert not np.any(corrected.draws.values == shifted.draws.values)
    assert (corrected.why_unresolved == "").all()
    np.testing.assert_allclose(corrected.efficiency, corrected.effective_size / 2000, rtol=1e-12)


def test_a_record_does_not_depend_on_those_beside_it(shifted, corrected):
    """Bit for bit; and the same again, but not with another seed."""
    part = correct_validation(MODEL, shifted.isel(curve=slice(4)), seed=1)
    xr.testing.assert_identical(part, corrected.isel(curve=slice(4)))
    again = correct_validation(MODEL, shifted, seed=1)
    xr.testing.assert_identical(again, corrected)
    other = correct_validation(MODEL, shifted.isel(curve=[0]), seed=2)
    assert not np.any(other.draws.values == corrected.draws.values[:1])
    # Another motion has generators of its own.
    motion = Linear(MODEL.prior, SENSOR, "opening")
    opening = correct_validation(motion, shifted.isel(curve=[0]), seed=1)
    assert not np.any(opening.draws.values == corrected.draws.values[:1])


def test_an_error_is_the_reason_of_its_record_and_stops_no_other(shifted, corrected, monkeypatch):
    def fails(model, record, *rest, **more):
        if np.array_equal(record, shifted.measured.values[1]):
            raise ZeroDivisionError("a planted fault")
        return correct(model, record, *rest, **more)

    monkeypatch.setattr("breaker.paper.correction.correct", fails)
    found = correct_validation(MODEL, shifted, seed=1)
    assert "a planted fault" in found.why_unresolved.values[1]
    assert not found.resolved.values[1]
    assert np.isnan(found.draws.values[1]).all()
    others = [0, 2, 3, 4, 5]
    xr.testing.assert_identical(found.isel(curve=others), corrected.isel(curve=others))


# ---- the judge -----------------------------------------------------------------------------------

JUDGED, WIDTH = 6, 1.2


class Gaussian:
    """A network: the exact posterior with a width that is off by a factor, and a density too."""

    model = MODEL

    def __init__(self, nan_at=None):
        self.nan_at = nan_at

    def log_prob(self, values, measured):
        assert values.ndim == 3
        assert measured.shape == (len(values), SAMPLES)
        density = np.empty(values.shape[:2])
        for i, (points, record) in enumerate(zip(values, measured, strict=True)):
            mean, covariance, _ = MODEL.exact(record)
            law = multivariate_normal(mean, WIDTH**2 * covariance)
            density[i] = law.logpdf(MODEL.standardise(points)) + MODEL.log_scaling(points)
        if self.nan_at is not None:
            density[:, self.nan_at] = np.nan
        return density


@pytest.fixture(scope="module")
def judged():
    """Draws of a network, what a correction that cannot be better makes of them, judged."""
    data = validation(JUDGED, "judged", draws=500, width=WIDTH)
    evidence = [MODEL.exact(record)[2] for record in data.measured.values]
    resolved = np.arange(JUDGED) != 1
    exact = data.assign(log_evidence=("curve", evidence), resolved=("curve", resolved))
    return data, exact, judge(Gaussian(), data, exact)


def test_a_judgement_by_hand(judged):
    """The gap is a formula of the truth, all else of the weights of the draws."""
    data, _, result = judged
    expected = ("efficiency", "pareto_k", "faulty_weights", "divergence", "c2st", "log_evidence")
    assert set(result.data_vars) == {*expected, "truth_log_density", "gap", "resolved"}
    assert all(result[name].dims == ("curve",) for name in result)
    assert result.attrs == {"motion": "closing"}
    assert result.resolved.values.tolist() == [True, False, True, True, True, True]
    for i, record in enumerate(data.measured.values):
        mean, covariance, _ = MODEL.exact(record)
        law = multivariate_normal(mean, WIDTH**2 * covariance)
        truth = MODEL.standardise(data.truth.values[i])
        e = np.linalg.solve(np.linalg.cholesky(covariance), truth - mean)
        gap = Q * np.log(WIDTH) - 0.5 * e @ e * (1 - WIDTH**-2)
        z = MODEL.standardise(data.draws.values[i])
        weights = importance(MODEL.log_joint(z, record), law.logpdf(z))
        found = result.isel(curve=i)
        assert found.gap.item() == pytest.approx(gap, abs=1e-8)
        assert found.truth_log_density.item() == pytest.approx(law.logpdf(truth), abs=1e-9)
        assert found.efficiency.item() == pytest.approx(weights.efficiency)
        assert found.pareto_k.item() == pytest.approx(weights.pareto_k)
        assert found.divergence.item() == pytest.approx(weights.gap)
        assert found.log_evidence.item() == pytest.approx(weights.log_evidence)
        assert found.faulty_weights.item() == 0


def test_faulty_weights_are_counted_and_leave_nothing_else(judged):
    data, exact, _ = judged
    with pytest.raises(ValueError, match="the corrected curves are not those to be judged"):
        judge(Gaussian(), data.isel(curve=slice(1, 4)), exact)
    result = judge(Gaussian(nan_at=[3, 70, 71]), data, exact)
    assert result.faulty_weights.values.tolist() == [3] * JUDGED
    for name in ("efficiency", "pareto_k", "divergence", "log_evidence"):
        assert np.isnan(result[name]).all(), name
    assert np.isfinite(result.gap).all()  # the truth is a point of its own
    result = judge(Gaussian(nan_at=[500]), data, exact)  # which comes last
    assert result.faulty_weights.values.tolist() == [0] * JUDGED
    assert np.isnan(result.gap).all()
    assert np.isfinite(result.efficiency).all()


# ---- in one row ----------------------------------------------------------------------------------


def judgement(**changes):
    """Six judged curves and eight corrected ones, numbers easy to sum up."""
    numbers = {
        "efficiency": np.array([0.5, 0.6, 0.7, 0.8, 0.9, 1.0]),
        "pareto_k": np.array([0.1, 0.8, -np.inf, 0.2, np.inf, np.nan]),
        "faulty_weights": np.zeros(6, dtype=int),
        "divergence": np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]),
        "c2st": np.array([0.5, 0.52, 0.54, 0.56, 0.58, 0.6]),
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


CASES = {
    "all sound": (
        {},
        {
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
            "c2st_median": 0.55,
            "truth_log_density": 2.5,
            "corrected_curves": 8,
            "resolved": 0.75,
            "corrected_efficiency_median": 0.45,  # the unknown one counts as none
            "rounds_mean": 2.0,
        },
    ),
    "a faulty one": (
        {
            "faulty_weights": np.array([0, 0, 0, 0, 0, 7]),
            "efficiency": np.array([0.5, 0.6, 0.7, 0.8, 0.9, np.nan]),
            "divergence": np.array([0.1, 0.2, 0.3, 0.4, 0.5, np.nan]),
        },
        {
            "judged_curves": 6,
            "faulty_curves": 1,
            "efficiency_median": 0.7,
            "divergence_nats": 0.3,
            "gap_curves": 5,
        },
    ),
    "an unknown gap": (
        {"gap": np.array([-1.0, np.nan, 1.0, 2.0, 3.0, 40.0])},
        {"gap_curves": 4, "gap_nats": 1.25},
    ),
    "one resolved": (
        {"resolved": np.arange(6) == 3},
        {"gap_curves": 1, "gap_nats": 2.0, "gap_se": np.nan},
    ),
    "nothing": (
        {
            "resolved": np.zeros(6, dtype=bool),
            "faulty_weights": np.full(6, 60),
            **dict.fromkeys(("efficiency", "divergence", "pareto_k"), np.full(6, np.nan)),
        },
        {"gap_curves": 0, "faulty_curves": 6, "pareto_k_below_0.7": 0, "gap_nats": np.nan}
        | {"gap_se": np.nan, "efficiency_lowest": np.nan, "divergence_nats": np.nan},
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_summary_by_hand(case):
    """Without a warning, which is an error here."""
    changes, expected = CASES[case]
    row = summary(*judgement(**changes)).iloc[0]
    for name, value in expected.items():
        assert row[name] == (
            value if isinstance(value, str) else pytest.approx(value, nan_ok=True)
        ), name
    assert row.index.tolist() == list(CASES["all sound"][1])
