"""Names, symbols and numbers as all figures write them."""

import re

import numpy as np

from breaker.mechanism import ONSET, PARAMETERS

__all__ = ["literal", "number", "symbolic"]

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


def number(value: float) -> str:
    """Write a number with three digits that count; large whole ones in groups of three.

    >>> [number(each) for each in (0.76543, 12.0, 1904.4, -0.5, float("inf"))]
    ['0.765', '12', '1,900', '−0.5', 'beyond']
    """
    if not np.isfinite(value):
        return "not known" if np.isnan(value) else "beyond"
    rounded = float(f"{value:.3g}")
    return (f"{rounded:.3g}" if abs(rounded) < 1000 else f"{rounded:,.0f}").replace("-", "−")
