"""The plan of a fleet: a job for each chunk, and appended visits run their own one again."""

import json
import re
from pathlib import Path

import yaml

from breaker.drive.fleet.breaker_chunks import breaker_chunks
from breaker.reading.files.folder_listing import fingerprint, list_fleet
from tests.workflow.conftest import ROOT, snakemake

HEAD = "file,motion,operation,breaker,phase"


def plan(*more):
    """Number of jobs by rule, and the chunks among them."""
    files = [ROOT / "config/config.yaml", "my.yaml"]
    where = ["--snakefile", ROOT / "Snakefile", "--cores", "1", "-n", "all", *more]
    text = snakemake(*where, "--configfile", *files, folder=Path.cwd())
    jobs = {name: int(count) for name, count in re.findall(r"^(\w+) +(\d+) *$", text, re.M)}
    return jobs, sorted(set(re.findall(r"chunk=(\d+)", text)))


def test_appended_visits_run_their_own_chunk(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = [f"{b}_{n}.csv,closing,{n},{b},R" for b in "ABCDE" for n in (1, 2)]
    (tmp_path / "curves").mkdir()
    for row in rows:
        (tmp_path / "curves" / row.split(",")[0]).touch()
    table = tmp_path / "curves/operations.csv"
    table.write_text("\n".join([HEAD, *rows, ""]), encoding="utf-8")
    mine = {"endurance": {"curves": "curves"}, "fleet": {"breakers_per_job": 2}}
    (tmp_path / "my.yaml").write_text(yaml.dump(mine | {"motions": ["closing"]}))
    jobs, _ = plan()
    assert jobs == {"fleet_chunk": 3, "fleet": 1, "data_package": 1, "all": 1, "total": 6}

    fleet = list_fleet("curves", events={})
    for chunk, names in breaker_chunks([*fleet], 2).items():
        source = fingerprint(each for name in names for _, each in fleet[name])
        store = tmp_path / f"results/fleet/chunk_{chunk}.zarr"
        store.mkdir(parents=True)
        (store / ".zattrs").write_text(json.dumps({"settings": json.dumps({"source": source})}))
    assert plan()[1] == []
    (tmp_path / "curves/C_3.csv").touch()
    with table.open("a", encoding="utf-8") as end:
        end.write("C_3.csv,closing,3,C,R\n")
    assert plan()[1] == ["001"]
    assert "fleet_chunk" not in plan("--config", "endurance={'breaker': 'A'}")[0]
