"""The configuration: the defaults, with YAML files of one's own laid over them, and checked.

The classes in ``settings`` hold every default; an overlay holds only what differs. A configuration
is a nested dictionary of plain values.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from functools import reduce
from pathlib import Path
from typing import Any

import yaml

from breaker.records.files import RejectedCurveError, read_bytes

WIDEST = 1
"""Largest log-sd of a prior: a factor of 2.7 to either side."""

UNLIKE = 30.0
"""Times the reference drive's that a median may be: less than the root of a slip of 1,000."""

_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # the same in C, where PyYAML has it
# Errors that PyYAML lets through where a value is not what its tag or its shape promises.
_UNREADABLE = (ValueError, ArithmeticError, LookupError, TypeError, AttributeError, RecursionError)

Lines = list[tuple[tuple[str, ...], int]]  # key and line of every value of a file


class ConfigurationError(ValueError):
    """What is wrong with a configuration; the text has one line for each problem."""


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
    combined = merge(both, config["by_motion"].get(motion, {}))
    inference = combined["network"]["inference"]
    chosen = {"kind": inference["kind"], **inference[inference["kind"]]}
    combined["network"] = {"summary": combined["network"]["summary"], "inference": chosen}
    return combined


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
    from breaker.configuration.consistency import broken
    from breaker.configuration.settings import Settings

    sources = {Path(path): parse(path)[1] for path in files}
    wrong = problems(Settings, config)
    problems_there = [*wrong.items(), *broken(config, {key[0] for key in wrong}, curves=curves)]
    lines = [f"{place(key, sources)}{dotted(key)} {text}" for key, text in problems_there]
    for path, source in sources.items():
        lines += [f"{path}, {text}" for text in repeated(source)]
    lines = list(dict.fromkeys(lines))  # a table of operations may be wrong for both motions
    if lines:
        text = "\n  ".join([f"Problems of the configuration: {len(lines)}", *lines])
        raise ConfigurationError(f"{text}\ndocs/reference/settings.md explains every key.")


# ---- YAML files, and where a value stands --------------------------------------------------------


def parse(path: str | Path) -> tuple[Any, Lines]:
    """Return what a YAML file holds, and where; a ConfigurationError if it cannot be read."""
    path = Path(path)
    try:
        text = read_bytes(path).decode("utf-8")
    except RejectedCurveError as error:
        raise ConfigurationError(str(error)) from error
    except UnicodeDecodeError as error:
        raise ConfigurationError(f"{path}: is not UTF-8 text; save it as UTF-8") from error
    try:
        loader = _Loader(text)
        node = loader.get_single_node()
        content = loader.construct_document(node) if node else None
        # Fails where an alias stands within what it names.
        json.dumps(content, default=str, skipkeys=True)
    except yaml.YAMLError as error:
        reason = " ".join(str(error).split())
        raise ConfigurationError(f"{path}: is not valid YAML: {reason}") from error
    except _UNREADABLE as error:
        raise ConfigurationError(f"{path}: has a value that YAML cannot read: {error}") from error
    return content, _lines(node)


def repeated(lines: Lines) -> Iterator[str]:
    """Yield a complaint for every key that stands twice in one section."""
    seen: dict[tuple[str, ...], int] = {}
    for key, line in lines:
        if key in seen:
            yield f"line {line}: {key[-1]} stands in line {seen[key]} already. Remove one of them."
        seen[key] = line


def place(key: tuple, sources: Mapping[Path, Lines]) -> str:
    """Return the file and line of a value, or of the section around it, as a message begins.

    The key holds names of sections and numbers of list entries; the last overlay comes first.
    """
    for depth in range(len(key), 0, -1):
        above = tuple(map(str, key[:depth]))
        for path, lines in sources.items():
            if line := dict(lines).get(above):
                return f"{path}, line {line}: "
    return ""


def _lines(node: yaml.Node | None, above: tuple[str, ...] = ()) -> Lines:
    """Return the key and the line of each entry of a section or list, and of those in it."""
    entries, lines = [], []
    if isinstance(node, yaml.MappingNode):
        entries = [(name.value, name, value) for name, value in node.value]
    elif isinstance(node, yaml.SequenceNode):
        entries = [(str(number), value, value) for number, value in enumerate(node.value)]
    for name, mark, value in entries:
        # Not of an earlier section, merged into this one by <<, which may change it.
        if mark.start_mark.line >= node.start_mark.line:
            key = (*above, name)
            lines += [(key, mark.start_mark.line + 1), *_lines(value, key)]
    return lines
