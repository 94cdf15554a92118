"""The configuration that commands share."""

from collections.abc import Sequence
from pathlib import Path

from breaker.shipped import DEFAULTS
from breaker.workflow import load

__all__ = ["PROJECT", "settings_of"]

PROJECT = Path("config/config.yaml")
"""Where the workflow's configuration is, from the project's folder."""


def settings_of(overlays: Sequence[str]) -> dict:
    """The configuration: overlays over that of the folder, or over the defaults that ship."""
    return load([PROJECT if PROJECT.exists() else DEFAULTS, *overlays])
