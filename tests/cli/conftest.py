"""What the tests of the commands share: a folder with records of the reference drive."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.family.curve_file import write_curve
from breaker.model.curves import travel

TIME = 0.1 * np.arange(760)  # ms
FEW = "endurance: {draws: 100}\n"


def written(file, prior, *motions, noise_sd=0.1, halts=0):
    """Write a record that holds motions one after the other, at the prior's medians.

    The drive may halt for some samples half-way through the first.
    """
    parts = [travel(prior.medians[None], TIME, each, onset=10.0).travel[0] for each in motions]
    whole = np.concatenate(parts)
    whole = np.insert(whole, np.full(halts, 160), whole[160])
    whole = whole + noise_sd * generator(1, "test curve", file.name).standard_normal(whole.size)
    time = 0.1 * np.arange(whole.size)
    write_curve(file, time, whole, motion=motions[0], operation=1)


@pytest.fixture(autouse=True, scope="module")
def quick(a_quarter_of_the_draws):
    """Every command here infers."""


@pytest.fixture
def folder(tmp_path, monkeypatch, prior):
    """An empty place with two closings, an opening, and a record of both; no configuration."""
    monkeypatch.chdir(tmp_path)
    for name, motions in {
        "a.csv": ["closing"],
        "b 2.csv": ["closing"],
        "open.csv": ["opening"],
        "both.csv": ["closing", "opening"],
    }.items():
        written(tmp_path / name, prior, *motions)
    (tmp_path / "few.yaml").write_text(FEW, encoding="utf-8")
    return tmp_path
