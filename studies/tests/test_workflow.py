"""The workflow of the studies plans every network of the paper, in any folder."""

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_networks_are_planned(tmp_path):
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "studies/Snakefile")]
    command += ["--directory", str(tmp_path), "--cores", "1", "-n", "networks"]
    command += ["--configfile", str(ROOT / "config/config.yaml"), str(ROOT / "config/test.yaml")]
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    jobs = dict(re.findall(r"^(\w+) +(\d+) *$", done.stdout + done.stderr, re.M))
    # Two summary networks, two inference networks, two motions; the deep sets with samples missing.
    assert {name: int(jobs[name]) for name in ("train_network", "judge_network")} == {
        "train_network": 8,
        "judge_network": 8,
    }
    assert (jobs["figure_missing"], jobs["figure_networks"]) == ("4", "2")
