"""Files that ship with the package: every default, their schema, and models trained with them.

``config.yaml`` is that of the project (``config/config.yaml``); the models are those of its default
run. ``make ship`` brings both up to date, and tests compare them.
"""

from pathlib import Path

__all__ = ["CARD", "DEFAULTS", "SCHEMA", "model_file"]

_HERE = Path(__file__).parent

CARD = _HERE / "MODEL_CARD.md"
"""What the models are, for whom, and how good."""

DEFAULTS = _HERE / "config.yaml"
"""Every setting with its default."""

SCHEMA = _HERE / "config.schema.yaml"
"""JSON schema of the configuration."""


def model_file(of: str, kind: str = "") -> Path:
    """Return a model file, trained with the defaults.

    Args:
        of: "closing" or "opening"; with a kind, the name of a family of drives.
        kind: "levels" or "changes", of a network of a family.

    Example:
        >>> model_file("closing").name, model_file("medium_voltage", "levels").name
        ('closing.safetensors', 'medium_voltage_levels.safetensors')
    """
    return _HERE / f"{f'{of}_{kind}' if kind else of}.safetensors"
