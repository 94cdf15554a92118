"""The default settings of the correction, for tests of every kind of posterior."""

import yaml

from breaker.shipped import DEFAULTS

__all__ = ["SETTINGS"]

SETTINGS = yaml.safe_load(DEFAULTS.read_text(encoding="utf-8"))["correction"]
