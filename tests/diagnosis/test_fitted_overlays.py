"""`breaker fit-prior` of few high-voltage breakers, in records of 400 ms."""

import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from breaker.cli import main
from breaker.configuration.loading import load
from breaker.model.parameters import NAMES
from breaker.records.curves import read_curves
from breaker.records.folder import list_operations
from breaker.records.grid import Grid
from tests.exports import way

ROOT = Path(__file__).parents[2]

LENGTH, BEGINS = 400.0, {"closing": 55.0, "opening": 245.0}  # ms, of a closing and opening
REST = "endurance: {format: {zero: rest}}\n"


def smooth(time, over=0.06):
    """Way over stroke at times over the duration: with over-travel, as of medium voltage."""
    return way(time, 0.0, 1.0, over=over)


def late(time):
    """The same of a drive whose force builds up, with a damper over the last third."""
    u = np.clip(time, 0.0, 1.0)
    damped = 0.85 + 0.15 * (1.0 - (1.0 - (u - 0.7) / 0.3) ** 2)
    return np.where(u < 0.7, 0.85 * (u / 0.7) ** 2, damped)


def write(folder, stroke, durations, *, shape=smooth, count=1, rate=10.0, seed=1):
    """Write records of closing and opening of one breaker, with their table."""
    folder.mkdir(parents=True)
    rng, time = np.random.default_rng(seed), np.arange(LENGTH * rate) / rate
    rows = ["file,motion,operation"]
    for number in range(1, count + 1):
        closed, opened = (
            shape((time - begins) / durations[motion]) for motion, begins in BEGINS.items()
        )
        travel = stroke * (closed - opened) + 0.1 * rng.standard_normal(time.size)
        np.savetxt(
            folder / f"{number}.csv",
            np.column_stack([time / 1e3, travel]),
            fmt=["%.5f", "%.2f"],
            delimiter=",",
            header="time,travel",
            comments="",
        )
        rows += [f"{number}.csv,{motion},{number}" for motion in BEGINS]
    (folder / "operations.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    return folder


@pytest.fixture
def fit(tmp_path, capsys):
    """Fit breakers; the overlay, the configuration with it, and what is said."""

    def fit(*breakers):
        rest, file = tmp_path / "rest.yaml", tmp_path / "type.yaml"
        rest.write_text(REST, encoding="utf-8")
        folders = [str(each) for each in breakers]
        assert main(["fit-prior", *folders, "--config", str(rest), "--output", str(file)]) == 0
        said = " ".join(capsys.readouterr().out.split())
        overlay = yaml.safe_load(file.read_text(encoding="utf-8"))
        return overlay, load([file]), said

    return fit


def assert_read(folders, config):
    """Both motions of every breaker are read with the proposed settings, and whole."""
    for folder in folders:
        for motion in BEGINS:
            sensor = config["sensor"]
            times = np.linspace(sensor["start"], sensor["stop"], sensor["samples"])
            found = list_operations(folder, motion)
            curves = read_curves(found, config["endurance"]["format"], Grid(times), motion)
            assert curves.accepted.all(), curves.reason.values
            assert curves.missing.max() == 0


@pytest.mark.parametrize("seed", [0, 2, 3])
def test_whatever_is_written_is_accepted_and_reads_the_records(tmp_path, fit, seed):
    """Few and odd breakers of a type that is none, whose spread is next to unknown."""
    rng, folders = np.random.default_rng(seed), []
    for number in range((1, 2, 3, 5)[seed]):
        durations = {"closing": rng.uniform(40.0, 120.0), "opening": rng.uniform(30.0, 60.0)}
        more = {"count": int(rng.integers(1, 4)), "rate": float(rng.choice([5.0, 10.0]))}
        stroke, over = rng.uniform(140.0, 245.0), rng.uniform(0.0, 0.08)
        folder = tmp_path / f"Q{number}"
        write(folder, stroke, durations, shape=lambda t, o=over: smooth(t, o), **more)
        folders.append(folder)
    _, config, _ = fit(*folders)
    assert_read(folders, config)


def test_a_spread_that_is_next_to_unknown_is_bounded_and_said(tmp_path, fit):
    """One breaker by another's measure: the friction of their contacts ranges over anything."""
    drives = [(178.0, 120.0, 20.0), (245.0, 30.0, 60.0)]
    folders = [
        write(
            tmp_path / f"Q{k}",
            stroke,
            {"closing": closing, "opening": opening},
            shape=lambda time, over=0.03 * k: smooth(time, over),
        )
        for k, (stroke, closing, opening) in enumerate(drives)
    ]
    _, config, said = fit(*folders)
    widths = [config["prior"][name]["log_sd"] for name in NAMES]
    assert max(widths) <= 1.0
    assert float(re.search(r"bounded to ([\d.]+)", said)[1]) in widths


def test_drives_of_another_family_are_fitted_by_it(tmp_path, fit):
    folder = write(tmp_path / "Q", 220.0, {"closing": 70.0, "opening": 40.0}, shape=late)
    overlay, config, said = fit(folder)
    assert config["family"]["name"] == "any"
    assert overlay["family"] == {"name": "any"}
    assert "family any" in said
    # Breakers of a type are as alike as those of the default prior, whatever family they are in.
    assert config["prior"]["L"]["log_sd"] < 0.3
    assert_read([folder], config)


@pytest.mark.parametrize(
    ("shape", "stroke", "closing"),
    [(smooth, 150.0, 110.0), (smooth, 250.0, 60.0), (late, 150.0, 60.0), (late, 200.0, 110.0)],
)
def test_standard_records_hold_the_proposed_grid(tmp_path, fit, shape, stroke, closing):
    durations = {"closing": closing, "opening": 0.5 * closing}
    folder = write(tmp_path / "Q", stroke, durations, shape=shape)
    _, config, _ = fit(folder)
    assert_read([folder], config)
    assert config["sensor"]["stop"] > closing
