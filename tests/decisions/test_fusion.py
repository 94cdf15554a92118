"""Both motions as one: joint density, fused posteriors, and whether they are of one drive."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.stats import chi2, multivariate_normal, norm

from breaker.decisions.fusion import Fused, Pair, fuse
from breaker.mechanism.parameters import MOTIONS, NAMES
from breaker.model.fisher import information
from breaker.model.joint import Model
from breaker.model.randomness import generator
from breaker.posterior.corrections import correct

PAIRS, DRAWS, P = 32, 600, len(NAMES)


def settings_of(defaults):
    """Fewer draws than the default, for speed."""
    return defaults["correction"] | {"draws": 1000, "smallest_size": 200}


def models_of(prior, sensor):
    return {motion: Model(prior, sensor, motion) for motion in MOTIONS}


@dataclass
class Operation:
    """Records of one operation, their own posteriors, and the parameters of each motion."""

    theta: dict
    records: dict
    draws: dict
    evidence: dict


def posterior(model, record, outputs, settings, rng):
    """Exact posterior of a record, from a normal about the truth ``(q,)`` in place of a network."""
    z = model.standardise(outputs)[None]
    found = information(model, record[None], z[:, :P], z[:, P:].sum(axis=1))
    cov = np.linalg.inv(found.matrix[0] + np.eye(P))
    mean = z[0, :P] + cov @ (found.slope[0] - z[0, :P])
    start = rng.multivariate_normal(mean, cov, DRAWS)
    if model.sensor.infers_onset:
        start = np.column_stack([start, found.onset + 0.1 * rng.standard_normal(DRAWS)])
    result = correct(model, record, model.destandardise(start), settings, rng)
    assert result.resolved, result.reason
    return result


def operate(models, theta, settings, rng):
    """Simulate an operation of a drive with parameters ``{motion: (p,)}`` and judge it."""
    records, draws, evidence = {}, {}, {}
    for motion, model in models.items():
        onset = model.sensor.onset_sd * rng.standard_normal(len(model.names) - P)
        outputs = np.append(theta[motion], onset)
        records[motion] = model.sensor.corrupt(model.curves(outputs[None]), rng)[0]
        found = posterior(model, records[motion], outputs, settings, rng)
        draws[motion] = found.draws
        evidence[motion] = found.importance.log_evidence
    return Operation(theta, records, draws, evidence)


def fused(pair, operation, settings, rng):
    evidence = sum(operation.evidence.values())
    return fuse(pair, operation.records, operation.draws, evidence, settings, rng)


@pytest.fixture(scope="module")
def operations(prior, sensor, defaults):
    """Operations of drives from the prior, one for both motions."""
    result, models = [], models_of(prior, sensor)
    for i in range(PAIRS):
        rng = generator(1, "test fusion", i)
        theta = dict.fromkeys(MOTIONS, prior.sample(1, rng)[0])
        result.append(operate(models, theta, settings_of(defaults), rng))
    return result


def fuse_all(pair, operations, settings):
    return [
        fused(pair, o, settings, generator(2, "test fusion", i)) for i, o in enumerate(operations)
    ]


@pytest.fixture(scope="module")
def together(operations, prior, sensor, defaults):
    return fuse_all(Pair(models_of(prior, sensor)), operations, settings_of(defaults))


# ---- the joint density -----------------------------------------------------------------------


@pytest.mark.parametrize("onset_sd", [0.3, 0.0])
def test_log_joint_is_prior_onsets_and_both_likelihoods(onset_sd, prior, sensor):
    """By covariance matrices and the density of the prior in physical units; both unknown zeros."""
    sensor = replace(sensor, onset_sd=onset_sd)
    pair, rng = Pair(models_of(prior, sensor)), generator(3, "test fusion")
    theta, own = prior.sample(6, rng), 2 if onset_sd else 0
    onsets = onset_sd * rng.standard_normal((6, own))
    values = np.hstack([theta, onsets])
    z = pair.standardise(values)
    np.testing.assert_allclose(z[:, :P], prior.standardise(theta))
    np.testing.assert_allclose(z[:, P:] * onset_sd, onsets)
    np.testing.assert_allclose(pair.destandardise(z), values)
    t = sensor.samples
    cov = sensor.noise_sd**2 * np.eye(t) + sensor.zero_sd**2
    expected = prior.log_prob(theta) + np.log(theta * prior.log_sds).sum(axis=1)
    expected += norm.logpdf(z[:, P:]).sum(axis=1)
    records = {}
    for i, (motion, model) in enumerate(pair.models.items()):
        mine = np.hstack([theta, onsets[:, i : i + 1]])
        curves = model.curves(mine)
        records[motion] = sensor.corrupt(curves[0], rng)
        expected += [multivariate_normal(curve, cov).logpdf(records[motion]) for curve in curves]
    np.testing.assert_allclose(pair.log_joint(z, records), expected, rtol=1e-10)


def test_log_joint_outside_the_support(operations, prior, sensor):
    pair = Pair(models_of(prior, sensor))
    z = np.zeros((3, P + 2))
    z[1, [NAMES.index("f"), NAMES.index("L")]] = -6.0, 6.0  # no wipe
    z[2, -1] = 21.0  # the onset of the last motion is beyond all
    found = pair.log_joint(z, operations[0].records)
    assert np.isfinite(found[0])
    assert found[1:].tolist() == [-np.inf, -np.inf]


# ---- posteriors ------------------------------------------------------------------------------


def calibration_p_value(found, operations, prior):
    """Two-sided, of squared distances of the truth from the means: chi-square of 7 each.

    Posteriors of both motions are nearly normal. 600 draws of an effective size of about 500
    make the sum larger by 3 per cent, a quarter of its standard deviation.
    """
    square = 0.0
    for each, operation in zip(found, operations, strict=True):
        z = prior.standardise(each.draws)
        off = z.mean(axis=0) - prior.standardise(operation.theta["closing"])
        square += off @ np.linalg.solve(np.cov(z.T), off)
    law = chi2(P * len(found))
    return 2 * min(law.cdf(square), law.sf(square))


def test_fused_posteriors_are_calibrated(together, operations, prior):
    """False alarm 1e-3."""
    assert all(each.reason == "" and each.draws.shape == (DRAWS, P) for each in together)
    assert calibration_p_value(together, operations, prior) > 1e-3


def test_one_motion_used_twice_is_caught(operations, prior, sensor, defaults):
    """The fault: the closing record counts as the opening one, too."""
    closing = Model(prior, sensor, "closing")
    pair = Pair({"closing": closing, "again": closing})
    twice = [
        replace(
            each,
            records=dict.fromkeys(pair.models, each.records["closing"]),
            draws=dict.fromkeys(pair.models, each.draws["closing"]),
        )
        for each in operations
    ]
    found = fuse_all(pair, twice, settings_of(defaults))
    assert all(each.reason == "" for each in found)
    assert calibration_p_value(found, operations, prior) < 1e-4


def test_fused_posteriors_are_narrower_than_either(together, operations, prior):
    """In volume, each of them; in every parameter, on average over operations."""
    ratios = []
    for each, operation in zip(together, operations, strict=True):
        z = prior.standardise(each.draws)
        alone = [prior.standardise(draws[:, :P]) for draws in operation.draws.values()]
        volumes = [np.linalg.slogdet(np.cov(one.T))[1] for one in alone]
        assert np.linalg.slogdet(np.cov(z.T))[1] < min(volumes) - 1.0
        ratios.append(z.std(axis=0) / np.min([one.std(axis=0) for one in alone], axis=0))
    assert np.all(np.exp(np.log(ratios).mean(axis=0)) < 0.85)


def test_same_generator_same_result(together, operations, prior, sensor, defaults):
    pair, settings = Pair(models_of(prior, sensor)), settings_of(defaults)
    again = fused(pair, operations[0], settings, generator(2, "test fusion", 0))
    np.testing.assert_array_equal(again.draws, together[0].draws)
    assert again.log_agreement == together[0].log_agreement


# ---- agreement -------------------------------------------------------------------------------


def test_motions_of_one_drive_agree(together):
    """The expectation of 1 / Bayes factor is one for them: by Markov's inequality, all of 32 above
    1 / 32000 has a false alarm of at most 1e-3. That it favours them is what it is for."""
    log_agreement = np.array([each.log_agreement for each in together])
    assert np.all(log_agreement > -np.log(1000 * PAIRS))
    assert np.mean(log_agreement > 0) >= 0.9
    # Chi-square rises by what seven common parameters cost: it is not judged by the truth.
    assert np.all([-5.0 < each.apart < chi2.isf(1e-3 / PAIRS, P) + 5.0 for each in together])


class Twice(Pair):
    """The fault: the prior counts once a motion."""

    def log_joint(self, z, records):
        parts = self._parts(z)
        return sum(model.log_joint(parts[m], records[m]) for m, model in self.models.items())


@pytest.mark.parametrize("pair_of", [Pair, Twice])
def test_a_record_that_says_nothing_neither_agrees_nor_disagrees(pair_of, prior, sensor, defaults):
    """The Bayes factor is one. 4 standard errors of three evidences: false alarm 4e-4 in all.

    Each of the evidences is of 1000 draws and an efficiency above 0.2, or 0.6 as a rule: a standard
    error of at most 0.063, or 0.026. Samples of a metre's noise say nothing of the parameters.
    """
    blind = replace(sensor, noise_sd=1000.0)
    models = {"closing": Model(prior, sensor, "closing"), "opening": Model(prior, blind, "opening")}
    settings, found, alone = settings_of(defaults), [], []
    for i in range(6):
        rng = generator(4, "test fusion", i)
        theta = dict.fromkeys(MOTIONS, prior.sample(1, rng)[0])
        operation = operate(models, theta, settings, rng)
        found.append(fused(pair_of(models), operation, settings, rng))
        z = prior.standardise(operation.draws["closing"][:, :P])
        alone.append((prior.standardise(found[-1].draws).mean(axis=0) - z.mean(0)) / z.std(0))
    factor = np.mean([each.log_agreement for each in found])
    error = 0.026 * np.sqrt(3 / len(found))
    if pair_of is Twice:
        assert abs(factor) > 20 * error
        return
    assert abs(factor) < 4 * error
    # Means of 600 draws with an effective size above 300, two of them: 5 standard errors, of 42.
    assert np.abs(alone).max() < 5 * np.sqrt(2 / 300)


def test_motions_of_two_drives_are_told_apart(operations, prior, sensor, defaults):
    pair, settings = Pair(models_of(prior, sensor)), settings_of(defaults)
    for i in range(3):
        rng, theta = generator(5, "test fusion", i), operations[i].theta["closing"]
        stronger = theta * np.where(np.array(NAMES) == "f", 1.3, 1.0)
        operation = operate(pair.models, {"closing": theta, "opening": stronger}, settings, rng)
        found = fused(pair, operation, settings, rng)
        assert found.apart > 60
        assert found.reason == "the motions have different parameters"
        assert np.isnan(found.log_agreement)
        assert found.draws.shape == (DRAWS, P)
        assert np.isnan(found.draws).all()


def test_slightly_different_motions_do_not_agree(operations, prior, sensor, defaults):
    """Near enough to be fused, and the Bayes factor is against it."""
    pair, settings = Pair(models_of(prior, sensor)), settings_of(defaults)
    rng, theta = generator(6, "test fusion"), operations[0].theta["closing"]
    stronger = theta * np.where(np.array(NAMES) == "f", 1.06, 1.0)
    operation = operate(pair.models, {"closing": theta, "opening": stronger}, settings, rng)
    found = fused(pair, operation, settings, rng)
    assert found.reason == ""
    assert np.isfinite(found.draws).all()
    assert 25 < found.apart < 60
    assert found.log_agreement < -3


def test_what_is_not_resolved_has_no_draws(operations, prior, sensor, defaults):
    settings = settings_of(defaults) | {"rounds": 2, "smallest_size": 999}
    found = fused(Pair(models_of(prior, sensor)), operations[0], settings, generator(7, "test"))
    assert isinstance(found, Fused)
    assert found.reason.endswith("999 are needed")
    assert np.isnan(found.draws).all()
    assert np.isnan(found.log_agreement)
    assert np.isfinite(found.apart)
