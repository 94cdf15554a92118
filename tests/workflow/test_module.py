"""The workflow as a module of another one, from a repository, with a prefix and own settings."""

import os
import re
import shutil
import subprocess
import sys

import pytest

from tests.workflow.conftest import ROOT, snakemake

# As `snakedeploy deploy-workflow` writes it, with a prefix and a section of one's own.
USE = """
configfile: "config/config.yaml"

module breaker:
    snakefile: github("someone/breaker", path="workflow/Snakefile", tag="v0")
    config: config["breaker"]
    prefix: "drive"

use rule * from breaker as breaker_*
"""
SETTINGS = """
breaker:
  motions: [closing]
  validation: {prior_curves: 20}
  simulated_test: {operations: 8}
  endurance: {operations_per_job: 20}
"""
FIGURE = "drive/figures/prior_predictive_closing.png"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a Snakefile that uses the workflow of a repository, which git finds here."""
    repository, own = tmp_path / "repository", tmp_path / "own"
    for name in ("config", "envs", "profiles", "workflow"):
        shutil.copytree(ROOT / name, repository / name)
    settings = {"init.defaultBranch": "main", "user.name": "a", "user.email": "a@example.org"}
    git = ["git", *(part for item in settings.items() for part in ("-c", "=".join(item)))]
    for command in (["init"], ["add", "."], ["commit", "-m", "a"], ["tag", "v0"]):
        subprocess.run([*git, *command], cwd=repository, check=True, capture_output=True)
    monkeypatch.setenv("GIT_CONFIG_COUNT", "1")
    monkeypatch.setenv("GIT_CONFIG_KEY_0", f"url.{repository}.insteadOf")
    monkeypatch.setenv("GIT_CONFIG_VALUE_0", "https://github.com/someone/breaker")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))  # where Snakemake clones to
    (own / "config").mkdir(parents=True)
    (own / "config/config.yaml").write_text(SETTINGS, encoding="utf-8")
    (own / "Snakefile").write_text(USE, encoding="utf-8")
    return own


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("git") is None, reason="Snakemake reads repositories by git")
def test_a_figure_is_made_through_a_module_of_a_repository(folder):
    """Below the prefix, by the user's settings over the defaults."""
    plan = snakemake("-n", FIGURE, folder=folder)
    rules = ("prior_predictive", "rig", "read_curves", "figure_prior_predictive")
    assert {*re.findall(r"^(?:local)?rule breaker_(\w+):", plan, re.M)} == {*rules}
    before = {item.name for item in folder.iterdir()}
    snakemake("-c1", FIGURE, folder=folder)
    assert (folder / FIGURE).stat().st_size > 10_000
    assert {item.name for item in folder.iterdir()} - before <= {"drive", ".snakemake"}
    assert "Nothing to be done" in snakemake("-n", FIGURE, folder=folder)
    snakemake("--lint", folder=folder)  # which fails where it has a finding


def test_without_the_package_the_remedy_is_named(tmp_path):
    (tmp_path / "breaker.py").write_text("raise ModuleNotFoundError('none', name='breaker')")
    command = [sys.executable, "-m", "snakemake", "-n", "all"]
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    said = done.stdout + done.stderr
    assert done.returncode == 1
    assert 'pip install ".[workflow]"' in said
    assert "Traceback" not in said
