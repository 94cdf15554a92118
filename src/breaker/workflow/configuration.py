"""Configuration of the workflow: merged from files, checked, and explained where it is wrong.

Every default stands in ``config/config.yaml``; an overlay holds only what differs. What a key may
be is said once, by the JSON schema ``workflow/schemas/config.schema.yaml``; what the schema cannot
say, that several keys must fit each other, is the table ``RULES`` of ``configuration_rules``.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import getitem
from pathlib import Path
from typing import Any

import yaml

from breaker.workflow.rules import RULES
from breaker.workflow.schema import Key, dotted, problems

__all__ = [
    "ConfigurationError",
    "check",
    "chosen_network",
    "load",
    "merge",
    "read",
]


_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # the same in C, where PyYAML has it


class ConfigurationError(ValueError):
    """What is wrong with a configuration; the text has one line for each problem."""


def load(paths: Sequence[str | Path], *, schema: str | Path) -> dict[str, Any]:
    """Read a configuration, each file laid over those before it, and check it.

    Args:
        paths: YAML files; the first holds the defaults.
        schema: File of the JSON schema.

    Raises:
        ConfigurationError: If a file cannot be read or the configuration is wrong.
    """
    config = reduce(merge, map(read, paths), {})
    check(config, schema=schema, files=tuple(reversed(paths)))
    return config


def read(path: str | Path) -> dict[str, Any]:
    """Read one YAML file of keys.

    Raises:
        ConfigurationError: If there is no such file, or it is not YAML with keys at top level.
    """
    content = _Source.open(path).content
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


def chosen_network(settings: Mapping[str, Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Return the settings of the networks that are chosen, without those of the other kinds.

    Args:
        settings: A section ``network.MOTION``, in which each of ``summary`` and ``inference``
            has its ``kind``, what all kinds have in common, and a section for every kind.

    Returns:
        ``{"summary": {"kind", ...}, "inference": {"kind", ...}}``, each flat: what is in common
        and what is in the section of its kind. So models are built, and so their files keep it.
    """
    chosen = {}
    for role, section in settings.items():
        common = {key: value for key, value in section.items() if not isinstance(value, Mapping)}
        chosen[role] = common | section[section["kind"]]
    return chosen


def check(
    config: Mapping[str, Any], *, schema: str | Path, files: Iterable[str | Path] = ()
) -> None:
    """Check a merged configuration: keys, types, ranges, and keys that must fit each other.

    Args:
        config: The merged configuration.
        schema: File of the JSON schema.
        files: Files it came from. A message names the first that holds the value in question; a
            key that stands twice in one of them, of which YAML drops one, is a problem too.

    Raises:
        ConfigurationError: If anything is wrong; the message lists all of it.
    """
    sources = [_Source.open(path) for path in files]
    found = list(problems(config, read(schema)))
    found += _unfit(config, [key for key, _ in found])
    lines = [f"{_place(config, key, sources)}{dotted(key)} {text}" for key, text in found]
    lines += [line for source in sources for line in source.repeated]
    lines = list(dict.fromkeys(lines))  # both motions may have the same to say of the bank
    if lines:
        count = "a problem" if len(lines) == 1 else f"{len(lines)} problems"
        raise ConfigurationError(
            "\n  ".join([f"The configuration has {count}:", *lines])
            + "\nEvery key is explained in config/config.yaml."
        )


@dataclass(frozen=True)
class _Source:
    """A YAML file: what it says, where it says it, and complaints about keys it repeats."""

    path: Path
    content: Any
    node: yaml.Node | None
    repeated: tuple[str, ...]

    @classmethod
    def open(cls, path: str | Path) -> "_Source":
        path = Path(path)
        if path.is_relative_to(Path.cwd()):  # Snakemake gives whole paths; messages stay short
            path = path.relative_to(Path.cwd())
        try:
            loader = _Loader(path.read_text(encoding="utf-8"))
            node = loader.get_single_node()
            repeated = tuple(_repeated(node, path))  # before `<<` is resolved, which may repeat
            content = None if node is None else loader.construct_document(node)
        except OSError as error:
            raise ConfigurationError(f"{path}: cannot be read: {error.strerror}") from error
        except (yaml.YAMLError, UnicodeDecodeError) as error:
            reason = " ".join(str(error).split())
            raise ConfigurationError(f"{path}: is not valid YAML: {reason}") from error
        return cls(path, content, node, repeated)

    def line(self, key: Key) -> int | None:
        """Return the line of a key, counted from 1; None if the file does not hold it itself."""
        node, line = self.node, None
        for part in key:
            if isinstance(node, yaml.MappingNode):
                entries = {name.value: (name, value) for name, value in node.value}
                if str(part) not in entries:
                    return None
                name, node = entries[str(part)]
                line = name.start_mark.line + 1
            elif isinstance(node, yaml.SequenceNode) and isinstance(part, int):
                node = node.value[part]
                line = node.start_mark.line + 1
            else:
                return None
        return line

    def holds(self, key: Key, value: Any) -> bool:
        """Say whether the file gives a key this value, or a part of it if it is a section."""
        try:
            own = reduce(getitem, key, self.content)
        except (KeyError, IndexError, TypeError):
            return False
        # As text: NaN is not equal to itself, and True is equal to 1.
        return isinstance(value, Mapping) or repr(own) == repr(value)


def _repeated(node: yaml.Node | None, path: Path) -> Iterator[str]:
    """Yield a complaint for every key that stands twice in one section: YAML drops the first."""
    if isinstance(node, yaml.SequenceNode):
        for entry in node.value:
            yield from _repeated(entry, path)
    if not isinstance(node, yaml.MappingNode):
        return
    lines: dict[str, int] = {}
    for name, value in node.value:
        line = name.start_mark.line + 1
        if name.value in lines:
            yield (
                f"{path}, line {line}: {name.value} stands in line {lines[name.value]} already. "
                "Remove one of the two."
            )
        lines[name.value] = line
        yield from _repeated(value, path)


def _place(config: Mapping[str, Any], key: Key, sources: Sequence[_Source]) -> str:
    """Return the file and line that a value comes from, as the start of a message."""
    try:
        value = reduce(getitem, key, config)
    except (KeyError, IndexError):
        return ""
    for source in sources:
        if source.holds(key, value):
            line = source.line(key)
            return f"{source.path}, line {line}: " if line else f"{source.path}: "
    return "command line: " if sources else ""


def _unfit(config: Mapping[str, Any], wrong: Sequence[Key]) -> Iterator[tuple[Key, str]]:
    """Yield the rules that do not hold, of those whose keys are all right by themselves."""
    for rule in RULES:
        keys = [tuple(key.split(".")) for key in rule.keys]
        if any(bad[: len(key)] == key[: len(bad)] for key in keys for bad in wrong):
            continue
        text = rule.complaint(*(reduce(getitem, key, config) for key in keys))
        if text:
            yield keys[0], text
