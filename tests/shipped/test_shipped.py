"""What ships is that of the defaults, and says so: configuration, models and model card."""

import copy
import importlib.util
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from breaker.mechanism.parameters import MOTIONS
from breaker.model.saved import open_model, write_model
from breaker.shipped import CARD, DEFAULTS, model_file
from breaker.workflow.configuration import load

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "envs" / "ship.py"
spec = importlib.util.spec_from_file_location("ship", SCRIPT)
ship = importlib.util.module_from_spec(spec)
spec.loader.exec_module(ship)


@pytest.fixture(scope="module")
def config():
    return load([DEFAULTS])


def test_the_defaults_that_ship_are_those_of_the_project():
    assert DEFAULTS.read_bytes() == (ROOT / "config" / "config.yaml").read_bytes()


@pytest.mark.parametrize("motion", MOTIONS)
def test_the_models_that_ship_are_those_of_the_defaults(motion, config):
    assert ship.unfit(model_file(motion), config, motion) == []


@pytest.mark.parametrize(
    ("place", "value", "line"),
    [
        (("seed",), 2, "seed: 1, not 2"),
        (("prior", "L", "median"), 11.0, "prior.L.median: 10.0, not 11.0"),
        (("sensor", "noise_sd"), 0.2, "sensor.noise_sd: 0.1, not 0.2"),
        (("training", "opening", "steps"), 9, "training.steps: 7500, not 9"),
        (("bank", "shards"), 2, "bank_curves: 262144, not 131072"),
        (("discrepancy", "components"), 0, "discrepancy.components: 20, not 0"),
        (
            ("network", "opening", "inference", "kind"),
            "flow_matching",
            "network.inference.kind: coupling_flow, not flow_matching",
        ),
    ],
)
def test_models_of_other_settings_are_noticed(place, value, line, config):
    changed = copy.deepcopy(config)
    section = changed
    for key in place[:-1]:
        section = section[key]
    section[place[-1]] = value
    found = ship.unfit(model_file("opening"), changed, "opening")
    assert f"{model_file('opening')}: {line}" in found


def test_the_model_of_another_motion_is_noticed(config):
    found = ship.unfit(model_file("closing"), config, "opening")
    assert found == [f"{model_file('closing')}: motion: closing, not opening"]


def test_a_model_without_its_learned_error_is_noticed(config, tmp_path):
    with open_model(model_file("closing")) as saved:
        write_model(tmp_path / "m.safetensors", saved.settings, {}, None)
    found = ship.unfit(tmp_path / "m.safetensors", config, "closing")
    assert found == [f"{tmp_path}/m.safetensors: discrepancy.components: 0, not 20"]


def test_the_model_card_is_that_of_the_files():
    text = CARD.read_text(encoding="utf-8")
    assert ship.described(text) == text
    for old, new in (("| 7,500 |", "| 7,501 |"), ("bytes | SHA-256", "bytes | SHA-1")):
        assert old in text
        assert ship.described(text.replace(old, new)) == text


def test_nothing_is_shipped_from_other_results(tmp_path):
    """And nothing is written: the package is a copy that must stay as it is."""
    shutil.copytree(ROOT / "config", tmp_path / "config")
    package = tmp_path / "src" / "breaker"
    shutil.copytree(ROOT / "src" / "breaker", package)
    before = {file: file.read_bytes() for file in (package / "shipped").iterdir() if file.is_file()}
    done = subprocess.run(
        [sys.executable, SCRIPT],
        cwd=tmp_path,
        env={"PYTHONPATH": str(tmp_path / "src"), "PATH": ""},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1
    assert "nothing is shipped" in done.stdout
    assert "results/discrepancy.zarr: there is no such store" in done.stdout
    assert "Run `make all` without overlays, then `make numbers ship`." in done.stdout
    assert before == {file: file.read_bytes() for file in before}
