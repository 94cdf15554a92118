"""A simulator of one's own, with its prior: what `all` makes of it, and what an edit runs again."""

import os
import re
import shutil

import pytest
import yaml

from tests.workflow.conftest import ROOT, snakemake

pytestmark = pytest.mark.slow

OWN = """
import numpy as np

class Prior:
    names = ("stroke", "rate", "delay")

    def sample(self, n, rng):
        z = rng.standard_normal((n, 3))
        return np.array([10.0, 0.2, 5.0]) * np.exp([0.1, 0.2, 0.3] * z)

def simulate(theta, times, motion, rng):
    stroke, rate, delay = theta.T[:, :, None]
    way = 1.0 - np.exp(-rate * np.maximum(times - delay, 0.0))
    return stroke * (way if motion == "closing" else 1.0 - way)
"""
MINE = {
    "model": {"simulator": "own:simulate", "prior": "own:Prior"},
    "sensor": {"onset_sd": 0.0},
    "motions": ["closing"],
}
FIGURES = ["contraction", "loss", "pairs", "posterior_predictive", "prior_predictive"]
FIGURES += ["recovery", "sbc"]
RULES = {"prior_predictive", "bank_shard", "train", "validate", "posterior_predictive", "all"}
RULES |= {f"figure_{name}" for name in ("loss", "validation", "prior_predictive")}
RULES |= {"figure_posterior_predictive"}


def rules_of(text):
    return set(re.findall(r"^(?:local)?rule (\w+):", text, re.M))


def test_all_makes_what_needs_no_density_and_an_edit_runs_it_again(tmp_path):
    """A project with a simulator and a prior next to its configuration."""
    folder = tmp_path / "project"
    for part in ("config", "envs", "profiles", "workflow"):
        shutil.copytree(ROOT / part, folder / part)
    shutil.copy(ROOT / "Snakefile", folder)
    (folder / "own.py").write_text(OWN, encoding="utf-8")
    (folder / "my.yaml").write_text(yaml.dump(MINE), encoding="utf-8")

    def run(*arguments):
        where = ["--configfile", "config/test.yaml", "my.yaml"]
        return snakemake(*arguments, "all", *where, folder=folder)

    text = run("-c1")
    assert rules_of(text) == RULES
    assert "left out" in text
    made = {file.name for file in (folder / "figures").iterdir()}
    assert made == {f"{name}_closing.png" for name in FIGURES}
    os.utime(folder / "own.py")
    assert rules_of(run("-n")) == set()
    with (folder / "own.py").open("a", encoding="utf-8") as file:
        file.write("# an edit\n")
    assert rules_of(run("-n")) == RULES
