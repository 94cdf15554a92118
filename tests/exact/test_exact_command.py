"""`breaker infer --exact`: what it answers, prints and writes, and what stays as it was.

With constants that make answers rough: what they promise of posteriors, other files test.
"""

import json
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
import pytest
import tqdm

from breaker.cli import main
from breaker.drive.exact import exact_posterior
from breaker.drive.family import network_files
from breaker.quantities.parameters import NAMES

pytestmark = pytest.mark.usefixtures("small")


@pytest.fixture(autouse=True)
def in_folder(folder, monkeypatch):
    """In the folder, and as where nobody waits at a terminal."""
    monkeypatch.chdir(folder)
    monkeypatch.setattr(tqdm, "tqdm", partial(tqdm.tqdm, disable=True))


def call(*arguments):
    return main(["infer", *arguments, "--config", "few.yaml"])


def answered(capsys, *arguments):
    """The document of a call, and what it says beside it."""
    assert call(*arguments, "--json") == 0
    out, err = capsys.readouterr()
    return json.loads(out), err


def test_both_motions_have_one_exact_answer_in_all_outputs(folder, capsys):
    import xarray as xr

    outputs = ["--output", "t.csv", "--draws", "d.zarr", "--plot", "p.png"]
    found, err = answered(capsys, "both.csv", "--exact", *outputs)
    closing, opening = found["records"]
    assert closing["parameters"] == opening["parameters"]
    exact = closing["fit"]["exact"]
    assert exact["family"] == "medium_voltage"
    assert exact["effective_size"] == closing["fit"]["effective_size"] >= 1.0
    assert closing["fit"]["resolved"]
    assert exact["drives"] > 1500 + 5 * 80
    assert sum(exact["contacts"].values()) == pytest.approx(1.0)
    assert {"elastic", "held", "drag", "build_up"} < exact["evidence"].keys()
    assert "sliding_contact" not in exact["evidence"]  # the family has none
    assert exact["gap"] > 0.0
    assert 0.0 < exact["residual"] < 0.6 > exact["noise"] > 0.2
    apart = {"p_value", "residual", "noise"}
    assert {k for k in exact if exact[k] != opening["fit"]["exact"][k]} <= apart
    assert {line.split()[0] for line in err.splitlines()} <= {"written", "draws", "drawn"}
    draws = xr.open_datatree("d.zarr", engine="zarr")
    mu = next(each["mu"] for each in draws.subtree if "mu" in each)
    assert np.median(mu) == pytest.approx(closing["parameters"]["mu"]["median"], rel=1e-4)
    assert (folder / "p.png").stat().st_size > 10_000
    table = pd.read_csv(folder / "t.csv")
    told = table[table.motion == "opening"].iloc[0]
    numbers = {name: opening["fit"]["exact"][name] for name in ("gap", "drives", "p_value")}
    numbers["evidence_drag"] = exact["evidence"]["drag"]
    numbers["contacts_held"] = exact["contacts"]["held"]
    assert {name: told[f"exact_{name}"] for name in numbers} == numbers
    assert "exact" not in table  # but for a column of each number
    again, _ = answered(capsys, "both.csv", "--exact")
    assert json.dumps(again) == json.dumps(found)  # the same seed, the same bytes


def test_what_networks_do_not_answer_stays_as_it_is(capsys):
    """A file that is no record, and a drive out of the family, beside one that is inferred."""
    files = ["odd.csv", "a.csv", "bad.csv"]
    documents = (answered(capsys, *files, *more)[0]["records"] for more in ([], ["--exact"]))
    plain, found = ({each["file"]: each for each in records} for records in documents)
    assert {name: each["accepted"] for name, each in found.items()} == {
        **{"odd.csv": True, "a.csv": True, "bad.csv": False}
    }
    assert found["odd.csv"]["fit"]["misfit"]
    for name in ("odd.csv", "bad.csv"):
        assert found[name] == plain[name]
    before, after = plain["a.csv"], found["a.csv"]
    assert "exact" not in before["fit"]
    assert "exact" in after["fit"]
    assert before["parameters"] != after["parameters"]
    measured = [n for n, each in before["quantities"].items() if each["source"] == "measured"]
    assert "stroke" in measured
    for name in measured:
        assert after["quantities"][name] == before["quantities"][name]
    assert call("bad.csv", "--exact") == 1
    assert "nothing was inferred" in capsys.readouterr().err


def test_a_size_and_a_fact_count(capsys):
    given = ["--size", "1", "1", "--known", "mu=2.0:0.1"]
    found, _ = answered(capsys, "a.csv", "--exact", *given)
    (record,) = found["records"]
    mu, exact = record["parameters"]["mu"], record["fit"]["exact"]
    assert mu["median"] == pytest.approx(2.0, abs=0.2)
    assert np.ptp(mu["interval_95"]) < 0.6
    assert record["fit"]["effective_size"] < exact["effective_size"]


def test_words_tell_how_exact_it_is_and_what_is_shown_of_the_way(capsys, monkeypatch):
    """The way is shown on stderr alone, and only on a terminal."""
    monkeypatch.setattr(tqdm, "tqdm", partial(tqdm.tqdm, disable=False))
    monkeypatch.setattr(exact_posterior, "LEAST", 1e9)
    assert call("a.csv", "--exact") == 0
    out, err = capsys.readouterr()
    words = " ".join(out.split())
    assert "exact in the family medium_voltage: effective size" in words
    assert "evidence for each mechanism and contact, nats: contact_preload" in words
    assert "NOT resolved (effective size" in words
    assert "the walk found too few independent draws" in words
    assert "train a network" not in words
    assert "likelihood to the power" in err
    assert "effective size" in err
    assert "likelihood" not in out
    assert all(f"\n {name} " not in out for name in NAMES)


def test_a_fact_that_leaves_few_draws_is_named_as_the_reason(capsys):
    assert call("a.csv", "--exact", "--known", "mu=20:0.05") == 0
    words = " ".join(capsys.readouterr().out.split())
    assert "what is given beside the record weighs the draws of a walk" in words
    assert "the walk found too few" not in words


def test_where_it_is_not_reached_the_networks_answer_stands_with_a_remark(capsys, monkeypatch):
    assert call("a.csv", "--json") == 0
    plain = capsys.readouterr().out
    monkeypatch.setattr(exact_posterior, "_DRIVES", 1)
    assert call("a.csv", "--exact", "--json") == 0
    found = json.loads(capsys.readouterr().out)
    (said,) = [each for each in found["records"][0]["remarks"] if each.startswith("not exact")]
    assert "the networks' answer stands" in said
    found["records"][0]["remarks"].remove(said)
    assert found == json.loads(plain)


def test_a_family_of_another_simulator_is_refused(levels, capsys, monkeypatch):
    drives = levels.settings["drives"] | {"simulator": "own"}
    other = replace(levels, settings=levels.settings | {"drives": drives, "family": "my_type"})
    monkeypatch.setattr(network_files, "shipped_levels", lambda: [other])
    assert call("a.csv", "--exact") == 1
    out, err = capsys.readouterr()
    assert out == ""
    expected = "breaker: the family my_type is of another simulator, own, which tells no density"
    assert err.startswith(expected)
    assert "leave out --exact" in err
    assert err.count("\n") == 1
