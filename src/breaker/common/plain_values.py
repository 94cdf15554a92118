"""Documents as JSON: dataclasses of plain numbers, alike in every rendering."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np


@dataclass(frozen=True)
class Plain:
    """A part of a document. A value whose default is None is left out of JSON where it is None."""

    def plain(self) -> dict:
        """Return the values by name, parts among them as they are."""
        pairs = ((field, getattr(self, field.name)) for field in fields(self))
        return {field.name: v for field, v in pairs if v is not None or field.default is not None}


@dataclass(frozen=True)
class Note(Plain):
    """A sentence and its code, for which programs look; the code is empty where it has none."""

    code: str
    text: str

    def __str__(self) -> str:
        """Return the sentence."""
        return self.text


def note_of(text: str) -> Note | None:
    """Return a sentence, such as a ``Sentence``, with its code; None of an empty text."""
    return Note(getattr(text, "code", ""), str(text)) if text else None


def plainly(value: object) -> object:
    """Return a number, text, array or document of them as JSON has it, numbers to six digits."""
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
