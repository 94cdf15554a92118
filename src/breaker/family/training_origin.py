"""What a network of a family was trained on, by the settings in its file. Light to import."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from breaker.common.tensor_file import settings_of
from breaker.configuration.definitions import family_of


def header_of(config: Mapping[str, Any], kind: str) -> dict[str, Any]:
    """Return the settings in the header of a network of "levels" or "changes"."""
    family = config["family"]
    # No weight depends on the number of workers.
    training = {name: each for name, each in family["training"].items() if name != "workers"}
    return {
        "kind": kind,
        "family": family["name"],
        "definition": family_of(family["name"]),
        "bank": {key: family[key] for key in ("drives", "shards")},
        **{key: config[key] for key in ("seed", "prior")},
        "network": family["network"],
        "training": training,
    }


def unfit(path: str | Path, config: Mapping[str, Any], kind: str) -> list[str]:
    """Return where the drives of a network are not those of a configuration: prior and family.

    Raises:
        FileNotFoundError: If there is no such file.
        ModelFileError: If it is no model file.
    """
    found, wanted = settings_of(path), header_of(config, kind)
    parts = ("family", "definition", "prior")
    return differing(*({key: each.get(key) for key in parts} for each in (found, wanted)))


def differing(found: Any, wanted: Any, key: str = "") -> list[str]:
    """Return where settings differ, as ``key: found, not wanted``.

    Example:
        >>> differing({"seed": 1, "prior": {"f": 2}}, {"seed": 1, "prior": {"f": 3}})
        ['prior.f: 2, not 3']
    """
    if not (isinstance(found, Mapping) and isinstance(wanted, Mapping)):
        return [] if found == wanted else [f"{key}: {found}, not {wanted}"]
    lines = []
    for name in sorted(found.keys() | wanted.keys()):
        pair = (each.get(name, "nothing") for each in (found, wanted))
        lines += differing(*pair, f"{key}.{name}".removeprefix("."))
    return lines
