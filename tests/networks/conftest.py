"""What tests of networks share."""

import pytest


@pytest.fixture(scope="module", autouse=True)
def same_sums(one_thread):
    """Every test here computes with torch."""
