"""Change detection on raw operating times, without a model of the drive.

From each record comes the time that the drive takes (``raw_time``). It wears as well, so what is
watched over the operations, online, is the residual of each from the line fitted to all before it,
in the sd of its prediction (recursive residuals, Brown, Durbin & Evans 1975). Of normal noise
around a line they are independent, Student t with two degrees of freedom less than values before.
A control chart makes a statistic of them, and an alarm is a statistic above a level:

- ``threshold``: the size of the residual (Shewhart);
- ``cusum``: the larger of the sums ``S = max(0, S ± residual - 0.5)`` (Page 1954);
- ``ewma``: the size of ``Z = 0.8 Z + 0.2 residual`` over its own sd (Roberts 1959).

After an alarm everything restarts from that operation: the statistic, and the fit with a new
warm-up of which it is the first value.

Shapes: ``n`` operations. They are counted by their position in the series, from 0. A NaN is an
operation without a value: only its position on the line counts.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from breaker.mechanism import compiled

__all__ = ["KINDS", "Watched", "level_for", "watch"]

KINDS = ("threshold", "cusum", "ewma")
_CUSUM, _EWMA = KINDS.index("cusum"), KINDS.index("ewma")
_SLACK = 0.5  # of the cusum, sd
_WEIGHT = 0.2  # of the newest residual in the ewma
_ROUND_OFF = 1e-12  # of a value: scatter below it is none

_compiled = compiled()


class Watched(NamedTuple):
    """A series as a control chart saw it, ``(n,)`` each.

    Attributes:
        residual: Residuals in their sd; NaN during a warm-up and where the series is NaN.
        statistic: The chart's statistic of the residuals, from 0; NaN where they are.
        alarm: Whether the statistic is above the level.
    """

    residual: np.ndarray
    statistic: np.ndarray
    alarm: np.ndarray


def watch(series: ArrayLike, kind: str, level: float, *, warm_up: int) -> Watched:
    """Watch a series online by a control chart.

    Args:
        series: Values, ``(n,)``, any unit; NaN where an operation has none.
        kind: "threshold", "cusum" or "ewma".
        level: Level of the statistic, from 0, above which it raises an alarm.
        warm_up: Values before the first residual, at least 3. The warm-up goes on for as long as
            the values do not scatter.

    Raises:
        ValueError: If an argument is out of its range, or a value infinite.

    Example:
        >>> series = [1.0, 1.1, 0.9, 1.0, 5.0, 5.1, 4.9]
        >>> watch(series, "threshold", 4.0, warm_up=3).alarm.nonzero()
        (array([4]),)
    """
    series = np.ascontiguousarray(series, dtype=float)
    if series.ndim != 1 or np.isinf(series).any():
        raise ValueError("a series must be (n,), of finite values and NaN")
    if not (warm_up >= 3 and level >= 0):
        raise ValueError("warm_up must be at least 3, and the level must not be negative")
    residual, statistic = np.empty((2, series.size))
    alarm = np.zeros(series.size, dtype=np.bool_)
    _watch(series, warm_up, KINDS.index(kind), float(level), residual, statistic, alarm)
    return Watched(residual, statistic, alarm)


def level_for(series: Sequence[ArrayLike], kind: str, rate: float, *, warm_up: int) -> float:
    """Return the lowest level that, like all higher ones, keeps the rate of false alarms.

    As alarms restart the fit, their number need not fall with the level everywhere; a bisection
    could end below a level at which it is too large again. So this goes down from no alarm: what
    is seen of a series changes only where the level passes its largest statistic without an alarm,
    and the first such value below which there are too many alarms is the level, exactly.

    Args:
        series: Series without a change, each ``(n,)``.
        rate: Largest number of alarms an operation, from 0. Every operation counts, those of a
            warm-up and those without a value too.
        kind, warm_up: As of ``watch``.

    Returns:
        The level; 0 if even that keeps the rate.
    """
    operations = sum(len(each) for each in series)
    if not (operations and rate >= 0):
        raise ValueError("there must be operations, and the rate must not be negative")
    allowed = np.floor(rate * operations * (1 + 1e-12))  # 1e-4 of 30,000 is 3

    def just_below(each: ArrayLike, level: float) -> tuple[float, int]:
        """Largest statistic of a series without an alarm below a level, and its alarms there."""
        _, statistic, alarm = watch(each, kind, np.nextafter(level, 0.0), warm_up=warm_up)
        silent = statistic[~alarm & ~np.isnan(statistic)]
        return silent.max(initial=0.0), int(alarm.sum())

    largest, alarms = np.array([just_below(each, np.inf) for each in series]).T
    while (level := largest.max()) > 0:
        k = largest.argmax()
        largest[k], alarms[k] = just_below(series[k], level)
        if alarms.sum() > allowed:
            return float(level)
    return 0.0


# ---- compiled --------------------------------------------------------------------------------
# A fit is: number of values, mean position, mean value, sum of squares of positions, sum of
# products, sum of squared recursive residuals (Brown, Durbin & Evans 1975: all that it takes).


@_compiled
def _watch(values, warm_up, kind, level, residual, statistic, alarm):
    """Go through a series: fill in residuals, statistics and alarms, restart after each alarm."""
    fit = np.zeros(6)
    state = np.zeros(3)  # number of residuals, and what the kind keeps
    for i in range(values.size):
        residual[i] = statistic[i] = np.nan
        if np.isnan(values[i]):
            continue
        residual[i] = _residual(fit, i, values[i], warm_up)
        if not np.isnan(residual[i]):
            statistic[i] = _advance(state, residual[i], kind)
            if statistic[i] > level:
                alarm[i] = True
                state[:] = 0.0
                fit[:] = 0.0
        _absorb(fit, i, values[i])


@_compiled
def _expected(fit, position):
    """Value that a fit of at least two values expects, and its variance over the noise's."""
    count, middle, mean, square, product, _ = fit
    away = position - middle
    return mean + product / square * away, 1 / count + away * away / square


@_compiled
def _residual(fit, position, value, warm_up):
    """Residual of the next value in its sd; NaN during the warm-up."""
    if fit[0] < warm_up:
        return np.nan
    sd = np.sqrt(fit[5] / (fit[0] - 2))
    if sd <= _ROUND_OFF * abs(fit[2]):
        return np.nan
    expected, variance = _expected(fit, position)
    return (value - expected) / (sd * np.sqrt(1 + variance))


@_compiled
def _absorb(fit, position, value):
    """Add a value to a fit."""
    if fit[0] >= 2:
        expected, variance = _expected(fit, position)
        fit[5] += (value - expected) ** 2 / (1 + variance)
    fit[0] += 1
    away, off = position - fit[1], value - fit[2]
    fit[1] += away / fit[0]
    fit[2] += off / fit[0]
    fit[3] += away * (position - fit[1])
    fit[4] += away * (value - fit[2])


@_compiled
def _advance(state, residual, kind):
    """Take in a residual and return the statistic."""
    state[0] += 1
    if kind == _CUSUM:
        state[1] = max(0.0, state[1] + residual - _SLACK)
        state[2] = max(0.0, state[2] - residual - _SLACK)
        return max(state[1], state[2])
    if kind == _EWMA:
        state[1] += _WEIGHT * (residual - state[1])
        left = 1 - (1 - _WEIGHT) ** (2 * state[0])
        return abs(state[1]) / np.sqrt(_WEIGHT / (2 - _WEIGHT) * left)
    return abs(residual)
