"""Limits that a user sets on the page: the file of types of breaker.

Commands and fleets use the same file, by ``types`` of the configuration.
"""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from breaker.common.clean_text import bare
from breaker.configuration.data_files import types_of
from breaker.configuration.loading import ConfigurationError


def read_types(file: str, config: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the entries of a file of types; none if there is no file.

    Raises:
        ConfigurationError: If an entry is wrong.
    """
    return types_of({**config, "types": file}) if os.path.exists(file) else {}


def set_limit(
    file: str, config: Mapping[str, Any], name: str, quantity: str, low: str, high: str
) -> None:
    """Set the limit of a type on a quantity, such as "closing stroke" from "170" to "184". Two
    empty texts remove it. The previous file is kept as ``.before``, as its comments are lost.

    Raises:
        ConfigurationError, ValueError: If the value is wrong; nothing is written.
        OSError: If the file cannot be written.
    """
    if not name:
        raise ValueError("a limit belongs to a type of breaker. Name the type, then set the limit.")
    types = read_types(file, config)
    name = next((known for known in types if bare(known) == bare(name)), name)
    limits = types.setdefault(name, {}).setdefault("limits", {})
    limits[quantity] = [_number(low), _number(high)]
    if limits[quantity] == [None, None]:
        del limits[quantity]
    part = Path(f"{file}.new")
    try:
        part.write_text(yaml.safe_dump(types, sort_keys=False, allow_unicode=True), "utf-8")
        types_of({**config, "types": str(part)})
        if os.path.exists(file):
            os.replace(file, f"{file}.before")
        os.replace(part, file)
    except ConfigurationError as error:
        raise ConfigurationError(str(error).replace(f"{part}: ", "")) from error
    finally:
        part.unlink(missing_ok=True)


def _number(text: str) -> float | str | None:
    """Return a text as a number if possible; None if empty."""
    try:
        return float(text.replace(",", "."))
    except ValueError:
        return text or None
