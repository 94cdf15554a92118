"""Exports drawn at random: the truth is that of the samples, and faults are found."""

import copy
import io
import json

import numpy as np
import pandas as pd
import pytest

from studies.exports.layouts import write_export
from studies.exports.scores import bare, score, true_values


def write(folder, *seed):
    """Return truth and samples of each file of a sheet."""
    files = []
    for truth in write_export(folder, np.random.default_rng(seed)):
        lines = (folder / truth["file"]).read_bytes().decode(truth["encoding"]).splitlines()
        names = truth["separator"].join(truth["columns"])
        start = next(i for i, line in enumerate(lines) if line.startswith(names))
        text = io.StringIO("\n".join(lines[start:]))
        samples = pd.read_csv(text, sep=truth["separator"], decimal=truth["decimal"])
        files.append((truth, samples))
    return files


def times(truth, samples):
    """Return the times of samples, ms of the file."""
    first = truth["columns"][0]
    if "ms" in first or "[s]" in first or "(s)" in first:
        return samples.iloc[:, 0].to_numpy() * (1 if "ms" in first else 1000)
    return np.arange(len(samples)) / truth["rate"]


def document_of(truth):
    """Return what a product says that reads all of a file rightly."""
    document = {"records": [], "refused": [], "columns": [], "moves": []}
    for column, channel in truth["channels"].items():
        for move in channel["motions"]:
            values = true_values(move, channel["kind"], {})
            quantities = {
                name: {"median": true[0], "interval_95": [true[0] - 0.1, true[0] + 0.1]}
                for name, (true, _) in values.items()
                if true[0] is not None
            }
            record = {"channel": column, "motion": move["motion"], "accepted": True}
            record |= {"fit": {"first_motion": move["first"]}, "quantities": quantities}
            document["records"].append(record)
            contact = next(iter(move["columns"]), None)
            document["columns"].append([column, move["motion"], contact, move["coil"]])
            document["moves"].append([bare(column), move["motion"]])
    return document


@pytest.fixture(scope="module")
def truth(tmp_path_factory):
    """The truth of the first file all of whose motions have contact and coil, and no slack."""
    for number in range(60):
        for truth, _ in write(tmp_path_factory.mktemp("sheet"), 5, number):
            moves = [m for c in truth["channels"].values() for m in c["motions"]]
            known = [None not in (m["contact"], m["energised"]) and not m["slack"] for m in moves]
            if len(moves) > 1 and all(known):
                return truth


@pytest.mark.parametrize("number", range(4))
def test_truth_is_that_of_the_samples(tmp_path, number):
    for truth, samples in write(tmp_path, 3, number):
        time = times(truth, samples)
        for column, channel in truth["channels"].items():
            x = samples[column].to_numpy()
            for i, move in enumerate(channel["motions"]):
                later = [m["first"] for m in channel["motions"][i + 1 :]]
                end = min([*later, time[-1] + 1])
                before = (time < move["first"]) & (time > move["first"] - 8)
                after = (time < end) & (time > end - 8)
                way = abs(np.median(x[after]) - np.median(x[before]))
                assert way == pytest.approx(move["stroke"], abs=0.02 * move["stroke"])
                if move["coil"]:
                    current, on = samples[move["coil"]].to_numpy(), move["energised"]
                    assert np.all(np.abs(current[(time < on) & (time > on - 30)]) < 0.1)
                    assert current[(time > on + 1) & (time < on + 10)].max() > 0.15


def test_same_seed_same_file(tmp_path):
    (one, a), *_ = write(tmp_path / "a", 4)
    (two, b), *_ = write(tmp_path / "b", 4)
    assert json.dumps(one) == json.dumps(two)
    pd.testing.assert_frame_equal(a, b)


def test_what_is_right_is_right_and_nothing_said_is_missing_or_withheld(truth):
    verdicts = {(r.kind, r.name): r.verdict for r in score(truth, document_of(truth))}
    assert set(verdicts.values()) == {"right"}
    assert {"stroke", "reaction_time", "travel_time"} <= {name for _, name in verdicts}
    nothing = {"records": [], "refused": [], "columns": [], "moves": []}
    assert {r.verdict for r in score(truth, nothing)} == {"missing"}
    nothing["refused"] = [[c, m] for c in truth["channels"] for m in ("closing", "opening")]
    assert {r.verdict for r in score(truth, nothing) if r.kind == "value"} == {"withheld"}


def shifted(quantity, by):
    """Return a fault: a quantity off by more than its interval."""

    def change(document):
        item = document["records"][0]["quantities"][quantity]
        item["median"] += by
        item["interval_95"] = [end + by for end in item["interval_95"]]

    return change


def other_motion(document):
    record = document["records"][0]
    record["motion"] = {"closing": "opening", "opening": "closing"}[record["motion"]]


@pytest.mark.parametrize(
    ("change", "names"),
    [
        (shifted("stroke", 9.0), {"stroke"}),
        (shifted("reaction_time", 6.0), {"reaction_time"}),
        (lambda e: e["columns"][0].__setitem__(3, "Test Current CH1 (A)"), {"coil column"}),
        (lambda e: e["columns"][0].__setitem__(2, "Coil Current C6 (A)"), {"contact column"}),
        (other_motion, {"no such motion"}),
    ],
)
def test_planted_faults_are_false(truth, change, names):
    document = copy.deepcopy(document_of(truth))
    change(document)
    assert {r.name for r in score(truth, document) if r.verdict == "false"} >= names
