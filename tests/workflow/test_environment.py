"""The environment: what is pinned, where, and that it is what the tests run in."""

import re
import sysconfig
import tomllib
from importlib import metadata

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

import breaker
from tests.scripts import ROOT, script

PYPROJECT = ROOT / "pyproject.toml"

PLATFORMS = [
    {"sys_platform": name.lower(), "platform_system": name, "platform_machine": machine}
    for name, machine in (("Linux", "x86_64"), ("Linux", "aarch64"), ("Darwin", "arm64"))
]
PYTHONS = ["3.11", "3.13", "3.14"]


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


def unmet(pinned: dict[str, str], environment: dict[str, str], cards: re.Pattern) -> list[str]:
    """What the pinned packages need on a platform and is not pinned at a version that will do.

    But what torch pins for graphics cards.
    """
    wrong = []
    for name in pinned:
        for requirement in map(Requirement, metadata.requires(name) or []):
            if requirement.marker and not requirement.marker.evaluate({"extra": "", **environment}):
                continue
            needed = canonicalize_name(requirement.name)
            version = pinned.get(needed)
            if cards.fullmatch(needed):
                continue
            if version is None or not requirement.specifier.contains(version, prereleases=True):
                wrong.append(f"{name} needs {requirement}, pinned is {version}")
    return wrong


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


@pytest.mark.parametrize(("platform", "python"), [*zip(PLATFORMS, PYTHONS, strict=True)])
def test_lock_is_complete_on_every_platform(platform, python):
    """Planted faults: a pin that is missing, and one that is out of date."""
    environment = {**platform, "python_version": python, "python_full_version": f"{python}.0"}
    environment["os_name"], pins = "posix", locked()
    assert unmet(pins, environment, lock.CARDS) == []
    wrong = {name: version for name, version in pins.items() if name != "llvmlite"}
    lines = unmet(wrong | {"numpy": "1.0"}, environment, lock.CARDS)
    assert any("llvmlite" in line for line in lines)
    assert any("numpy" in line for line in lines)


def test_tests_run_in_the_locked_environment_and_nothing_else_is_in_it():
    installed = {
        canonicalize_name(distribution.name): Version(distribution.version).public
        for distribution in metadata.distributions(path=[sysconfig.get_path("purelib")])
    }
    extra = {name for name in installed.keys() - locked().keys() if not lock.CARDS.fullmatch(name)}
    assert extra == {"pip", breaker.DISTRIBUTION}
    assert {name: installed.get(name) for name in locked()} == locked()


def test_version_is_stated_once_cited_and_in_the_changelog():
    project = tomllib.loads(PYPROJECT.read_text(encoding="utf-8"))["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert project["dynamic"] == ["version"]  # from the package itself
    assert breaker.__version__ == citation["version"]
    assert breaker.__version__ in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert project["name"] == breaker.DISTRIBUTION
    assert project["license"] == citation["license"] == "MIT"
    assert (ROOT / "LICENSE").read_text(encoding="utf-8").startswith("MIT License")
    assert project["scripts"] == {"breaker": "breaker.cli:run"}
