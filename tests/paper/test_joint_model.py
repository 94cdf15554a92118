"""The joint model against densities and matrices written out: prior, records, information."""

import sys
from dataclasses import replace
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from breaker.common.randomness import generator
from breaker.model.parameters import MOTIONS, NAMES
from breaker.model.prior import Prior
from breaker.paper.joint_model import Model, OwnPrior, contraction_limit, limit_over_prior
from tests.model.laws import covariance
from tests.networks_fixtures import exact_curves

P = len(NAMES)
F = NAMES.index("f")


@pytest.fixture(params=product(MOTIONS, ["default", "paper"]))
def model(request, prior, sensor):
    """With onset and zero, or without them, as in the paper."""
    motion, which = request.param
    none = {} if which == "default" else {"onset_sd": 0.0, "zero_sd": 0.0}
    return Model(prior, replace(sensor, **none), motion)


@pytest.fixture
def tight(model):
    """The same with P(f > k_a L) of 0.36, so that the condition matters."""
    medians = np.where(np.arange(P) == F, 0.42, model.prior.medians)
    return replace(model, prior=replace(model.prior, medians=medians))


def unknowns(model, n, name):
    """Outputs drawn from the prior, ``(n, q)``, physical units."""
    values = np.column_stack(model.sample(n, generator(1, "test model", name)))
    return values[:, : len(model.names)]


def a_record(model):
    """A record, and outputs of which some explain it."""
    values = unknowns(model, 6, "record")
    rng = generator(1, "test model", "noise")
    return model.sensor.corrupt(exact_curves(model, values[:1]), rng)[0], values


def test_log_prior_is_that_of_the_physical_outputs(model, tight):
    """``p(z) = p(values) / |d z / d values|``, with the onset's normal density."""
    for chosen in (model, tight):
        values = unknowns(chosen, 60, "change of variables").reshape(3, 20, -1)
        z = chosen.standardise(values)
        np.testing.assert_allclose(chosen.destandardise(z), values, rtol=1e-13)
        onset = norm.logpdf(values[..., P:], scale=chosen.sensor.onset_sd or 1.0).sum(axis=-1)
        expected = chosen.prior.log_prob(values[..., :P]) + onset - chosen.log_scaling(values)
        np.testing.assert_allclose(chosen.log_prior(z), expected, atol=1e-10)


def same(prior):
    """A prior of one's own that is the paper's; its scale comes from its draws."""
    return SimpleNamespace(names=NAMES, sample=prior.sample, log_prob=prior.log_prob)


def test_a_prior_of_ones_own_with_a_density_has_the_same_posterior(tight):
    """Per unit of physical outputs, though another scale standardises them."""
    own = Model(OwnPrior(same(tight.prior)), tight.sensor, tight.motion)
    record, values = a_record(tight)
    density, expected = (
        item.log_joint(item.standardise(values), record) + item.log_scaling(values)
        for item in (own, tight)
    )
    np.testing.assert_allclose(density, expected, atol=1e-8)
    values[:, F] = 1e-3
    assert np.isneginf(own.log_prior(own.standardise(values))).all()


def test_the_models_that_do_not_fit_together_are_refused(prior, sensor):
    short, other = same(prior), same(prior)
    short.sample = lambda n, rng: np.ones((5, 6))
    with pytest.raises(ValueError, match="names"):
        OwnPrior(short)
    other.names = [f"x{i}" for i in range(P)]
    with pytest.raises(ValueError, match=r"model\.simulator"):
        Model(OwnPrior(other), sensor, "closing")  # the paper's drive has other parameters
    with pytest.raises(ValueError, match="onset_sd"):
        Model(prior, sensor, "closing", lambda *_: None)
    model = Model(prior, replace(sensor, onset_sd=0.0), "closing", lambda *_: np.ones((2, 3)))
    with pytest.raises(ValueError, match="shape"):
        model.curves(np.ones((2, P)))


def test_log_prior_is_minus_infinity_outside(model):
    q = len(model.outputs)
    z = np.zeros((4, q))
    # A weak closing force and a stiff opening spring: f of 0.56 is less than k_a L, 0.71.
    z[1, [F, NAMES.index("k_a")]] = -3.0, 3.0
    z[2, 0], z[3, 0] = 20.0, 20.001
    assert np.isneginf(model.log_prior(z)).tolist() == [False, True, False, True]
    # No overflow, no curve that takes for ever, and a tame point among wild ones is not lost.
    wild = np.concatenate([1e100 * np.eye(q), -1e6 * np.eye(q), np.zeros((1, q))])
    record, _ = a_record(model)
    assert np.isneginf(model.log_joint(wild, record)).tolist() == [True] * (2 * q) + [False]


def test_drives_too_fast_to_be_simulated_have_no_density(prior, sensor):
    """Within 20 prior sds of a wide prior; the others keep theirs."""
    model = Model(Prior(prior.medians, np.full(P, 1.5)), sensor, "closing")
    record, values = a_record(model)
    z = model.standardise(values)
    alone = model.log_joint(z, record)
    z[1, NAMES.index("gamma_b")] = 15.0
    density = model.log_joint(z, record)
    assert np.isneginf(density[1])
    np.testing.assert_array_equal(np.delete(density, 1), np.delete(alone, 1))


@pytest.mark.parametrize("kept", [range(151), [*range(40), *range(80, 151)], [7, 80, 130], []])
def test_log_joint_is_prior_times_likelihood(model, kept):
    """In matrices written out, of the samples that are there; to a relative 1e-11."""
    record, values = a_record(model)
    kept, z = list(kept), model.standardise(values)
    record[np.setdiff1d(np.arange(record.size), kept)] = np.nan
    curves = exact_curves(model, values)
    likelihood = 0.0
    if kept:
        errors = covariance(model.sensor)[np.ix_(kept, kept)]
        residual = record[kept] - curves[:, kept]
        likelihood = multivariate_normal(np.zeros(len(kept)), errors).logpdf(residual)
    result = model.log_joint(z, record)
    np.testing.assert_allclose(result, model.log_prior(z) + likelihood, rtol=1e-11)


def test_limit_in_plain_matrices(model):
    """From curves of the model, differences of 4th order and the covariance written out."""
    values, step, q = unknowns(model, 10, "limit"), 1e-3, len(model.names)
    limits = contraction_limit(model, values)
    inverse = np.linalg.inv(covariance(model.sensor))

    def curves(z):
        return model.curves(model.destandardise(z))

    for place, limit in zip(model.standardise(values), limits, strict=True):
        slopes = sum(
            weight * (curves(place + s * step * np.eye(q)) - curves(place - s * step * np.eye(q)))
            for s, weight in ((1, 8 / 12), (2, -1 / 12))
        )
        fisher = slopes @ inverse @ slopes.T / step**2
        expected = 1 - np.diag(np.linalg.inv(fisher + np.eye(q)))
        np.testing.assert_allclose(limit, expected, rtol=0, atol=1e-5)
    over_prior = limit_over_prior(model, 10, generator(1, "test model", "limit"))
    np.testing.assert_array_equal(over_prior.contraction, limits)
    assert over_prior.output.values.tolist() == model.names


OWN = """
import numpy as np
from breaker.model.parameters import NAMES

class Prior:
    names = ("a", "b")

    def sample(self, n, rng):
        return rng.random((n, 2)) + 1.0

class Impossible(Prior):
    def log_prob(self, theta):
        return np.full(len(theta), -np.inf)

class Loose:
    names = NAMES

    def sample(self, n, rng):
        medians = [2.0, 0.045, 0.04, 0.3, 0.12, 0.75, 10.0]  # 0.2 % of draws have f < k_a L
        return medians * np.exp(0.1 * rng.standard_normal((n, 7)))

def simulate(theta, times, motion, rng):
    return theta[:, :1] * np.ones_like(times)

def endless(theta, times, motion, rng):
    return theta[:, :1] * np.full_like(times, np.nan)
"""


@pytest.mark.parametrize(
    ("prior", "simulator", "message"),
    [
        ("Prior", "simulate", ""),
        ("Loose", None, "draws do not fulfil"),
        ("Impossible", "simulate", "log_prob"),
        ("Prior", "endless", "finite"),
        ("Prior", "nothing", "has no function"),
    ],
)
def test_functions_of_ones_own_are_tried_first(
    tmp_path, monkeypatch, defaults, prior, simulator, message
):
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "own", raising=False)
    (tmp_path / "own.py").write_text(OWN, encoding="utf-8")
    model = {"prior": f"own:{prior}", "simulator": simulator and f"own:{simulator}"}
    settings = defaults | {"model": model, "motion": "closing"}
    settings["sensor"] = settings["sensor"] | {"onset_sd": 0.0}
    if not message:
        assert Model.from_settings(settings).names == ["a", "b"]
    else:
        with pytest.raises(ValueError, match=message):
            Model.from_settings(settings)
