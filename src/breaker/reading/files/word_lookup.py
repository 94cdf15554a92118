"""Looks words of makers up in the lexicon. Light to import: words are compiled when looked for."""

import re
from collections.abc import Callable, Mapping
from functools import cache, lru_cache

from breaker.reading.files.lexicon import COLUMNS

_LONGEST = 200  # signs of a text that is remembered


def any_of(words: Mapping[str, str]) -> str:
    """Return one regular expression for words of all languages, for text in lower case."""
    return f"(?:{'|'.join(words.values())})"


@cache
def _compiled(*words: str) -> re.Pattern:
    return re.compile("|".join(words))


def says(text: str, words: Mapping[str, str]) -> bool:
    """Say whether a text has any of some words, by language, in any case.

    >>> says("Hauptkontakt 1", COLUMNS["contact"]), says("Hub", COLUMNS["contact"])
    (True, False)
    """
    return _compiled(*words.values()).search(text.lower()) is not None


def holds(name: str, kind: str) -> bool:
    """Say whether a column holds a kind of ``lexicon.COLUMNS``, by its name."""
    return says(name, COLUMNS[kind])


def by_words(table: Mapping[str, Mapping[str, str]]) -> Callable[[str], tuple[str, ...]]:
    r"""Return a function that says which meanings of a table a text has, by words for each. Files
    of a folder have the same names, so that it remembers them.

    >>> by_words({"station": {"en": r"\bstation"}, "date": {"en": r"\bdat[ea]\b"}})("Test Date")
    ('date',)
    """

    @lru_cache(maxsize=2048)
    def meant(text: str) -> tuple[str, ...]:
        return tuple(meaning for meaning, words in table.items() if says(text, words))

    return lambda text: (meant if len(text) <= _LONGEST else meant.__wrapped__)(text)
