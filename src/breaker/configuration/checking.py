"""What is wrong with a configuration: each problem by its key, with what is allowed and the remedy.

Types and bounds are those of the classes in ``settings``; ``consistency`` has what several sections
must fulfil together. Only a check imports these modules, and with them pydantic.
"""

import difflib
import json
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from datetime import date
from typing import Any

import yaml
from pydantic import ValidationError

from breaker.configuration.settings import Limit, Section, TypeEntry, TypesFile, defaults
from breaker.model.quantities import QUANTITIES

Key = tuple[str | int, ...]  # of a value: names of sections and numbers of entries, outermost first

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d{1,2})?", re.IGNORECASE)
_WORDS = {
    "a valid integer": "a whole number",
    "a valid string": "a text",
    "a valid boolean": "true or false",
    "a valid dictionary": "a section",
    "a valid": "a",
    " after validation": "",
    "greater than or equal to": "at least",
    "less than or equal to": "at most",
}
_NAMELESS = "is not a known key: YAML reads a number or a date, not a text. Quote it."
_COMMA = "is not a known key: a comma separates entries. Write a decimal point, such as 1.3."
_MEANT = {"min": "lower", "max": "upper"}


def problems(section: type[Section], content: Any) -> dict[Key, str]:
    """Return what is wrong with the content of a section: by key, a text that goes on after it."""
    by_key: dict[Key, str] = {}
    try:
        section.model_validate(content)
    except ValidationError as error:
        for failure in error.errors(include_url=False):
            if failure["type"] == "missing" and failure["loc"][0] == "by_motion":
                continue  # it holds only what differs
            key, text = _problem(failure, content, section)
            # A value that may be of two types has an error for each of them.
            or_else = f"{by_key.get(key)} Or it {text.partition(', but ')[2]}"
            by_key[key] = or_else if key in by_key else text
    return by_key


def dotted(key: Key) -> str:
    """Write a key as ``network.summary.kernels[0]``."""
    parts = (f"[{part}]" if type(part) is int else f".{part}" for part in key)
    return "".join(parts).removeprefix(".").removesuffix(".[key]")


def leaves(section: Mapping, above: Key = ()) -> Iterator[Key]:
    """Yield the key of every value of nested sections; an empty section is a value."""
    for name, value in section.items():
        inner = isinstance(value, Mapping) and value
        yield from leaves(value, (*above, name)) if inner else [(*above, name)]


def _problem(error: Mapping, content: Any, section: type) -> tuple[Key, str]:
    """Return the key that an error of pydantic is about, and what to say of its value."""
    place, about, kind = error["loc"], error.get("ctx", {}), error["type"]
    key: Key = ()
    value = content
    for part in place:  # after the key, pydantic names the type that it has tried
        with suppress(KeyError, IndexError, TypeError):
            key, value = (*key, part), value[part]
    if kind == "missing":
        return place, "is missing."
    words = error["msg"].partition("should")[2].partition(" or instance of")[0]
    for technical, plain in _WORDS.items():
        words = words.replace(technical, plain)
    words = str(about.get("error", f"must{words}"))
    if key[:1] == ("limits",) and key[-1] in QUANTITIES:
        unit = "%" if content["limits"][key[1]].get("of") == "change" else QUANTITIES[key[-1]].unit
        words = words.replace("number", f"number in {unit}") if unit != "1" else words
    if kind == "extra_forbidden":
        return place, _unknown(place, section)
    if kind == "invalid_key" or place[-1:] == ("[key]",):
        if kind in ("invalid_key", "string_type"):
            return place, _COMMA if value is None else _NAMELESS
        return place, f"is not a known key; it {words}."
    shown = json.dumps(value, ensure_ascii=False, default=str, skipkeys=True)
    shown = "empty" if value is None else shown
    shown = f"{shown[:57]}..." if len(shown) > 60 else shown
    return key, f"is {shown}, but {words}.{_hint(value, kind)}"


def _unknown(key: Key, section: type) -> str:
    """Say that a key is unknown, and which one was probably meant."""
    known = [*leaves(defaults())]
    if key[0] == "by_motion":
        key = key[2:]
    elif section is TypesFile or key[0] == "limits":
        entry = TypeEntry if section is TypesFile else Limit
        known = [(*key[:-1], name) for name in entry.model_fields]
    inside = {path[: len(key)] for path in known if path[: len(key) - 1] == key[:-1]}
    siblings = [path[-1] for path in sorted(inside)]
    name = _MEANT.get(key[-1], key[-1])
    close = [(*key[:-1], name) for name in difflib.get_close_matches(name, siblings, n=1)]
    if meant := close or [path for path in known if path[-1] == key[-1]]:
        return f"is not a known key. Did you mean {' or '.join(map(dotted, meant))}?"
    return f"is not a known key. Known here: {', '.join(siblings)}."


def _hint(value: Any, kind: str) -> str:
    """Return the remedy where YAML reads a text as a number or a date, or a number as a text."""
    if kind == "string_type" and type(value) in (int, float, date):
        return f' Quote it: "{value}".'
    text = value.replace(",", ".") if isinstance(value, str) else ""
    if kind not in ("int_type", "float_type") or not _NUMBER.fullmatch(text):
        return ""
    number = float(text)
    number = int(number) if kind == "int_type" and number.is_integer() else number
    written = yaml.safe_dump(number).split()[0]
    if not isinstance(yaml.safe_load(value), str):
        return f" Quotes, and sections in --config, make texts; in a file, write {written}."
    return f" YAML reads {value} as a text; write {written}."
