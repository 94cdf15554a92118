"""Drives made of scores are those that the family draws, and their curves those of a drive."""

import numpy as np
import pytest
from scipy.stats import ks_2samp

from breaker.common.randomness import generator
from breaker.drive.exact.family_scores import FamilyScores
from breaker.drive.simulation.drive_family import Family
from breaker.mechanism.prior import Prior
from studies.family_exact import curves

_DRIVES = 600


@pytest.fixture(scope="module")
def family(defaults):
    return Family(Prior.from_settings(defaults["prior"]), defaults["family"])


@pytest.fixture(scope="module")
def scores(family):
    return FamilyScores.of(family, generator(1, "test scores"))


@pytest.fixture(scope="module")
def drawn(family):
    rng = generator(1, "test scores, drives")
    return [family.new(rng) for _ in range(_DRIVES)]


def unlike(numbers: np.ndarray, drives) -> float:
    """Smallest p-value of any number of a drive, times how many there are."""
    own = np.array([each.numbers for each in drives])
    varied = np.flatnonzero(own.std(axis=0))
    found = [ks_2samp(numbers[:, k], own[:, k]).pvalue for k in varied]
    return float(min(found) * len(varied))


def test_scores_make_the_drives_that_the_family_draws(scores, drawn):
    rng = generator(2, "test scores")
    numbers = scores.numbers(rng.standard_normal((2 * _DRIVES, scores.unknowns)))
    found = curves(numbers, True, np.array([0.0, 30.0]), np.zeros(len(numbers)))
    works = np.isfinite(found).all(axis=1)
    assert 0.7 < works.mean() < 1.0
    assert unlike(numbers[works], drawn) > 1e-3  # false alarms: 1e-3 by Bonferroni
    shifted = numbers[works].copy()
    shifted[:, 1] *= 1.1  # a planted fault
    assert unlike(shifted, drawn) < 1e-3


def test_a_drive_of_scores_does_not_depend_on_those_beside_it(scores):
    some = generator(3, "test scores").standard_normal((20, scores.unknowns))
    whole = scores.numbers(some)
    assert np.array_equal(whole[7:8], scores.numbers(some[7:8]))


@pytest.mark.parametrize("motion", ["closing", "opening"])
def test_curves_are_those_of_a_drive(drawn, motion):
    times, begins = np.linspace(-2.0, 40.0, 60), np.linspace(-0.5, 0.5, 20)
    numbers = np.array([each.numbers for each in drawn[:20]])
    found = curves(numbers, motion == "closing", times, begins)
    own = [d.travel(motion, times - b) for d, b in zip(drawn[:20], begins, strict=True)]
    assert np.allclose(found, own, atol=0.005)


def test_a_drive_that_does_not_work_has_no_curve(drawn):
    numbers = drawn[0].changed(f=1e-3).numbers[None]
    assert np.isnan(curves(numbers, True, np.linspace(-2.0, 40.0, 10), np.zeros(1))).all()
