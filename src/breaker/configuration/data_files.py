"""Data files: families of drives, types of breaker, the simulated test, and advice."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from breaker.common.clean_text import bare
from breaker.configuration.loading import ConfigurationError, merge, read
from breaker.model.quantities import in_words
from breaker.shipped import ADVICE, FAMILIES, SIMULATED_TEST, family_file


def family_of(name: str) -> dict[str, Any]:
    """Return a family of ``breaker.shipped`` or a YAML file; raise a ConfigurationError if missing.

    ``Family`` checks its content.
    """
    file = Path(name) if name.endswith((".yaml", ".yml")) else family_file(name)
    if not file.exists():
        raise ConfigurationError(f"{name} is not there. Take {', '.join(FAMILIES)}, or a YAML file")
    return read(file)


def types_of(config: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the entries of the file ``types`` by type; raise a ConfigurationError if wrong."""
    if not config["types"]:
        return {}
    from breaker.configuration.settings import TypesFile, problems

    types = read(config["types"])
    if wrong := problems(TypesFile, types):
        lines = [f"{config['types']}: {key} {text}" for key, text in wrong.items()]
        raise ConfigurationError("\n  ".join(lines))
    for name in types:
        try:
            laid_over({"speeds": config["speeds"], "limits": []}, entry_of_type(types, name))
        except ValueError as error:
            raise ConfigurationError(f"{config['types']}: {name}.limits: {error}") from error
    return types


def laid_over(config: Mapping[str, Any], entry: Mapping[str, Any]) -> dict[str, Any]:
    """Return a configuration overridden by the entry of a type, with the limits of both.

    Raises:
        ValueError: If a limit of the entry is wrong.
    """
    from breaker.model.limits import entries_of_type
    from breaker.model.quantities import every_speed

    ratio = {"ratio": entry["ratio"]} if "ratio" in entry else {}
    over = {"speeds": entry.get("speeds", {}), "endurance": {"format": ratio}}
    merged = merge(config, over)
    limits = entries_of_type(entry.get("limits", {}), every_speed(merged["speeds"]))
    return merged | {"limits": [*config["limits"], *limits]}


def entry_of_type(types: Mapping[str, dict[str, Any]], name: str) -> dict[str, Any]:
    """Return the entry of a type in any spelling; raise a ConfigurationError unless one matches."""
    matches = [known for known in types if bare(known) == bare(name)]
    if len(matches) != 1:
        there = f"is there as {' and '.join(matches)}" if matches else "is not among the types"
        raise ConfigurationError(f"type {name} {there}. Known types: {', '.join(types) or 'none'}")
    return types[matches[0]]


def simulated_test(config: Mapping[str, Any]) -> dict[str, Any]:
    """Return drive, wear and sensor of the simulated endurance test, and its operations."""
    return read(SIMULATED_TEST) | config["simulated_test"]


def advice_of() -> dict[str, str]:
    """Return advice on parts to inspect first, by quantity."""
    return read(ADVICE)


def advice_on(names: Iterable[str], advice: Mapping[str, str]) -> list[str]:
    """Return advice on parts to inspect first for worse quantities, each advice once.

    A speed without an entry has the advice on the usual speed of its motion.

    Example:
        >>> advice_on(["f", "mu", "closing_speed_10_90"], {"f": "spring", "closing_speed": "latch"})
        ['closing force: spring', 'closing speed 10 to 90 %: latch']
    """
    by: dict[str, list[str]] = {}
    for name in dict.fromkeys(names):
        motion, is_speed, _ = name.partition("_speed_")
        key = f"{motion}_speed" if is_speed and name not in advice else name
        if words := advice.get(key):
            by.setdefault(words, []).append(in_words(name))
    return [f"{', '.join(worse)}: {words}" for words, worse in by.items()]
