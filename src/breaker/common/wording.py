"""Sentences from templates of one YAML file; a sentence keeps its code and values."""

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import yaml


class Sentence(str):
    """A sentence with the code of its template and the values in it.

    Tests and programs look at ``code`` and ``values``; the words may be edited freely.
    """

    __slots__ = ("code", "values")

    def __new__(cls, text: str, code: str, values: Mapping[str, Any]) -> "Sentence":
        """Return a sentence of a template."""
        sentence = super().__new__(cls, text)
        sentence.code, sentence.values = code, dict(values)
        return sentence


class Wording:
    """Templates of a file, ``code: text with {values}``; sections of the file only group them.

    Args:
        file: YAML file with templates below the names of sections.
    """

    def __init__(self, file: Path) -> None:
        self.file = file

    @cached_property
    def templates(self) -> dict[str, str]:
        """Templates by code."""
        sections = yaml.safe_load(self.file.read_text(encoding="utf-8"))
        return {code: text for section in sections.values() for code, text in section.items()}

    def say(self, code: str, **values: Any) -> Sentence:
        """Return the sentence of a code; a KeyError names a code or value that is missing."""
        return Sentence(self.templates[code].format(**values), code, values)
