"""Curves from the steps of an integration: at any times, and where a share of the way is passed.

A step is a row: its begin and length, ms, and six coefficients of the reading in powers of the
share of the step, mm. Nothing here knows of the forces behind them.
"""

import numpy as np

from breaker.mechanism import compiled

__all__ = ["passing", "sampled"]

_fast = compiled()
_HALVINGS = 50


@_fast
def _within(step, u):
    """Reading at a share of a step."""
    value = step[7]
    for i in range(6, 1, -1):
        value = step[i] + u * value
    return value


@_fast
def sampled(steps, times):
    """Reading at rising times, ``(t,)``, mm; at rest before the first step."""
    result, i = np.empty(times.size), 0
    for j in range(times.size):
        while i < len(steps) - 1 and times[j] > steps[i, 0] + steps[i, 1]:
            i += 1
        result[j] = _within(steps[i], max(0.0, times[j] - steps[i, 0]) / steps[i, 1])
    return result


@_fast
def passing(steps, level):
    """Time at which the reading first is a level, ms; nan if at no step's end it is past it."""
    if not len(steps):
        return np.nan
    sign = 1.0 if level > steps[0, 2] else -1.0
    for step in steps:
        if sign * (_within(step, 1.0) - level) >= 0.0:
            low, high = 0.0, 1.0
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                if sign * (_within(step, middle) - level) < 0.0:
                    low = middle
                else:
                    high = middle
            return step[0] + high * step[1]
    return np.nan
