"""When to service a drive, by what it costs.

A service costs ``c``, a failure ``d``. A drive of an age ``a`` that goes on for ``t`` more
operations fails with probability P(t), and makes E(t) more. The best t has the least expected cost
of an operation, ``(c + (d - c) P(t)) / (a + E(t))``. A failure counts if nobody notices it before:
a change of the rate is noticed an interval of inspection and some fifty records after it.
Renewal reward and age replacement: Barlow & Proschan, Mathematical Theory of Reliability, 1965.

Shapes: ``n`` rows, ``d`` draws, ``h`` operations ahead.
"""

from collections.abc import Mapping
from typing import NamedTuple, Self

import numpy as np

YEAR = 365.25  # days
_AHEAD = 160  # operations ahead at which a service is tried, geometric: 6 % from one to the next


class Costs(NamedTuple):
    """What is planned with: the section ``planning`` of the configuration.

    Attributes:
        service, failure: What each costs, in any unit.
        often, unit: How far inspections are from each other, in units "operation" or "year".
        sudden: Failures of a drive in a year that no wear announces.
    """

    service: float
    failure: float
    often: float
    unit: str
    sudden: float

    @classmethod
    def from_settings(cls, planning: Mapping) -> Self:
        """Build from the section.

        >>> usual = {"service_cost": 1.0, "failure_cost": 20.0, "sudden_failures": 0.0}
        >>> Costs.from_settings(usual | {"inspection": "2 years"})[2:4]
        (2.0, 'year')
        """
        costs = planning["service_cost"], planning["failure_cost"]
        number, unit = planning["inspection"].split()  # "every operation" or "100 operations"
        often = 1.0 if number == "every" else float(number)
        return cls(*costs, often, unit.removesuffix("s"), planning["sudden_failures"])

    def interval(self, days: np.ndarray) -> np.ndarray:
        """Return operations from one inspection to the next, ``(n,)``, at least 1.

        Args:
            days: From one operation to the next, ``(n,)``; nan where not known: then inf, since no
                further inspection can be counted on.
        """
        if self.unit == "operation":
            return np.full(np.shape(days), max(self.often, 1.0))
        return np.nan_to_num(np.maximum(self.often * YEAR / days, 1.0), nan=np.inf)


class Plan(NamedTuple):
    """What is best for rows of the same limit.

    Attributes:
        best: Operations ahead at which a service costs least, ``(n,)``; inf beyond the horizon, nan
            where nothing is known.
        risk: Probability to exceed the limit or to fail suddenly before the next inspection.
        extra: What a service costs more at each of ``ahead`` than at the best, ``(n, h)``, in
            services.
    """

    best: np.ndarray
    risk: np.ndarray
    extra: np.ndarray


def ahead_of(horizon: float) -> np.ndarray:
    """Return operations ahead at which a service is tried, ``(h,)``; the first is 0."""
    return np.append(0.0, np.geomspace(1.0, horizon, _AHEAD - 1))


def plan(
    ahead: np.ndarray,
    costs: Costs,
    lives: np.ndarray,
    turns: np.ndarray,
    noticed: np.ndarray,
    *,
    age: np.ndarray,
    days: np.ndarray,
) -> Plan:
    """Plan the service of a limit.

    Args:
        ahead: What ``ahead_of`` returns.
        lives: Operations left to each draw, ``(n, d)``.
        turns: Operations until its rate changes, ``(n, d)``.
        noticed: Operations in which records show a change, ``(n,)``.
        age: Operations since new, or since the last maintenance, ``(n,)``.
        days: From one operation to the next, ``(n,)``, nan if not known.
    """
    interval = costs.interval(days)
    lag = interval + noticed
    unseen = np.where(lives < turns + lag[:, None], lives, np.inf)
    cost, risk = np.full((2, len(lives), len(ahead)), np.nan)
    for row in np.flatnonzero(~np.isnan(lives).any(axis=1)):
        coming = np.sort(unseen[row][lives[row] > 0.0])  # no service undoes what is exceeded
        if not coming.size:
            cost[row] = ahead  # none is too early
            continue
        fails = np.searchsorted(coming, ahead, side="right") / coming.size
        made = age[row] + np.append(
            0.0, np.cumsum(np.diff(ahead) * (1.0 - 0.5 * (fails[1:] + fails[:-1])))
        )
        cost[row] = (costs.service + (costs.failure - costs.service) * fails) / made
        cost[row] /= costs.service
    known = ~np.isnan(cost[:, 0])
    at = np.where(known, np.nan_to_num(cost).argmin(axis=1), 0)
    least = cost[np.arange(len(cost)), at]
    sudden = np.nan_to_num(costs.sudden * days / YEAR)
    with np.errstate(invalid="ignore"):
        by_then = (lives <= interval[:, None]).mean(axis=1)
        risk = 1.0 - (1.0 - by_then) * np.exp(-sudden * interval)
    best = np.where(at == len(ahead) - 1, np.inf, ahead[at])
    extra = (cost - least[:, None]) * (age[:, None] + ahead)
    best, risk = (np.where(known, each, np.nan) for each in (best, risk))
    return Plan(best, risk, extra)
