"""Models that tests of posteriors share."""

import pytest

from tests.networks_fixtures import curved_model


@pytest.fixture(scope="module", autouse=True)
def same_sums(one_thread):
    """Every test here computes with torch."""


@pytest.fixture(scope="module")
def series():
    """A model, and records for it."""
    return curved_model()
