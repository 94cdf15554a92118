"""The workflow as a module of another one, from a repository, with a prefix and own settings."""

import os
import re
import shutil
import subprocess
import sys
from importlib import metadata

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.workflow.conftest import ROOT, snakemake

# As `snakedeploy deploy-workflow` writes it, with a prefix, a section and a rule of one's own.
USE = """
configfile: "config/config.yaml"

rule own:
    output: "own/{name}.txt"
    log: "logs/own/{name}.log"
    conda: "own.yaml"
    script: "scripts/own.py"

module breaker:
    snakefile: github("someone/breaker", path="workflow/Snakefile", tag="v0")
    config: config["breaker"]
    prefix: "drive"

use rule * from breaker as breaker_*
"""
SETTINGS = """
breaker:
  motions: [closing]
  prior_predictive: {curves: 20}
  rig: {operations: 8}
  endurance: {operations_per_job: 20}
"""
FIGURE = "drive/figures/prior_predictive_closing.png"
LOCAL = USE.replace(
    'github("someone/breaker", path="workflow/Snakefile", tag="v0")', f'"{ROOT}/workflow/Snakefile"'
)


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """Run Snakemake in an environment that has what Snakemake requires, and nothing else."""
    site, found, waiting = tmp_path_factory.mktemp("site"), set(), ["snakemake"]
    while waiting:
        name = canonicalize_name(waiting.pop())
        if name in found:
            continue
        found.add(name)
        needed = map(Requirement, metadata.requires(name) or [])
        waiting += [r.name for r in needed if not r.marker or r.marker.evaluate({"extra": ""})]
        for top in {file.parts[0] for file in metadata.files(name)} - {"..", "__pycache__"}:
            (site / top).symlink_to(metadata.distribution(name).locate_file(top))
    assert "numpy" not in found

    def run(*arguments, folder):
        environment = {**os.environ, "PYTHONPATH": str(site)}
        command = [sys.executable, "-S", "-m", "snakemake", "--nolock", *map(str, arguments)]
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
        said = done.stdout + done.stderr
        assert "Traceback" not in said, said[-5000:]
        return done.returncode, said

    return run


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
    for name in ("config", "scripts"):
        (own / name).mkdir(parents=True)
    (own / "scripts/own.py").write_text("", encoding="utf-8")
    (own / "config/config.yaml").write_text(SETTINGS, encoding="utf-8")
    (own / "Snakefile").write_text(USE, encoding="utf-8")
    return own


@pytest.mark.skipif(shutil.which("git") is None, reason="Snakemake reads repositories by git")
def test_a_figure_is_made_through_a_module_of_a_repository(folder):
    """Below the prefix, by the user's settings over the defaults; other rules stay as they are."""
    plan = snakemake("-n", "own/a.txt", FIGURE, folder=folder)
    said = re.split(r"^(?:local)?rule ", plan, flags=re.MULTILINE)[1:]
    jobs = {each.partition(":")[0]: each for each in said}
    assert set(jobs) == {
        "own",
        *(f"breaker_{name}" for name in ("prior_predictive", "rig", "read_curves")),
        "breaker_figure_prior_predictive",
    }
    assert all(("mem_mb=" in said) == (name != "own") for name, said in jobs.items())
    assert "benchmark:" not in jobs["own"]
    assert "input:" not in jobs["own"]
    before = {each.name for each in folder.iterdir()}
    snakemake("-c1", FIGURE, folder=folder)
    assert (folder / FIGURE).stat().st_size > 10_000
    assert {each.name for each in folder.iterdir()} - before <= {"drive", ".snakemake"}
    # Curves of another source are noticed below the prefix.
    said = folder / "drive/results/endurance/closing/curves_000.zarr/.zattrs"
    said.write_text(said.read_text(encoding="utf-8").replace("stand-in", "other"), encoding="utf-8")
    assert "Forced execution" in snakemake("-n", FIGURE, folder=folder)


def test_a_figure_is_made_through_a_module_of_a_clone(tmp_path):
    (tmp_path / "config").mkdir()
    (tmp_path / "config/config.yaml").write_text(SETTINGS, encoding="utf-8")
    (tmp_path / "Snakefile").write_text(LOCAL, encoding="utf-8")
    snakemake("-c1", FIGURE, folder=tmp_path)
    assert (tmp_path / FIGURE).stat().st_size > 10_000
    assert {each.name for each in tmp_path.iterdir()} == {
        "config",
        "Snakefile",
        "drive",
        ".snakemake",
    }


@pytest.mark.skipif(shutil.which("git") is None, reason="Snakemake reads repositories by git")
def test_the_lint_of_a_use_is_content(folder):
    assert "in a good condition" in snakemake("--lint", folder=folder)


def test_the_catalogue_finds_what_it_looks_for(tmp_path):
    """A file of the usage, a schema, and a graph of the rules by its own command."""
    usage = yaml.safe_load((ROOT / ".snakemake-workflow-catalog.yml").read_text(encoding="utf-8"))
    assert set(usage["usage"]) == {"mandatory-flags", "software-stack-deployment"}
    assert set(usage["usage"]["mandatory-flags"]) == {"desc", "flags"}
    assert usage["usage"]["software-stack-deployment"] == {
        "conda": True,
        "apptainer": False,
        "apptainer+conda": False,
        "report": True,
    }
    shutil.copytree(ROOT / ".test", tmp_path / ".test")
    where = ["-s", ROOT / "workflow/Snakefile", "-c", "1", "-d", tmp_path / ".test"]
    graph = snakemake(*where, "--forceall", "--rulegraph")
    assert 'label = "figure_verdict"' in graph
    here = ["--configfile", ROOT / "config/test.yaml", "--forceall", "--rulegraph"]
    rules = [set(re.findall('label = "(.*?)"', said)) for said in (graph, snakemake(*here))]
    assert rules[1] - rules[0] == {"everything"}, "without a target, the project's file does `all`"
    assert (ROOT / "workflow/schemas/config.schema.yaml").exists()
    words = (ROOT / "README.md").read_text(encoding="utf-8").lower()
    assert "snakemake" in words
    assert "workflow" in words


def test_checkpoints_are_below_the_prefix_too():
    """Snakemake knows nothing of these files."""
    rules = "".join(p.read_text(encoding="utf-8") for p in (ROOT / "workflow").rglob("*.smk"))
    assert len(re.findall(r"checkpoint=placed\(", rules)) == 3
    assert not re.search(r"checkpoint=\"", rules)


MISSING = f"missing in the environment of {sys.executable}: "
REMEDY = 'Run `pip install "breaker-drive[workflow]"`'


@pytest.mark.skipif(shutil.which("git") is None, reason="Snakemake reads repositories by git")
def test_with_nothing_but_snakemake_a_repository_says_what_to_install(alone, folder):
    code, said = alone("-n", FIGURE, folder=folder)
    assert code == 1
    assert f"{MISSING}breaker. {REMEDY}" in said


def test_with_nothing_but_snakemake_a_clone_is_linted(alone):
    code, said = alone("--lint", folder=ROOT)
    assert code == 0, said[-5000:]
    assert "in a good condition" in said


def test_with_nothing_but_snakemake_a_module_of_a_clone_is_planned(alone, tmp_path):
    """By names of curve files and limits of one's own; a job then fails, and a line says why."""
    (tmp_path / "config").mkdir()
    own = yaml.safe_load(SETTINGS)
    own["breaker"]["endurance"]["curves"] = str(tmp_path / "curves")
    own["breaker"]["limits"] = [{"quantity": "stroke", "reference": 13.0, "tolerance": "5 %"}]
    (tmp_path / "config/config.yaml").write_text(yaml.safe_dump(own), encoding="utf-8")
    (tmp_path / "curves/closing").mkdir(parents=True)
    for number in (1, 2, 30):
        (tmp_path / f"curves/closing/operation_{number}.csv").write_text("", encoding="utf-8")
    (tmp_path / "breaker").mkdir()  # as of a clone in the folder: it is not the package
    (tmp_path / "Snakefile").write_text(LOCAL, encoding="utf-8")
    code, said = alone("-n", "drive/results/limits.csv", folder=tmp_path)
    assert code == 0, said[-5000:]
    assert "drive/results/endurance/closing/curves_001.zarr" in said
    assert f"{MISSING}matplotlib, numba" in said
    assert REMEDY in said


def test_with_nothing_but_snakemake_a_run_ends_before_its_first_job(alone, tmp_path):
    (tmp_path / "config").mkdir()
    (tmp_path / "config/config.yaml").write_text("seed: 1", encoding="utf-8")
    where = ["--snakefile", ROOT / "workflow/Snakefile", "--directory", tmp_path]
    code, said = alone(*where, "-c1", "results/rig/curves/closing", folder=tmp_path)
    assert code == 1
    assert f"{MISSING}matplotlib, numba" in said
    assert not (tmp_path / "results").exists()
