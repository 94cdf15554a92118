"""The distribution on the page: a format that nobody here knows."""

import os
import subprocess
import sys

import numpy as np
import pytest

from tests.plugins.distribution import install_example


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The distribution in a folder, which is no part of this process's path."""
    return install_example(tmp_path_factory.mktemp("installed"))


def run(folder, *arguments, **options):
    """Run Python with the distribution on its path."""
    path = os.pathsep.join([str(folder), *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, *map(str, arguments)]
    return subprocess.run(
        command, env=os.environ | {"PYTHONPATH": path}, capture_output=True, text=True, **options
    )


def acme(file, *, whole=True):
    """A closing of 60 ms in the format of the page, at 10 kHz."""
    time = 0.1 * np.arange(1000)
    share = np.clip((time - 20.0) / 25.0, 0.0, 1.0)
    travel = 13.0 * share * share * (3.0 - 2.0 * share)
    travel += 0.01 * np.random.default_rng(1).standard_normal(time.size)
    content = b"ACME" + (10_000).to_bytes(4, "little") + travel.astype("<f4").tobytes()
    file.write_bytes(content if whole else content[:-3])
    return file


def test_a_file_of_the_format_is_inspected_and_read(folder, tmp_path):
    file = acme(tmp_path / "closing 1.acme")
    shown = run(folder, "-m", "breaker", "inspect", file, "--output", tmp_path / "my.yaml")
    assert shown.returncode == 0, shown.stderr
    assert "a record of Acme" in shown.stdout
    told = run(folder, "-m", "breaker", "infer", file, "--config", tmp_path / "my.yaml")
    assert told.returncode == 0, told.stderr
    assert "stroke" in told.stdout


def test_a_damaged_file_is_refused(folder, tmp_path):
    file = acme(tmp_path / "closing 1.acme", whole=False)
    shown = run(folder, "-m", "breaker", "inspect", file)
    assert shown.returncode == 1
    assert f"{file}: is no whole record of Acme" in shown.stderr


def test_without_the_distribution_it_is_no_format(tmp_path):
    file = acme(tmp_path / "closing 1.acme")
    shown = run(tmp_path, "-m", "breaker", "inspect", file)
    assert shown.returncode == 1
    assert "acme-breaker" not in shown.stderr


def contract(folder):
    """Run the test module of the page on a folder."""
    options = ["-q", "-p", "no:cacheprovider", "-p", "no:zarr", f"--rootdir={folder}"]
    return run(folder, "-m", "pytest", *options, folder / "test_recorder.py", cwd=folder)


def test_the_format_passes_the_contract(folder):
    shown = contract(folder)
    assert "9 passed" in shown.stdout, shown.stdout
    assert shown.returncode == 0


def test_a_format_that_reads_other_numbers_fails_the_contract(tmp_path):
    folder = install_example(tmp_path)
    module = folder / "acme_breaker" / "recorder.py"
    module.write_text(module.read_text().replace("astype(float)", "astype(float) + 0.01"))
    shown = contract(folder)
    assert (
        "FAILED test_recorder.py::TestAcme::test_what_is_read_is_what_was_written" in shown.stdout
    )
