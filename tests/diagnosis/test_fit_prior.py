"""`breaker fit-prior`: its lines of configuration, for records of high-voltage breakers."""

import numpy as np
import pytest

from breaker.cli import main
from breaker.common.randomness import generator
from breaker.configuration.definitions import family_of
from breaker.configuration.loading import load
from breaker.model.parameters import MOTIONS, NAMES, Size
from breaker.records.curves import Grid, read_curves
from breaker.records.folder import list_operations
from breaker.shipped import HELD_BACK
from tests.diagnosis.drives import breakers_of, type_of, write_breakers

SIZE = Size(10.0, 4.0)


def test_the_configuration_takes_the_lines(tmp_path, prior):
    """Prior and size are those of the drives, and the grid of the sensor is within the records."""
    rng = generator(5, "test written")
    true = type_of(prior, rng, off=0.3)
    drives = breakers_of(true, family_of(HELD_BACK), 3, rng)
    folder = write_breakers(tmp_path / "type", drives, 2, rng, SIZE)
    file, plot, rest = (tmp_path / name for name in ("type.yaml", "type.png", "rest.yaml"))
    rest.write_text("endurance: {format: {zero: rest}}\n", encoding="utf-8")
    command = ["fit-prior", str(folder), "--config", str(rest), "--output", str(file)]
    assert main([*command, "--plot", str(plot)]) == 0
    config = load([file])
    assert config["size"]["lengths"] == pytest.approx(SIZE.lengths, rel=0.3)
    medians = np.array([config["prior"][name]["median"] for name in NAMES])
    log_sds = np.array([config["prior"][name]["log_sd"] for name in NAMES])
    off = np.log(medians / (true.medians * SIZE.factors)) / log_sds
    assert np.abs(off).max() < 3.0
    sensor, form = config["sensor"], config["endurance"]["format"]
    noise = np.hypot(0.1 * SIZE.lengths, 0.02 * SIZE.lengths)
    assert sensor["noise_sd"] == pytest.approx(noise, rel=0.2)
    assert form["zero"] == "rest"
    grid = Grid(np.linspace(sensor["start"], sensor["stop"], sensor["samples"]))
    for motion in MOTIONS:
        operations = list_operations(folder, motion, breaker="Q0")
        curves = read_curves(operations, form, grid, motion)
        assert curves.accepted.all(), curves.reason.values
        assert curves.missing.max() == 0
    assert plot.read_bytes().startswith(b"\x89PNG")
