"""Change detection on raw operating times: what is done without a model of the drive.

From each record comes the time that the drive takes (``raw_time``). It wears as well, so what is
watched over the operations, online, is the residual of each from the line fitted to all before it
(recursive residuals, Brown, Durbin & Evans 1975), or, classically, from mean and standard deviation
of the warm-up. Three control charts watch residuals; an alarm is a statistic above a level:

- ``threshold``: their size (Shewhart), setting ``run``: so many in a row, all on one side;
- ``cusum``: their two-sided cumulative sum (Page 1954), setting ``slack``;
- ``ewma``: their exponentially weighted mean (Roberts 1959), setting ``weight``.

Shapes: ``n`` operations, ``t`` samples. Operations are counted by their position in the series,
from 0. A NaN is an operation without a value: it takes its place on the line, nothing else.
Arguments out of their range raise ValueError, and so do infinite values and wrong shapes.
"""

from collections.abc import Sequence
from heapq import heapify, heapreplace

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

__all__ = [
    "SETTINGS",
    "alarms",
    "cusum",
    "ewma",
    "level_for",
    "monitor",
    "residuals",
    "threshold",
]

SETTINGS = {"threshold": ("run", 1), "cusum": ("slack", 0.5), "ewma": ("weight", 0.2)}
_KINDS = tuple(SETTINGS)
_THRESHOLD, _CUSUM, _EWMA = range(3)
_AS_THEY_ARE, _MEAN, _LINE = range(3)  # parameters of what residuals are from
_ROUND_OFF = 1e-12  # of a value: scatter below it is none

_compiled = njit(cache=True, error_model="numpy")


# ---- residuals and their statistics ----------------------------------------------------------


def residuals(series: ArrayLike, *, warm_up: int, detrend: bool = True) -> np.ndarray:
    """Return how far each value is from what those before it predict, ``(n,)``, in its sd.

    Of normal noise around a line they are independent, Student t with two degrees of freedom less
    than values before.

    Args:
        series: Values, ``(n,)``, any unit; NaN where an operation has none.
        warm_up: Values before the first residual, at least 3. The warm-up goes on for as long as
            the values do not scatter.
        detrend: Whether residuals are from the line fitted to all values before, in the sd of its
            prediction; else from the mean of the warm-up, in its sd (of the values, ``n - 1``).

    Returns:
        Residuals; NaN during the warm-up and where the series is NaN.
    """
    return _run(_checked(series), **_fit(warm_up, detrend))[0]


def threshold(residuals: ArrayLike, *, run: int = 1) -> np.ndarray:
    """Return the size that the last ``run`` residuals all have, on one side, ``(n,)``, from 0.

    With a run of 1, their absolute value. NaN where a residual is, which breaks no run.
    """
    return _statistic(residuals, "threshold", {"run": run})


def cusum(residuals: ArrayLike, *, slack: float = 0.5) -> np.ndarray:
    """Return the larger of the two one-sided cumulative sums, ``(n,)``, from 0.

    ``S = max(0, S + residual - slack)``, and the same of the negative residuals; without a reset.
    NaN where a residual is, which is left out.
    """
    return _statistic(residuals, "cusum", {"slack": slack})


def ewma(residuals: ArrayLike, *, weight: float = 0.2) -> np.ndarray:
    """Return the size of the exponentially weighted mean, ``(n,)``, from 0, in its own sd.

    ``Z = (1 - weight) Z + weight residual`` from 0, over the sd that it has after so many
    residuals of unit variance; without a reset. NaN where a residual is, which is left out.
    """
    return _statistic(residuals, "ewma", {"weight": weight})


def alarms(residuals: ArrayLike, kind: str, level: float, **settings: float) -> np.ndarray:
    """Return where the statistic of given residuals passes a level, ``(k,)`` positions.

    After an alarm the statistic restarts with the next residual; the residuals stay as they are.

    Args:
        residuals: Residuals, ``(n,)``; NaN are left out.
        kind: "threshold", "cusum" or "ewma".
        level: Level, from 0, in units of the statistic.
        settings: The setting of the kind: ``run``, ``slack`` or ``weight``.
    """
    return _alarms(residuals, level, chart=_chart(kind, settings))


def monitor(
    series: ArrayLike,
    kind: str,
    level: float,
    *,
    warm_up: int,
    detrend: bool = True,
    **settings: float,
) -> np.ndarray:
    """Return the alarms of a series watched online, ``(k,)`` positions.

    After an alarm everything restarts from that operation: the statistic, and the fit with a new
    warm-up of which it is the first value. Arguments as of ``residuals`` and ``alarms``.
    """
    return _alarms(series, level, **_fit(warm_up, detrend), chart=_chart(kind, settings))


def level_for(
    series: Sequence[ArrayLike],
    kind: str,
    rate: float,
    *,
    warm_up: int,
    detrend: bool = True,
    **settings: float,
) -> float:
    """Return the least level from which on upwards the rate of false alarms is kept.

    As alarms restart the fit, their number need not fall with the level everywhere; a bisection
    could end below a level at which it is too large again. So this goes down from no alarm: what
    is seen of a series changes only where the level passes its largest statistic without an alarm,
    and the first such value below which there are too many alarms is the level, exactly.

    Args:
        series: Series without a change, each ``(n,)``.
        rate: Largest number of alarms an operation, from 0. Every operation counts, those of a
            warm-up and those without a value too.
        kind, warm_up, detrend, settings: As of ``monitor``.

    Returns:
        The level; 0 if even that keeps the rate.
    """
    series = [_checked(each) for each in series]
    operations = sum(each.size for each in series)
    if not (operations and rate >= 0):
        raise ValueError("there must be operations, and the rate must not be negative")
    allowed = np.floor(rate * operations * (1 + 1e-12))  # 1e-4 of 30,000 is 3
    watch = _fit(warm_up, detrend) | {"chart": _chart(kind, settings)}

    def just_below(level: float, k: int) -> tuple[float, int, int]:
        """Largest statistic without an alarm, negative for the heap, series, and its alarms."""
        _, statistic, alarmed = _run(series[k], **watch, level=np.nextafter(level, 0.0))
        silent = np.where(alarmed | np.isnan(statistic), 0.0, statistic)
        return -silent.max(initial=0.0), k, int(alarmed.sum())

    heap = [just_below(np.inf, k) for k in range(len(series))]
    heapify(heap)
    total = sum(count for _, _, count in heap)
    while heap[0][0] < 0:
        level, k, count = -heap[0][0], *heap[0][1:]
        heapreplace(heap, lower := just_below(level, k))
        total += lower[2] - count
        if total > allowed:
            return level
    return 0.0


def _statistic(residuals: ArrayLike, kind: str, settings: dict[str, float]) -> np.ndarray:
    return _run(_checked(residuals), chart=_chart(kind, settings))[1]


def _alarms(values: ArrayLike, level: float, **watch) -> np.ndarray:
    if not level >= 0:
        raise ValueError("the level must not be negative")
    return np.flatnonzero(_run(_checked(values), **watch, level=float(level))[2])


def _run(values, fitted=_AS_THEY_ARE, warm_up=0, chart=(_THRESHOLD, 1.0), level=np.inf):
    """Residuals, statistics and alarms ``(n,)`` of checked arguments."""
    residual, statistic = np.empty((2, values.size))
    alarmed = np.zeros(values.size, dtype=np.bool_)
    _watch(values, fitted, warm_up, *chart, level, residual, statistic, alarmed)
    return residual, statistic, alarmed


def _chart(kind: str, settings: dict[str, float]) -> tuple[int, float]:
    """Return a kind's number and the value of its setting."""
    if kind not in SETTINGS:
        raise ValueError(f"no statistic {kind!r}; there are {', '.join(SETTINGS)}")
    name, usual = SETTINGS[kind]
    if set(settings) - {name}:
        raise ValueError(f"{kind} has the setting {name}, not {', '.join(settings)}")
    value = settings.get(name, usual)
    whole = value >= 1 and value % 1 == 0
    if not {"run": whole, "slack": 0 <= value < np.inf, "weight": 0 < value <= 1}[name]:
        raise ValueError(f"{name} is out of its range: {value:g}")
    return _KINDS.index(kind), float(value)


def _checked(series: ArrayLike) -> np.ndarray:
    series = np.ascontiguousarray(series, dtype=float)
    if series.ndim != 1 or np.isinf(series).any():
        raise ValueError("a series must be (n,), of finite values and NaN")
    return series


def _fit(warm_up: int, detrend: bool) -> dict[str, int]:
    if not (warm_up >= 3 and warm_up % 1 == 0):
        raise ValueError("warm_up must be a whole number from 3")
    return {"fitted": _LINE if detrend else _MEAN, "warm_up": int(warm_up)}


# ---- compiled --------------------------------------------------------------------------------
# A fit is: number of values, mean position, mean value, sum of squares of positions, sum of
# products, sum of squared recursive residuals (Brown, Durbin & Evans 1975: all that it takes).


@_compiled
def _watch(values, fitted, warm_up, kind, setting, level, residual, statistic, alarmed):
    """Go through a series: fill in residuals, statistics and alarms, restart after each alarm."""
    fit = np.zeros(6)
    state = np.zeros(3 + int(setting))  # number of residuals, and what the kind keeps
    for i in range(values.size):
        residual[i] = statistic[i] = np.nan
        if np.isnan(values[i]):
            continue
        residual[i] = _residual(fit, i, values[i], fitted, warm_up)
        if not np.isnan(residual[i]):
            statistic[i] = _advance(state, residual[i], kind, setting)
            if statistic[i] > level:
                alarmed[i] = True
                state[:] = 0.0
                fit[:] = 0.0
        if fitted == _LINE or fit[0] < warm_up or np.isnan(residual[i]):
            _absorb(fit, i, values[i], fitted)


@_compiled
def _expected(fit, position, fitted):
    """Value that a fit of at least ``fitted`` values expects, and its variance over the noise's."""
    count, middle, mean, square, product, _ = fit
    if fitted == _MEAN:
        return mean, 1 / count
    away = position - middle
    return mean + product / square * away, 1 / count + away * away / square


@_compiled
def _residual(fit, position, value, fitted, warm_up):
    """Residual of the next value in its sd; NaN during the warm-up."""
    if fitted == _AS_THEY_ARE:
        return value
    if fit[0] < warm_up:
        return np.nan
    sd = np.sqrt(fit[5] / (fit[0] - fitted))
    if sd <= _ROUND_OFF * abs(fit[2]):
        return np.nan
    expected, variance = _expected(fit, position, fitted)
    return (value - expected) / (sd if fitted == _MEAN else sd * np.sqrt(1 + variance))


@_compiled
def _absorb(fit, position, value, fitted):
    """Add a value to a fit."""
    if fit[0] >= fitted:
        expected, variance = _expected(fit, position, fitted)
        fit[5] += (value - expected) ** 2 / (1 + variance)
    fit[0] += 1
    away, off = position - fit[1], value - fit[2]
    fit[1] += away / fit[0]
    fit[2] += off / fit[0]
    fit[3] += away * (position - fit[1])
    fit[4] += away * (value - fit[2])


@_compiled
def _advance(state, residual, kind, setting):
    """Take in a residual and return the statistic."""
    state[0] += 1
    if kind == _CUSUM:
        state[1] = max(0.0, state[1] + residual - setting)
        state[2] = max(0.0, state[2] - residual - setting)
        return max(state[1], state[2])
    if kind == _EWMA:
        state[1] += setting * (residual - state[1])
        left = 1 - (1 - setting) ** (2 * state[0])
        return abs(state[1]) / np.sqrt(setting / (2 - setting) * left)
    run = int(setting)
    recent = state[1 : 1 + run]
    recent[int(state[0] - 1) % run] = residual
    if state[0] < run:
        return 0.0
    return max(recent.min(), -recent.max(), 0.0)
