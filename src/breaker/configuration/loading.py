"""The configuration: the defaults, with files of one's own laid over them, and checked.

The classes in ``settings`` hold every default; an overlay holds only what differs. A configuration
is a nested dictionary of plain values.
"""

from collections.abc import Mapping, Sequence
from functools import reduce
from pathlib import Path
from typing import Any

from breaker.configuration.yaml_sources import ConfigurationError, parse, place, repeated

WIDEST = 1
"""Largest log-sd of a prior: a factor of 2.7 to either side."""

UNLIKE = 30.0
"""Times the reference drive's that a median may be: less than the root of a slip of 1,000."""


def load(paths: Sequence[str | Path] = (), *, curves: bool = True) -> dict[str, Any]:
    """Read YAML files, each laid over the defaults and the files before it, and ``check`` them."""
    config = reduce(merge, map(read, paths), defaults())
    check(config, files=tuple(reversed(paths)), curves=curves)
    return config


def defaults() -> dict[str, Any]:
    """Return the defaults: a configuration without any file."""
    from breaker.configuration import settings  # pydantic: a fifth of a second

    return settings.defaults()


def read(path: str | Path) -> dict[str, Any]:
    """Read one YAML file of keys; raise a ConfigurationError if it is none."""
    content, _ = parse(path)
    if not isinstance(content, dict):
        raise ConfigurationError(f"{path}: must hold keys and values, such as 'seed: 1'")
    return content


def merge(base: Mapping[str, Any], overlay: Mapping[str, Any]) -> dict[str, Any]:
    """Lay one configuration over another: sections key by key, anything else as a whole."""
    merged = dict(base)
    for key, value in overlay.items():
        below = merged.get(key)
        both = isinstance(value, Mapping) and isinstance(below, Mapping)
        merged[key] = merge(below, value) if both else value
    return merged


def of_motion(config: Mapping[str, Any], motion: str) -> dict[str, dict[str, Any]]:
    """Return the sections ``network`` and ``training`` with what ``by_motion`` changes in them.

    Of inference networks, the chosen one alone is kept, flat, so that no model depends on others.
    """
    both = {key: config[key] for key in ("network", "training")}
    found = merge(both, config["by_motion"].get(motion, {}))
    inference = found["network"]["inference"]
    chosen = {"kind": inference["kind"], **inference[inference["kind"]]}
    found["network"] = {"summary": found["network"]["summary"], "inference": chosen}
    return found


def check(config: Mapping, *, files: Sequence[str | Path] = (), curves: bool = True) -> None:
    """Check a merged configuration: keys, types, ranges, and keys that must fit each other.

    Args:
        files: Files it came from, the last overlay first, in which values are looked for. A key
            that stands twice in one is a problem, too: YAML drops the first.
        curves: Whether to look at the folder ``endurance.curves``, and what must fit it.

    Raises:
        ConfigurationError: If anything is wrong; the message lists all of it.
    """
    from breaker.configuration.checking import dotted, problems
    from breaker.configuration.conditions import broken
    from breaker.configuration.settings import Settings

    sources = {Path(path): parse(path)[1] for path in files}
    wrong = problems(Settings, config)
    found = [*wrong.items(), *broken(config, {key[0] for key in wrong}, curves=curves)]
    lines = [f"{place(key, sources)}{dotted(key)} {text}" for key, text in found]
    for path, each in sources.items():
        lines += [f"{path}, {text}" for text in repeated(each)]
    lines = list(dict.fromkeys(lines))  # a table of operations may be wrong for both motions
    if lines:
        text = "\n  ".join([f"Problems of the configuration: {len(lines)}", *lines])
        raise ConfigurationError(f"{text}\ndocs/settings.md explains every key.")
