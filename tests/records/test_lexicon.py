"""Words of makers are patterns for text in lower case."""

import re

import pytest

from breaker.records.words import WORDS

GROUPS = ("columns", "motion_words", "labels", "stated", "rate_words")
SPELT = [item for group in GROUPS for by in WORDS[group].values() for item in by.items()]


@pytest.mark.parametrize(("language", "spelt"), SPELT)
def test_words_are_for_text_in_lower_case(language, spelt):
    re.compile(spelt)
    assert re.sub(r"\\.", "", spelt) == re.sub(r"\\.", "", spelt).lower()
    assert all(re.fullmatch("[a-z]{2}", item) for item in language.split())
