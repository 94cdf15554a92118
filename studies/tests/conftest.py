"""What tests of the studies share with those of the package: one thread, and the defaults."""

from tests.conftest import defaults, one_thread, prior, sensor

__all__ = ["defaults", "one_thread", "prior", "sensor"]
