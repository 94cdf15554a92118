"""What a run left, on the page: a life with its limits and plan, and a fleet in its ranks."""

import json
import shutil
from html import unescape

import numpy as np
import pandas as pd
import pytest

from breaker.app.run_results import read_fleet
from breaker.app.view_session import SHOWN
from breaker.common.zarr_store import open_store
from breaker.drive.fleet.fleet_page import fleet_document
from breaker.model.parameters import PARAMETERS
from tests.app.run_folders import write_fleet, write_life
from tests.lives import a_life


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A project with the results of a life and a fleet."""
    place = tmp_path_factory.mktemp("project")
    write_life(place / "results", a_life())
    write_fleet(place / "results", 250)
    return place / "results"


@pytest.mark.parametrize("named", ["", "results"])
def test_results_are_found_in_a_project_and_by_themselves(opened, results, tmp_path, named):
    page = opened(results.parent / named, tmp_path)
    listed = page.get("/").text
    assert 'href="/life"' in listed
    assert 'href="/fleet"' in listed
    assert "decisions.csv" not in listed  # a table of the run is no record
    assert ("no file of a record" in listed) == (not named)


def test_a_folder_of_records_has_no_life(page):
    assert 'href="/life"' not in page.get("/").text
    assert page.get("/life").status == page.get("/fleet").status == 404


def test_curves_of_a_life_are_the_numbers_of_the_run(opened, results, tmp_path):
    page = opened(results, tmp_path)
    life = open_store(results / "life.zarr").load()
    panels = json.loads(page.get("/life/curves?limit=stiff").text)["panels"]
    value, probability, left, cost, parameters = panels
    (line,) = value["lines"]
    stored = life.value.isel(part=1).values.T
    for name, each in zip(("low", "y", "high"), stored, strict=True):
        assert line[name] == pytest.approx(each.tolist(), abs=1e-6)
    assert line["x"] == life.asked.values.tolist()
    assert ["limit: above 1", 1.0] in value["levels"]
    assert value["places"][0] == ["change of gamma_a or f", 300.0]
    assert "stiff" in value["title"]
    assert [each["name"] for each in parameters["lines"]] == [e.word for e in PARAMETERS]
    assert len(probability["lines"][0]["x"]) <= 1000
    assert probability["lines"][0]["x"][-1] == 500
    assert cost["x"] != left["x"] == "operation"
    first = json.loads(page.get("/life/curves").text)["panels"][0]
    assert "slow" in first["title"]  # what is due
    assert page.get("/life/curves?limit=none").status == 404


def test_a_fleet_is_that_of_the_run_in_its_ranks_and_parts(opened, results, tmp_path):
    page = opened(results, tmp_path)
    text = page.get("/fleet").text
    assert text.count("Bay ") == SHOWN
    assert text.index("Bay 0 &lt;b&gt;&amp;") < text.index("Bay 1 &lt;b&gt;&amp;")
    assert "<b>" not in text
    assert "&#39;=1+1" not in text  # as it was before it was made harmless for spreadsheets
    assert "=1+1" in text
    assert "unlike their type: 1" in text
    assert page.get("/fleet?page=3").text.count("Bay ") == 50
    found = page.get("/fleet?find=BAY+17").text
    assert "11 of them" in found
    table = pd.read_csv(results / "fleet.csv", keep_default_na=False)
    table["pole_spread"] = pd.to_numeric(table["pole_spread"])
    types = pd.read_csv(results / "fleet" / "types.csv")
    ranked = fleet_document(table.assign(phase="=1+1"), types)
    assert read_fleet(results).parts[0].rows == ranked.parts[0].rows


@pytest.mark.parametrize(
    ("lost", "path", "said"),
    [
        ("standing.zarr", "/life", "standing.zarr"),
        ("limits.csv", "/life", "snakemake -c2 all"),
        ("life.zarr/beyond/0.0", "/life", "is lost"),
        ("fleet/types.csv", "/fleet", "snakemake -c2 all"),
    ],
)
def test_results_that_are_not_whole_are_said_with_a_remedy(
    opened, results, tmp_path, lost, path, said
):
    copy = tmp_path / "results"
    shutil.copytree(results, copy)
    page = opened(copy, tmp_path)
    assert page.get(path).status == 200
    gone = copy / lost
    (shutil.rmtree if gone.is_dir() else type(gone).unlink)(gone)
    if "beyond" in lost:  # a store as it was, of which a file goes, is one that was read before
        page = opened(copy, tmp_path)
    answer = page.get(path)
    assert answer.status == 422
    assert said in unescape(answer.text)


def test_a_run_that_goes_on_is_shown_anew(opened, results, tmp_path):
    copy = tmp_path / "results"
    shutil.copytree(results, copy)
    page = opened(copy, tmp_path)
    before = page.get("/life").text
    write_life(copy, a_life(fails=(np.inf, np.inf)))
    assert page.get("/life").text != before
