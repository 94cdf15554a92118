"""Loading of the configuration: the defaults, overridden by the user's YAML files, and checked.

The classes in ``settings`` contain all defaults; an overlay contains only differing settings. A
configuration is a nested dictionary of plain values.
"""

from collections.abc import Mapping, Sequence
from functools import reduce
from pathlib import Path
from typing import Any

import yaml

WIDEST = 1
"""Largest log-sd of a prior: a factor of 2.7 on both sides."""


class ConfigurationError(ValueError):
    """Problems of a configuration; the text has one line for each problem."""


class _Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):
    """YAML loader that refuses a repeated key in a section, where YAML would drop the first."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict:
        names = [name.value for name, _ in node.value]
        for name, _ in node.value:
            if names.count(name.value) > 1:
                text = f"the key {name.value} stands twice in a section"
                raise yaml.constructor.ConstructorError(None, None, text, name.start_mark)
        return super().construct_mapping(node, deep)


def load(paths: Sequence[str | Path] = (), *, curves: bool = True) -> dict[str, Any]:
    """Read YAML files, each over the defaults and the earlier files, and ``check`` the result."""
    config = reduce(merge, map(read, paths), defaults())
    check(config, source=", ".join(map(str, paths)), curves=curves)
    return config


def defaults() -> dict[str, Any]:
    """Return the defaults: a configuration without any file."""
    from breaker.configuration import settings  # pydantic: a fifth of a second

    return settings.defaults()


def read(path: str | Path) -> dict[str, Any]:
    """Read one YAML file of keys and values.

    Raises:
        FileNotFoundError: If there is no such file.
        ConfigurationError: If it is not a YAML file of keys.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
        content = yaml.load(text, _Loader)
    except FileNotFoundError as error:
        raise FileNotFoundError(f"there is no file {path} of settings or types") from error
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())
        raise ConfigurationError(f"{path}: is not valid YAML in UTF-8: {reason}") from error
    if not isinstance(content, dict):
        raise ConfigurationError(f"{path}: must hold keys and values, such as 'seed: 1'")
    return content


def merge(base: Mapping[str, Any], overlay: Mapping[str, Any]) -> dict[str, Any]:
    """Override a configuration by another: sections key by key, other values entirely."""
    merged = dict(base)
    for key, value in overlay.items():
        below = merged.get(key)
        both = isinstance(value, Mapping) and isinstance(below, Mapping)
        merged[key] = merge(below, value) if both else value
    return merged


def of_motion(config: Mapping[str, Any], motion: str) -> dict[str, dict[str, Any]]:
    """Return the sections ``network`` and ``training`` with the changes of ``by_motion``.

    Only the chosen kind of inference network is kept, so that a model does not depend on others.
    """
    both = {key: config[key] for key in ("network", "training")}
    combined = merge(both, config["by_motion"].get(motion, {}))
    inference = combined["network"]["inference"]
    chosen = {"kind": inference["kind"], **inference[inference["kind"]]}
    combined["network"] = {"summary": combined["network"]["summary"], "inference": chosen}
    return combined


def check(config: Mapping, *, source: str = "", curves: bool = True) -> None:
    """Check a merged configuration: keys, types, ranges, and keys that must fit each other.

    Args:
        config: The configuration.
        source: Names of its files, for the message.
        curves: Whether to check the folder ``endurance.curves``.

    Raises:
        ConfigurationError: If anything is wrong; the message lists all problems.
    """
    from breaker.configuration.consistency import broken
    from breaker.configuration.settings import Settings, problems

    wrong = problems(Settings, config) or dict(broken(config, curves=curves))
    if wrong:
        lines = [f"{key} {text}" for key, text in wrong.items()]
        text = "\n  ".join([f"Problems of {source or 'the configuration'}: {len(lines)}", *lines])
        raise ConfigurationError(f"{text}\ndocs/reference/settings.md explains every key.")
