"""The environment: what is pinned, where, and that it is what the tests run in."""

import re
import sysconfig
import tomllib
from importlib import metadata

import yaml
from packaging.utils import canonicalize_name
from packaging.version import Version

import breaker
from tests.scripts import ROOT, script

PYPROJECT = ROOT / "pyproject.toml"

lock = script("envs/lock.py")


def entries(file: str = "requirements.lock") -> dict[str, list[str]]:
    """Options by requirement, read from a lock as pip reads it."""
    text = (ROOT / "envs" / file).read_text(encoding="utf-8")
    joined = text.replace("\\\n", " ").splitlines()
    lines = [line.split() for line in joined if line and not line.startswith("#")]
    return {requirement: options for requirement, *options in lines}


def locked(file: str = "requirements.lock") -> dict[str, str]:
    """Versions by canonical name."""
    return dict(requirement.split("==") for requirement in entries(file))


def test_files_are_what_the_lock_command_writes():
    """Catches a pin changed by hand, a dependency added but not locked, and one left over."""
    for requirement, options in (entries() | entries("slurm.lock")).items():
        assert len(set(options)) == len(options) > 0, requirement
        assert all(re.fullmatch(r"--hash=sha256:[0-9a-f]{64}", option) for option in options)
    assert set(locked()) == lock.closure(
        requirement.name for requirement in lock.direct(PYPROJECT)[0]
    )
    text = (ROOT / "envs" / "requirements.lock").read_text(encoding="utf-8")
    assert lock.versions(text) == locked()
    conda = (ROOT / "envs" / "breaker.yaml").read_text(encoding="utf-8")
    assert conda == lock.conda_environment(text)


def test_direct_dependencies_are_locked_within_their_range():
    pins = locked()
    stated, for_slurm = lock.direct(PYPROJECT)
    names = {requirement.name for requirement in stated}
    assert {"numpy", "torch", "snakemake", "pytest", "setuptools"} <= names  # of every kind
    cluster = locked("slurm.lock")
    assert not set(pins) & set(cluster)
    for requirement in (*stated, *for_slurm):
        assert requirement.specifier, f"{requirement} has no range"
        version = (pins | cluster)[canonicalize_name(requirement.name)]
        assert requirement.specifier.contains(version)


def test_tests_run_in_the_locked_environment_and_nothing_else_is_in_it():
    installed = {
        canonicalize_name(distribution.name): Version(distribution.version).public
        for distribution in metadata.distributions(path=[sysconfig.get_path("purelib")])
    }
    extra = {name for name in installed.keys() - locked().keys() if not lock.CARDS.fullmatch(name)}
    assert extra == {"pip", "breaker-drive"}
    assert {name: installed.get(name) for name in locked()} == locked()


def test_version_is_stated_once_cited_and_in_the_changelog():
    project = tomllib.loads(PYPROJECT.read_text(encoding="utf-8"))["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert project["dynamic"] == ["version"]  # from the package itself
    assert breaker.__version__ == citation["version"]
    assert breaker.__version__ in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert project["name"] == "breaker-drive"
    assert project["license"] == citation["license"] == "MIT"
    assert (ROOT / "LICENSE").read_text(encoding="utf-8").startswith("MIT License")
    assert project["scripts"] == {"breaker": "breaker.cli:run"}
