"""The configuration that commands share."""

import json
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from breaker.common.visible_text import say
from breaker.configuration.loading import load, read
from breaker.shipped import DEFAULTS

ADVANCED = Path("config/advanced.yaml")
PROJECT = Path("config/config.yaml")
"""Where the workflow's configuration is, from the project's folder; the second over the first."""

_LONGEST = 60  # signs of a value in a message


def settings_of(overlays: Sequence[str], more: Sequence[str] = ()) -> dict:
    """The configuration: overlays, and more, over that of the folder, or over the defaults that
    ship. What one of them sets and a later one changes is printed; of overlays alone, without more.

    The defaults alone are not checked: tests do that, and it takes a tenth of the first answer.
    """
    own = [ADVANCED if ADVANCED.exists() else DEFAULTS, PROJECT] if PROJECT.exists() else [DEFAULTS]
    files = [*own, *overlays, *more]
    # Commands name the folders of records themselves.
    config = load(files, curves=False) if len(files) > 1 else read(DEFAULTS)
    stated: dict[str, tuple[str, str]] = {}
    for place, file in enumerate([*overlays, *more]):
        for key, value in _values(read(file)):
            before, old = stated.get(key, (file, value))
            if old != value and (place >= len(overlays) or not more):
                new, old = (textwrap.shorten(each, _LONGEST) for each in (value, old))
                said = f"note: {file}: {key} is {new}, in place of {old} of {before}"
                say(said, beside=True)
            stated[key] = (file, value)
    return config


def _values(section: Mapping, above: str = "") -> Iterator[tuple[str, str]]:
    """Keys of a section and of those in it, with points between, and their values as texts."""
    for key, value in section.items():
        if isinstance(value, Mapping):
            yield from _values(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", json.dumps(value, default=str, ensure_ascii=False)


def limits_of(config: Mapping, overlays: Sequence[str]) -> list:
    """The limits of the drive: those that ship are an example, and none unless they are asked for.

    They are where the configuration changes them, or an overlay names them.
    """
    named = any("limits" in read(path) for path in overlays)
    return config["limits"] if named or config["limits"] != read(DEFAULTS)["limits"] else []
