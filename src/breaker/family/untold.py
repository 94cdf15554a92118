"""Why changes of parameters are not told, in words that every page has.

>>> f"No parameter is told: {APART}"
'No parameter is told: closing and opening contradict each other'
"""

from collections.abc import Iterable, Mapping

WITHHELD = "the drive is of no family that ships"
BEYOND = "the change is larger than any wear that the networks know"
APART = "closing and opening contradict each other"
UNLIKE = "the visits were measured differently"


def as_sentence(words: str) -> str:
    """Return words with a capital letter, as a sentence begins."""
    return words[:1].upper() + words[1:]


LOOK = "Where to look first (no diagnosis)"
"""Title of the advice on what has become worse."""


def advice_on(names: Iterable[str], advice: Mapping[str, str]) -> list[str]:
    """Return where to look first for quantities that have become worse, equal advice once.

    Args:
        names: Quantities, parameters or additional effects. A speed without an entry has that of
            its motion.
        advice: Advice by name.

    Example:
        >>> advice_on(["f", "mu", "closing_speed_10_90"], {"f": "spring", "closing_speed": "latch"})
        ['f: spring', 'closing_speed_10_90: latch']
    """
    found: dict[str, list[str]] = {}
    for name in dict.fromkeys(names):
        motion, is_speed, _ = name.partition("_speed_")
        key = f"{motion}_speed" if is_speed and name not in advice else name
        if words := advice.get(key):
            found.setdefault(words, []).append(name)
    return [f"{', '.join(these)}: {words}" for words, these in found.items()]
