"""Files that ship with the package: every default, their schema, and models trained with them.

``defaults.yaml`` is made from the project's ``config`` (``make defaults``); the networks are those
of its families of drives (``make ship``). Tests compare them.
"""

import json
from pathlib import Path

__all__ = ["CARD", "DEFAULTS", "FAMILIES", "KINDS", "SCHEMA", "model_file", "widening"]

_HERE = Path(__file__).parent

CARD = _HERE / "MODEL_CARD.md"
"""What the models are, for whom, and how good."""

DEFAULTS = _HERE / "defaults.yaml"
"""Every setting with its default."""

SCHEMA = _HERE / "schema.yaml"
"""What a setting may be, beside what its default says."""


FAMILIES = ("medium_voltage", "any")
"""Families of drives, in the order in which they are tried."""

KINDS = ("levels", "changes")
"""Networks of each."""


def model_file(family: str, kind: str) -> Path:
    """Return the file of a network.

    Example:
        >>> model_file("medium_voltage", "levels").name
        'medium_voltage_levels.safetensors'
    """
    return _HERE / f"{family}_{kind}.safetensors"


def widening(family: str) -> dict[int, dict[str, float]]:
    """Return by how much wider draws of levels are told than the network has them, so that
    intervals hold in the worst group of drives of other code (``studies/widening.py``).

    Returns:
        Factors by name of an output, by the number of motions that tell a drive; none of a family
        for which they were not measured.
    """
    known = json.loads((_HERE / "widening.json").read_text(encoding="utf-8")).get(family, {})
    return {int(motions): factors for motions, factors in known.items()}
