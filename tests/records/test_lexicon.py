"""Words of makers are patterns for text in lower case."""

import re

import pytest

from breaker.records import lexicon

GROUPS = ("columns", "motion_words", "labels", "stated", "rate_words", "results")
WORDS = [
    (language, words)
    for group in GROUPS
    for by_language in lexicon.WORDS[group].values()
    for language, words in by_language.items()
]


@pytest.mark.parametrize(("language", "words"), WORDS)
def test_words_are_for_text_in_lower_case(language, words):
    re.compile(words)
    assert re.sub(r"\\.", "", words) == re.sub(r"\\.", "", words).lower()
    assert all(re.fullmatch("[a-z]{2}", each) for each in language.split())
