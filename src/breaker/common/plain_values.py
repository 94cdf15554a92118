"""Documents as JSON, and back: dataclasses of plain numbers, alike in every rendering."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from types import NoneType
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np


@dataclass(frozen=True)
class Plain:
    """A part of a document. A value whose default is None is left out of JSON where it is None."""

    def plain(self) -> dict:
        """Return the values by name, parts among them as they are."""
        pairs = ((each, getattr(self, each.name)) for each in fields(self))
        return {each.name: v for each, v in pairs if v is not None or each.default is not None}


def of_plain(kind: Any, value: Any) -> Any:
    """Return what JSON has of a value or document of a kind as that kind again.

    >>> from dataclasses import make_dataclass
    >>> Row = make_dataclass("Row", [("sd", float)], bases=(Plain,), frozen=True)
    >>> of_plain(Sequence[Row], [{"sd": 0.5}])
    [Row(sd=0.5)]
    """
    origin, inner = get_origin(kind), get_args(kind)
    if value is None or (inner and NoneType in inner):
        kinds = [each for each in inner if each is not NoneType]
        return value if value is None or len(kinds) > 1 else of_plain(kinds[0], value)
    if origin is Mapping:
        return {key: of_plain(inner[1], each) for key, each in value.items()}
    if origin is Sequence:
        return [of_plain(inner[0], each) for each in value]
    if not isinstance(kind, type):
        return value
    if issubclass(kind, tuple) and hasattr(kind, "_fields"):
        return kind(*value)
    if issubclass(kind, Plain):
        hints = get_type_hints(kind)  # what JSON has beside follows from these
        return kind(
            **{name: of_plain(of, value[name]) for name, of in hints.items() if name in value}
        )
    return value


def plainly(value: object) -> object:
    """A number, flag, text, or array or document of them as JSON has it, numbers to six digits.

    >>> plainly({"sd": np.array([2.0 / 3.0, np.nan])})
    {'sd': [0.666667, None]}
    """
    if isinstance(value, Plain):
        return replace(value, **{e.name: plainly(getattr(value, e.name)) for e in fields(value)})
    if isinstance(value, Mapping):
        return {key: plainly(each) for key, each in value.items()}
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [plainly(each) for each in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return float(f"{value:.6g}") if np.isfinite(value) else None
    return value


def to_json(document: object) -> str:
    """Return a document as JSON."""
    return json.dumps(document, default=lambda part: part.plain())
