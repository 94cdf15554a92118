"""Data files: families of drives, the simulated test and advice, with units and reasons."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from breaker.configuration.loading import read
from breaker.configuration.yaml_sources import ConfigurationError
from breaker.shipped import ADVICE, FAMILIES, SIMULATED_TEST, family_file


def family_of(name: str) -> dict[str, Any]:
    """Return a family of ``breaker.shipped`` or a YAML file; ConfigurationError if it is wrong."""
    from breaker.configuration.checking import dotted, problems
    from breaker.configuration.settings import FamilyFile

    file = Path(name) if name.endswith((".yaml", ".yml")) else family_file(name)
    if not file.exists():
        raise ConfigurationError(f"{name} is not there. Take {', '.join(FAMILIES)}, or a YAML file")
    content = read(file)
    if found := problems(FamilyFile, content):
        lines = [f"{file}: {dotted(key)} {text}" for key, text in found.items()]
        raise ConfigurationError("\n  ".join(lines))
    return content


def simulated_test(config: Mapping[str, Any]) -> dict[str, Any]:
    """Return drive, wear and sensor of the simulated endurance test, and its operations."""
    return read(SIMULATED_TEST) | config["simulated_test"]


def advice_of(own: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return where to look first, by quantity: the words that ship, or one's own instead."""
    return {**read(ADVICE), **(own or {})}
