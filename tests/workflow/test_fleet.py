"""A fleet: jobs have breakers of one type; what is appended or edited reruns its own job."""

import csv
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml

from breaker.family.endurance import write_curve
from breaker.model.curves import travel
from tests.workflow.conftest import ROOT, snakemake

pytestmark = pytest.mark.slow

HEAD = "file,motion,operation,breaker,phase,date,type"
TYPES = {"A": "GL 314", "B": "LTB 145"}
TIME = 0.1 * np.arange(760)


@pytest.fixture
def fleet(tmp_path, monkeypatch, prior):
    """Two breakers, each recorded on two dates, in a folder with the settings of the project."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "config", "config")
    Path("curves").mkdir()
    rows = []
    for name in "AB":
        for inspection, year in ((1, 2014), (2, 2024)):
            curve = travel(prior.medians[None], TIME, "closing", onset=10.0).travel[0]
            noise = 0.1 * np.random.default_rng([ord(name), inspection]).standard_normal(TIME.size)
            file = f"{name}_{inspection}.csv"
            write_curve(
                Path("curves", file), TIME, curve + noise, motion="closing", operation=inspection
            )
            rows.append(f"{file},closing,{inspection},{name},R,{year}-03-01,{TYPES[name]}")
    Path("curves/operations.csv").write_text("\n".join([HEAD, *rows, ""]), encoding="utf-8")
    mine = {"endurance": {"curves": "curves"}, "types": "types.yaml", "motions": ["closing"]}
    Path("my.yaml").write_text(yaml.dump(mine), encoding="utf-8")
    write_types("[1, 2]")


def write_types(stroke):
    """Write the entries of both types, with the limits on the stroke of one."""
    entries = (
        f"gl-314: {{limits: {{stroke: [1, 200]}}}}\nLTB145: {{limits: {{stroke: {stroke}}}}}\n"
    )
    Path("types.yaml").write_text(entries, encoding="utf-8")


def run(*arguments):
    """What Snakemake says of the fleet."""
    where = ["--snakefile", ROOT / "Snakefile", "--configfile", "my.yaml"]
    return snakemake("-c1", *where, *arguments, folder=Path.cwd())


def planned():
    """Chunks that a dry run plans, with the summary."""
    plan = run("-n", "--", "all")
    assert set(re.findall(r"^(?:local)?rule (\w+):", plan, re.M)) == {"fleet_chunk", "fleet", "all"}
    return set(re.findall(r"chunk=(\d+)", plan))


def test_an_edit_of_a_type_or_an_appended_record_runs_the_chunk_of_its_breaker_alone(fleet):
    run("--", "all")
    with Path("results/fleet.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    states = {(row["breaker"], row["inspections"], row["state"]) for row in rows}
    assert states == {("A", "2", "ok"), ("B", "2", "due")}  # by the limits of their types
    assert "Nothing to be done" in run("-n", "--", "all")
    write_types("[3, 4]")  # of the type of B alone
    assert planned() == {"001"}
    write_types("[1, 2]")
    assert "Nothing to be done" in run("-n", "--", "all")

    shutil.copy("curves/B_2.csv", "curves/B_3.csv")
    with Path("curves/operations.csv").open("a", encoding="utf-8") as end:
        end.write("B_3.csv,closing,3,B,R,2025-03-01,LTB 145\n")
    assert planned() == {"001"}
