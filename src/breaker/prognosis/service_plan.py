"""When to service a drive, by what it costs.

A service costs ``c``, a failure ``d`` more. A drive that goes on for ``t`` more operations fails
with probability P(t), and is used for E(t) more. What an operation is worth is the least, over t,
of ``(c + d W) / A``, where A is the mean number of operations from new and W the probability to
wear out in them. The operation by which to service minimises ``d P(t) - (c + d W) / A * E(t)``.

P is the probability that a limit is exceeded, the rate of the wear may change, and nobody notices
until an interval of inspection is over and the records show it: some fifty of them, or those of a
quarter of the operations so far. So a longer interval and a dearer failure never plan later. Sudden
failures are as probable with a service as without it, and only shorten E and A.
Renewal reward and age replacement: Barlow & Proschan, Mathematical Theory of Reliability, 1965.

Shapes: ``n`` rows, ``h`` operations ahead.
"""

from collections.abc import Mapping
from typing import NamedTuple, Self

import numpy as np

from breaker.prognosis.forecast import Future

YEAR = 365.25  # days
_NOTICED = 0.25  # share of the operations so far, in which few records show a change, too


class Costs(NamedTuple):
    """What is planned with: the section ``planning`` of the configuration.

    Attributes:
        service, failure, inspection: What each costs, in any unit.
        often, unit: How far inspections are apart, in units "operation" or "year".
        sudden: Failures of a drive in a year that no wear announces.
    """

    service: float
    failure: float
    inspection: float
    often: float
    unit: str
    sudden: float

    @classmethod
    def from_settings(cls, planning: Mapping) -> Self:
        """Build from the section.

        >>> usual = {f"{name}_cost": 1.0 for name in ("service", "failure", "inspection")}
        >>> usual |= {"inspection": "2 years", "sudden_failures": 0.0}
        >>> Costs.from_settings(usual)[3:5]
        (2.0, 'year')
        """
        costs = (planning[f"{name}_cost"] for name in ("service", "failure", "inspection"))
        number, unit = planning["inspection"].split()  # "every operation" or "100 operations"
        often = 1.0 if number == "every" else float(number)
        return cls(*costs, often, unit.removesuffix("s"), planning["sudden_failures"])

    def interval(self, days: np.ndarray) -> np.ndarray:
        """Return operations from one inspection to the next, at least 1.

        Args:
            days: From one operation to the next, ``(n,)``; nan where not known: then inf, since no
                further inspection can be counted on.
        """
        if self.unit == "operation":
            return np.full(np.shape(days), max(self.often, 1.0))
        return np.nan_to_num(np.maximum(self.often * YEAR / days, 1.0), nan=np.inf)

    def suddenly(self, days: np.ndarray) -> np.ndarray:
        """Return sudden failures in an operation, ``(n,)``; 0 where no days are known."""
        return np.nan_to_num(self.sudden * days / YEAR)


class Plan(NamedTuple):
    """What is best for rows of the same limit.

    Attributes:
        best: Operations ahead at which a service costs least, ``(n,)``; inf beyond the horizon, nan
            where nothing is known.
        risk: Probability to exceed the limit or to fail suddenly before the next inspection.
        extra: What a service costs more at each of ``ahead`` than at the best, ``(n, h)``,
        rate: and the expected cost of an operation by this plan, ``(n,)``, in services; inspections
            count unless every operation is watched.
    """

    best: np.ndarray
    risk: np.ndarray
    extra: np.ndarray
    rate: np.ndarray


def plan(
    future: Future,
    costs: Costs,
    lives: np.ndarray,
    past: np.ndarray,
    *,
    age: np.ndarray,
    days: np.ndarray,
    spacing: np.ndarray,
) -> Plan:
    """Plan the service of a limit.

    Args:
        lives, past: As of ``Future.fails``.
        age: Operations since new, or since the last work, ``(n,)``.
        days: From one operation to the next, ``(n,)``, nan if not known.
        spacing: Operations from one record to the next, ``(n,)``.
    """
    ahead, interval, sudden = future.ahead(), costs.interval(days), costs.suddenly(days)
    lag = interval + np.minimum(future.noticed * spacing, _NOTICED * past)
    lag = np.append(ahead, np.inf)[np.searchsorted(ahead, lag)]
    fails, unseen = (future.fails(lives, past, each) for each in (np.inf, lag))
    over = np.searchsorted
    steady = np.array([over(each, ahead, side="right") for each in lives]).reshape(fails.shape)
    steady = steady / lives.shape[1]
    price = costs.service / (costs.failure - costs.service)
    worth = _worth(_coming(steady), ahead, sudden, age, price)
    lost, used = _going_on(_coming(unseen), ahead, sudden)
    extra = lost - worth[:, None] * used
    at = np.argmin(extra, axis=1)
    rows = np.arange(len(at))
    least = extra[rows, at][:, None]
    # Where nothing is lost by going on to the horizon, no service is planned.
    best = np.where(extra[:, -1] <= least[:, 0] + 1e-9, np.inf, ahead[at])
    by_then = [np.interp(each, ahead, row) for each, row in zip(interval, fails, strict=True)]
    with np.errstate(invalid="ignore"):
        risk = 1.0 - (1.0 - np.array(by_then)) * np.exp(-sudden * interval)
    before = _made(age, sudden)
    alive = np.exp(-sudden * age)
    rate = (price + alive * lost[rows, at]) / (before + alive * used[rows, at]) + sudden
    visits = np.where(interval > 1.0, costs.inspection / costs.service / interval, 0.0)
    known = ~np.isnan(lives[:, 0])
    return Plan(
        np.where(known, best, np.nan),
        np.where(known, risk, np.nan),
        np.where(known[:, None], (extra - least) / price, np.nan),
        np.where(known, rate / price + visits, np.nan),
    )


def _coming(fails: np.ndarray) -> np.ndarray:
    """Probabilities of drives that are not beyond the limit yet: no service undoes what is."""
    now = fails[:, :1]
    return np.where(now < 1.0, (fails - now) / np.where(now < 1.0, 1.0 - now, 1.0), 1.0)


def _going_on(
    fails: np.ndarray, ahead: np.ndarray, sudden: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Probability to wear out, and mean operations made, by each of ``ahead``, ``(n, h)`` each."""
    middle = 0.5 * (ahead[1:] + ahead[:-1])
    lasts = np.exp(-sudden[:, None] * middle)
    made = lasts * np.diff(ahead) * (1.0 - 0.5 * (fails[:, 1:] + fails[:, :-1]))
    worn = lasts * np.diff(fails, axis=1)
    none = np.zeros((len(fails), 1))
    return tuple(np.hstack([none, each.cumsum(axis=1)]) for each in (worn, made))


def _made(age: np.ndarray, sudden: np.ndarray) -> np.ndarray:
    """Mean number of operations by an age, if nothing but sudden failures ended a life."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(sudden * age > 1e-9, -np.expm1(-sudden * age) / sudden, age)


def _worth(
    fails: np.ndarray, ahead: np.ndarray, sudden: np.ndarray, age: np.ndarray, price: float
) -> np.ndarray:
    """What an operation costs at least, from new on, beside sudden failures: in failures, (n,)."""
    worn, made = _going_on(fails, ahead, sudden)
    alive = np.exp(-sudden * age)[:, None]
    whole = _made(age, sudden)[:, None] + alive * made
    return ((price + alive * worn) / whole).min(axis=1)
