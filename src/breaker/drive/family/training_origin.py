"""What a network of a family was trained on, by the settings in its file. Light to import."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from breaker.common.tensor_file import settings_of

_SIZES = {"drives", "shards"}  # of a bank, not of its drives
_FORMER = "simulator"  # a setting of earlier networks, always empty


def trained_on(path: str | Path, prior: Mapping, family: Mapping) -> bool:
    """Say whether a network was trained on drives of this prior and family, whatever the bank's
    size.

    Raises:
        FileNotFoundError: If there is no such file.
        ModelFileError: If it is no model file.
    """

    def drives(family: Mapping) -> dict:
        return {name: value for name, value in family.items() if name not in _SIZES}

    known = settings_of(path)
    return known["prior"] == prior and drives(drives_of(known)) == drives(family)


def drives_of(settings: Mapping) -> dict:
    """Return the section ``family`` that a network was trained on, by its settings."""
    return {name: each for name, each in settings["drives"].items() if name != _FORMER}


def deciding(networks: Mapping[str, Any]) -> dict[str, Any]:
    """Return the section ``family_networks`` without settings on which no weight depends."""
    training = {name: each for name, each in networks["training"].items() if name != "workers"}
    return {**networks, "training": training}
