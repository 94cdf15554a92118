"""Poles of a breaker in files of their own, side by side in a report."""

import re
from pathlib import Path

import pytest
import yaml

from breaker.cli import main
from breaker.diagnosis.limits import simultaneity_of
from tests.exports import pole

FORM = {"time_column": None, "rate": 5.0, "travel_column": "Travel 1"}
CONTACT, TRIGGER = {"contact_column": "Contact 1"}, {"trigger_column": "Coil 1 (A)"}


def page(*files, form=FORM, more=(), report=None):
    settings = {"endurance": {"draws": 50, "format": form}} | ({"report": report} if report else {})
    Path("my.yaml").write_text(yaml.safe_dump(settings))
    assert main(["report", *files, *more, "--config", "my.yaml", "--output", "a.html"]) == 0
    return Path("a.html").read_text(encoding="utf-8")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_poles_in_files_of_their_own_stand_side_by_side():
    for k, phase in enumerate(("R", "Y", "B")):
        pole(f"{k}.csv", phase, k, clock=f"10:42:1{k}", trip=30.0 + 4 * k)
    found = page("0.csv", "1.csv", "2.csv", form=FORM | CONTACT | TRIGGER)
    assert found.count("<th>± 95 %</th>") == 1
    assert "<th>R</th><th>Y</th><th>B</th>" in found
    assert "0.csv and 2 more" in found
    # Each file has the coil later by 4 ms: that is no difference of poles.
    said = re.search(r"simultaneity of the touch: ([\d.]+) ± [\d.]+ ms, \w first", found)
    assert float(said[1]) < 0.5
    assert "each from the trigger of its file" in found
    assert "2021-03-14 10:42:10, 2021-03-14 10:42:11" in found


@pytest.mark.parametrize(
    ("apart", "verdict"),
    [(4.6, "pass"), (4.9, "inconclusive"), (5.1, "inconclusive"), (5.4, "fail")],
)
def test_simultaneity_is_judged_where_its_interval_is_on_one_side_of_the_limit(apart, verdict):
    """Two contacts, known to 0.1 ms each: 95 % of 0.28 ms."""

    def of(phase, touch):
        fit = {"contact_time": touch, "contact_sd": 0.1, "first_motion": 0.0}
        return {"motion": "closing", "operation": 1, "phase": phase, "file": "1", "fit": fit}

    poles = [of("R", 3.0), of("Y", 3.0 + apart), of("B", 3.1)]
    found = simultaneity_of(poles, {"closing": 5.0, "opening": 3.3})
    assert found["verdict"] == verdict
    assert (found["first"], found["last"], found["value"]) == ("R", "Y", pytest.approx(apart))
    assert "verdict" not in simultaneity_of(poles, {"closing": None})


def test_simultaneity_counts_in_the_verdict_of_the_sheet():
    """A limit below what contacts are known to is not shown; one that poles keep is passed."""
    for k, phase in enumerate(("R", "Y", "B")):
        pole(f"{k}.csv", phase, k, clock=f"10:42:1{k}", trip=30.0 + 4 * k)
    for most, said in (
        (0.01, "inconclusive: simultaneity closing"),
        (5.0, "pass: simultaneity closing"),
    ):
        report = {"simultaneity": {"closing": most}}
        found = page("0.csv", "1.csv", "2.csv", form=FORM | CONTACT | TRIGGER, report=report)
        assert said in found
