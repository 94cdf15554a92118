"""What the tests of the room share: the family of the defaults, its drives, and its scores."""

import pytest

from breaker.common.randomness import generator
from breaker.drive.exact.family_scores import FamilyScores
from breaker.drive.simulation.drive_family import Family
from breaker.mechanism.prior import Prior


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
