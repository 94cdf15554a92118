"""What the tests of the commands share: a folder with records of the reference drive."""

import shutil

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.family.endurance import write_curve
from breaker.model.curves import travel

TIME = 0.1 * np.arange(760)  # ms
FEW = "endurance: {draws: 100}\n"


def written(file, prior, *motions, noise_sd=0.1):
    """Write a record with motions one after the other, at the prior's medians."""
    parts = [travel(prior.medians[None], TIME, motion, onset=10.0).travel[0] for motion in motions]
    way = np.concatenate(parts)
    way = way + noise_sd * generator(1, "test curve", file.name).standard_normal(way.size)
    write_curve(file, 0.1 * np.arange(way.size), way, motion=motions[0], operation=1)


@pytest.fixture(autouse=True, scope="module")
def quick(a_quarter_of_the_draws):
    """Every command here infers."""


@pytest.fixture(scope="package")
def records(tmp_path_factory, prior):
    """Two closings, an opening, and a record of both; no configuration."""
    folder = tmp_path_factory.mktemp("records")
    for name, motions in {
        "a.csv": ["closing"],
        "b 2.csv": ["closing"],
        "open.csv": ["opening"],
        "both.csv": ["closing", "opening"],
    }.items():
        written(folder / name, prior, *motions)
    (folder / "few.yaml").write_text(FEW, encoding="utf-8")
    return folder


@pytest.fixture
def folder(records, tmp_path, monkeypatch):
    """A copy of the records, where the commands run."""
    monkeypatch.chdir(tmp_path)
    return shutil.copytree(records, tmp_path, dirs_exist_ok=True)
