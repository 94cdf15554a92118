"""Configuration of the workflow: merged from files, checked, and explained where it is wrong.

Every default stands in ``config/config.yaml`` or, if hardly any user turns it, in
``config/advanced.yaml``; an overlay holds only what differs. ``breaker.configuration.schema``
makes the JSON schema of allowed keys and values, of the defaults and of ``schema.yaml`` in
``breaker.shipped``. The table ``RULES`` of ``breaker.configuration.rules`` defines which keys must
be consistent with each other.
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import reduce
from operator import getitem
from pathlib import Path
from typing import Any

from breaker.configuration.yaml_sources import (
    ConfigurationError,
    Sources,
    parse,
    place,
    repeated,
)

_SHOWN = 20  # problems that a message lists


def load(paths: Sequence[str | Path], *, curves: bool = True) -> dict[str, Any]:
    """Read a configuration, each file laid over those before it, and check it.

    Args:
        paths: YAML files; the first ones hold the defaults.
        curves: Whether ``endurance.curves`` is the folder in question: as of ``check``.

    Raises:
        ConfigurationError: If a file cannot be read or the configuration is wrong.

    Example:
        >>> files = ["config/advanced.yaml", "config/config.yaml", "config/paper.yaml"]
        >>> load(files)["sensor"]["zero_sd"]
        0.0
    """
    config = reduce(merge, map(read, paths), {})
    check(config, files=tuple(reversed(paths)), curves=curves)
    return config


def read(path: str | Path) -> dict[str, Any]:
    """Read one YAML file of keys.

    Raises:
        ConfigurationError: If there is no such file, or it is not YAML with keys at top level.
    """
    content, _ = parse(path)
    if not isinstance(content, dict):
        raise ConfigurationError(f"{path}: must hold keys and values, such as 'seed: 1'")
    return content


def merge(base: Mapping[str, Any], overlay: Mapping[str, Any]) -> dict[str, Any]:
    """Lay one configuration over another: sections key by key, anything else as a whole.

    Example:
        >>> merge({"bank": {"shards": 4, "curves": 9}, "seed": 1}, {"bank": {"shards": 2}})
        {'bank': {'shards': 2, 'curves': 9}, 'seed': 1}
    """
    merged = dict(base)
    for key, value in overlay.items():
        below = merged.get(key)
        both = isinstance(value, Mapping) and isinstance(below, Mapping)
        merged[key] = merge(below, value) if both else value
    return merged


def chosen_network(settings: Mapping[str, Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Return the settings of the networks that are chosen, without those of the other kinds.

    Args:
        settings: A section ``network.MOTION``, in which each of ``summary`` and ``inference``
            has its ``kind``, what all kinds have in common, and a section for every kind.

    Returns:
        ``{"summary": {"kind", ...}, "inference": {"kind", ...}}``, each flat: what is in common
        and what is in the section of its kind. So models are built, and so their files keep it.

    Example:
        >>> chosen_network({"summary": {"kind": "a", "features": 3, "a": {"width": 1}, "b": {}}})
        {'summary': {'kind': 'a', 'features': 3, 'width': 1}}
    """
    chosen = {}
    for role, section in settings.items():
        common = {key: value for key, value in section.items() if not isinstance(value, Mapping)}
        chosen[role] = common | section[section["kind"]]
    return chosen


def check(
    config: Mapping[str, Any], *, files: Iterable[str | Path] = (), curves: bool = True
) -> None:
    """Check a merged configuration: keys, types, ranges, and keys that must fit each other.

    Args:
        config: The merged configuration.
        files: Files it came from, if known, the last overlay first. A message names the first one
            with the value in question, and the line. A key that stands twice in a file is a
            problem too: YAML drops one.
        curves: Whether to look at the folder ``endurance.curves``, and what must fit it.

    Raises:
        ConfigurationError: If anything is wrong; the message lists all of it.
    """
    # Here, as it takes longer than the check: jobs run on what was checked before the first one.
    from breaker.configuration.rules import RULES
    from breaker.configuration.schema import configuration_schema, dotted, problems
    from breaker.reading.files.folder_listing import list_once

    list_once.cache_clear()
    sources: Sources = {Path(path): parse(path) for path in files}
    lines, wrong = [], []
    for key, text in problems(config, configuration_schema()):
        lines.append(f"{place(config, [key], sources)}{dotted(key)} {text}")
        wrong.append(key)
    for names, complaint in RULES:
        if not curves and "endurance.curves" in names:
            continue
        keys = [tuple(name.split(".")) for name in names]
        if any(bad[: len(key)] == key[: len(bad)] for key in keys for bad in wrong):
            continue  # a rule is about keys that are right by themselves
        if text := " ".join(complaint(*(reduce(getitem, key, config) for key in keys))):
            lines.append(f"{place(config, keys, sources)}{names[0]} {text}")
    for path, (_, node) in sources.items():
        lines += [f"{path}, {text}" for text in repeated(node)]
    lines = list(dict.fromkeys(lines))  # both motions may have the same to say of the bank
    if lines:
        count = "a problem" if len(lines) == 1 else f"{len(lines)} problems"
        more = [f"and {len(lines) - _SHOWN} more"] if len(lines) > _SHOWN else []
        raise ConfigurationError(
            "\n  ".join([f"The configuration has {count}:", *lines[:_SHOWN], *more])
            + "\nEvery key is explained in config/config.yaml or config/advanced.yaml."
        )
