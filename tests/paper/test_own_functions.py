"""A model file that names functions of one's own, and what a simulator of one's own cannot do."""

import sys

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.common.tensor_file import ModelFileError
from breaker.paper.bank import simulate
from breaker.paper.correction import correct_validation
from breaker.paper.inference import validate
from breaker.paper.joint_model import limit_over_prior
from breaker.paper.posterior import Posterior
from breaker.paper.training import freeze_inputs
from breaker.paper.validation import quality, scale_of
from tests.networks_fixtures import settings
from tests.scripts import ROOT

EXAMPLES = ROOT / "docs/examples"
OWN = {"simulator": "own_simulator:simulate", "prior": "own_simulator:Oscillator"}


@pytest.fixture
def oscillator(monkeypatch):
    monkeypatch.chdir(EXAMPLES)
    posterior = Posterior(settings(onset=False) | {"model": OWN}, seed=1)
    rows = simulate(posterior.model, 200, generator(1, "test own"))
    freeze_inputs(posterior, rows, generator(1, "test own", "components"))
    yield posterior.eval()
    sys.modules.pop("own_simulator", None)


def test_a_file_calls_functions_on_trust_alone(oscillator, tmp_path, monkeypatch):
    file = tmp_path / "m.safetensors"
    oscillator.save(file)
    with pytest.raises(ModelFileError, match="own_simulator:simulate"):
        Posterior.load(file)
    again = Posterior.load(file, own_functions=True)
    records, noise = again.model.curves(np.array([[14.0, 0.2, 0.4]])), np.zeros((1, 3, 3))
    np.testing.assert_array_equal(again.sample(records, noise), oscillator.sample(records, noise))
    monkeypatch.chdir(tmp_path)  # its functions are not here
    sys.modules.pop("own_simulator")
    with pytest.raises(ModelFileError, match="own_simulator"):
        Posterior.load(file, own_functions=True)


def test_what_needs_a_density_says_so(oscillator):
    model = oscillator.model
    data = validate(oscillator, 8, draws=40, seed=2)
    assert data.output.values.tolist() == ["stroke", "frequency", "damping"]
    assert np.isfinite(quality(data, None, np.ones(3), **scale_of(data)).z_sd).all()
    with pytest.raises(ValueError, match=r"model\.simulator"):
        correct_validation(model, data, seed=1)
    with pytest.raises(ValueError, match=r"model\.simulator"):
        limit_over_prior(model, 5, generator(1, "test own", "limit"))
