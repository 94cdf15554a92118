"""Which motions a text names, in the languages of makers. Light to import."""

import re
from collections.abc import Mapping

from breaker.reading.files.lexicon import FOREIGN_LETTERS, LETTERS, MOTION_WORDS
from breaker.reading.files.word_lookup import any_of, by_words


def _whole(words: Mapping[str, str]) -> dict[str, str]:
    """Words that stand alone, and signs that stand within others."""
    alone = any_of({language: each for language, each in words.items() if language != "zh"})
    return {"alone": rf"(?<![^\W\d_]){alone}(?![^\W\d_])", "within": words["zh"]}


motions_in = by_words({motion: _whole(words) for motion, words in MOTION_WORDS.items()})
"""The motions that words of a text name."""

MOTION_OF = {"C": "closing", "O": "opening"}
"""Motions by their letters in a sequence."""

_LETTERS = {sign: letter for letter, motion in MOTION_OF.items() for sign in LETTERS[motion]}
_FOREIGN = {
    sign: letter for letter, motion in MOTION_OF.items() for sign in FOREIGN_LETTERS[motion]
}


def motion_of(text: str) -> str:
    """Return the motion that a text names, empty where it names none, or both.

    >>> motion_of("Ausschaltweg"), motion_of("V closing (m/s)"), motion_of("C speed")
    ('opening', 'closing', 'closing')
    """
    letter = re.match(r"\s*([CO])\b", text)
    said = motions_in(text) or (letter and (MOTION_OF[letter[1]],)) or ()
    return said[0] if len(said) == 1 else ""


def sequence_of(text: str) -> str:
    """Return the motions of an operation that a text states, in their order.

    >>> sequence_of("O-0.3s-CO"), sequence_of("Closing"), sequence_of("AUS - EIN")
    ('O-C-O', 'C', 'O-C')
    """
    words = re.findall(r"[^\W\d_]+", text.lower())
    letters = _LETTERS | (_FOREIGN if max(map(len, words), default=0) == 1 else {})
    parts = (part for w in words for part in (w if {*w} <= {*_LETTERS} else [w]))
    initials = {motion: letter for letter, motion in MOTION_OF.items()}
    said = (letters.get(part) or initials.get(motion_of(part), "") for part in parts)
    return "-".join(filter(None, said))
