"""The schema of a configuration: made of the defaults and of what is stated, and what violates it.

``schema.yaml`` in ``breaker.shipped`` states bounds, choices and descriptions. Of the defaults come
which settings there are, and the type of each: so a setting is added in two places, not in three.

Violations are told in plain words. The check is stricter than JSON Schema: a number is finite, an
integer is written as one, and a section has every key that its schema knows, unless the schema says
which ones are ``required``. The schema of a configuration does so in lists alone.
"""

import difflib
import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from datetime import date
from functools import cache
from typing import Any

import yaml
from jsonschema import Draft202012Validator, ValidationError, validators

from breaker.configuration.yaml_sources import ConfigurationError, parse
from breaker.shipped import DEFAULTS, SCHEMA

Key = tuple[str | int, ...]
"""Where a value stands: keys of sections and numbers of list entries, outermost first."""

_KINDS = {
    "integer": "a whole number",
    "number": "a number",
    "string": "a text",
    "boolean": "true or false",
    "array": "a list",
    "object": "a section",
    "null": "null (none)",
}
_BOUNDS = {
    "exclusiveMinimum": "greater than",
    "minimum": "at least",
    "exclusiveMaximum": "less than",
    "maximum": "at most",
}
_Schema = Mapping[str, Any]

_TYPES = {
    bool: "boolean",
    int: "integer",
    float: "number",
    str: "string",
    list: "array",
    dict: "object",
}
_TYPED = {"type", "enum", "oneOf"}  # of these, one says what a value may be
_OF_SECTION = {"description", "patternProperties"}


def dotted(key: Key) -> str:
    """Write a key as ``network.closing.summary.kernels[0]``.

    Example:
        >>> dotted(("motions", 0))
        'motions[0]'
    """
    parts = (f"[{part}]" if type(part) is int else f".{part}" for part in key)
    return "".join(parts).removeprefix(".")


def leaves(schema: _Schema, above: Key = ()) -> Iterator[Key]:
    """Yield every key of a schema that is not itself a section."""
    for name, part in schema.get("properties", {}).items():
        yield from leaves(part, (*above, name)) if "properties" in part else [(*above, name)]


def problems(config: Mapping[str, Any], schema: _Schema) -> Iterator[tuple[Key, str]]:
    """Yield every key that is unknown, wrong or missing, and a text that goes on after its name.

    Args:
        config: The merged configuration.
        schema: The content of the JSON schema.

    Example:
        >>> list(problems({"seed": "1"}, {"properties": {"seed": {"type": "integer"}}}))
        [(('seed',), 'is "1", but must be a whole number. YAML reads 1 as a text; write 1.')]
    """
    unnamed: list[Key] = []
    errors = _VALIDATOR(schema).iter_errors(_named(config, (), unnamed))
    for key in unnamed:
        yield key, "is not a known key: YAML reads a number or a date, not a text. Quote it."
    for error in sorted(errors, key=lambda error: list(map(str, error.path))):
        key, known = tuple(error.absolute_path), error.schema.get("properties", {})
        patterns = error.schema.get("patternProperties", {})
        if error.validator == "additionalProperties":
            for name in error.instance:
                if name not in known and not any(re.search(each, name) for each in patterns):
                    yield (*key, name), _unknown(key, name, schema, list(known))
        elif error.validator == "properties":
            yield key, f"is missing; it must be {_allowed(known[key[-1]])}."
        else:
            yield key, _wrong(error.instance, error.schema)


def _named(part: Any, key: Key, unnamed: list[Key]) -> Any:
    """Copy sections and lists without what has no text as its key, and add such keys to a list."""
    if isinstance(part, list):
        return [_named(each, (*key, i), unnamed) for i, each in enumerate(part)]
    if not isinstance(part, Mapping):
        return part
    unnamed += [(*key, name) for name in part if not isinstance(name, str)]
    texts = {name: value for name, value in part.items() if isinstance(name, str)}
    return {name: _named(value, (*key, name), unnamed) for name, value in texts.items()}


def _all_there(
    validator: Any, properties: _Schema, section: Any, schema: _Schema
) -> Iterator[ValidationError]:
    """The keyword ``properties``, which also asks for the keys themselves."""
    yield from Draft202012Validator.VALIDATORS["properties"](validator, properties, section, schema)
    if validator.is_type(section, "object"):
        for name in schema.get("required", properties):
            if name not in section:
                yield ValidationError("missing", path=[name])


_JSON_TYPES = Draft202012Validator.TYPE_CHECKER
_VALIDATOR = validators.extend(
    Draft202012Validator,
    {"properties": _all_there, "required": lambda *_: ()},
    type_checker=_JSON_TYPES.redefine_many(
        {
            "number": lambda _, value: (
                _JSON_TYPES.is_type(value, "number") and math.isfinite(value)
            ),
            # JSON Schema takes 2.0 for an integer; range(2.0) and a shape of 2.0 fail much later.
            "integer": lambda _, value: isinstance(value, int) and not isinstance(value, bool),
        }
    ),
)


def _unknown(key: Key, name: Any, root: _Schema, siblings: Sequence[str]) -> str:
    """Say that a key of a section is unknown, and which was probably meant."""
    meant = [(*key, close) for close in difflib.get_close_matches(str(name), siblings, n=1)]
    if not meant:  # a key of this name elsewhere, further down in this section if it is there
        elsewhere = [path for path in leaves(root) if path[-1] == name]
        meant = [path for path in elsewhere if path[: len(key)] == key] or elsewhere
    if meant:
        return f"is not a known key. Did you mean {' or '.join(map(dotted, meant))}?"
    return f"is not a known key. Known here: {', '.join(siblings)}."


def _wrong(value: Any, schema: _Schema) -> str:
    """Say which value is wrong, what is allowed, what the key means, and how to mend it."""
    shown = json.dumps(value, ensure_ascii=False, default=str, skipkeys=True)
    shown = "empty" if value is None else shown
    if len(shown) > 60:
        shown = shown[:57] + "..."
    meaning = f" ({schema['description'].rstrip('.')})" if "description" in schema else ""
    return f"is {shown}, but must be {_allowed(schema)}{meaning}.{_hint(value, schema)}"


def _types(schema: _Schema) -> list[str]:
    types = schema.get("type", [])
    return [types] if isinstance(types, str) else types


def _allowed(schema: _Schema) -> str:
    """Put into words which values a part of the schema allows."""
    if "enum" in schema:
        values = ", ".join(map(str, schema["enum"]))
        return f"one of {values}" if len(schema["enum"]) > 1 else values
    if "oneOf" in schema:
        return " or ".join(map(_allowed, schema["oneOf"]))
    text = " or ".join(_KINDS[name] for name in _types(schema))
    bounds = [f"{words} {schema[bound]}" for bound, words in _BOUNDS.items() if bound in schema]
    text += ", " + " and ".join(bounds) if bounds else ""
    text += ", not empty" if "minLength" in schema else ""
    text += f", of {schema['maxLength']} signs at most" if "maxLength" in schema else ""
    if "items" in schema:
        least, most = schema.get("minItems", 0), schema.get("maxItems")
        count = f"{most}" if least == most else f"{least} to {most}"
        text += f" of {least} or more entries" if most is None else f" of {count} entries"
        text += ", none twice" if schema.get("uniqueItems") else ""
        text += f", each {_allowed(schema['items'])}"
    if "properties" in schema:
        text += f" with the keys {', '.join(schema['properties'])}"
    return text


def _hint(value: Any, schema: _Schema) -> str:
    """Return the remedy where YAML reads a text as a number or a date, or a number as a text."""
    types = _types(schema)
    if type(value) in (int, float, date) and "string" in types:
        return f' Quote it: "{value}".'
    if not isinstance(value, str) or not {"integer", "number"} & set(types):
        return ""
    try:
        number = float(value)
    except ValueError:
        return ""
    if not math.isfinite(number):
        return ""
    if number.is_integer() and "integer" in types:
        number = int(number)
    return f" YAML reads {value} as a text; write {yaml.safe_dump(number).split()[0]}."


@cache
def configuration_schema() -> Mapping[str, Any]:
    """Return the JSON schema of the configuration of the workflow."""
    return derived(parse(SCHEMA)[0], parse(DEFAULTS)[0])


def derived(stated: Mapping[str, Any], default: Any) -> dict[str, Any]:
    """Return the JSON schema of a setting, or of a section and all that is in it.

    Args:
        stated: Words of JSON Schema that hold beside the default, and ``range``, the least and the
            largest number, of the setting or of each entry of a list. Of a section, the same for
            each of its keys, under its name.
        default: What the setting or section is unless it is changed.

    Raises:
        ConfigurationError: If a section states a key that has no default, or not one that has.

    Example:
        >>> derived({"range": [0, 9]}, 2.5)
        {'type': 'number', 'minimum': 0, 'maximum': 9}
    """
    if isinstance(default, Mapping) and default:
        return _of_section(stated, default)
    part = {key: value for key, value in stated.items() if key != "range"}
    bounds = dict(zip(("minimum", "maximum"), stated.get("range", ()), strict=False))
    if not _TYPED & set(stated):
        part = {"type": _TYPES[type(default)], **part}
    if not isinstance(default, list):
        return part | bounds
    if "items" not in stated or not _TYPED & set(stated["items"]):
        part["items"] = {"type": _TYPES[type(default[0])], **stated.get("items", {}), **bounds}
    if not {"minItems", "maxItems"} & set(stated):
        part |= {"minItems": len(default), "maxItems": len(default)}
    return part


def _of_section(stated: Mapping[str, Any], default: Mapping[str, Any]) -> dict[str, Any]:
    words = _OF_SECTION & (set(stated) - set(default))
    if wrong := (set(stated) - words) ^ set(default):
        raise ConfigurationError(
            f"{SCHEMA.name} and {DEFAULTS.name} do not name the same settings: "
            f"{', '.join(sorted(wrong))}. State each in both (`make defaults`)."
        )
    return {
        "type": "object",
        "additionalProperties": False,
        **{word: stated[word] for word in stated if word in words},
        "properties": {key: derived(stated[key], default[key]) for key in stated if key in default},
    }
