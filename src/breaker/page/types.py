"""Limits and speed zones that a user sets on the page: the file of types of breaker.

Commands and fleets use the same file, by ``types`` of the configuration.
"""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from breaker.common.text import bare
from breaker.configuration.definitions import types_of
from breaker.configuration.loading import ConfigurationError
from breaker.records.files import read_bytes


def read_types(file: str, config: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the entries of a file of types; none if there is no file.

    Raises:
        ConfigurationError: If an entry is wrong.
    """
    return types_of({**config, "types": file}) if os.path.exists(file) else {}


def set_of_type(
    file: str, config: Mapping[str, Any], name: str, key: str, ends: Sequence[str]
) -> None:
    """Set a value of a type's entry, such as ``limits.closing stroke`` from "170" to "184", or a
    zone of ``speeds``; empty ends remove it.

    Raises:
        ConfigurationError, ValueError: If the value is wrong; nothing is written.
        OSError: If the file cannot be written.
    """
    section, _, quantity = key.partition(".")
    if not name.strip() or section not in ("limits", "speeds") or not quantity:
        raise ValueError("name the type of the breaker first, then set its limits")
    types = read_types(file, config)
    name = next((known for known in types if bare(known) == bare(name)), name.strip())
    entries = types.setdefault(name, {}).setdefault(section, {})
    entries[quantity] = [_number(end) for end in ends]
    if entries[quantity] == [None] * len(ends):
        del entries[quantity]
    _write(file, config, types)


def _number(text: str) -> float | str | None:
    """Return a text as a number if possible; None if empty."""
    try:
        return float(text.replace(",", "."))
    except ValueError:
        return text.strip() or None


def _write(file: str, config: Mapping[str, Any], types: Mapping[str, Any]) -> None:
    """Check and write types; keep the previous file as ``.before``."""
    part, text = Path(f"{file}.new"), yaml.safe_dump(types, sort_keys=False, allow_unicode=True)
    try:
        part.write_text(text, encoding="utf-8")
        try:
            types_of({**config, "types": str(part)})
        except ConfigurationError as error:
            raise ConfigurationError(str(error).replace(f"{part}: ", "")) from error
        if os.path.exists(file):  # its comments are not kept
            Path(f"{file}.before").write_bytes(read_bytes(file))
        os.replace(part, file)
    finally:
        part.unlink(missing_ok=True)
