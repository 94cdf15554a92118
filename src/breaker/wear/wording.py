"""Numbers in words, rounded alike wherever they stand: in tables, sentences and figures."""

import math

__all__ = ["about", "and_so_on", "in_percent", "span"]


def about(value: float) -> str:
    """Write a number of operations or days that is an estimate, to three digits.

    >>> about(1878.3), about(42.4), about(float("inf"))
    ('1,880', '42', 'beyond the horizon')
    """
    if not math.isfinite(value):
        return "unknown" if math.isnan(value) else "beyond the horizon"
    digits = max(0, math.floor(math.log10(max(value, 1.0))) - 2)
    return f"{round(value, -digits):,.0f}"


def span(low: float, high: float) -> str:
    """Write an interval of such numbers.

    >>> span(12.2, 1878.3)
    '12 to 1,880'
    """
    return f"{about(low)} to {about(high)}"


def in_percent(probability: float) -> str:
    """Write a probability; never 0 or 100 % of what is not certain.

    >>> in_percent(0.233), in_percent(0.9996), in_percent(0.001)
    ('23 %', '> 99 %', '< 1 %')
    """
    if probability < 0.01:
        return "< 1 %"
    return "> 99 %" if probability > 0.99 else f"{100 * probability:.0f} %"


def and_so_on(words: list[str], most: int) -> str:
    """List words, at most so many, and count the others.

    >>> and_so_on(["a", "b", "c"], 2)
    'a, b and 1 more'
    """
    more = len(words) - most
    return ", ".join(words) if more <= 0 else f"{', '.join(words[:most])} and {more} more"
