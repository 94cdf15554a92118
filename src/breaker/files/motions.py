"""Which motions a text names, in the languages of makers. Light to import."""

import re

from breaker.files.names import by_words

_WORD = r"(?<![^\W\d_])(?:{})(?![^\W\d_])|{}"  # a whole word, or signs that stand within words
_CLOSING = r"clos\w*|ein(?:schalt\w*)?|ferm\w*|enclench\w*|cierr\w*|chius\w*|вкл\w*"
_OPENING = r"open\w*|trip(?:s|ped|ping)?|aus(?:schalt\w*)?|ouvert\w*|déclench\w*|apert\w*|откл\w*"
motions_in = by_words(
    {"closing": _WORD.format(_CLOSING, "合[闸閘]"), "opening": _WORD.format(_OPENING, "分[闸閘]")}
)
"""The motions that words of a text name."""

_LETTERS = dict.fromkeys("c合", "C") | dict.fromkeys("o分", "O")
_FOREIGN = {"e": "C", "f": "C", "a": "O"}  # in a sequence of letters only
MOTION_OF = {"C": "closing", "O": "opening"}
"""Motions by their letters in a sequence."""


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
