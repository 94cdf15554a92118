"""Plan the service of a drive by its cost, and the date at which an operation is expected.

A service costs ``c``, a failure ``d``. A drive of an age ``a`` that continues for ``t`` more
operations fails with probability P(t), and makes E(t) more. The best t has the least expected cost
of an operation, ``(c + (d - c) P(t)) / (a + E(t))`` (age replacement: Barlow & Proschan,
Mathematical Theory of Reliability, 1965). A failure counts if it is not detected before: a change
of the rate is detected an interval of inspection and a quarter of the age after it.

Shapes: ``o`` operations, ``a`` of them with forecasts, ``l`` limits.
"""

from collections.abc import Mapping

import numpy as np
import xarray as xr

YEAR = 365.25  # days
_AHEAD = 160  # operations ahead at which the cost is computed, geometric with steps of 6 %


def interval_of(planning: Mapping, days: np.ndarray) -> np.ndarray:
    """Return operations from one inspection to the next, ``(a,)``, at least 1, by the days between
    operations; inf where these are nan, as no inspection is certain.

    >>> interval_of({"inspection": "2 years"}, np.array([7.305, np.nan]))
    array([100.,  inf])
    """
    number, unit = planning["inspection"].split()  # or "every operation"
    often = 1.0 if number == "every" else float(number)
    operations = often if unit.startswith("operation") else often * YEAR / days
    interval = np.nan_to_num(np.maximum(operations, 1.0), nan=np.inf)
    return np.broadcast_to(interval, np.shape(days))


def plan(
    life: xr.Dataset, planning: Mapping, days: np.ndarray, age: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Plan the service of each limit: ``days`` are days from one operation to the next, nan if
    unknown, and ``age`` operations since new or the last maintenance, ``(a,)``.

    Returns:
        Operations ahead at which a service costs least, ``(a, l)``; inf beyond the horizon. The
        probability to exceed the limit or to fail suddenly before the next inspection, ``(a, l)``.
        Both are nan where nothing is known.
    """
    lives, interval = life.lives.values, interval_of(planning, days)
    ahead = np.append(0.0, np.geomspace(1.0, life.attrs["horizon"], _AHEAD - 1))
    seen = life.turns.values + (interval + life.noticed_in.values)[:, None]
    unseen = np.where(lives < seen[:, None], lives, np.inf)
    dearer = planning["failure_cost"] / planning["service_cost"] - 1.0
    best = np.full(lives.shape[:2], np.nan)
    for i, j in np.argwhere(~np.isnan(lives).any(axis=-1)):
        cost = ahead
        coming = np.sort(unseen[i, j][lives[i, j] > 0.0])  # exceeded draws cannot be prevented
        if coming.size:
            fails = np.searchsorted(coming, ahead, side="right") / coming.size
            made = np.cumsum(np.diff(ahead) * (1.0 - 0.5 * (fails[1:] + fails[:-1])))
            cost = (1.0 + dearer * fails) / (age[i] + np.append(0.0, made))  # of an operation
        least = cost.argmin()
        best[i, j] = np.inf if least == len(ahead) - 1 else ahead[least]
    by_then = (lives <= interval[:, None, None]).mean(axis=-1)
    with np.errstate(invalid="ignore"):
        sudden = np.nan_to_num(planning["sudden_failures"] * days / YEAR) * interval
    risk = 1.0 - (1.0 - by_then) * np.exp(-sudden)[:, None]
    return best, np.where(np.isnan(best), np.nan, risk)


def days_per_operation(operations: np.ndarray, days: np.ndarray) -> np.ndarray:
    """Return the recent mean number of days between operations, ``(o,)``, nan if unknown, from
    their rising numbers and the results of ``days_of``, ``(o,)``.

    Days count from the last dated operation that is at least a year back, or else from the first
    one; they must be a month or more.

    >>> days_per_operation(np.array([1, 5, 100, 104]), np.array([0, 0, 1461, 1461])).round(1)
    array([ nan,  nan, 15.4, 14.8])
    """
    days_each, known = np.full(len(operations), np.nan), np.flatnonzero(np.isfinite(days))
    for i in known:
        past = known[(known < i) & (days[known] <= days[i] - YEAR)]
        since = past[-1] if past.size else known[0]
        if days[i] - days[since] >= YEAR / 12.0:
            days_each[i] = (days[i] - days[since]) / (operations[i] - operations[since])
    return days_each[_last_known(days)]


def on_date(
    wanted: np.ndarray, operations: np.ndarray, days: np.ndarray, pace: np.ndarray
) -> np.ndarray:
    """Return the dates at which the ``wanted`` operations are expected, as known at each operation,
    ``(o, l)``; ``pace`` is the result of ``days_per_operation``.

    Dates are empty if rate or number is unknown, or the date more than a century away.
    """
    last = _last_known(days)
    with np.errstate(invalid="ignore"):
        ahead = (wanted - operations[last, None]) * pace[:, None]
        day = np.where(np.abs(ahead) < 100.0 * YEAR, days[last, None] + ahead, np.nan)
    day = day.astype("timedelta64[D]")
    return np.where(np.isnat(day), "", (np.datetime64("0001-01-01") + day).astype(str))


def _last_known(values: np.ndarray) -> np.ndarray:
    """Return the index of the last known value at each operation; 0 before the first."""
    known = np.where(np.isfinite(values), np.arange(len(values)), 0)
    return np.maximum.accumulate(known)
