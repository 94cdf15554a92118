"""Names and symbols as all figures write them; ``breaker.decisions.about`` writes numbers."""

import re

from breaker.mechanism import ONSET, PARAMETERS

__all__ = ["literal", "symbolic"]

_SYMBOLS = {each.name: each.symbol for each in (*PARAMETERS, ONSET)}
_NAMES = re.compile(rf"\b({'|'.join(_SYMBOLS)})\b")


def literal(text: object) -> str:
    """Return a text, with names that a user gave, without signs of mathematics.

    >>> literal("5 $ or more")
    '5 \\\\$ or more'
    """
    return str(text).replace("$", r"\$")


def symbolic(text: object) -> str:
    r"""Return a literal text with parameters by their symbols, as panels name them.

    >>> symbolic("touch_time above 9.7 ms and f below 0.765 mm/ms²")
    'touch_time above 9.7 ms and $f$ below 0.765 mm/ms²'
    """
    return _NAMES.sub(lambda found: _SYMBOLS[found.group()], literal(text))
