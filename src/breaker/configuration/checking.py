"""Problems of a configuration: keys with wrong values, and the allowed values.

The classes in ``settings`` define types and bounds. Only a check imports pydantic.
"""

import json
import re
from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from breaker.configuration.settings import Section

_NO_NAME = "is not a key: write decimal numbers with a point, such as 1.3, and quote texts."


def problems(section: type[Section], content: Any) -> dict[str, str]:
    """Return problems in the content of a section by key; a text continues after the key."""
    wrong: dict[str, str] = {}
    try:
        section.model_validate(content)
    except ValidationError as error:
        for failure in error.errors(include_url=False):
            if failure["type"] == "missing" and failure["loc"][0] == "by_motion":
                continue  # by_motion contains only differing settings
            key, text = _problem(failure, content)
            if key not in wrong:
                wrong[key] = text
            elif (
                wrong[key] != _NO_NAME
            ):  # a value with several allowed types has one error per type
                wrong[key] += f" Or it {text.partition(': ')[2]}"
    return wrong


def _problem(failure: Mapping, content: Any) -> tuple[str, str]:
    """Return the key of an error of pydantic, and the problem of its value in words."""
    place, kind = failure["loc"], failure["type"]
    words = failure["msg"].removeprefix("Value error, ").partition(" or instance of")[0]
    words = re.sub("^(Input|String|List|Dictionary) should", "must", words)
    words = words.replace("valid string", "text").replace("valid dictionary", "section")
    words = words.removesuffix(".") + "."
    if kind in ("missing", "extra_forbidden"):
        return dotted(place), "is missing." if kind == "missing" else "is not a known key."
    if kind == "invalid_key" or place[-1] == "[key]":
        is_text = kind not in ("invalid_key", "string_type")
        key = dotted(place[: -(place[-1] == "[key]") or None])
        return key, f"is not a known key: {words}" if is_text else _NO_NAME
    length, value = 0, content
    for part in place:  # after the key, pydantic appends the type that it tried
        try:
            value = value[part]
        except (KeyError, IndexError, TypeError):
            break
        length += 1
    shown = json.dumps(value, ensure_ascii=False, default=str, skipkeys=True)
    shown = f"{shown[:57]}..." if len(shown) > 60 else shown
    return dotted(place[:length]), f"is {shown}: {words}"


def dotted(key: tuple[str | int, ...]) -> str:
    """Write a key as ``network.summary.kernels[0]``."""
    parts = (f"[{part}]" if type(part) is int else f".{part}" for part in key)
    return "".join(parts).removeprefix(".")
