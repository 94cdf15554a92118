"""One record has the same numbers, whichever is asked: infer, report, compare or the fleet."""

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
NO_CONTACT = FORM | {"rate": 5.0, "contact_column": "Aux 1"}  # which never switches
TABLE = "file,motion,operation,breaker\none.csv,closing,1,Q1\none.csv,opening,1,Q1\n"
OF_STROKE = [f"{m}_speed_{zone}" for m in MOTIONS for zone in ("10_90", "10_50", "50_90")]


@pytest.fixture
def config(tmp_path, monkeypatch, defaults):
    """An export that states its rate, with a contact and a coil that nothing names; an earlier one;
    and the configuration of both.
    """
    monkeypatch.chdir(tmp_path)
    (tmp_path / "fleet").mkdir()
    for seed, name in enumerate(("before.csv", "one.csv", "fleet/one.csv")):
        write(name, rate=5.0, seed=min(seed, 1), channels=1, motions=MOTIONS)
    (tmp_path / "fleet/operations.csv").write_text(TABLE)
    return configured(defaults)


def configured(config, **more):
    """Write settings for the commands; the configuration with them."""
    Path("own.yaml").write_text(yaml.safe_dump(own := OWN | more), encoding="utf-8")
    return merge(config, own)


def values_of(records):
    """Medians of the records of a document by name and motion, and the family."""
    values = {}
    for entry in records:
        quantities = entry["parameters"] | entry["quantities"]
        values |= {(name, entry["motion"]): one["median"] for name, one in quantities.items()}
        values["family", entry["motion"]] = entry["fit"]["family"]
    return {about: value for about, value in values.items() if value is not None}


def document(capsys, *words):
    assert main([*words, "--json", "--config", "own.yaml"]) == 0
    return json.loads(capsys.readouterr().out)


def inferred(capsys):
    return values_of(document(capsys, "infer", "one.csv")["records"])


def reported(capsys, monkeypatch):
    caught, real = [], report.report_of
    monkeypatch.setattr(report, "report_of", lambda one: caught.append(one) or real(one))
    assert main(["report", "one.csv", "--output", "a.html", "--config", "own.yaml"]) == 0
    capsys.readouterr()
    (diagnosis,) = caught
    return values_of(json.loads(to_json(diagnosis.result))["records"])


def compared(capsys):
    rows = document(capsys, "compare", "before.csv", "--today", "one.csv")["measured"]
    return {(row["name"], row["motion"]): row["today"] for row in rows}


def of_fleet(config):
    (drive,) = drives_of(list_fleet("fleet"), MOTIONS, config["endurance"]["format"])
    measured = examine(drive, config, {}).measured
    return {
        (one.quantity.rpartition(" ")[2], motion): one.value
        for one in measured
        for motion in MOTIONS
        if motion in one.quantity
    }


def followed(config):
    """What the workflow reads of a record for a life."""
    form, operations = config["endurance"]["format"], dict(list_fleet("fleet")["Q1"])
    records = read_operations({m: [one] for m, one in operations.items()}, form)
    about = {"speeds": Diagnosis(config).speeds_of(records)}
    values = {}
    for motion, one in operations.items():
        curves = read_curves([one], form, Grid(np.arange(-2.0, 40.0, 0.5)), motion, **about)
        measured = curves.measured.isel(operation=0).to_series().dropna()
        values |= {(name, motion): value for name, value in measured.items()}
    return values


def different(one, other):
    """Names and motions of the values that two have in common, and that differ."""
    common = one.keys() & other.keys()
    assert {("touch_time", "closing"), ("closing_speed", "closing")} <= common
    return [about for about in sorted(common) if not same(one[about], other[about])]


def same(one, other):
    return one == other or (type(one) is float and math.isclose(one, other, rel_tol=1e-5))


def test_a_record_has_the_same_numbers_through_every_command(config, capsys, monkeypatch):
    """Planted fault: a report that takes another ratio."""
    alone = inferred(capsys)
    assert alone["closing_time", "closing"] > 0.0  # from the coil to the contact
    reports = reported(capsys, monkeypatch)
    assert len(reports) >= len(alone)
    for other in (reports, compared(capsys), of_fleet(config), followed(config)):
        assert different(alone, other) == []
    real = Reader.with_stated

    def with_ratio(self, *about):
        one = real(self, *about)
        return replace(one, settings=one.settings | {"ratio": 1.01})

    monkeypatch.setattr(Reader, "with_stated", with_ratio)
    assert ("closing_speed", "closing") in different(alone, reported(capsys, monkeypatch))


def test_a_drive_without_a_contact_has_speeds_of_its_stroke_everywhere(config, capsys, monkeypatch):
    own = configured(config, endurance=OWN["endurance"] | {"format": NO_CONTACT})
    results = [inferred(capsys), reported(capsys, monkeypatch), compared(capsys), of_fleet(own)]
    for values in results:
        speeds = {about: value for about, value in values.items() if about[0] in OF_STROKE}
        assert {name for name, _ in speeds} == {*OF_STROKE}
        assert min(speeds.values()) > 0.0


def test_a_speed_that_is_shown_may_have_a_limit(config, capsys):
    """Planted fault: speeds of the stroke were shown everywhere, and no limit could name them."""
    limit = {"quantity": "closing_speed_10_90", "reference": 3.0, "tolerance": "80 %"}
    configured(config, limits=[limit | {"motion": "closing", "of": "record"}])
    (first, _) = document(capsys, "infer", "one.csv")["records"]
    change = document(capsys, "compare", "before.csv", "--today", "one.csv")
    for limits in (first["limits"], change["limits"]):
        verdicts = [(one["name"], one["verdict"]) for one in limits]
        assert verdicts == [("closing_speed_10_90", "pass")]
