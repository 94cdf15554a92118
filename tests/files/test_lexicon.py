"""Words of makers are patterns for text in lower case."""

import re

import pytest

from breaker.reading.files import lexicon

GROUPS = ("COLUMNS", "MOTION_WORDS", "LABELS", "STATED", "RATE_WORDS", "RESULTS")
WORDS = [
    (language, words)
    for group in GROUPS
    for by_language in getattr(lexicon, group).values()
    for language, words in by_language.items()
]


@pytest.mark.parametrize(("language", "words"), WORDS)
def test_words_are_for_text_in_lower_case(language, words):
    re.compile(words)
    assert re.sub(r"\\.", "", words) == re.sub(r"\\.", "", words).lower()
    assert all(re.fullmatch("[a-z]{2}", each) for each in language.split())
