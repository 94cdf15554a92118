"""Trainings and models that tests of posteriors share."""

from functools import partial

import pytest

from tests.networks_fixtures import curved_model, new_trainer


@pytest.fixture(scope="module", autouse=True)
def same_sums(one_thread):
    """Every test here computes with torch."""


@pytest.fixture
def trainer(tmp_path):
    """Maker of trainings that share one checkpoint."""
    return partial(new_trainer, tmp_path)


@pytest.fixture(scope="module")
def series():
    """A model, and records for it."""
    return curved_model()
