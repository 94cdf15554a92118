"""The judge's curves of drives of a family are those of a drive."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.drive.simulation.drive_family import Family
from breaker.mechanism.prior import Prior
from studies.family_exact import curves


@pytest.fixture(scope="module")
def drawn(defaults):
    family = Family(Prior.from_settings(defaults["prior"]), defaults["family"])
    rng = generator(1, "test scores, drives")
    return [family.new(rng) for _ in range(20)]


@pytest.mark.parametrize("motion", ["closing", "opening"])
def test_curves_are_those_of_a_drive(drawn, motion):
    times, begins = np.linspace(-2.0, 40.0, 60), np.linspace(-0.5, 0.5, 20)
    numbers = np.array([each.numbers for each in drawn])
    found = curves(numbers, motion == "closing", times, begins)
    own = [d.travel(motion, times - b) for d, b in zip(drawn, begins, strict=True)]
    assert np.allclose(found, own, atol=0.005)


def test_a_drive_that_does_not_work_has_no_curve(drawn):
    numbers = drawn[0].changed(f=1e-3).numbers[None]
    assert np.isnan(curves(numbers, True, np.linspace(-2.0, 40.0, 10), np.zeros(1))).all()
