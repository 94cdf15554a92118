"""Online watching of series at any level, with a restart after each alarm.

A *detector* makes a statistic of the values so far, one a value, and an alarm is a statistic above
a level. After an alarm everything restarts from that operation: the detector begins anew, and the
operation of the alarm is the first that it sees.

Shapes: ``n`` operations, ``q`` series. They are counted by their position, from 0. An operation of
which any value is NaN is one without values: only its position counts.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["Detector", "Watch", "Watched", "level_for"]

Detector = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""From positions ``(n,)`` and values ``(n, q)`` to the statistic ``(n,)``, NaN in a warm-up.

What it says of a value depends on that and on earlier ones only."""


class Watched(NamedTuple):
    """The statistic of a series, NaN in a warm-up and without a value, and where it is above the
    level, ``(n,)`` each."""

    statistic: np.ndarray
    alarm: np.ndarray


class Watch:
    """A series that a detector watches online, at any level.

    What the detector says from a restart on does not depend on the level, so it is kept.

    Args:
        series: Values, ``(n,)`` or ``(n, q)``, any units.
        detector: For example one of ``control_charts``, with its settings.

    Raises:
        ValueError: If a value is infinite, or the shape another.

    Example:
        >>> def rise(position, values):
        ...     return (values - values[0])[:, 0]
        >>> Watch([1.0, 1.1, 0.9, 1.0, 5.0, 5.1, 4.9, 9.1], rise).at(3.0).alarm.nonzero()
        (array([4, 7]),)
    """

    def __init__(self, series: ArrayLike, detector: Detector) -> None:
        values = np.asarray(series, dtype=float)
        if values.ndim not in (1, 2) or np.isinf(values).any():
            raise ValueError("series must be (n,) or (n, q), of finite values and NaN")
        self.values = values.reshape(len(values), -1)
        self.detector = detector
        self._from: dict[int, np.ndarray] = {}

    def at(self, level: float, until: int | None = None) -> Watched:
        """Return what is seen at a level, from 0, of the values up to a position, or of all.

        Raises:
            ValueError: If the level is negative or NaN.
        """
        if not level >= 0:
            raise ValueError("the level must not be negative")
        n = len(self.values[:until])
        statistic, alarm = np.full(n, np.nan), np.zeros(n, bool)
        start = first = 0
        while True:
            seen = self._since(start)[: n - start]
            statistic[start + first :] = seen[first:]
            above = first + np.flatnonzero(seen[first:] > level)
            if not above.size:
                return Watched(statistic, alarm)
            start, first = start + int(above[0]), 1  # the statistic of the alarm itself stands
            alarm[start] = True

    def _since(self, start: int) -> np.ndarray:
        """Statistic of a watch that begins at a position."""
        if start not in self._from:
            rest = self.values[start:]
            there = np.flatnonzero(~np.isnan(rest).any(axis=1))
            seen = np.full(len(rest), np.nan)
            seen[there] = self.detector(there.astype(float), rest[there])
            self._from[start] = seen
        return self._from[start]


def level_for(watches: Sequence[Watch], rate: float, until: Sequence[int | None] = ()) -> float:
    """Return the lowest level that, like all higher ones, keeps the rate of false alarms.

    As alarms restart the fit, their number need not fall with the level everywhere; a bisection
    could end below a level at which it is too large again. So this goes down from no alarm: what
    is seen of a series changes only where the level passes its largest statistic without an alarm,
    and the first such value below which there are too many alarms is the level, exactly.

    Args:
        rate: Largest number of alarms an operation, from 0. Every operation counts, those of a
            warm-up and those without a value too.
        until: Position from which each series may have changed; none of them has unless told.

    Returns:
        The level; 0 if even that keeps the rate.
    """
    until = until or [None] * len(watches)
    operations = sum(len(w.values[:end]) for w, end in zip(watches, until, strict=True))
    if not (operations and rate >= 0):
        raise ValueError("there must be operations, and the rate must not be negative")
    allowed = np.floor(rate * operations * (1 + 1e-12))  # 1e-4 of 30,000 is 3

    def just_below(k: int, level: float) -> tuple[float, int]:
        """Largest statistic of a series without an alarm below a level, and its alarms there."""
        statistic, alarm = watches[k].at(np.nextafter(level, 0.0), until[k])
        silent = statistic[~alarm & ~np.isnan(statistic)]
        return silent.max(initial=0.0), int(alarm.sum())

    largest, alarms = np.array([just_below(k, np.inf) for k in range(len(watches))]).T
    while (level := largest.max()) > 0:
        k = largest.argmax()
        largest[k], alarms[k] = just_below(int(k), level)
        if alarms.sum() > allowed:
            return float(level)
    return 0.0
