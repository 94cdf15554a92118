"""The wheel: all that the command needs is in it, and what it asks for is little."""

import importlib
import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import numpy as np
import pytest
from packaging.requirements import Requirement

import breaker
from breaker.common.randomness import generator
from breaker.configuration.loading import load
from breaker.family.curve_file import write_curve
from breaker.model.curves import travel
from tests.bare import HEAVY, WITHOUT

pytestmark = pytest.mark.slow  # builds a wheel and works with it
ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "src" / "breaker"


@pytest.fixture(scope="module")
def dist():
    """The module that builds and checks."""
    sys.path.insert(0, str(ROOT / "envs"))  # as of `python envs/wheel_check.py`
    try:
        return importlib.import_module("wheel_check")
    finally:
        sys.path.remove(str(ROOT / "envs"))


@pytest.fixture(scope="module")
def built(dist, tmp_path_factory):
    """Source distribution and wheel of a copy of the project, made without a network."""
    copy, out = tmp_path_factory.mktemp("project"), tmp_path_factory.mktemp("dist")
    skipped = shutil.ignore_patterns("*.egg-info", "__pycache__")
    shutil.copytree(ROOT / "src", copy / "src", ignore=skipped)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, copy)
    return dist.build(copy, out)


@pytest.fixture(scope="module")
def described(dist, built):
    """The metadata of the wheel."""
    return dist.metadata_of(built[1])


def packaged():
    """Every file of the package, as it should be in a wheel."""
    files = (file for file in SOURCES.rglob("*") if file.is_file())
    return {
        file.relative_to(ROOT / "src").as_posix()
        for file in files
        if "__pycache__" not in file.parts
    }


def test_wheel_and_source_distribution_have_every_file_of_the_package(built):
    with zipfile.ZipFile(built[1]) as wheel:
        assert {name for name in wheel.namelist() if name.startswith("breaker/")} == packaged()
        for name in (
            "shipped/any_levels.safetensors",
            "shipped/MODEL_CARD.md",
            "family/examples.yaml",
        ):
            assert wheel.read(f"breaker/{name}") == (SOURCES / name).read_bytes()
        (licence,) = (name for name in wheel.namelist() if name.endswith("/licenses/LICENSE"))
        assert wheel.read(licence) == (ROOT / "LICENSE").read_bytes()
    with tarfile.open(built[0]) as source:
        names = {name.partition("/")[2] for name in source.getnames()}
        assert names >= {f"src/{name}" for name in packaged()} | {"LICENSE", "pyproject.toml"}


def test_the_command_needs_neither_torch_nor_snakemake(described):
    needed = [Requirement(each) for each in described.get_all("Requires-Dist")]
    core = {each.name for each in needed if each.marker is None}
    assert {"numpy", "scipy", "safetensors"} <= core
    assert not core & {"torch", "snakemake", *HEAVY}
    networks = {e.name for e in needed if e.marker and e.marker.evaluate({"extra": "networks"})}
    assert networks - core == {"torch", "breaker-drive"}  # with its extras for stores and speed


def test_the_wheel_works_in_any_folder_without_the_extras(built, tmp_path):
    place, folder = tmp_path / "installed", tmp_path / "elsewhere"
    with zipfile.ZipFile(built[1]) as wheel:
        wheel.extractall(place)
    (place / "sitecustomize.py").write_text(WITHOUT)
    folder.mkdir()
    times = 0.1 * np.arange(760)
    medians = [[each["median"] for each in load()["prior"].values()]]
    record = travel(np.array(medians), times, "closing", onset=10.0).travel[0]
    record += 0.1 * generator(1, "test of the wheel").standard_normal(times.size)
    write_curve(folder / "a.csv", times, record, motion="closing", operation=1)

    def run(*arguments):
        return subprocess.run(
            [sys.executable, *arguments],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(place)},
            capture_output=True,
            text=True,
        )

    done = run("-c", "import breaker; print(breaker.__file__); import torch")
    assert done.stdout == f"{place}/breaker/__init__.py\n"
    assert "ModuleNotFoundError" in done.stderr
    assert run("-m", "breaker", "--version").stdout == f"breaker {breaker.__version__}\n"
    answered = run("-m", "breaker", "infer", "a.csv", "--output", "a.table")
    assert answered.stderr == ""
    assert "medium_voltage" in answered.stdout
    assert (folder / "a.table").read_text().count("closing") > 7
