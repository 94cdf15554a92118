"""The configuration that commands share."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from breaker.shipped import DEFAULTS
from breaker.workflow import load, read

__all__ = ["ADVANCED", "PROJECT", "limits_of", "settings_of"]

ADVANCED = Path("config/advanced.yaml")
PROJECT = Path("config/config.yaml")
"""Where the workflow's configuration is, from the project's folder; the second over the first."""


def settings_of(overlays: Sequence[str]) -> dict:
    """The configuration: overlays over that of the folder, or over the defaults that ship.

    The defaults alone are not checked: tests do that, and it takes a tenth of the first answer.
    """
    own = [ADVANCED if ADVANCED.exists() else DEFAULTS, PROJECT] if PROJECT.exists() else [DEFAULTS]
    files = [*own, *overlays]
    return load(files) if len(files) > 1 else read(DEFAULTS)


def limits_of(config: Mapping, overlays: Sequence[str]) -> list:
    """The limits of the drive: those that ship are an example, and none unless they are asked for.

    They are where the configuration changes them, or an overlay names them.
    """
    named = any("limits" in read(path) for path in overlays)
    return config["limits"] if named or config["limits"] != read(DEFAULTS)["limits"] else []
