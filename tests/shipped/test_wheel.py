"""The wheel: all files of the package are in it, and what it asks for is little.

``make dist`` installs and uses it.
"""

import shutil
import sys
import zipfile

import pytest
from packaging.requirements import Requirement

from tests.bare import HEAVY
from tests.scripts import ROOT, script


@pytest.mark.slow
def test_the_wheel_has_every_file_and_asks_for_neither_torch_nor_snakemake(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "path", [str(ROOT / "envs"), *sys.path])  # as of `python envs/...`
    dist, copy = script("envs/wheel_check.py"), tmp_path / "project"
    skipped = shutil.ignore_patterns("*.egg-info", "__pycache__")
    shutil.copytree(ROOT / "src", copy / "src", ignore=skipped)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, copy)
    source, wheel = dist.build(copy, tmp_path / "dist")
    assert dist.faults(source, wheel) == []
    packaged = {
        file.relative_to(ROOT / "src").as_posix(): file.read_bytes()
        for file in (ROOT / "src" / "breaker").rglob("*")
        if file.is_file() and "__pycache__" not in file.parts
    }
    with zipfile.ZipFile(wheel) as opened:
        names = [name for name in opened.namelist() if name.startswith("breaker/")]
        assert {name: opened.read(name) for name in names} == packaged
    needed = [Requirement(item) for item in dist.metadata_of(wheel).get_all("Requires-Dist")]
    core = {item.name for item in needed if item.marker is None}
    assert {"numpy", "scipy", "safetensors"} <= core
    assert not core & {"torch", "snakemake", *HEAVY}
    networks = {e.name for e in needed if e.marker and e.marker.evaluate({"extra": "networks"})}
    assert networks - core == {"torch", "breaker-drive"}  # with its extras for stores and speed
