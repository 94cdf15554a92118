"""The tutorial's commands run in order, and print, draw and lead to what the text states."""

import importlib.util
import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image

from breaker.configuration.loading import load
from breaker.drive.simulation.endurance_rig import Rig
from breaker.drive.simulation.rack_exports import HIGH_VOLTAGE
from breaker.quantities.parameters import MOTIONS, NAMES
from breaker.shipped import DEFAULTS
from tests.bare import without_extras

FOLDER = Path(__file__).parents[2] / "docs" / "tutorial"
spec = importlib.util.spec_from_file_location("renew", FOLDER / "renew.py")
renew = importlib.util.module_from_spec(spec)
spec.loader.exec_module(renew)

TEXT = renew.PAGE.read_text(encoding="utf-8")
PICTURES = re.findall(r"!\[[^\]]*\]\(([\w.]+\.png)\)", TEXT)
WITHIN = 0.1  # of a shown number: posteriors are drawn, and other processors round otherwise
LEVELS = 5.0  # of 255, in the mean: a picture moved by three pixels has 10 and more
REMEDY = "mend the text, then run: python docs/tutorial/renew.py"


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """The folder of the commands, which ran without extras; their steps with what they printed."""
    folder = tmp_path_factory.mktemp("tutorial")
    bare = without_extras(tmp_path_factory.mktemp("bare") / "path")
    return folder, list(renew.run(TEXT, folder, environment=bare))


def test_commands_print_what_stands_there(done):
    for step, output in done[1]:
        for shown, printed in renew.as_printed(step.shown, output):
            assert renew.close(shown, printed, WITHIN), f"{shown}\n{printed}\n{REMEDY}"


def apart(*pictures):
    """Mean difference of two pictures, levels of 255; inf where they differ in size."""
    first, second = (np.asarray(Image.open(each).convert("RGB"), float) for each in pictures)
    return abs(first - second).mean() if first.shape == second.shape else np.inf


@pytest.mark.parametrize("picture", PICTURES)
def test_pictures_are_what_is_drawn_and_small(done, picture, tmp_path):
    assert (done[0] / picture).stat().st_size > 10_000
    assert (FOLDER / picture).stat().st_size <= 60_000
    renew.small(done[0] / picture, tmp_path / picture)
    assert apart(tmp_path / picture, FOLDER / picture) < LEVELS, REMEDY


def test_true_values_and_how_many_intervals_hold_them_are_stated(done, defaults):
    drive = Rig.from_settings(defaults["rig"], 1).new.scaled(HIGH_VOLTAGE)
    truth = dict(zip(NAMES, drive.theta, strict=True))
    records = json.loads((done[0] / "answer.json").read_text(encoding="utf-8"))["records"]
    assert [each["motion"] for each in records] == list(MOTIONS)
    assert all(each["fit"]["resolved"] for each in records)
    told = {name: each for name, each in records[0]["parameters"].items() if each["median"]}
    assert set(NAMES) - set(told) == {"L"}  # where the contact touches, as the touch itself
    intervals = {name: each["interval_95"] for name, each in told.items()}
    assert all(records[1]["parameters"][name]["interval_95"] == intervals[name] for name in told)
    held = sum(low <= truth[name] <= high for name, (low, high) in intervals.items())
    assert f"{held} of the {len(told)} intervals" in TEXT
    for name in NAMES:
        assert f"{truth[name]:.3g}" in TEXT
    for each, quantity in zip(records, ("touch_time", "part_time"), strict=True):
        assert each["quantities"][quantity]["median"] is None


def test_the_last_settings_are_those_of_a_workflow(done, tmp_path):
    """The fitted prior and the limits, over the defaults, with the example's folder."""
    folder, _ = done
    own = {"endurance": {"curves": str(folder / "rack"), "phase": "S 1"}}
    (tmp_path / "breaker.yaml").write_text(yaml.safe_dump(own), encoding="utf-8")
    overlays = [folder / "prior.yaml", folder / "limits.yaml", tmp_path / "breaker.yaml"]
    config = load([DEFAULTS, *overlays])
    assert config["size"]["lengths"] == pytest.approx(HIGH_VOLTAGE.lengths, rel=0.2)
    assert "snakemake -c2 all --configfile prior.yaml limits.yaml breaker.yaml" in TEXT


def test_a_line_that_is_not_printed_is_found(done):
    step, output = next(each for each in done[1] if each[0].shown)
    with pytest.raises(ValueError, match="not printed"):
        renew.as_printed(step.shown.replace("accepted", "rejected"), output)


def test_a_number_that_is_not_printed_is_found(done):
    step, output = next(each for each in done[1] if each[0].shown)
    changed = step.shown.replace("10 kHz", "12 kHz")
    assert changed != step.shown
    assert not all(renew.close(*pair, WITHIN) for pair in renew.as_printed(changed, output))


def test_a_command_that_fails_is_told(tmp_path):
    with pytest.raises(RuntimeError, match="fails with 1"):
        list(renew.run("```sh\nbreaker infer nothing.csv\n```\n", tmp_path))
