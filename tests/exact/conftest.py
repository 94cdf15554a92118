"""What the tests of the room share: the family of the defaults, its drives, and its scores."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.drive.exact import exact_posterior, family_scores, particles, residual_emulator
from breaker.drive.exact.family_scores import FamilyScores
from breaker.drive.simulation.drive_family import Family
from breaker.mechanism.curves import travel
from breaker.mechanism.prior import Prior
from breaker.reading.instruments.export import write_curve

STEP = 0.3  # ms, of records


@pytest.fixture(scope="package")
def family(defaults):
    """Of the defaults, but for contacts that slide, which it has too."""
    contacts = {"elastic": 0.5, "held": 0.3, "sliding": 0.2}
    return Family(
        Prior.from_settings(defaults["prior"]), defaults["family"] | {"contacts": contacts}
    )


@pytest.fixture(scope="package")
def scores(family):
    return FamilyScores.of(family, generator(1, "test scores"))


@pytest.fixture(scope="package")
def drawn(family):
    """Drives that the family draws."""
    rng = generator(1, "test scores, drives")
    return [family.new(rng) for _ in range(600)]


SMALL = {
    exact_posterior: {
        **{"PARTICLES": 80, "ENOUGH": 20.0, "LEAST": 1.0, "_MOST": 2, "_EARLY": 20, "_LATE": 40},
        **{"_LEARNED": (0,), "_FEWEST": 5, "_ROUNDS": 5, "_BEFORE": 500},
    },
    particles: {"_FIRST": 1500, "_MOVES": {"_trajectory": 1, "_redrawn": 4}, "_LEAPS": (2, 4)},
    residual_emulator: {"_HIDDEN": (24, 24)},
    family_scores: {"_DRAWN": 300},
}


@pytest.fixture(scope="module")
def small():
    """Constants with which an answer takes seconds, and is as rough."""
    with pytest.MonkeyPatch.context() as patch:
        for module, values in SMALL.items():
            for name, value in values.items():
                patch.setattr(module, name, value)
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory, prior):
    """A record of both motions, one of a closing, one that is none, and a drive that halts."""
    place = tmp_path_factory.mktemp("exact")
    _write(place / "both.csv", prior, "closing", "opening")
    _write(place / "a.csv", prior, "closing")
    _write(place / "odd.csv", prior, "closing", halts=50)
    (place / "bad.csv").write_text("no record\n", encoding="utf-8")
    (place / "few.yaml").write_text("endurance: {draws: 100}\n", encoding="utf-8")
    return place


def _write(file, prior, *motions, halts=0):
    """A coarse record at the prior's medians, whose drive may halt in its first motion."""
    time, rng = STEP * np.arange(260), generator(1, "exact", file.name)
    parts = [travel(prior.medians[None], time, each, onset=10.0).travel[0] for each in motions]
    whole = np.concatenate(parts)
    whole = np.insert(whole, np.full(halts, 53), whole[53])
    whole = whole + 0.3 * rng.standard_normal(whole.size)
    write_curve(file, STEP * np.arange(whole.size), whole, motion=motions[0], operation=1)
