"""The posterior of one motion: densities, independence of curves, and its file."""

import pickle
from copy import deepcopy

import numpy as np
import pytest
from scipy.stats import lognorm, norm

from breaker.common.randomness import generator
from breaker.common.tensor_file import ModelFileError, write_model
from breaker.model.parameters import NAMES
from breaker.paper.bank import simulate
from breaker.paper.posterior import Posterior
from breaker.paper.training import freeze_inputs
from tests.networks_fixtures import (
    COMBINATIONS,
    PRIOR,
    SENSOR,
    Trap,
    curved_model,
    noise_of,
    pin,
    settings,
)
from tests.scripts import ROOT


@pytest.mark.parametrize("onset", [True, False])
def test_density_changes_variables_once(onset):
    """Against scipy; float32 networks: a density of some 30 nats is exact to about 1e-4."""
    new = Posterior(settings(onset=onset))
    q = len(new.outputs)
    mean, sd, z = np.linspace(-0.5, 0.7, q), 0.6, np.random.default_rng(1).normal(size=(3, 6, q))
    pin(new, mean, sd)
    values, expected = z * SENSOR["onset_sd"], np.zeros((3, 6))
    for i, name in enumerate(NAMES):
        median, log_sd = PRIOR[name]["median"], PRIOR[name]["log_sd"]
        values[..., i] = median * np.exp(log_sd * z[..., i])
        law = lognorm(sd * log_sd, scale=median * np.exp(mean[i] * log_sd))
        expected += law.logpdf(values[..., i])
    if onset:
        law = norm(mean[7] * SENSOR["onset_sd"], sd * SENSOR["onset_sd"])
        expected += law.logpdf(values[..., 7])
    density = new.log_prob(values, np.zeros((3, SENSOR["samples"])))
    np.testing.assert_allclose(density, expected, rtol=0, atol=2e-4)
    # Planted faults: the change of variables left out, or made twice, is seen.
    for times in (-1, 1):
        assert np.abs(density + times * new.model.log_scaling(values) - expected).min() > 0.1


@pytest.mark.parametrize("name", COMBINATIONS)
def test_a_loaded_model_is_the_saved_one_bit_for_bit(name, tmp_path):
    """Of every inference network, with its frozen inputs, also where its file is written over."""
    posterior, records = curved_model(COMBINATIONS[name])
    file, noise = tmp_path / "m.safetensors", noise_of(posterior, 5, 20)
    posterior.save(file)
    content = file.read_bytes()
    loaded = Posterior.load(file)
    with file.open("r+b") as opened:  # in place, as a copy over it does
        opened.write(bytes(file.stat().st_size))
    draws = posterior.sample(records, noise)
    np.testing.assert_array_equal(loaded.sample(records, noise), draws)
    density = posterior.log_prob(draws, records)
    np.testing.assert_array_equal(loaded.log_prob(draws, records), density)
    np.testing.assert_array_equal(loaded.distance(records), posterior.distance(records))
    assert not loaded.training
    loaded.save(file)
    assert file.read_bytes() == content


def trapped(_, target):
    target.write_bytes(pickle.dumps(Trap(target.with_name("ran"))))


def content(change):
    """A fault of the bytes of a file."""
    return lambda posterior, target: target.write_bytes(change(target.read_bytes()))


def parts(change):
    """A fault of settings or tensors, in a file that is written as if it was right."""

    def fault(posterior, target):
        settings = deepcopy(posterior.settings)
        tensors = {name: weight.numpy().copy() for name, weight in posterior.state_dict().items()}
        change(settings, tensors)
        write_model(target, settings, tensors)

    return fault


# Faults by the key, number or name that the message has to state.
FAULTS = [
    (trapped, ""),
    (content(lambda c: c[:9]), ""),
    (content(lambda c: c.replace(b'"{', b'"[', 1)), ""),
    (content(lambda c: (900_000).to_bytes(8, "little") + b"[" * 900_000), ""),
    (parts(lambda s, t: t.pop("inference.head.bias")), "inference.head.bias"),
    (parts(lambda s, t: t.update(more=np.ones(2))), "more"),
    (parts(lambda s, t: t.update(curve_mean=t["curve_mean"].astype("f4"))), "curve_mean"),
    (parts(lambda s, t: t["inference.head.bias"].fill(np.nan)), "inference.head.bias"),
    (parts(lambda s, t: s["sensor"].update(samples=41)), "[41]"),
    (parts(lambda s, t: s["network"]["summary"].update(depth=3)), "depth"),
    (parts(lambda s, t: t["solver_steps"].fill(10**12)), "solver_steps is 1000000000000"),
]


@pytest.mark.parametrize(("fault", "message"), FAULTS)
def test_a_file_that_does_not_fit_is_refused(fault, message, series, tmp_path):
    target = tmp_path / "broken.safetensors"
    series[0].save(target)
    fault(series[0], target)
    with pytest.raises(ModelFileError) as caught:
        Posterior.load(target)
    assert str(target) in str(caught.value)
    assert message in str(caught.value)
    assert not target.with_name("ran").exists()  # no pickle is run


EXAMPLES = ROOT / "docs/examples"
OWN = {"simulator": "own_simulator:simulate", "prior": "own_simulator:Oscillator"}


def test_a_file_calls_functions_on_trust_alone(tmp_path, monkeypatch):
    monkeypatch.chdir(EXAMPLES)
    own, file = Posterior(settings(onset=False) | {"model": OWN}, seed=1), tmp_path / "m"
    rows = simulate(own.model, 200, generator(1, "test own"))
    freeze_inputs(own, rows, generator(1, "test own", "components"))
    own.save(file)
    with pytest.raises(ModelFileError, match="own_simulator:simulate"):
        Posterior.load(file)
    again = Posterior.load(file, own_functions=True)
    records, noise = again.model.curves(np.array([[14.0, 0.2, 0.4]])), np.zeros((1, 3, 3))
    np.testing.assert_array_equal(again.sample(records, noise), own.sample(records, noise))
