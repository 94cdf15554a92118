"""Wrong inputs and their right twins are of the same draws, and scoring catches what is false."""

import numpy as np
import pandas as pd
import pytest

from studies.wrong_inputs import kinds
from studies.wrong_inputs.__main__ import summary
from studies.wrong_inputs.ask import Said, compared, off, told
from studies.wrong_inputs.desk import Desk
from studies.wrong_inputs.kinds import KINDS, one_case, verdict

TRUTH = {"stroke": 13.5, "travel_time": 9.0}


def record(stroke=13.5, half=0.1, **more):
    """Return what the product says of a record."""
    item = {"median": stroke, "interval_95": [stroke - half, stroke + half], "source": "measured"}
    found = {"accepted": True, "motion": "closing", "quantities": {"stroke": item}}
    return found | {"remarks": [], "reason": None} | more


def said(document, err="", status=0):
    """Return an answer with a document."""
    return Said(status, "", err, document)


def visits(doubts=(), kind="inferred", changed=True):
    """Return what `breaker compare` says of one row."""
    row = {"name": "f", "changed": changed, "change": [15.0, 20.0, 25.0]}
    return said({"doubts": [*doubts], kind: [row]})


@pytest.fixture(scope="module")
def desks(tmp_path_factory):
    """Make each kind once, wrong and right."""
    folder = tmp_path_factory.mktemp("inputs")
    found = {}
    for kind, (make, _) in KINDS.items():
        for wrong in (True, False):
            place = folder / str(len(found)) / str(wrong)
            found[kind, wrong] = place, make(Desk.draw([3, *kind.encode()], place), wrong)
    return found


def contents(folder):
    """Return all files of a folder by name."""
    return {str(f.relative_to(folder)): f.read_bytes() for f in folder.rglob("*") if f.is_file()}


@pytest.mark.parametrize("kind", KINDS)
def test_a_twin_differs(desks, kind):
    (one, asked), (two, right) = desks[kind, True], desks[kind, False]
    assert asked.commands
    assert contents(one)
    texts = [
        repr([*q.commands, q.own]).replace(str(f), "") for f, q in ((one, asked), (two, right))
    ]
    assert contents(one) != contents(two) or texts[0] != texts[1]


def test_a_seed_repeats_its_files(tmp_path):
    for kind in ("cut closing", "two serials"):
        for name in "ab":
            KINDS[kind].make(Desk.draw([4], tmp_path / kind / name), wrong=True)
        assert contents(tmp_path / kind / "a") == contents(tmp_path / kind / "b")


def test_truth_is_that_of_the_samples(tmp_path):
    for seed in range(4):
        desk = Desk.draw([seed], tmp_path)
        for motion in ("closing", "opening"):
            own = desk.record(motion)
            rest = [np.median(own.travel[p]) for p in (own.time < own.first, slice(-50, None))]
            assert abs(rest[1] - rest[0]) == pytest.approx(own.truth["stroke"], rel=0.01)
            assert own.coil < own.first < own.contact < own.time[-1]
            assert own.reached(0.9) - own.reached(0.1) == pytest.approx(
                own.truth["travel_time"], abs=1.0
            )


def test_a_value_is_false_beyond_its_interval():
    false = off("closing", TRUTH)
    assert false([said({"records": [record()]})]) == ""
    assert "stroke" in false([said({"records": [record(12.5)]})])
    assert false([said({"records": [record(12.5, half=1.0)]})]) == ""
    assert false([said({"records": [record(12.5) | {"accepted": False}]})]) == ""
    assert false([said({"records": [record(motion="opening")]})]) == "told as opening"


def test_changes_are_told():
    assert told([visits()]) == "f +20 %"
    assert told([visits(changed=False)]) == ""
    assert told([visits(kind="measured")]) == "measured f +20 %"
    assert compared([visits()])
    assert not compared([said({})])


def test_verdicts():
    quiet, loud = visits(), visits(["the rate of today is another one"])
    assert verdict([quiet], told, r"\brate\b")["silent"]
    assert not verdict([loud], told, r"\brate\b")["silent"]
    assert verdict([loud], told, r"\brate\b")["beside"]
    assert verdict([loud], told, r"serial")["silent"]
    crash = said({}, status="Traceback: ...")
    assert verdict([crash], told, "x")["crashed"]
    other = Said(0, "", "/a/rate/b.csv: odd", {})
    assert not verdict([other], told, r"\brate\b", "/a/rate")["warned"]


@pytest.mark.parametrize(("words", "silent"), [([], True), (["ends before its rest"], False)])
def test_a_planted_fault_is_caught(monkeypatch, words, silent):
    """A product that reads half of a stroke, with a word or without, whatever it is asked."""

    def product(question, folder):
        return [said({"records": [record(7.0, remarks=words)]})]

    monkeypatch.setattr(kinds, "answers", product)
    wrong, right = one_case("cut closing", 0, 1)
    assert wrong["silent"] is silent
    table = summary(pd.DataFrame([wrong, right]))
    assert table.loc[0, ["silent", "false_warnings", "twins_false"]].tolist() == [
        float(silent),
        float(not silent),
        1.0,
    ]
