"""What ships is that of the defaults, and says so: configuration, networks and model card."""

import shutil
import subprocess
import sys

import pytest
import yaml
from jsonschema import Draft202012Validator

from breaker.configuration.data_files import family_of
from breaker.configuration.loading import load
from breaker.family.network_files import unfit
from breaker.shipped import CARD, FAMILIES, KINDS, model_file
from tests.scripts import ROOT, script

ship, defaults = script("envs/ship.py"), script("envs/defaults.py")
OVERLAYS = {"medium_voltage": [], "any": [ROOT / "config" / "any.yaml"]}


@pytest.mark.parametrize("file", [*defaults.files()], ids=str)
def test_what_is_made_of_the_settings_is_up_to_date(file):
    text = (ROOT / file).read_text(encoding="utf-8")
    assert text == defaults.files()[file], "run `make defaults`"


def test_the_schema_for_others_takes_the_defaults_and_overlays_and_nothing_wrong():
    check = Draft202012Validator(defaults.schema())
    check.check_schema(check.schema)
    for file in (ROOT / "config").glob("*.yaml"):
        assert list(check.iter_errors(yaml.safe_load(file.read_text(encoding="utf-8")))) == []
    wrong = {"seed": -1, "sensor": {"noise": 1}, "motions": []}
    result = {tuple(error.absolute_path) for error in check.iter_errors(wrong)}
    assert result == {("seed",), ("sensor",), ("motions",)}
    assert check.schema["properties"]["sensor"]["properties"]["samples"]["default"] == 151


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("kind", KINDS)
def test_the_networks_that_ship_are_those_of_the_configuration(family, kind):
    config, file, definition = load(OVERLAYS[family]), model_file(family, kind), family_of(family)
    assert ship.unfit(file, config, kind) == []
    assert (
        unfit(file, {**config, "family": config["family"] | {"drives": 10}}, kind, definition) == []
    )
    other = {**config, "prior": config["prior"] | {"mu": {"median": 1.0, "log_sd": 0.2}}}
    assert unfit(file, other, kind, definition)[0].startswith("prior.mu.")
    other = family_of(FAMILIES[family == FAMILIES[0]])
    result = unfit(file, config, kind, other)
    assert any(line.startswith("definition.effects.") for line in result)


def test_all_of_them_together_are_small():
    files = [model_file(family, kind) for family in FAMILIES for kind in KINDS]
    assert sum(file.stat().st_size for file in files) <= 12e6


def test_the_model_card_states_the_files(monkeypatch):
    monkeypatch.chdir(ROOT)
    card = CARD.read_text(encoding="utf-8")
    assert ship.described(card) == card
    assert "bytes | SHA-256" in card
    assert ship.described(card.replace("bytes | SHA-256", "bytes | SHA-1")) == card


@pytest.mark.slow
def test_nothing_is_shipped_from_other_results(tmp_path):
    """And nothing is written: the package is a copy that must stay as it is."""
    shutil.copytree(ROOT / "config", tmp_path / "config")
    package = tmp_path / "src" / "breaker"
    shutil.copytree(ROOT / "src" / "breaker", package)
    before = {file: file.read_bytes() for file in (package / "shipped").iterdir() if file.is_file()}
    done = subprocess.run(
        [sys.executable, ROOT / "envs/ship.py"],
        cwd=tmp_path,
        env={"PYTHONPATH": str(tmp_path / "src"), "PATH": ""},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1
    assert "nothing is shipped" in done.stdout
    assert "there is no model file results/family/trained/levels.safetensors" in done.stdout
    assert before == {file: file.read_bytes() for file in before}
