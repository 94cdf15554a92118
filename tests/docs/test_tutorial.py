"""The tutorial's commands run in order, and lead to what the text states."""

import json
import re

import pytest
import yaml

from breaker.configuration.definitions import simulated_test
from breaker.configuration.loading import load
from breaker.family.endurance import EnduranceTest
from breaker.family.exports import HIGH_VOLTAGE
from breaker.model.parameters import MOTIONS, NAMES
from tests.bare import without_extras
from tests.scripts import ROOT, script

FOLDER = ROOT / "docs" / "tutorial"
renew = script("docs/tutorial/renew.py")
TEXT = renew.PAGE.read_text(encoding="utf-8")
PICTURES = re.findall(r"!\[[^\]]*\]\(([\w.]+\.png)\)", TEXT)


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """The folder in which the commands ran, in an environment without extras."""
    folder = tmp_path_factory.mktemp("tutorial")
    bare = without_extras(tmp_path_factory.mktemp("bare") / "path")
    list(renew.run(TEXT, folder, environment=bare))
    return folder


@pytest.mark.parametrize("picture", PICTURES)
def test_pictures_are_drawn_and_small(done, picture):
    assert (done / picture).stat().st_size > 10_000
    assert (FOLDER / picture).stat().st_size <= 60_000


def test_true_values_are_stated_and_intervals_contain_them(done, defaults):
    drive = EnduranceTest.from_settings(simulated_test(defaults), 1).new.scaled(HIGH_VOLTAGE)
    truth = dict(zip(NAMES, drive.theta, strict=True))
    records = json.loads((done / "answer.json").read_text(encoding="utf-8"))["records"]
    assert [each["motion"] for each in records] == list(MOTIONS)
    assert all(each["fit"]["resolved"] for each in records)
    told = {name: each for name, each in records[0]["parameters"].items() if each["median"]}
    assert set(NAMES) - set(told) == {"L"}  # where the contact touches, as the touch itself
    intervals = {name: each["interval_95"] for name, each in told.items()}
    assert all(records[1]["parameters"][name]["interval_95"] == intervals[name] for name in told)
    held = sum(low <= truth[name] <= high for name, (low, high) in intervals.items())
    assert held >= len(told) - 1  # of 95 %
    for name in NAMES:
        assert f"{truth[name]:.3g}" in TEXT
    for each, quantity in zip(records, ("touch_time", "separation_time"), strict=True):
        assert each["quantities"][quantity]["median"] is None


def test_the_last_settings_are_those_of_a_workflow(done, tmp_path):
    """The fitted prior and the limits, over the defaults, with the example's folder."""
    own = {"endurance": {"curves": str(done / "rack"), "phase": "S 1"}}
    (tmp_path / "breaker.yaml").write_text(yaml.safe_dump(own), encoding="utf-8")
    overlays = [done / "prior.yaml", done / "limits.yaml", tmp_path / "breaker.yaml"]
    config = load([*overlays])
    assert config["size"]["lengths"] == pytest.approx(HIGH_VOLTAGE.lengths, rel=0.2)
    assert "snakemake -c2 all --configfile prior.yaml limits.yaml breaker.yaml" in TEXT


def test_a_line_that_is_not_printed_is_found():
    assert renew.as_printed("a 1 b\n...\n", "x\na  2 b\n") == [("a 1 b", "a  2 b"), ("...", "...")]
    with pytest.raises(ValueError, match="not printed"):
        renew.as_printed("a 1 c\n", "a 1 b\n")


def test_a_command_that_fails_is_told(tmp_path):
    with pytest.raises(RuntimeError, match="fails with 1"):
        list(renew.run("```sh\nbreaker infer nothing.csv\n```\n", tmp_path))
