"""Root of a function between two places, by Brent's method.

Brent (1973), "Algorithms for Minimization without Derivatives", ch. 4: inverse quadratic
interpolation where it converges, bisection where it does not. Written out here, step by step as
``scipy.optimize.brentq``, which it equals to the last bit: to import that takes a tenth of the time
of a first answer.
"""

from collections.abc import Callable
from math import inf

__all__ = ["root_between"]

_STEPS = 100


def root_between(
    function: Callable[[float], float], low: float, high: float, *, xtol: float, rtol: float
) -> float:
    """Return where a function is 0.

    Args:
        function: Continuous, of other sign at ``low`` than at ``high``.
        low, high: The two places.
        xtol, rtol: The root is right to ``xtol + rtol * |root|``.

    Raises:
        ValueError: If the signs are alike.
        ArithmeticError: If 100 steps are too few.

    Example:
        >>> round(root_between(lambda x: x**2 - 2.0, 0.0, 2.0, xtol=1e-12, rtol=1e-12), 9)
        1.414213562
    """
    # The last two places, and one where the function has the other sign than at the last.
    before, last, across = low, high, low
    at_before, at_last, at_across = function(low), function(high), 0.0
    if at_before == 0.0 or at_last == 0.0:
        return low if at_before == 0.0 else high
    if (at_before < 0) == (at_last < 0):
        raise ValueError(f"the function has the same sign at {low:g} and {high:g}")
    step = step_before = high - low
    for _ in range(_STEPS):
        if (at_before < 0) != (at_last < 0):
            across, at_across = before, at_before
            step = step_before = last - before
        if abs(at_across) < abs(at_last):
            before, last, across = last, across, last
            at_before, at_last, at_across = at_last, at_across, at_last
        least, half = (xtol + rtol * abs(last)) / 2, (across - last) / 2
        if at_last == 0.0 or abs(half) < least:
            return last
        tried = inf
        if abs(step_before) > least and abs(at_last) < abs(at_before):
            tried = _interpolated(before, last, across, at_before, at_last, at_across)
        if 2 * abs(tried) < min(abs(step_before), 3 * abs(half) - least):
            step_before, step = step, tried
        else:
            step_before = step = half
        before, at_before = last, at_last
        last += step if abs(step) > least else (least if half > 0 else -least)
        at_last = function(last)
    raise ArithmeticError(f"no root was found in {_STEPS} steps, the last at {last:g}")


def _interpolated(
    before: float, last: float, across: float, at_before: float, at_last: float, at_across: float
) -> float:
    """Step from the last place to the root, by the line or the parabola through the places."""
    if before == across:
        return -at_last * (last - before) / (at_last - at_before)
    slope = (at_before - at_last) / (before - last)
    slope_across = (at_across - at_last) / (across - last)
    across_part = at_across * slope_across - at_before * slope
    return -at_last * across_part / (slope_across * slope * (at_across - at_before))
