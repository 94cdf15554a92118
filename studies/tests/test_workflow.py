"""The workflow of the studies plans every network of the paper, in any folder."""

import re

from tests.workflow.conftest import ROOT, snakemake


def test_networks_are_planned(tmp_path):
    where = ["--snakefile", ROOT / "studies/Snakefile", "--directory", tmp_path]
    files = [ROOT / "config/config.yaml", ROOT / "config/test.yaml"]
    text = snakemake(*where, "--cores", "1", "-n", "networks", "--configfile", *files)
    jobs = dict(re.findall(r"^(\w+) +(\d+) *$", text, re.M))
    # Two summary networks, two inference networks, two motions; the deep sets with samples missing.
    assert {name: int(jobs[name]) for name in ("train_network", "judge_network")} == {
        "train_network": 8,
        "judge_network": 8,
    }
    assert (jobs["compare_missing"], jobs["compare_networks"]) == ("4", "2")
