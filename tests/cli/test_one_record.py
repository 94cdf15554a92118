"""One record has the same numbers, whichever is asked: infer, report, compare or the fleet."""

import csv
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from breaker.cli import main
from breaker.common.plain_values import to_json
from breaker.configuration.loading import merge
from breaker.diagnosis import report
from breaker.diagnosis.reading import read_operations
from breaker.diagnosis.session import Diagnosis
from breaker.model.parameters import MOTIONS
from breaker.prognosis.fleet import drives_of, examine
from breaker.records.curves import Grid, read_curves
from breaker.records.folder import list_fleet
from breaker.records.reader import Reader
from tests.exports import write

FORM = {"time_column": None, "travel_column": "Travel 1", "rate": None}
OWN = {"endurance": {"draws": 60, "format": FORM}}
TABLE = "file,motion,operation,breaker\none.csv,closing,1,Q1\none.csv,opening,1,Q1\n"


@pytest.fixture
def config(tmp_path, monkeypatch, defaults):
    """An export that states its rate and the points of its speeds, with a contact and a coil that
    nothing names; one of a visit before; and the configuration of both.
    """
    monkeypatch.chdir(tmp_path)
    (tmp_path / "fleet").mkdir()
    for seed, name in enumerate(("before.csv", "one.csv", "fleet/one.csv")):
        write(name, rate=5.0, seed=min(seed, 1), channels=1, motions=MOTIONS)
    (tmp_path / "fleet/operations.csv").write_text(TABLE)
    (tmp_path / "own.yaml").write_text(yaml.safe_dump(OWN))
    return merge(defaults, OWN)


def told(records):
    """What a document says of records, by name and motion."""
    found = {}
    for entry in records:
        values = entry["parameters"] | entry["quantities"]
        found |= {(name, entry["motion"]): each["median"] for name, each in values.items()}
        found["family", entry["motion"]] = entry["fit"]["family"]
    return {about: value for about, value in found.items() if value is not None}


def inferred(capsys):
    assert main(["infer", "one.csv", "--json", "--config", "own.yaml"]) == 0
    return told(json.loads(capsys.readouterr().out)["records"])


def reported(capsys, monkeypatch):
    caught, real = [], report.report_of
    monkeypatch.setattr(report, "report_of", lambda one: caught.append(one) or real(one))
    assert main(["report", "one.csv", "--output", "a.html", "--config", "own.yaml"]) == 0
    capsys.readouterr()
    (diagnosis,) = caught
    return told(json.loads(to_json(diagnosis.result))["records"])


def compared(capsys):
    call = ["compare", "before.csv", "--today", "one.csv", "--json", "--config", "own.yaml"]
    assert main(call) == 0
    rows = json.loads(capsys.readouterr().out)["measured"]
    return {(e["name"], e["motion"]): e["today"] for e in rows}


def of_fleet(config):
    (drive,) = drives_of(list_fleet("fleet"), MOTIONS, config["endurance"]["format"])
    values = {each.quantity: each.value for each in examine(drive, config, {}).measured}
    names = {label: label.rpartition(" ")[2] for label in values}
    return {(names[e], motion): v for e, v in values.items() for motion in MOTIONS if motion in e}


def followed(config):
    """What the workflow reads of a record for a life."""
    form, operations = config["endurance"]["format"], dict(list_fleet("fleet")["Q1"])
    records = read_operations({m: [each] for m, each in operations.items()}, form)
    about = {"speeds": Diagnosis(config).speeds_of(records)}
    found = {}
    for motion, each in operations.items():
        curves = read_curves([each], form, Grid(np.arange(-2.0, 40.0, 0.5)), motion, **about)
        values = curves.measured.isel(operation=0).to_series().dropna()
        found |= {(name, motion): value for name, value in values.items()}
    return found


def unlike(one, other):
    """Names and motions of what both tell, and tell differently."""
    both = one.keys() & other.keys()
    assert {("touch_time", "closing"), ("closing_speed", "closing")} <= both
    return [each for each in sorted(both) if not alike(one[each], other[each])]


def alike(one, other):
    return one == other or (type(one) is float and math.isclose(one, other, rel_tol=1e-5))


def test_a_record_has_the_same_numbers_through_every_command(config, capsys, monkeypatch):
    alone = inferred(capsys)
    assert alone["closing_time", "closing"] > 0.0  # from the coil to the contact
    report = reported(capsys, monkeypatch)
    assert len(report) >= len(alone)
    assert unlike(alone, report) == unlike(alone, compared(capsys)) == []
    assert unlike(alone, of_fleet(config)) == unlike(alone, followed(config)) == []


def test_a_command_that_prepares_a_record_in_another_way_is_noticed(config, capsys, monkeypatch):
    """Planted: a report that takes another ratio."""
    alone, real = inferred(capsys), Reader.with_stated

    def told(self, *about):
        found = real(self, *about)
        return replace(found, settings=found.settings | {"ratio": 1.01})

    monkeypatch.setattr(Reader, "with_stated", told)
    assert ("closing_speed", "closing") in unlike(alone, reported(capsys, monkeypatch))


OF_STROKE = [f"{m}_speed_{zone}" for m in MOTIONS for zone in ("10_90", "10_50", "50_90")]


def test_a_drive_without_a_contact_has_speeds_of_its_stroke_everywhere(config, capsys, monkeypatch):
    form = FORM | {"rate": 5.0, "contact_column": "Aux 1"}  # which never switches
    own = yaml.safe_dump({"endurance": OWN["endurance"] | {"format": form}})
    Path("own.yaml").write_text(own, encoding="utf-8")
    alone, report = inferred(capsys), reported(capsys, monkeypatch)
    fleet = of_fleet(merge(config, {"endurance": {"format": form}}))
    for found in (alone, report, compared(capsys), fleet):
        assert {name for name, _ in found} >= {*OF_STROKE}
        assert not {(n, m) for n, m in found if n in OF_STROKE and not found[n, m] > 0.0}


def test_a_limit_may_name_a_speed_that_is_shown(config, capsys):
    """Planted fault: speeds of the stroke were shown everywhere, and no limit could name them."""
    limit = {"quantity": "closing_speed_10_90", "reference": 3.0, "tolerance": "80 %"}
    own = OWN | {"limits": [limit | {"motion": "closing", "of": "record"}]}
    Path("own.yaml").write_text(yaml.safe_dump(own), encoding="utf-8")
    names = {}
    for call in (["infer", "one.csv"], ["compare", "before.csv", "--today", "one.csv"]):
        assert main([*call, "--json", "--config", "own.yaml"]) == 0
        found = json.loads(capsys.readouterr().out)
        limits = found["limits"] if "limits" in found else found["records"][0]["limits"]
        names[call[0]] = [(each["name"], each["verdict"]) for each in limits]
    assert names["infer"] == names["compare"] == [("closing_speed_10_90", "pass")]


def test_a_speed_has_its_zone_in_table_and_report(config, capsys):
    assert main(["infer", "one.csv", "--config", "own.yaml", "--output", "a.csv"]) == 0
    capsys.readouterr()
    rows = {
        (r["output"], r["motion"]): r
        for r in csv.DictReader(Path("a.csv").read_text(encoding="utf-8").splitlines())
    }
    own = rows["closing_speed", "closing"]
    assert (own["zone"], own["unit"]) == ("from 40 to 80 % of stroke", "m/s")  # as the file states
    assert rows["stroke", "closing"]["zone"] == ""
    assert main(["report", "one.csv", "--output", "a.html", "--config", "own.yaml"]) == 0
    assert "closing speed from 40 to 80 % of stroke" in Path("a.html").read_text(encoding="utf-8")
