"""The distribution on the page: a format, limits and a simulator that nobody here knows."""

import os
import subprocess
import sys

import numpy as np
import pytest
import yaml

from breaker.cli import main
from breaker.common.plugins import plugins
from breaker.configuration.loading import load, merge
from breaker.drive.family.network_files import open_network, write_network
from breaker.drive.simulation.own_family import family_of
from breaker.drive.training.family_bank import simulate_family
from breaker.drive.training.network_training import train_network
from breaker.drive.training.training_rows import rows_of, sample_rows
from breaker.mechanism.limits import from_list
from breaker.mechanism.prior import Prior
from breaker.quantities.parameters import NAMES
from breaker.reading.instruments.export import write_curve
from breaker.shipped import DEFAULTS
from tests.plugins.distribution import blocks, install_example


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The distribution in a folder, which is no part of this process's path."""
    return install_example(tmp_path_factory.mktemp("installed"))


@pytest.fixture
def installed(folder, monkeypatch):
    """The distribution on the path of this process, which has read its formats already."""
    monkeypatch.syspath_prepend(folder)
    plugins.cache_clear()
    yield folder
    plugins.cache_clear()
    for name in [each for each in sys.modules if each.startswith("acme_breaker")]:
        del sys.modules[name]


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


def test_a_report_of_a_misread_file_has_the_version(folder, tmp_path):
    file, report = acme(tmp_path / "closing 1.acme"), tmp_path / "problem.txt"
    shown = run(folder, "-m", "breaker", "inspect", file, "--report-problem", report)
    assert shown.returncode == 0, shown.stderr
    assert "the format acme of acme-breaker 1.0" in report.read_text(encoding="utf-8")


def test_a_damaged_file_is_named_with_the_distribution(folder, tmp_path):
    file = acme(tmp_path / "closing 1.acme", whole=False)
    shown = run(folder, "-m", "breaker", "inspect", file)
    assert shown.returncode == 1
    said = f"{file}: is no whole record of Acme (the format acme of acme-breaker 1.0)"
    assert said in shown.stderr


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
    assert "11 passed" in shown.stdout, shown.stdout
    assert shown.returncode == 0


def test_a_format_that_reads_other_numbers_fails_the_contract(tmp_path):
    folder = install_example(tmp_path)
    module = folder / "acme_breaker" / "recorder.py"
    module.write_text(module.read_text().replace("astype(float)", "astype(float) + 0.01"))
    shown = contract(folder)
    assert (
        "FAILED test_recorder.py::TestAcme::test_what_is_read_is_what_was_written" in shown.stdout
    )


def test_limits_of_the_distribution_stand_beside_ones_own(installed, tmp_path):
    file = tmp_path / "acme.yaml"
    file.write_text(blocks()["acme.yaml"])
    config = load([DEFAULTS, file], curves=False)
    names = [each.name for each in from_list(config["limits"], config["motions"])]
    assert names == [
        *("touch late", "stroke closing high", "stroke closing low"),
        *("stroke opening high", "stroke opening low", "slow"),
    ]


def test_limits_of_nobody_are_refused(tmp_path, capsys):
    overlay = tmp_path / "my.yaml"
    overlay.write_text("limits: [{from: acme-vb12}]")
    assert main(["check", str(tmp_path), "--config", str(overlay)]) == 1
    assert "no distribution that is installed has the limits acme-vb12" in capsys.readouterr().err


@pytest.fixture
def config(installed, tmp_path):
    overlay = merge(
        yaml.safe_load(blocks()["coil.yaml"]), {"family": {"wear": {"change": {"f": [-0.2, -0.1]}}}}
    )
    (tmp_path / "coil.yaml").write_text(yaml.safe_dump(overlay))
    return load([DEFAULTS, tmp_path / "coil.yaml"], curves=False)


def test_drives_move_by_the_simulator(config):
    family = family_of(Prior.from_settings(config["prior"]), config["family"])
    bank = simulate_family(family, 30, np.random.default_rng(1))
    assert bank.sizes["drive"] == 30
    theta = dict(zip(NAMES, bank["parameters"].sel(condition="new").values.T, strict=True))
    closed = (theta["f"] + theta["k_b"] * theta["L"]) / (theta["k_a"] + theta["k_b"])
    assert np.allclose(bank["stroke"].sel(condition="new"), closed, rtol=1e-3)
    # Force builds up from 0 on: nothing moves at once, and something does before the touch.
    release, switching = (bank[n].sel(condition="new") for n in ("release", "switching"))
    assert (release < 0.0).all()
    assert (switching > release).all()
    assert (bank["elements"].values[..., 0] == 0.0).all()


def test_what_the_simulator_adds_wears(config):
    family = family_of(Prior.from_settings(config["prior"]), config["family"])
    rng = np.random.default_rng(1)
    new = family.new(rng)
    worn = [family.worn(new, rng, "dense") for _ in range(30)]
    coils = np.array([each.value("coil") / new.value("coil") for each in worn])
    assert coils.max() > 1.1
    assert coils.min() >= 1.0


def test_networks_are_trained_checked_and_answer(config, tmp_path, capsys, one_thread):
    """Hardly trained: whether all of it goes through, not how good it is."""
    small = {"width": 32, "blocks": 1, "features": 16, "components": 3, "head": 8}
    training = {"steps": 60, "batch": 64, "evaluate_every": 20, "validation_curves": 40}
    settings = merge(config["family_networks"], {"network": small, "training": training})
    family = family_of(Prior.from_settings(config["prior"]), config["family"])
    bank = simulate_family(family, 240, np.random.default_rng(1))
    held_out = simulate_family(family, 60, np.random.default_rng(2))
    _, weights, frozen = train_network(rows_of("levels", bank), held_out, settings, 1)
    about = {"kind": "levels", "family": "acme_coil", "prior": config["prior"]}
    model = tmp_path / "levels.safetensors"
    write_network(model, about | {"drives": config["family"]}, weights, frozen)
    levels = open_network(model)
    rows = rows_of("levels", held_out, levels)
    judged = sample_rows(levels, rows, "both", 50, np.random.default_rng(3))
    assert np.isfinite(judged["draws"]).all()

    drive, rng = family.new(np.random.default_rng(4)), np.random.default_rng(5)
    [(steps, _), _] = family.followed(drive, np.inf, np.inf)
    time = np.arange(-10.0, 100.0, 0.1)
    travel = np.interp(time, steps[:, 0], steps[:, 2]) + 0.01 * rng.standard_normal(time.size)
    record = tmp_path / "closing 1.csv"
    write_curve(record, time, travel, motion="closing", operation=1)
    assert main(["infer", str(record), "--model", str(model)]) == 0
    assert "acme_coil" in capsys.readouterr().out


def test_the_page_shows_every_file():
    assert set(blocks()) == {
        *("pyproject.toml", "acme_breaker/recorder.py", "test_recorder.py", "acme.yaml"),
        *("acme_breaker/datasheet.py", "acme_breaker/drives.py", "coil.yaml"),
    }
    lines = blocks()["acme_breaker/drives.py"].count("\n")
    assert lines <= 50, "some fifty lines are promised"
