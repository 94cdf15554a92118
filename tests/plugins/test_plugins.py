"""Formats of other distributions: the example, and formats that raise or lack a part."""

import logging
import os
import subprocess
import sys
import tomllib

import numpy as np
import pytest

from breaker.records.files import RejectedCurveError
from breaker.records.formats import registry
from breaker.records.formats.registry import FORMATS, added_formats, read_columns
from breaker.records.settings import complete
from tests.scripts import ROOT


def install(folder, name, formats, files):
    """Put a distribution of formats by name, and of files, into a folder, as pip does."""
    about = folder / f"{name.replace('-', '_')}-1.0.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    lines = ["[breaker.formats]", *(f"{key} = {value}" for key, value in formats.items())]
    (about / "entry_points.txt").write_text("\n".join(lines) + "\n")
    for file, text in files.items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_text(text, encoding="utf-8")
    return folder


@pytest.fixture
def folder(tmp_path):
    """The distribution of the documentation in a folder, with the contract of its test."""
    example = ROOT / "docs/examples/own_format"
    some = [file for file in example.rglob("*") if file.suffix in (".py", ".toml")]
    files = {str(file.relative_to(example)): file.read_text(encoding="utf-8") for file in some}
    contract = ROOT / "tests/records/format_contract.py"
    files["format_contract.py"] = contract.read_text(encoding="utf-8")
    project = tomllib.loads(files["pyproject.toml"])["project"]
    formats = project["entry-points"]["breaker.formats"]
    return install(tmp_path / "installed", project["name"], formats, files)


def run(folder, *arguments):
    """Run Python with the distribution on its path."""
    path = os.pathsep.join([str(folder), *filter(None, [os.environ.get("PYTHONPATH")])])
    command, place = [sys.executable, *map(str, arguments)], os.environ | {"PYTHONPATH": path}
    return subprocess.run(command, env=place, capture_output=True, text=True, cwd=folder)


def test_a_file_of_the_format_is_inspected_and_read(folder, tmp_path):
    """A closing of 60 ms at 10 kHz; a damaged file is refused."""
    time = 0.1 * np.arange(1000)
    share = np.clip((time - 20.0) / 25.0, 0.0, 1.0)
    travel = 13.0 * share * share * (3.0 - 2.0 * share)
    travel += 0.01 * np.random.default_rng(1).standard_normal(time.size)
    content = b"ACME" + (10_000).to_bytes(4, "little") + travel.astype("<f4").tobytes()
    file = tmp_path / "closing 1.acme"
    file.write_bytes(content)
    shown = run(folder, "-m", "breaker", "inspect", file, "--output", tmp_path / "my.yaml")
    assert shown.returncode == 0, shown.stderr
    shown = run(folder, "-m", "breaker", "infer", file, "--config", tmp_path / "my.yaml")
    assert shown.returncode == 0, shown.stderr
    assert "stroke" in shown.stdout
    file.write_bytes(content[:-3])
    shown = run(folder, "-m", "breaker", "inspect", file)
    assert shown.returncode == 1
    assert str(file) in shown.stderr


@pytest.mark.parametrize("fault", [False, True])
def test_the_contract_notices_other_numbers(folder, fault):
    if fault:
        module = folder / "acme_breaker" / "recorder.py"
        module.write_text(module.read_text().replace("astype(float)", "astype(float) + 0.01"))
    options = ["-q", "-p", "no:cacheprovider", "-p", "no:zarr", f"--rootdir={folder}"]
    shown = run(folder, "-m", "pytest", *options, folder / "test_recorder.py")
    assert shown.returncode == fault, shown.stdout
    failed = "FAILED test_recorder.py::TestAcme::test_what_is_read_is_what_was_written"
    assert (failed in shown.stdout) == fault


# ---- formats that raise, or lack something -------------------------------------------------------

GOOD = """
ENDINGS, SIGNATURES, EXTRA = {'.bad': 'a bad record'}, (), ''
def read(opened, form): raise RuntimeError('no')
"""


@pytest.fixture
def plugged(tmp_path, monkeypatch):
    """Install a distribution of one module, for this test."""

    def install_module(text):
        place = tmp_path / "bad"
        install(place, "bad-plugin", {"bad": "module_of_bad"}, {"module_of_bad.py": text})
        monkeypatch.syspath_prepend(place)
        monkeypatch.delitem(sys.modules, "module_of_bad", raising=False)

    return install_module


@pytest.mark.parametrize("text", ["1 / 0", "import nothing_of_this_name", "ENDINGS = {}"])
def test_a_format_that_is_none_is_named_and_left_out(plugged, caplog, text):
    plugged(text)
    with caplog.at_level(logging.ERROR):
        assert [*added_formats()] == []
    assert "module_of_bad" in caplog.text


def test_a_format_that_raises_refuses_its_own_files_alone(plugged, monkeypatch, tmp_path):
    plugged(GOOD)
    monkeypatch.setattr(registry, "FORMATS", (*FORMATS, *added_formats()))
    for name in ("a.bad", "a.csv"):
        (tmp_path / name).write_bytes(b"time,travel\ns,mm\n0.1,1\n0.2,2\n")
    with pytest.raises(RejectedCurveError, match="a bad record"):
        read_columns(tmp_path / "a.bad", complete({}))
    assert read_columns(tmp_path / "a.csv", complete({})).travel.size == 2
