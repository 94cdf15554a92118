"""`breaker fit-prior`: its lines of configuration, and records of high-voltage breakers."""

import numpy as np
import pytest
import yaml

from breaker.cli import main
from breaker.common.randomness import generator
from breaker.configuration.definitions import family_of
from breaker.configuration.loading import load
from breaker.model.parameters import NAMES, Size
from breaker.records.curves import Grid, read_curves
from breaker.records.folder import list_operations
from breaker.shipped import HELD_BACK
from tests.diagnosis.drives import breakers_of, type_of, write_breakers
from tests.exports import way

SIZE = Size(10.0, 4.0)
LENGTH, BEGINS = 400.0, {"closing": 55.0, "opening": 245.0}  # ms, of a closing and opening


def late(time):
    """Way over stroke of a drive whose force builds up, with a damper over the last third."""
    u = np.clip(time, 0.0, 1.0)
    damped = 0.85 + 0.15 * (1.0 - (1.0 - (u - 0.7) / 0.3) ** 2)
    return np.where(u < 0.7, 0.85 * (u / 0.7) ** 2, damped)


def smooth(time):
    """The same of a drive with over-travel."""
    return way(time, 0.0, 1.0, over=0.06)


def write(folder, stroke, closing, shape=smooth):
    """Write a closing and an opening, which takes half as long, with their table."""
    folder.mkdir(parents=True)
    rng, time = np.random.default_rng(1), np.arange(10.0 * LENGTH) / 10.0
    durations = {"closing": closing, "opening": 0.5 * closing}
    closed, opened = (shape((time - BEGINS[m]) / durations[m]) for m in BEGINS)
    travel = stroke * (closed - opened) + 0.1 * rng.standard_normal(time.size)
    columns, look = np.column_stack([time / 1e3, travel]), {"fmt": ["%.5f", "%.2f"]}
    look |= {"delimiter": ",", "header": "time,travel", "comments": ""}
    np.savetxt(folder / "1.csv", columns, **look)
    rows = ["file,motion,operation", *(f"1.csv,{motion},1" for motion in BEGINS)]
    (folder / "operations.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    return folder


@pytest.fixture
def fit(tmp_path):
    """Fit breakers; the lines of configuration, and the configuration with them."""

    def fit(*folders):
        rest, file = tmp_path / "rest.yaml", tmp_path / "type.yaml"
        rest.write_text("endurance: {format: {zero: rest}}\n", encoding="utf-8")
        command = ["fit-prior", *map(str, folders), "--config", str(rest), "--output", str(file)]
        assert main(command) == 0
        return yaml.safe_load(file.read_text(encoding="utf-8")), load([file])

    return fit


@pytest.mark.parametrize(
    ("shape", "stroke", "closing"),
    [(smooth, 250.0, 60.0), (late, 200.0, 110.0)],
)
def test_the_sensor_has_a_grid_within_the_records(tmp_path, fit, shape, stroke, closing):
    folder = write(tmp_path / "Q", stroke, closing, shape)
    lines, config = fit(folder)
    sensor = config["sensor"]
    assert sensor["stop"] > closing
    grid = Grid(np.linspace(sensor["start"], sensor["stop"], sensor["samples"]))
    for motion in BEGINS:
        result = list_operations(folder, motion)
        curves = read_curves(result, config["endurance"]["format"], grid, motion)
        assert curves.accepted.all(), curves.reason.values
        assert curves.missing.max() == 0
    assert lines["endurance"] == {"format": {"zero": "rest"}}
    assert lines["family"] == {"name": "any"}
    assert max(config["prior"][name]["log_sd"] for name in NAMES) <= 1.0


def test_the_configuration_takes_the_lines(tmp_path, prior):
    rng = generator(5, "test written")
    true = type_of(prior, rng, off=0.3)
    drives = breakers_of(true, family_of(HELD_BACK), 3, rng)
    folder = write_breakers(tmp_path / "type", drives, 2, rng, SIZE)
    file, plot = tmp_path / "type.yaml", tmp_path / "type.png"
    assert main(["fit-prior", str(folder), "--output", str(file), "--plot", str(plot)]) == 0
    config = load([file])
    assert config["size"]["lengths"] == pytest.approx(SIZE.lengths, rel=0.3)
    medians = np.array([config["prior"][name]["median"] for name in NAMES])
    log_sds = np.array([config["prior"][name]["log_sd"] for name in NAMES])
    off = np.log(medians / (true.medians * SIZE.factors)) / log_sds
    assert np.abs(off).max() < 3.0
    noise = np.hypot(0.1 * SIZE.lengths, 0.02 * SIZE.lengths)
    assert config["sensor"]["noise_sd"] == pytest.approx(noise, rel=0.2)
    assert plot.read_bytes().startswith(b"\x89PNG")
