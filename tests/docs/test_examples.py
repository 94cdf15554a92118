"""The examples of the pages on research run."""

import importlib.util
import runpy

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.configuration.loading import defaults, of_motion
from breaker.networks.training import Trainer
from breaker.paper import is_exact
from breaker.paper.bank import simulate
from breaker.paper.calibration import ranks
from breaker.paper.correction import correct
from breaker.paper.inference import validate
from breaker.paper.posterior import Posterior
from breaker.paper.training import Rows, freeze_inputs
from tests.scripts import ROOT

EXAMPLES = ROOT / "docs/examples"
SMALL = {"steps": 60, "batch": 32, "evaluate_every": 30, "checkpoint_every": 100}
CHANGES = {
    "own_prior": {"model": {"simulator": None, "prior": "own_prior:Springs"}},
    "own_summary_network": {"kind": "own_summary_network:DeepSet"},
    "own_simulator": {
        "model": {"simulator": "own_simulator:simulate", "prior": "own_simulator:Oscillator"},
        "sensor": defaults()["sensor"] | {"onset_sd": 0.0},
    },
}


@pytest.mark.parametrize(
    "name",
    [
        name if name != "own_simulator" else pytest.param(name, marks=pytest.mark.slow)
        for name in CHANGES
    ],
)
def test_an_example_is_simulated_trained_and_validated(name, monkeypatch):
    monkeypatch.chdir(EXAMPLES)
    assert len((EXAMPLES / f"{name}.py").read_text().splitlines()) <= 30
    changes = dict(CHANGES[name])
    config = {**defaults(), "motion": "closing"}
    network = of_motion(config, "closing")["network"]
    if kind := changes.pop("kind", None):
        network["summary"] |= {"kind": kind}
    posterior = Posterior(config | changes | {"network": network}, seed=1)
    rows = simulate(posterior.model, 256, generator(1, name))
    freeze_inputs(posterior, rows, generator(1, "components"))
    parts = (Rows.of(rows.isel(curve=part), posterior) for part in (slice(200), slice(200, None)))
    Trainer(
        network=posterior,
        rows=next(parts),
        validation=next(parts),
        settings=defaults()["training"] | SMALL,
        seed=1,
    ).run()
    data = validate(posterior.eval(), 4, 50, seed=2)
    result = ranks(data.draws.values, data.truth.values)
    assert result.shape == (4, len(posterior.outputs))
    assert is_exact(config | changes) == (name != "own_simulator")
    if name == "own_prior":
        record, draws = data.measured.values[0], data.draws.values[0]
        exact = correct(posterior.model, record, draws, generator(1, "correct"))
        assert np.isfinite(exact.importance.log_evidence)


@pytest.mark.parametrize("tool", ["sbi", "bayesflow", "pymc"])
def test_another_tool_trains_on_the_simulator(tool):
    if importlib.util.find_spec(tool) is None:
        pytest.skip(f"{tool} is not installed")
    runpy.run_path(str(EXAMPLES / f"with_{tool}.py"))


@pytest.mark.usefixtures("one_thread")
def test_the_example_in_python_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)  # no folder of the project is needed
    runpy.run_path(str(EXAMPLES / "in_python.py"))
    assert capsys.readouterr().out.endswith("False\n")
