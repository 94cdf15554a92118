"""Documents as JSON: dataclasses of plain numbers, the same in all renderings."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np


@dataclass(frozen=True)
class Plain:
    """A part of a document. JSON omits values of None that have the default None."""

    def plain(self) -> dict:
        """Return the values by name, with parts unchanged."""
        pairs = ((field, getattr(self, field.name)) for field in fields(self))
        return {field.name: v for field, v in pairs if v is not None or field.default is not None}


@dataclass(frozen=True)
class Note(Plain):
    """A sentence and its code for programs; the code may be empty."""

    code: str
    text: str

    def __str__(self) -> str:
        """Return the sentence."""
        return self.text


def note_of(text: str) -> Note | None:
    """Return a sentence, such as a ``Sentence``, with its code; None for an empty text."""
    return Note(getattr(text, "code", ""), str(text)) if text else None


def plainly(value: object) -> object:
    """Return a number, text, array or document as values for JSON, numbers to six digits."""
    if isinstance(value, Plain):
        return replace(value, **{e.name: plainly(getattr(value, e.name)) for e in fields(value)})
    if isinstance(value, Mapping):
        return {key: plainly(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [plainly(item) for item in value]
    if isinstance(value, float):
        return float(f"{value:.6g}") if np.isfinite(value) else None
    return value


def to_json(document: object) -> str:
    """Return a document as JSON."""
    return json.dumps(document, default=lambda part: part.plain())
