"""The workflow of the studies plans every network of the paper, in any folder."""

import re

from tests.workflow.conftest import ROOT, snakemake


def test_networks_are_planned(tmp_path):
    where = ["--snakefile", ROOT / "studies/Snakefile", "--directory", tmp_path]
    files = [ROOT / "config/config.yaml", ROOT / "config/test.yaml"]
    text = snakemake(*where, "--cores", "1", "-n", "networks", "--configfile", *files)
    jobs = dict(re.findall(r"^(\w+) +(\d+) *$", text, re.M))
    # Two summary networks, two inference networks, two motions.
    wanted = {"train_network": "8", "judge_network": "8", "compare_networks": "2"}
    assert {name: jobs[name] for name in wanted} == wanted
