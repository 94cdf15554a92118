"""The exports of the examples: files of analysers, from inspection to accepted records."""

import numpy as np
import pytest

from breaker.cli import main
from breaker.configuration.data_files import simulated_test
from breaker.configuration.loading import defaults
from breaker.family.endurance import EnduranceTest
from breaker.family.exports import (
    CHANNELS,
    HIGH_VOLTAGE,
    write_close_opens,
    write_inspections,
)
from breaker.model.parameters import MOTIONS
from breaker.records.curves import Grid, read_curves
from breaker.records.operations import Operation
from breaker.records.proposal import inspect_file

OPERATIONS = range(1, 4)


@pytest.fixture(scope="module")
def drive():
    return EnduranceTest.from_settings(simulated_test(defaults()), 1).new


@pytest.fixture(scope="module")
def exports(tmp_path_factory, drive):
    """Folder of the files, and the true starts of motion."""
    folder = tmp_path_factory.mktemp("rack")
    return folder, write_close_opens(drive, 1, folder, OPERATIONS)


def test_inspection_leads_to_accepted_records_of_all_channels(exports):
    """First motions are 0.5 to 0.7 ms late at size 1 in closing, as the closing force builds up."""
    (folder, starts), sensor = exports, defaults()["sensor"]
    settings = inspect_file(folder / "rack_0001.txt", sensor).settings
    grid = Grid(np.linspace(sensor["start"], sensor["stop"], sensor["samples"]), sensor["noise_sd"])
    for motion in MOTIONS:
        for i, channel in enumerate(CHANNELS):
            files = {n: folder / f"rack_{n:04d}.txt" for n in OPERATIONS}
            operations = [Operation(n, file, channel=channel) for n, file in files.items()]
            curves = read_curves(operations, settings, grid, motion)
            assert curves.accepted.all(), curves.reason.values
            assert (curves.remarks == "").all(), curves.remarks.values
            assert not np.isnan(curves.travel).any()
            true = [starts[n][i, MOTIONS.index(motion)] for n in OPERATIONS]
            assert np.abs(curves.first_motion.values - true).max() < 0.3 * HIGH_VOLTAGE.times


def test_the_example_folders_are_always_the_same(exports, tmp_path):
    assert main(["example", str(tmp_path / "rack")]) == 0
    first = tmp_path / "rack" / "rack_0001.txt"
    assert first.read_bytes() == (exports[0] / first.name).read_bytes()
    assert main(["example", str(tmp_path / "inspections"), "--inspections"]) == 0
    write_inspections(defaults(), tmp_path)
    for file in (tmp_path / "inspections").iterdir():
        assert file.read_bytes() == (tmp_path / file.name).read_bytes()
