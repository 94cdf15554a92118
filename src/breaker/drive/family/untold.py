"""Why changes of parameters are not told, in words that every page has.

>>> f"No parameter is told: {APART}"
'No parameter is told: closing and opening contradict each other'
"""

WITHHELD = "the drive is of no family that ships"
BEYOND = "the change is larger than any wear that the networks know"
APART = "closing and opening contradict each other"
UNLIKE = "the visits were measured differently"


def as_sentence(words: str) -> str:
    """Return words with a capital letter, as a sentence begins."""
    return words[:1].upper() + words[1:]
