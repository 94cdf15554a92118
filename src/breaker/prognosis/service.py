"""When to service a drive, by what it costs, and on which date an operation is expected.

A service costs ``c``, a failure ``d``. A drive of an age ``a`` that goes on for ``t`` more
operations fails with probability P(t), and makes E(t) more. The best t has the least expected cost
of an operation, ``(c + (d - c) P(t)) / (a + E(t))``. A failure counts if nobody notices it before:
a change of the rate is noticed an interval of inspection and a quarter of the age after it.
Renewal reward and age replacement: Barlow & Proschan, Mathematical Theory of Reliability, 1965.

Shapes: ``o`` operations, ``a`` of them at which the life was read, ``l`` limits, ``h`` operations
ahead.
"""

from collections.abc import Mapping

import numpy as np
import xarray as xr

YEAR = 365.25  # days
_AHEAD = 160  # operations ahead at which a service is tried, geometric: 6 % from one to the next


def ahead_of(horizon: float) -> np.ndarray:
    """Return operations ahead at which a service is tried, ``(h,)``; the first is 0."""
    return np.append(0.0, np.geomspace(1.0, horizon, _AHEAD - 1))


def interval_of(planning: Mapping, days: np.ndarray) -> np.ndarray:
    """Return operations from one inspection to the next, ``(a,)``, at least 1.

    >>> interval_of({"inspection": "2 years"}, np.array([7.305, np.nan]))
    array([100.,  inf])

    Args:
        planning: That section of the configuration.
        days: From one operation to the next, ``(a,)``; nan where not known: then inf, since no
            further inspection can be counted on.
    """
    number, unit = planning["inspection"].split()  # or "every operation"
    often = 1.0 if number == "every" else float(number)
    operations = often if unit.startswith("operation") else often * YEAR / days
    interval = np.nan_to_num(np.maximum(operations, 1.0), nan=np.inf)
    return np.broadcast_to(interval, np.shape(days))


def plan(
    life: xr.Dataset, planning: Mapping, days: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Plan the service of each limit.

    Args:
        life: ``lives``, ``turns``, ``noticed_in``, ``age`` and ``horizon`` of ``forecast_of``.
        planning: That section of the configuration.
        days: From one operation to the next, ``(a,)``; nan if not known.

    Returns:
        Operations ahead at which a service costs least, ``(a, l)``; inf beyond the horizon. The
        probability to exceed the limit or to fail suddenly before the next inspection, ``(a, l)``.
        What a service costs more at each of ``ahead_of`` than at the best, ``(a, l, h)``, in
        services. All nan where nothing is known.
    """
    lives, age = life.lives.values, life.age.values
    ahead, interval = ahead_of(life.attrs["horizon"]), interval_of(planning, days)
    seen = life.turns.values + (interval + life.noticed_in.values)[:, None]
    unseen = np.where(lives < seen[:, None], lives, np.inf)
    cost = np.full((*lives.shape[:2], len(ahead)), np.nan)
    for i, j in np.argwhere(~np.isnan(lives).any(axis=-1)):
        coming = np.sort(unseen[i, j][lives[i, j] > 0.0])  # no service undoes what is exceeded
        cost[i, j] = _cost(coming, age[i], ahead, planning) if coming.size else ahead
    known = ~np.isnan(cost[..., 0])
    at = np.where(known, np.nan_to_num(cost).argmin(axis=-1), 0)
    extra = cost - np.take_along_axis(cost, at[..., None], axis=-1)
    extra *= age[:, None, None] + ahead
    with np.errstate(invalid="ignore"):
        by_then = (lives <= interval[:, None, None]).mean(axis=-1)
        sudden = np.nan_to_num(planning["sudden_failures"] * days / YEAR) * interval
    risk = 1.0 - (1.0 - by_then) * np.exp(-sudden)[:, None]
    best = np.where(at == len(ahead) - 1, np.inf, ahead[at])
    return np.where(known, best, np.nan), np.where(known, risk, np.nan), extra


def _cost(coming: np.ndarray, age: float, ahead: np.ndarray, planning: Mapping) -> np.ndarray:
    """Return the expected cost of an operation by when to service, ``(h,)``, in services.

    ``coming`` are draws of the operations until a failure that nobody notices before, rising.
    """
    fails = np.searchsorted(coming, ahead, side="right") / coming.size
    made = np.cumsum(np.diff(ahead) * (1.0 - 0.5 * (fails[1:] + fails[:-1])))
    dearer = planning["failure_cost"] / planning["service_cost"] - 1.0
    return (1.0 + dearer * fails) / (age + np.append(0.0, made))


def days_per_operation(operations: np.ndarray, days: np.ndarray) -> np.ndarray:
    """Return the recent mean number of days between operations, ``(o,)``, nan if not known.

    Counted from the last dated operation that is a year back or more, else from the first one, and
    not at all within a month.

    Args:
        operations: Their numbers, rising, ``(o,)``.
        days: What ``days_of`` returns of their dates, ``(o,)``.

    >>> days_per_operation(np.array([1, 5, 100, 104]), np.array([0, 0, 1461, 1461])).round(1)
    array([ nan,  nan, 15.4, 14.8])
    """
    found, known = np.full(len(operations), np.nan), np.flatnonzero(np.isfinite(days))
    for i in known:
        past = known[(known < i) & (days[known] <= days[i] - YEAR)]
        since = past[-1] if past.size else known[0]
        if days[i] - days[since] >= YEAR / 12.0:
            found[i] = (days[i] - days[since]) / (operations[i] - operations[since])
    return found[_last_known(days)]


def on_date(
    wanted: np.ndarray, operations: np.ndarray, days: np.ndarray, pace: np.ndarray
) -> np.ndarray:
    """Return the date at which an operation is expected, as known at each operation, ``(o, l)``.

    Empty where rate or number are not known, or more than a century away.

    Args:
        wanted: Numbers of operations, ``(o, l)``.
        operations, days: As of ``days_per_operation``; ``pace`` is what it returns.
    """
    last = _last_known(days)
    with np.errstate(invalid="ignore"):
        ahead = (wanted - operations[last, None]) * pace[:, None]
        there = np.abs(ahead) < 100.0 * YEAR
        day = np.where(there, days[last, None] + ahead, np.nan)
    day = np.where(np.isfinite(day), day, np.nan).astype("timedelta64[D]")
    return np.where(np.isnat(day), "", (np.datetime64("0001-01-01") + day).astype(str))


def _last_known(values: np.ndarray) -> np.ndarray:
    """Return the index of the last value that is known at each operation; 0 before the first."""
    known = np.where(np.isfinite(values), np.arange(len(values)), 0)
    return np.maximum.accumulate(known)
