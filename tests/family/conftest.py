"""A bank that the tests of the room share."""

import numpy as np
import pytest

from breaker.configuration.data_files import family_of
from breaker.family.bank import simulate_family
from breaker.family.drive_family import Family


@pytest.fixture(scope="package")
def bank(prior):
    """160 drives of the family, new and worn."""
    family = Family(prior, family_of("medium_voltage"))
    return simulate_family(family, 160, np.random.default_rng(2))
