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

Q, SAMPLES = 8, 15
SLOPES = 0.12 * generator(1, "test exactness", "slopes").standard_normal((SAMPLES, Q))
SENSOR = Sensor(start=-2.0, stop=54.0, samples=SAMPLES, noise_sd=0.1, onset_sd=0.3, zero_sd=0.1)
NOISE = 0.1**2 * np.eye(SAMPLES) + 0.1**2


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


MEDIANS = np.array([2.0, 0.045, 0.040, 0.30, 0.12, 5.0, 10.0])
LOG_SDS = np.array([0.20, 0.15, 0.20, 0.20, 0.40, 0.10, 0.05])
MODEL = Linear(Prior(MEDIANS, LOG_SDS), SENSOR, "closing")


def validation(n, name, *, draws=300, missing=0, shift=0.0, width=1.0):
    """In the layout of ``validate``: exact posteriors, moved and widened by so many sds."""
    rng = generator(1, "test exactness", name)
    onset = SENSOR.onset_sd * rng.standard_normal((n, 1))
    truth = np.hstack([MODEL.prior.sample(n, rng), onset])
    records = SENSOR.corrupt(MODEL.curves(truth), rng)
    records[:, rng.permutation(SAMPLES)[:missing]] = np.nan
    drawn = []
    for record in records:
        mean, covariance, _ = MODEL.exact(record)
        off = shift * np.sqrt(np.diag(covariance))
        e = rng.standard_normal((draws, Q)) @ np.linalg.cholesky(covariance).T
        drawn.append(MODEL.destandardise(mean + off + width * e))
    return xr.Dataset(
        {
            "draws": (("curve", "draw", "output"), np.array(drawn)),
            "truth": (("curve", "output"), truth),
            "measured": (("curve", "time"), records, {"unit": "mm"}),
        },
        coords={"output": MODEL.names, "time": SENSOR.times},
        attrs={"motion": "closing"},
    )


def test_a_record_is_corrected_by_its_own_generator():
    """It depends on no other, and on motion and seed; draws that are all the same make none."""
    data = validation(3, "shifted", missing=6, shift=1.0, width=1.4)
    data.draws[1] = data.draws[1, 0]
    result = correct_validation(MODEL, data, seed=1)
    for i in range(3):
        rng, row = generator(1, "correction", "closing", i), result.isel(curve=i)
        one = correct(MODEL, data.measured.values[i], data.draws.values[i], rng)
        np.testing.assert_array_equal(row.draws, one.draws)
        assert (row.resolved, row.rounds, row.why_unresolved) == (i != 1, one.rounds, one.reason)
        np.testing.assert_array_equal(row.log_evidence, one.importance.log_evidence)
    for motion, seed in (("closing", 2), ("opening", 1)):
        model = Linear(MODEL.prior, SENSOR, motion)
        other = correct_validation(model, data.isel(curve=[0]), seed=seed)
        assert not np.any(other.draws.values == result.draws.values[:1])


# ---- the judge -----------------------------------------------------------------------------------

JUDGED, WIDTH = 6, 1.2


class Gaussian:
    """A network: the exact posterior with a width that is off by a factor, at points also nan."""

    model = MODEL

    def __init__(self, *nan_at):
        self.nan_at = list(nan_at)

    def log_prob(self, values, measured):
        ((points,), (record,)) = values, measured
        mean, covariance, _ = MODEL.exact(record)
        law = multivariate_normal(mean, WIDTH**2 * covariance)
        density = law.logpdf(MODEL.standardise(points)) + MODEL.log_scaling(points)
        density[self.nan_at] = np.nan
        return density[None]


def test_a_judgement_by_hand():
    """The gap is a formula of the truth, all else of the weights of the draws. Faulty weights are
    counted, and leave the gap, whose point is the last one."""
    data = validation(JUDGED, "judged", draws=500, width=WIDTH)
    evidence = [MODEL.exact(record)[2] for record in data.measured.values]
    resolved = np.arange(JUDGED) != 1
    exact = data.assign(log_evidence=("curve", evidence), resolved=("curve", resolved))
    result = judge(Gaussian(), data, exact)
    assert result.resolved.values.tolist() == resolved.tolist()
    for i, record in enumerate(data.measured.values):
        mean, covariance, _ = MODEL.exact(record)
        law = multivariate_normal(mean, WIDTH**2 * covariance)
        truth = MODEL.standardise(data.truth.values[i])
        e = np.linalg.solve(np.linalg.cholesky(covariance), truth - mean)
        gap = Q * np.log(WIDTH) - 0.5 * e @ e * (1 - WIDTH**-2)
        z = MODEL.standardise(data.draws.values[i])
        weights = importance(MODEL.log_joint(z, record), law.logpdf(z))
        row = result.isel(curve=i)
        assert row.gap.item() == pytest.approx(gap, abs=1e-8)
        expected = [weights.efficiency, weights.pareto_k, weights.c2st, weights.gap]
        names = ["efficiency", "pareto_k", "c2st", "divergence"]
        np.testing.assert_allclose(row[names].to_array(), expected)
    faulty = judge(Gaussian(3, 70, 71), data, exact)
    assert faulty.faulty_weights.values.tolist() == [3] * JUDGED
    assert faulty[["efficiency", "pareto_k", "divergence"]].isnull().all().to_array().all()
    np.testing.assert_array_equal(faulty.gap, result.gap)
    assert np.isnan(judge(Gaussian(500), data, exact).gap).all()
    with pytest.raises(ValueError, match="not those to be judged"):
        judge(Gaussian(), data.isel(curve=slice(1, 4)), exact)


def test_summary_by_hand():
    """Of curves without evidence no gap counts, and no efficiency without weights."""
    judged = {
        "efficiency": [0.5, 0.6, 0.8, 1.0, np.nan],
        "pareto_k": [0.1, 0.8, -np.inf, np.inf, np.nan],
        "faulty_weights": [0, 0, 0, 0, 3],
        "divergence": [0.1, 0.2, 0.3, 0.4, np.nan],
        "c2st": [0.5, 0.52, 0.54, 0.56, np.nan],
        "gap": [0.0, 1.0, 2.0, 3.0, 40.0],
        "resolved": [True, True, True, True, False],
    }
    corrected = {
        "efficiency": [0.2, 0.3, np.nan],
        "rounds": [1, 2, 6],
        "resolved": judged["resolved"][2:],
    }
    both = [
        xr.Dataset({n: ("curve", v) for n, v in table.items()}) for table in (judged, corrected)
    ]
    row = summary(both[0].assign_attrs(motion="opening"), both[1]).iloc[0].to_dict()
    assert row.pop("motion") == "opening"
    assert row == pytest.approx(
        {
            **{"judged_curves": 5, "faulty_curves": 1, "pareto_k_below_0.7": 0.4, "rounds_mean": 3},
            **{"efficiency_median": 0.7, "efficiency_lowest": 0.5, "c2st_median": 0.53},
            **{"gap_curves": 4, "gap_nats": 1.5, "gap_se": np.sqrt(5 / 3 / 4)},
            **{"divergence_nats": 0.25, "corrected_curves": 3, "resolved": 2 / 3},
            "corrected_efficiency_median": 0.2,  # the unknown one counts as none
        }
    )
