"""The configuration that commands share."""

import filecmp
from collections.abc import Mapping, Sequence
from pathlib import Path

from breaker.shipped import DEFAULTS
from breaker.workflow import load, read

__all__ = ["PROJECT", "limits_of", "settings_of"]

PROJECT = Path("config/config.yaml")
"""Where the workflow's configuration is, from the project's folder."""


def settings_of(overlays: Sequence[str]) -> dict:
    """The configuration: overlays over that of the folder, or over the defaults that ship.

    The defaults alone are not checked: tests do that, and it takes a tenth of the first answer.
    """
    own = PROJECT.exists() and not filecmp.cmp(PROJECT, DEFAULTS, shallow=False)
    if own or overlays:
        return load([PROJECT if own else DEFAULTS, *overlays])
    return read(DEFAULTS)


def limits_of(config: Mapping, overlays: Sequence[str]) -> list:
    """The limits of the drive: those that ship are an example, and none unless they are asked for.

    They are where the configuration changes them, or an overlay names them.
    """
    named = any("limits" in read(path) for path in overlays)
    return config["limits"] if named or config["limits"] != read(DEFAULTS)["limits"] else []
