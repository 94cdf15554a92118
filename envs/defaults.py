"""Write the files of defaults, the JSON schema and the page of settings from the classes.

Run by ``make defaults``, from the project's folder, after a change of
``breaker.configuration.settings``. The schema is for editors and the catalogue of workflows.
"""

import json
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from breaker.configuration.settings import ADVANCED, Section, Settings

__all__ = ["files", "schema"]

_WIDTH = 100
_HEADS = {
    "config/config.yaml": """\
The settings of a drive, its records and decisions, with their defaults; all others are in
advanced.yaml. Units are mm, ms and m/s, which is mm/ms. Do not edit these files: write the settings
that differ into a file of your own (docs/reference/settings.md), and give it to the workflow,

    snakemake -c2 all --configfile config/my.yaml

or to `breaker`, by --config. Write small numbers as 1.0e-3: YAML reads 1e-3 as a text.""",
    "config/advanced.yaml": """\
The settings that hardly any user changes, with their defaults: networks, training, checks and the
simulated endurance test. Write those that differ into a file of your own (config.yaml).""",
}
_PAGE = """\
# Settings

Every setting with its default, what it may be, and its meaning. `config/config.yaml` and
`config/advanced.yaml` hold the same defaults. Write only the settings that differ into a file of
your own. A wrong key or value stops the workflow before the first job. A wrong function stops it
at first use.

This page is made by `make defaults` from `src/breaker/configuration/settings.py`.
"""
_BOUNDS = {"minimum": "≥", "exclusiveMinimum": ">", "maximum": "≤", "exclusiveMaximum": "<"}


def files() -> dict[Path, str]:
    """Return the content of all generated files, by path in the project."""
    result = {}
    for file, head in _HEADS.items():
        lines = ["Made by `make defaults` from src/breaker/configuration/settings.py.", ""]
        lines = [f"# {line}".rstrip() for line in [*lines, *head.splitlines()]]
        for name in Settings.model_fields:
            if (name in ADVANCED) == ("advanced" in file):
                lines += ["", *_yaml_of(name, Settings, 0)]
        result[Path(file)] = "\n".join(lines) + "\n"
    text = yaml.safe_dump(schema(), sort_keys=False, width=_WIDTH, allow_unicode=True)
    result[Path("workflow/schemas/config.schema.yaml")] = f"# Made by `make defaults`.\n{text}"
    result[Path("docs/reference/settings.md")] = page()
    return result


def _yaml_of(name: str, section: type[Section], depth: int) -> Iterator[str]:
    """Yield the lines of a setting, or of a section with its settings."""
    field, indent = section.model_fields[name], "  " * depth
    if field.is_required():
        yield from _comment(field.annotation.__doc__, indent)
        yield f"{indent}{name}:"
        for inner in field.annotation.model_fields:
            yield from _yaml_of(inner, field.annotation, depth + 1)
        return
    value = field.default
    if name == "limits":
        yield from _comment(field.description, indent)
        yield f"{name}:"
        yield from (f"  - {_flow(item)}" for item in value)
        return
    line = f"{indent}{name}: {_flow(value)}"
    beside = f"{line}  # {field.description}"
    if depth and len(beside) <= _WIDTH:
        yield beside
    else:
        yield from _comment(field.description, indent)
        yield line


def _comment(text: str, indent: str) -> list[str]:
    mark = f"{indent}# "
    return textwrap.wrap(
        " ".join(text.split()), _WIDTH, initial_indent=mark, subsequent_indent=mark
    )


def _flow(value: Any) -> str:
    text = yaml.safe_dump(value, default_flow_style=True, width=1000, sort_keys=False)
    return text.removesuffix("\n").removesuffix("\n...")


def schema() -> dict[str, Any]:
    """Return the JSON schema, without references, so that a catalogue can show it."""
    full = Settings.model_json_schema()
    kinds = full.pop("$defs")

    def resolved(part: Any) -> Any:
        if isinstance(part, list):
            return [resolved(item) for item in part]
        if not isinstance(part, dict):
            return part
        kind = kinds[part["$ref"].rpartition("/")[2]] if "$ref" in part else {}
        merged = kind | {key: item for key, item in part.items() if key != "$ref"}
        # An overlay contains only some settings.
        return {k: resolved(item) for k, item in merged.items() if k not in ("title", "required")}

    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "breaker"}
    return head | resolved(full)


def page() -> str:
    """Return the page of all settings: a table for each section."""
    parts = schema()["properties"]
    lines = [_PAGE]
    single = {name: part for name, part in parts.items() if "properties" not in part}
    for name, part in {"": {"properties": single}, **parts}.items():
        if "properties" in part:
            lines += _table(name, part)
    return "\n".join(lines)


def _table(name: str, part: dict[str, Any]) -> list[str]:
    title = f"\n## {name}\n" if name else "\n## General\n"
    about = [" ".join(part["description"].split()) + "\n"] if "description" in part else []
    rows = [
        f"| `{key}` | `{json.dumps(item['default'], ensure_ascii=False)}` | {_allowed(item)} "
        f"| {item['description']} |"
        for key, item in _leaves(part["properties"])
    ]
    return [title, *about, "| setting | default | allowed | meaning |", "|---|---|---|---|", *rows]


def _leaves(parts: dict[str, Any], above: str = "") -> Iterator[tuple[str, dict]]:
    for name, part in parts.items():
        if "properties" in part and "default" not in part:
            yield from _leaves(part["properties"], f"{above}{name}.")
        else:
            yield f"{above}{name}", part


def _allowed(part: dict[str, Any]) -> str:
    """Return the allowed values of a part of the schema in words."""
    if "anyOf" in part:
        return " or ".join(map(_allowed, part["anyOf"]))
    if "median" in part.get("properties", {}):
        return "; ".join(f"{name}: {_allowed(item)}" for name, item in part["properties"].items())
    if "enum" in part or "const" in part:
        return ", ".join(map(_value, part.get("enum", [part.get("const")])))
    words = {"integer": "whole number", "object": "section", "array": "list", "string": "text"}
    text = words.get(part["type"], part["type"])
    bounds = [f"{sign} {part[name]:g}" for name, sign in _BOUNDS.items() if name in part]
    text = " ".join([text, ", ".join(bounds)]) if bounds else text
    return f"{text} of {_allowed(part['items'])}" if "items" in part else text


def _value(value: Any) -> str:
    """Return an allowed value for a cell; signs and blanks are quoted, and a bar is escaped."""
    text = str(value)
    if any(map(str.isalnum, text)):
        return text
    return f"`{json.dumps(text)}`".replace("|", r"\|")


if __name__ == "__main__":
    for file, text in files().items():
        file.write_text(text, encoding="utf-8")
        print(f"written to {file}")
