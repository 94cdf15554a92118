"""All words of makers stand in the lexicon, and in no other module."""

import ast
import re
from pathlib import Path

import pytest

from breaker.reading.files import lexicon

PACKAGE = Path(lexicon.__file__).resolve().parents[1]
READING = ("files", "inspection", "records", "answers", "cli")
GROUPS = ("COLUMNS", "MOTION_WORDS", "LABELS", "STATED", "RATE_WORDS", "RESULTS")
WORDS = [
    (language, words)
    for group in GROUPS
    for by_language in getattr(lexicon, group).values()
    for language, words in by_language.items()
]
FOREIGN = {
    word
    for language, words in WORDS
    if "en" not in language.split()
    for word in re.findall(r"[^\W\d_]{4,}", re.sub(r"\\.", " ", words))
} - {"tempo", "course"}  # names in code, too
PHASES = re.compile(r"\[[RYBSTACUVW]{5,}\]|L\[123\]", re.IGNORECASE)


def said_twice(text: str) -> list[str]:
    """Words of other languages, and letters of phases, in the code of a module: no docstrings."""
    tree = ast.parse(text)
    prose = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and node.body
        if isinstance(node.body[0], ast.Expr)
    }
    return [
        word
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in prose
        for word in [
            *(FOREIGN & {*re.findall(r"[^\W\d_]+", node.value.lower())}),
            *PHASES.findall(node.value),
        ]
    ]


def modules():
    return {
        str(file.relative_to(PACKAGE)): file.read_text(encoding="utf-8")
        for room in READING
        for file in sorted((PACKAGE / room).glob("*.py"))
        if file.name != "lexicon.py"
    }


def test_no_other_module_has_words_of_makers():
    assert {name: found for name, text in modules().items() if (found := said_twice(text))} == {}


@pytest.mark.parametrize("planted", ['r"coil|spule"', 'f"[RYBACSTUVW]{1}"', '"l[123]"'])
def test_a_word_elsewhere_is_found(planted):
    assert said_twice(f'"""Weg."""\nA = {planted}\n')


@pytest.mark.parametrize(("language", "words"), WORDS)
def test_words_are_for_text_in_lower_case(language, words):
    re.compile(words)
    assert re.sub(r"\\.", "", words) == re.sub(r"\\.", "", words).lower()
    assert all(re.fullmatch("[a-z]{2}", each) for each in language.split())
