"""The JSON schema of the configuration: from what is stated of a setting, and from its default.

``schema.yaml`` in ``breaker.shipped`` states bounds, choices and descriptions. Of the defaults come
which settings there are, and the type of each: so a setting is added in two places, not in three.
"""

from collections.abc import Mapping
from functools import cache
from typing import Any

from breaker.configuration.yaml_sources import ConfigurationError, parse
from breaker.shipped import DEFAULTS, SCHEMA

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
