"""An export as analysers of high-voltage breakers write it, from inspection to accepted records."""

import numpy as np
import pytest
import yaml

from breaker.cli import main
from breaker.common.randomness import generator
from breaker.configuration.definitions import family_of, simulated_test
from breaker.configuration.loading import defaults, load
from breaker.family.drive_family import Family
from breaker.family.endurance_rig import Rig
from breaker.family.rack_exports import CHANNELS, HIGH_VOLTAGE, write_exports
from breaker.family.visit_exports import write_visits
from breaker.model.parameters import Size
from breaker.records.curves import read_curves
from breaker.records.grid import Grid
from breaker.records.operations import Operation
from breaker.records.proposal import inspect_file, overlay_of
from breaker.shipped import HELD_BACK

OPERATIONS = 3
LENGTHS, TIMES = HIGH_VOLTAGE.lengths, HIGH_VOLTAGE.times


@pytest.fixture(scope="module")
def exports(tmp_path_factory, defaults):
    """Folder of the files, and the true first motions."""
    folder = tmp_path_factory.mktemp("rack")
    return folder, write_exports(
        Rig.from_settings(simulated_test(defaults), 1).new, 1, folder, range(1, OPERATIONS + 1)
    )


@pytest.fixture(scope="module")
def overlay(exports, defaults, tmp_path_factory):
    """What is proposed for the first file."""
    text = overlay_of(inspect_file(exports[0] / "rack_0001.txt", defaults["sensor"]))
    file = tmp_path_factory.mktemp("config") / "rack.yaml"
    file.write_text(text, encoding="utf-8")
    return file


def test_the_drive_is_the_default_one_on_another_scale(defaults):
    drive = Rig.from_settings(simulated_test(defaults), 1).new
    times = np.linspace(0.0, 60.0, 200)
    for motion in ("closing", "opening"):
        small = drive.travel(motion, times)
        large = drive.scaled(Size(LENGTHS, TIMES)).travel(motion, TIMES * times)
        np.testing.assert_allclose(large, LENGTHS * small, atol=1e-9)
    speed = np.abs(np.diff(large) / np.diff(TIMES * times)).max()
    assert large[0] == pytest.approx(150.0, abs=1.0)
    assert speed == pytest.approx(3.5, abs=0.3)


def test_inspection_leads_to_accepted_records_of_all_phases(exports, overlay, defaults):
    """Ten lines; first motions within 0.3 ms of the default drive's times, which are 4.46 longer.

    They are 0.5 to 0.7 ms late in closing, as the closing force builds up, and in opening.
    """
    folder, truth = exports
    assert len(overlay.read_text(encoding="utf-8").splitlines()) <= 10
    config = load([overlay])
    sensor = config["sensor"]
    times = np.linspace(sensor["start"], sensor["stop"], sensor["samples"])
    errors = []
    for motion in ("closing", "opening"):
        for channel in CHANNELS:
            files = [folder / f"rack_{n:04d}.txt" for n in range(1, OPERATIONS + 1)]
            operations = [Operation(n, f, channel=channel) for n, f in enumerate(files, start=1)]
            curves = read_curves(
                operations,
                config["endurance"]["format"],
                Grid(times, sensor["noise_sd"]),
                motion,
            )
            assert curves.accepted.all(), curves.reason.values
            assert (curves.remarks == "").all(), curves.remarks.values
            assert not np.isnan(curves.travel).any()
            wanted = [truth[channel, motion, n] for n in range(1, OPERATIONS + 1)]
            errors.append(curves.first_motion.values - wanted)
    assert np.abs(errors).max() < 0.3 * TIMES


def test_the_files_are_of_the_layout(exports):
    folder, _ = exports
    heads = []
    for file in sorted(folder.glob("rack_*.txt")):
        lines = file.read_text(encoding="utf-8").splitlines()
        names = next(i for i, line in enumerate(lines) if line.startswith("I1;"))
        heads.append(names)
        assert lines[names].split(";")[:13] == [*(f"I{i}" for i in range(1, 7)), *CHANNELS, ""]
        assert len(lines) - names - 1 == 6000
        assert lines[-1].split(";")[11:] == ["", "", ""]
    assert len(set(heads)) > 1
    assert all(4 <= head <= 45 for head in heads)


@pytest.mark.parametrize("rig", [2, 4, 6, 8])
def test_drives_that_are_fastest_early_or_creep_to_rest_are_seen_to_move(
    rig, tmp_path, defaults, prior
):
    """Of 30 drives of the family, these and eight more were once taken for currents."""
    drive = Family(prior, family_of(HELD_BACK)).new(generator(1, "other drives", rig))
    write_exports(drive, rig, tmp_path, [1], force_sd=0.0, apart=800.0)
    found = inspect_file(tmp_path / "rack_0001.txt", defaults["sensor"])
    assert {each.column for each in found.motions} == set(CHANNELS)
    assert all(each.record for each in found.motions)


def test_the_example_folder_is_always_the_same(exports, tmp_path, capsys):
    folder, _ = exports
    assert main(["example", str(tmp_path / "rack"), "--operations", "1"]) == 0
    assert "1 files written" in capsys.readouterr().out
    (file,) = (tmp_path / "rack").iterdir()
    assert file.read_bytes() == (folder / file.name).read_bytes()


def test_worn_operations_are_the_last_of_the_life_and_slower(tmp_path, capsys):
    assert main(["example", str(tmp_path / "later"), "--worn", "--operations", "2"]) == 0
    assert [f.name for f in sorted((tmp_path / "later").iterdir())] == [
        "rack_1999.txt",
        "rack_2000.txt",
    ]


@pytest.mark.parametrize("there", ["a file", "a full folder"])
def test_nothing_is_replaced(tmp_path, capsys, there):
    target = tmp_path / "rack"
    if there == "a full folder":
        target.mkdir()
        (target / "notes.txt").write_text("mine")
    else:
        target.write_text("mine")
    assert main(["example", str(target)]) == 1
    assert "is there, and is not replaced" in capsys.readouterr().err
    assert main(["example", str(tmp_path / "many"), "--operations", "1000"]) == 1
    assert not (tmp_path / "many").exists()


def test_the_overlay_is_yaml_of_the_keys_of_the_configuration(overlay):
    content = yaml.safe_load(overlay.read_text(encoding="utf-8"))
    assert content["endurance"]["format"]["travel_column"] == CHANNELS[0]
    assert content["endurance"]["format"]["rate"] == 10.0
    assert content.keys() == {"endurance"}  # what else its size needs, fit-prior proposes


def test_the_example_of_the_page_is_written_by_the_command(tmp_path, capsys):
    assert main(["example", str(tmp_path / "visits"), "--visits"]) == 0
    assert "3 files written" in capsys.readouterr().out
    write_visits(defaults(), tmp_path)
    for file in (tmp_path / "visits").iterdir():
        assert file.read_bytes() == (tmp_path / file.name).read_bytes()
    old, new = (tmp_path / f"visit_{date}.csv" for date in ("2014-05-12", "2026-03-02"))
    assert old.read_text().splitlines()[-100] != new.read_text().splitlines()[-100]  # it has worn
    assert main(["example", str(tmp_path / "other"), "--visits", "--worn"]) == 1
    assert "leave --operations and --worn out" in capsys.readouterr().err
    assert not (tmp_path / "other").exists()
