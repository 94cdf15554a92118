"""What tests of the studies share with those of the package: one thread, and the defaults."""

from tests.conftest import defaults, models, one_thread, prior, sensor

__all__ = ["defaults", "models", "one_thread", "prior", "sensor"]
