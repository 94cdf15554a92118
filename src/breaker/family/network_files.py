"""Write the model files of a family, and compare them with a configuration."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from breaker.common.tensor_file import settings_of, write_model


def header_of(config: Mapping[str, Any], kind: str, definition: Mapping) -> dict[str, Any]:
    """Return the header of a network of "levels" or "changes", of a family with a definition."""
    family = config["family"]
    training = {**family["training"]}
    del training["workers"]  # no weight depends on it
    return {
        "kind": kind,
        "family": family["name"],
        "definition": definition,
        "bank": {key: family[key] for key in ("drives", "shards")},
        **{key: config[key] for key in ("seed", "prior")},
        "network": family["network"],
        "training": training,
    }


def unfit(path: str | Path, config: Mapping[str, Any], kind: str, definition: Mapping) -> list[str]:
    """Return the differences between a network and a configuration in prior and family; raise as
    ``settings_of``.
    """
    both = settings_of(path), header_of(config, kind, definition)
    parts = [{key: e.get(key) for key in ("family", "definition", "prior")} for e in both]
    return differing(*parts)


def differing(actual: Any, wanted: Any, key: str = "") -> list[str]:
    """Return the differences of settings, as ``prior.f: 2, not 3``."""
    if not (isinstance(actual, Mapping) and isinstance(wanted, Mapping)):
        return [] if actual == wanted else [f"{key}: {actual}, not {wanted}"]
    lines = []
    for name in sorted(actual.keys() | wanted.keys()):
        pair = (settings.get(name, "nothing") for settings in (actual, wanted))
        lines += differing(*pair, f"{key}.{name}".removeprefix("."))
    return lines


def write_network(
    path: str | Path, settings: Mapping, weights: Mapping[str, np.ndarray], frozen: Mapping
) -> None:
    """Write a network: settings of ``header_of``, weights of ``training.FamilyNetwork``, and other
    arrays of ``StateNetwork`` or ``ChangeNetwork``, some of them by motion.
    """
    arrays = {f"network.{name}": np.float32(weight) for name, weight in weights.items()}
    for name, value in frozen.items():
        if not isinstance(value, Mapping):
            arrays[name] = np.float64(value)
            continue
        for motion, parts in value.items():
            for part, array in parts._asdict().items():
                arrays[f"{name}.{motion}.{part}"] = np.float64(array)
    write_model(path, settings, arrays)
