"""What a JSON schema has against a configuration, in plain words.

Knows schemas and YAML, not what the keys are about. A schema states no ``required``, so that it
also fits an overlay that holds only what differs; the configuration checked here has to have every
key. Numbers are stricter than JSON Schema has them: finite, and an integer is written as one.
"""

import difflib
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import yaml
from jsonschema import Draft202012Validator, TypeChecker, ValidationError, validators

__all__ = ["Key", "dotted", "leaves", "problems"]

Key = tuple[str | int, ...]
"""Where a value stands: keys of sections and numbers of list entries, outermost first."""

KINDS = {
    "integer": "a whole number",
    "number": "a number",
    "string": "a text",
    "boolean": "true or false",
    "array": "a list",
    "object": "a section",
    "null": "null (none)",
}
BOUNDS = {
    "exclusiveMinimum": "greater than",
    "minimum": "at least",
    "exclusiveMaximum": "less than",
    "maximum": "at most",
}


def _finite(checker: TypeChecker, value: Any) -> bool:
    return Draft202012Validator.TYPE_CHECKER.is_type(value, "number") and math.isfinite(value)


def _whole(checker: TypeChecker, value: Any) -> bool:
    # JSON Schema also takes 2.0 for an integer; range(2.0) and a shape of 2.0 fail much later.
    return isinstance(value, int) and not isinstance(value, bool)


_VALIDATOR = validators.extend(
    Draft202012Validator,
    type_checker=Draft202012Validator.TYPE_CHECKER.redefine_many(
        {"number": _finite, "integer": _whole}
    ),
)


def dotted(key: Key) -> str:
    """Write a key as ``network.closing.summary.kernels[0]``."""
    parts = (f"[{part}]" if type(part) is int else f".{part}" for part in key)
    return "".join(parts).removeprefix(".")


def problems(config: Mapping[str, Any], schema: Mapping[str, Any]) -> Iterator[tuple[Key, str]]:
    """Yield every key that is unknown, wrong or missing, and a text that goes on after its name.

    Args:
        config: The merged configuration.
        schema: The content of the JSON schema.
    """
    for error in sorted(
        _VALIDATOR(schema).iter_errors(config), key=lambda e: list(map(str, e.path))
    ):
        key = tuple(error.absolute_path)
        if error.validator == "additionalProperties":
            for name in error.instance:
                if name not in error.schema.get("properties", {}):
                    yield (*key, name), _unknown(key, name, schema, error.schema)
        else:
            yield key, _wrong(error)
    yield from _missing(config, schema)


def _unknown(key: Key, name: Any, root: Mapping[str, Any], section: Mapping[str, Any]) -> str:
    """Say that a key is unknown, and which was probably meant."""
    siblings = list(section.get("properties", {}))
    meant = difflib.get_close_matches(str(name), siblings, n=1)
    elsewhere = [path for path in leaves(root) if path[-1] == name]
    # Further down in this section, if it is there: of sections that are alike, this one is meant.
    elsewhere = [path for path in elsewhere if path[: len(key)] == key] or elsewhere
    if meant:
        return f"is not a known key. Did you mean {dotted((*key, meant[0]))}?"
    if elsewhere:
        return f"is not a known key. Did you mean {' or '.join(map(dotted, elsewhere))}?"
    return f"is not a known key. Known here: {', '.join(siblings)}."


def _wrong(error: ValidationError) -> str:
    """Say which value is wrong, what is allowed, what the key means, and how to mend it."""
    value, schema = error.instance, error.schema
    shown = "empty" if value is None else json.dumps(value, ensure_ascii=False, default=str)
    if len(shown) > 60:
        shown = shown[:57] + "..."
    meaning = f" ({schema['description'].rstrip('.')})" if "description" in schema else ""
    return f"is {shown}, but must be {_allowed(schema)}{meaning}.{_hint(value, schema)}"


def _types(schema: Mapping[str, Any]) -> list[str]:
    types = schema.get("type", [])
    return [types] if isinstance(types, str) else list(types)


def _allowed(schema: Mapping[str, Any]) -> str:
    """Put into words which values a part of the schema allows."""
    if "enum" in schema:
        values = ", ".join(map(str, schema["enum"]))
        return f"one of {values}" if len(schema["enum"]) > 1 else values
    text = " or ".join(KINDS[name] for name in _types(schema))
    bounds = [f"{words} {schema[bound]}" for bound, words in BOUNDS.items() if bound in schema]
    text += ", " + " and ".join(bounds) if bounds else ""
    if "items" in schema:
        least = schema.get("minItems", 0)
        text += f" of {least} or more entries" if least else ""
        text += ", none twice" if schema.get("uniqueItems") else ""
        text += f", each {_allowed(schema['items'])}"
    if "properties" in schema:
        text += f" with the keys {', '.join(schema['properties'])}"
    return text


def _hint(value: Any, schema: Mapping[str, Any]) -> str:
    """Return the remedy where YAML reads a value as something else than was meant."""
    types = _types(schema)
    numeric = {"number", "integer"} & set(types)
    if isinstance(value, bool) and ("enum" in schema or "string" in types):
        return " YAML reads yes, no, on and off as true and false; quote a text."
    if numeric and isinstance(value, str):
        for text in (value, value.replace(",", ".")):
            try:
                number = float(text)
            except ValueError:
                continue
            if math.isfinite(number) and ("number" in types or number.is_integer()):
                quoted = isinstance(yaml.safe_load(value), int | float)
                cause = "It is given as a text" if quoted else f"YAML reads {value} as a text"
                return f" {cause}; write {_number(number, types)}."
    if "integer" in types and isinstance(value, float) and value.is_integer():
        return f" Write {_number(value, types)}."
    return ""


def _number(value: float, types: Sequence[str]) -> str:
    """Write a number so that YAML 1.1 reads it as one: it asks for a point and a signed power."""
    if "integer" in types and value.is_integer():
        return str(int(value))
    text = repr(value)
    mantissa, power, exponent = text.partition("e")
    return f"{mantissa if '.' in mantissa else mantissa + '.0'}{power}{exponent}"


def _missing(
    config: Mapping[str, Any], schema: Mapping[str, Any], above: Key = ()
) -> Iterator[tuple[Key, str]]:
    """Yield the keys of the schema that a configuration does not have."""
    for name, part in schema.get("properties", {}).items():
        key = (*above, name)
        if name not in config:
            yield key, f"is missing; it must be {_allowed(part)}."
            continue
        value = config[name]
        if isinstance(value, Mapping):
            yield from _missing(value, part, key)
        elif isinstance(value, list) and "items" in part:
            for index, item in enumerate(value):
                if isinstance(item, Mapping):
                    yield from _missing(item, part["items"], (*key, index))


def leaves(schema: Mapping[str, Any], above: Key = ()) -> Iterator[Key]:
    """Yield every key of a schema that is not itself a section."""
    for name, part in schema.get("properties", {}).items():
        if "properties" in part:
            yield from leaves(part, (*above, name))
        else:
            yield (*above, name)
