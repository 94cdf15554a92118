"""Sentences of a diagnosis: ``say(code, **values)``, from the templates in ``sentences.yaml``."""

from functools import cache
from pathlib import Path
from typing import Any

import yaml


class Sentence(str):
    """A sentence with the code of its template and its values; its words may be edited freely."""

    code: str
    values: dict[str, Any]


@cache
def _templates() -> dict[str, str]:
    """Templates by code; sections of the file only group them."""
    sections = yaml.safe_load(Path(__file__).with_suffix(".yaml").read_text(encoding="utf-8"))
    return {code: text for section in sections.values() for code, text in section.items()}


def say(code: str, **values: Any) -> Sentence:
    """Return the sentence of a code; a KeyError names a code or value that is missing."""
    sentence = Sentence(_templates()[code].format(**values))
    sentence.code, sentence.values = code, values
    return sentence
