"""The YAML files of a configuration: read, and searched for where a value stands."""

import json
from collections.abc import Iterator, Mapping
from functools import reduce
from operator import getitem
from pathlib import Path
from typing import Any

import yaml

from breaker.reading.files.guards import RejectedCurveError, read_bytes

_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # the same in C, where PyYAML has it
# Errors that PyYAML lets through where a value is not what its tag or its shape promises.
_UNREADABLE = (ValueError, ArithmeticError, LookupError, TypeError, AttributeError, RecursionError)


class ConfigurationError(ValueError):
    """What is wrong with a configuration; the text has one line for each problem."""


def parse(path: str | Path) -> tuple[Any, yaml.Node | None]:
    """Return what a YAML file holds, and the nodes it is made of, which know their lines.

    Raises:
        ConfigurationError: If it cannot be read, or is not YAML.
    """
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
    return content, node


def repeated(node: yaml.Node | None) -> Iterator[str]:
    """Yield a complaint for every key that stands twice in one section."""
    lines: dict[str, int] = {}
    for name, line, value in _entries(node):
        if line <= node.start_mark.line:
            continue  # of an earlier section, merged into this one by <<, which may change it
        if name in lines:
            yield f"line {line}: {name} stands in line {lines[name]} already. Remove one of them."
        lines[name] = line
        yield from repeated(value)


def place(key: tuple, sources: Mapping[Path, tuple[Any, yaml.Node | None]]) -> str:
    """Return the file and line of a value, or of the section around it, as the start of a message.

    Args:
        key: Keys of sections and numbers of list entries.
        sources: What ``parse`` returns for each file, the last overlay first.
    """
    while key:
        for path, (content, node) in sources.items():
            try:
                reduce(getitem, key, content)
            except (KeyError, IndexError, TypeError):
                continue
            line = 0
            for part in key:  # a key that <<: merges has no line in its section
                found = [each for each in _entries(node) if each[0] == str(part)]
                _, line, node = found[-1] if found else (part, line, None)
            return f"{path}, line {line}: "
        key = key[:-1]
    return ""


def _entries(node: yaml.Node | None) -> list[tuple[str, int, yaml.Node]]:
    """Return key or number, line from 1, and node of each entry of a section or list."""
    if isinstance(node, yaml.MappingNode):
        return [(name.value, name.start_mark.line + 1, value) for name, value in node.value]
    if isinstance(node, yaml.SequenceNode):
        return [(str(i), value.start_mark.line + 1, value) for i, value in enumerate(node.value)]
    return []
