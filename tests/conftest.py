"""The default prior and sensor, for the tests of every module."""

from pathlib import Path

import pytest
import yaml

from breaker.model.prior import Prior
from breaker.model.sensor import Sensor

DEFAULTS = Path(__file__).parents[1] / "config" / "config.yaml"


@pytest.fixture(scope="session")
def defaults():
    """Every setting with its default."""
    return yaml.safe_load(DEFAULTS.read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def prior(defaults):
    return Prior.from_settings(defaults["prior"])


@pytest.fixture(scope="session")
def sensor(defaults):
    return Sensor.from_settings(defaults["sensor"])
