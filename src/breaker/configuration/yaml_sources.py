"""The YAML files of a configuration: read, and searched for where a value stands."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from breaker.records.files import RejectedCurveError, read_bytes

_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # the same in C, where PyYAML has it
# Errors that PyYAML lets through where a value is not what its tag or its shape promises.
_UNREADABLE = (ValueError, ArithmeticError, LookupError, TypeError, AttributeError, RecursionError)

Lines = list[tuple[tuple[str, ...], int]]  # key and line of every value of a file


class ConfigurationError(ValueError):
    """What is wrong with a configuration; the text has one line for each problem."""


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
    entries, found = [], []
    if isinstance(node, yaml.MappingNode):
        entries = [(name.value, name, value) for name, value in node.value]
    elif isinstance(node, yaml.SequenceNode):
        entries = [(str(number), value, value) for number, value in enumerate(node.value)]
    for name, mark, value in entries:
        # Not of an earlier section, merged into this one by <<, which may change it.
        if mark.start_mark.line >= node.start_mark.line:
            key = (*above, name)
            found += [(key, mark.start_mark.line + 1), *_lines(value, key)]
    return found
